#include "interpolate.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "boundary.h"

namespace dacrt::compat {
namespace {

/// Item `i` of the buffer that describes the primitives.
template <class Primitive>
Primitive ReadPrimitive(const BufferView& primitives, uint32_t i) {
  if (!primitives.data() || i >= primitives.count) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "primID = ", i,
                   " is not below the number of primitives, which is ", primitives.count);
  }
  Primitive primitive;
  std::memcpy(&primitive, primitives.data() + i * primitives.stride, sizeof(primitive));
  return primitive;
}

/// A point between four vertices: in the triangle at the first, or in the one at the third.
InterpolationPoint PointInFacets(const uint32_t (&corner)[4], float u, float v) {
  if (u + v <= 1) return {corner[0], corner[1], corner[3], u, v};
  return {corner[2], corner[3], corner[1], 1 - u, 1 - v, /*turned=*/true};
}

const std::byte* Item(const BufferView& data, uint32_t i) {
  if (!data.data() || i >= data.count) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "the primitive's vertex ", i,
                   " is not below the number of the buffer's items, which is ", data.count);
  }
  return data.data() + i * data.stride;
}

float Value(const std::byte* item, std::size_t i) {
  float value;
  std::memcpy(&value, item + i * sizeof(value), sizeof(value));
  return value;
}

}  // namespace

InterpolationPoint PointInTriangle(const BufferView& primitives, uint32_t primitive, float u,
                                   float v) {
  struct Triangle {
    uint32_t corner[3];
  };
  const auto triangle = ReadPrimitive<Triangle>(primitives, primitive);
  return {triangle.corner[0], triangle.corner[1], triangle.corner[2], u, v};
}

InterpolationPoint PointInQuad(const BufferView& primitives, uint32_t primitive, float u, float v) {
  struct Quad {
    uint32_t corner[4];
  };
  return PointInFacets(ReadPrimitive<Quad>(primitives, primitive).corner, u, v);
}

InterpolationPoint PointInGrid(const BufferView& primitives, uint32_t primitive, float u, float v) {
  const auto grid = ReadPrimitive<RTCGrid>(primitives, primitive);
  if (grid.width < 2 || grid.height < 2) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "primID = ", primitive, " is a grid of ", grid.width,
                   " x ", grid.height, " vertices");
  }
  const auto columns = static_cast<float>(grid.width - 1);
  const auto rows = static_cast<float>(grid.height - 1);
  // What is not a number counts as 1, as in Embree.
  const auto clamp = [](float x) { return x < 1 ? std::max(x, 0.0f) : 1.0f; };
  const float x = clamp(u) * columns, y = clamp(v) * rows;
  // The far edges belong to the last cells. Embree takes the cells behind them, which has the same
  // vertices for the point, but others, of the next row or of none, for the derivatives.
  const float column = std::min(std::floor(x), columns - 1);
  const float row = std::min(std::floor(y), rows - 1);
  const uint32_t first =
      grid.startVertexID + static_cast<uint32_t>(row) * grid.stride + static_cast<uint32_t>(column);
  InterpolationPoint point = PointInFacets(
      {first, first + 1, first + 1 + grid.stride, first + grid.stride}, x - column, y - row);
  point.columns = columns;
  point.rows = rows;
  return point;
}

void Interpolate(const BufferView& data, const InterpolationPoint& point, std::size_t value_count,
                 const InterpolationOutput& output) {
  const std::byte* const a = Item(data, point.a);
  const std::byte* const b = Item(data, point.b);
  const std::byte* const c = Item(data, point.c);
  const float weight = 1 - point.u - point.v;
  const auto put = [&](float* to, std::size_t i, float value) {
    if (to) to[i * output.stride] = value;
  };
  for (std::size_t i = 0; i < value_count; ++i) {
    const float value_a = Value(a, i), value_b = Value(b, i), value_c = Value(c, i);
    // Embree's order of operations.
    put(output.p, i, weight * value_a + (point.u * value_b + point.v * value_c));
    if (output.dpdu) {
      const auto step = [&](float value) {
        return point.turned ? value_a - value : value - value_a;
      };
      put(output.dpdu, i, step(value_b) / point.columns);
      put(output.dpdv, i, step(value_c) / point.rows);
    }
    if (output.ddpdudu) {
      put(output.ddpdudu, i, 0);
      put(output.ddpdvdv, i, 0);
      put(output.ddpdudv, i, 0);
    }
  }
}

}  // namespace dacrt::compat

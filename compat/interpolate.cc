#include "interpolate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "boundary.h"
#include "geometry.h"
#include "names.h"

namespace dacrt::compat {
namespace {

/// A triangle of a primitive, and where in it the point lies.
struct Place {
  uint32_t corner[3];
  float u, v;
  bool is_turned;  ///< its edges run against the primitive's u and v
};

template <class T>
T ReadItem(const BufferView& view, unsigned int i) {
  T value;
  std::memcpy(&value, view.data() + i * view.stride, sizeof(value));
  return value;
}

/// Of the two triangles of a quad (0, 1, 3) and (2, 3, 1) the one that holds (u, v).
Place InQuad(const uint32_t* corner, float u, float v) {
  if (u + v <= 1.0f) return {{corner[0], corner[1], corner[3]}, u, v, false};
  return {{corner[2], corner[3], corner[1]}, 1.0f - u, 1.0f - v, true};
}

Place InGrid(const RTCGrid& grid, float u, float v) {
  const auto locate = [](float& x, unsigned int vertices) {
    const unsigned int cells = vertices < 2 ? 1 : vertices - 1;
    const float place = x * static_cast<float>(cells);
    // Embree goes one cell too far at 1, and may read what is no vertex of the grid.
    const float cell = std::clamp(std::floor(place), 0.0f, static_cast<float>(cells - 1));
    x = place - cell;
    return static_cast<uint32_t>(cell);
  };
  const uint32_t x = locate(u, grid.width), y = locate(v, grid.height);
  const uint32_t first = grid.startVertexID + y * grid.stride + x;
  const uint32_t corner[4] = {first, first + 1, first + grid.stride + 1, first + grid.stride};
  return InQuad(corner, u, v);
}

Place FindPlace(const Geometry& geometry, unsigned int primitive, float u, float v) {
  const bool is_grid = geometry.type() == RTC_GEOMETRY_TYPE_GRID;
  const BufferView& primitives =
      geometry.buffers().View(is_grid ? RTC_BUFFER_TYPE_GRID : RTC_BUFFER_TYPE_INDEX, 0);
  if (!primitives.data() || primitive >= primitives.count) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "primID = ", primitive,
                   " is not below the number of primitives, which is ", primitives.count);
  }
  if (is_grid) return InGrid(ReadItem<RTCGrid>(primitives, primitive), u, v);
  struct Triangle {
    uint32_t corner[3];
  };
  struct Quad {
    uint32_t corner[4];
  };
  if (geometry.type() == RTC_GEOMETRY_TYPE_QUAD) {
    return InQuad(ReadItem<Quad>(primitives, primitive).corner, u, v);
  }
  const auto triangle = ReadItem<Triangle>(primitives, primitive);
  return {{triangle.corner[0], triangle.corner[1], triangle.corner[2]}, u, v, false};
}

}  // namespace

void Interpolate(const Geometry& geometry, unsigned int primitive, float u, float v,
                 RTCBufferType type, unsigned int slot, unsigned int count, std::size_t stride,
                 const InterpolationOutput& output) {
  switch (geometry.type()) {
    case RTC_GEOMETRY_TYPE_TRIANGLE:
    case RTC_GEOMETRY_TYPE_QUAD:
    case RTC_GEOMETRY_TYPE_GRID:
      break;
    default:
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry is a ", Name(geometry.type()),
                     ", in which nothing is interpolated");
  }
  if (type != RTC_BUFFER_TYPE_VERTEX && type != RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "bufferType = ", static_cast<int>(type),
                   " is neither VERTEX nor VERTEX_ATTRIBUTE");
  }
  const BufferView& values = geometry.buffers().View(type, slot);
  const Place place = FindPlace(geometry, primitive, u, v);
  for (const uint32_t corner : place.corner) {
    if (values.data() && corner < values.count) continue;
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "primID = ", primitive, " has the vertex ", corner,
                   ", and bufferSlot = ", slot, " has ", values.count);
  }
  const auto put = [&](float* to, std::size_t i, float value) {
    if (to) to[i * stride] = value;
  };
  const float w = 1.0f - place.u - place.v;
  for (std::size_t i = 0; i < count; ++i) {
    float p[3];
    for (int corner = 0; corner < 3; ++corner) {
      std::memcpy(&p[corner],
                  values.data() + place.corner[corner] * values.stride + i * sizeof(float),
                  sizeof(float));
    }
    const float along_u = p[1] - p[0], along_v = p[2] - p[0];
    put(output.value, i, std::fma(w, p[0], std::fma(place.u, p[1], place.v * p[2])));
    put(output.along_u, i, place.is_turned ? -along_u : along_u);
    put(output.along_v, i, place.is_turned ? -along_v : along_v);
    put(output.along_uu, i, 0.0f);
    put(output.along_vv, i, 0.0f);
    put(output.along_uv, i, 0.0f);
  }
}

}  // namespace dacrt::compat

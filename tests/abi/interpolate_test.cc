// rtcInterpolate and rtcInterpolateN give the real library's bits.
//
// Two exceptions, both of grids. Embree multiplies their derivatives by an approximate reciprocal,
// which differs from processor to processor; dacrt divides, so the last places may differ. And
// where u or v is 1, Embree takes the cell behind the grid's last; see TheFarEdgesOfAGrid.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

constexpr unsigned int kVertices = 200;
constexpr unsigned int kPrimitives = 40;
constexpr float kUntouched = 77;

/// Data of meshes of every type, for both libraries.
struct Source {
  static constexpr std::size_t kWideStride = 260;  ///< floats; room for 256 values an item

  Source() {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> coordinate(-3, 3);
    for (auto* values : {&vertices[0], &vertices[1], &narrow}) {
      values->resize(kVertices * 8 + 4);  // Embree reads 16 bytes at once
      for (float& value : *values) value = coordinate(random);
    }
    wide.resize(kVertices * kWideStride + 4);
    for (float& value : wide) value = coordinate(random);
    for (auto& quad : indices) {
      for (unsigned int& index : quad) index = static_cast<unsigned int>(random() % kVertices);
    }
    indices[0] = {3, 3, 3, 3};  // derivatives of zero, which have a sign
    const std::array<unsigned short, 2> sizes[] = {{4, 4}, {3, 7}, {8, 5}, {2, 2}, {11, 13}};
    for (unsigned int i = 0; i < kPrimitives; ++i) {
      const auto [width, height] = sizes[i % std::size(sizes)];
      grids.push_back({i % 8, width + i % 3, width, height});
    }
  }

  /// A mesh with vertices at two time steps and three attributes: of 2 values, none, and of 256.
  RTCGeometry Mesh(Session& s, RTCGeometryType type) const {
    const Api& api = s.api;
    const RTCGeometry mesh = s.Own(api.rtcNewGeometry(s.device, type));
    api.rtcSetGeometryTimeStepCount(mesh, 2);
    api.rtcSetGeometryVertexAttributeCount(mesh, 3);
    const auto set = [&](RTCBufferType buffer, unsigned int slot, RTCFormat format,
                         const void* data, std::size_t stride, std::size_t count) {
      api.rtcSetSharedGeometryBuffer(mesh, buffer, slot, format, data, 0, stride, count);
    };
    if (type == RTC_GEOMETRY_TYPE_GRID) {
      set(RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids.data(), sizeof(RTCGrid), kPrimitives);
    } else {
      set(RTC_BUFFER_TYPE_INDEX, 0,
          type == RTC_GEOMETRY_TYPE_QUAD ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3, indices.data(), 16,
          kPrimitives);
    }
    set(RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices[0].data(), 32, kVertices);
    set(RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, vertices[1].data(), 32, kVertices);
    set(RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT2, narrow.data(), 20, kVertices);
    set(RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 2, RTC_FORMAT_FLOAT16, wide.data(), 4 * kWideStride,
        kVertices);
    api.rtcCommitGeometry(mesh);
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE) << api.name;
    return mesh;
  }

  std::vector<float> vertices[2], narrow, wide;
  std::array<std::array<unsigned int, 4>, kPrimitives> indices;
  std::vector<RTCGrid> grids;
};

const Source& TheSource() {
  static const Source source;
  return source;
}

constexpr int kOutputs = 6;  // P, dPdu, dPdv, ddPdudu, ddPdvdv, ddPdudv
using Outputs = std::array<std::vector<float>, kOutputs>;

struct BufferChoice {
  RTCBufferType type;
  unsigned int slot;
};

Outputs MakeOutputs(std::size_t values) {
  Outputs outputs;
  outputs.fill(std::vector<float>(values + 16, kUntouched));  // more than is to be written
  return outputs;
}

/// Those that are `wanted`, a bit each; null for the others.
std::array<float*, kOutputs> Pointers(Outputs& outputs, unsigned int wanted = 63) {
  std::array<float*, kOutputs> pointers;
  for (unsigned int i = 0; i < kOutputs; ++i) {
    pointers[i] = wanted >> i & 1 ? outputs[i].data() : nullptr;
  }
  return pointers;
}

Outputs Interpolate(const Api& api, RTCGeometry mesh, unsigned int primitive, float u, float v,
                    BufferChoice buffer, unsigned int count, unsigned int wanted = 63) {
  Outputs outputs = MakeOutputs(count);
  const auto to = Pointers(outputs, wanted);
  const RTCInterpolateArguments args{mesh,        primitive, u,     v,     buffer.type,
                                     buffer.slot, to[0],     to[1], to[2], to[3],
                                     to[4],       to[5],     count};
  api.rtcInterpolate(&args);
  return outputs;
}

/// The number of floats between `a` and `b`.
double UlpsBetween(float a, float b) {
  if (std::memcmp(&a, &b, sizeof a) == 0) return 0;
  if (!std::isfinite(a) || !std::isfinite(b)) return std::numeric_limits<double>::infinity();
  const float size = std::max(std::abs(a), std::abs(b));
  const float ulp = std::nextafter(size, INFINITY) - size;
  return std::abs(double{a} - double{b}) / ulp;
}

/// `derivative_ulps` is how far derivatives may be apart.
void ExpectSame(const Outputs& real, const Outputs& ours, double derivative_ulps,
                const std::string& where) {
  for (int output = 0; output < kOutputs; ++output) {
    const double most = output == 1 || output == 2 ? derivative_ulps : 0;
    for (std::size_t i = 0; i < real[output].size(); ++i) {
      const float a = real[output][i], b = ours[output][i];
      if (std::isnan(a) && std::isnan(b)) continue;
      ASSERT_LE(UlpsBetween(a, b), most)
          << where << ": output " << output << "[" << i << "]: " << a << " and " << b;
    }
  }
}

struct MeshType {
  RTCGeometryType type;
  const char* name;
  double derivative_ulps;
};

void PrintTo(const MeshType& type, std::ostream* out) { *out << type.name; }

class InterpolateMesh : public testing::TestWithParam<MeshType> {
 protected:
  RTCGeometry Real() { return TheSource().Mesh(real_, GetParam().type); }
  RTCGeometry Ours() { return TheSource().Mesh(ours_, GetParam().type); }
  float Limit() const { return GetParam().type == RTC_GEOMETRY_TYPE_GRID ? 0.999f : 1; }

  Session real_{RealEmbree()};
  Session ours_{DropIn()};
  std::mt19937 random_{7};
};

INSTANTIATE_TEST_SUITE_P(, InterpolateMesh,
                         testing::Values(MeshType{RTC_GEOMETRY_TYPE_TRIANGLE, "triangles", 0},
                                         MeshType{RTC_GEOMETRY_TYPE_QUAD, "quads", 0},
                                         MeshType{RTC_GEOMETRY_TYPE_GRID, "grids", 4}),
                         [](const auto& info) { return info.param.name; });

TEST_P(InterpolateMesh, EveryBufferAndCount) {
  const RTCGeometry real = Real(), ours = Ours();
  std::uniform_real_distribution<float> parameter(0, Limit());
  struct {
    BufferChoice buffer;
    std::vector<unsigned int> counts;
  } const cases[] = {{{RTC_BUFFER_TYPE_VERTEX, 0}, {0, 1, 2, 3}},
                     {{RTC_BUFFER_TYPE_VERTEX, 1}, {1, 3, 4, 5}},
                     {{RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0}, {1, 2}},
                     {{RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 2}, {1, 7, 8, 16, 17, 31, 255, 256}}};
  for (const auto& [buffer, counts] : cases) {
    for (const unsigned int count : counts) {
      for (unsigned int i = 0; i < 100; ++i) {
        const unsigned int primitive = i % kPrimitives;
        const float u = parameter(random_), v = parameter(random_);
        ExpectSame(Interpolate(real_.api, real, primitive, u, v, buffer, count),
                   Interpolate(ours_.api, ours, primitive, u, v, buffer, count),
                   GetParam().derivative_ulps,
                   "slot " + std::to_string(buffer.slot) + ", count " + std::to_string(count));
        if (HasFatalFailure()) return;
      }
    }
  }
  EXPECT_EQ(ours_.TakeError(), RTC_ERROR_NONE);
}

TEST_P(InterpolateMesh, CornersEdgesAndBeyond) {
  const RTCGeometry real = Real(), ours = Ours();
  const bool is_grid = GetParam().type == RTC_GEOMETRY_TYPE_GRID;
  std::vector<float> parameters{0, -0.0f, 0.25f, 0.5f, 1.0f / 3, 0.75f, 0.1f, 0.9f, -0.5f};
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float x : {1.0f, 1.5f, infinity, nan}) {
    if (!is_grid) parameters.push_back(x);
  }
  parameters.push_back(-infinity);
  for (unsigned int primitive = 0; primitive < kPrimitives; ++primitive) {
    for (const float u : parameters) {
      for (const float v : parameters) {
        const BufferChoice buffer{RTC_BUFFER_TYPE_VERTEX, 1};
        ExpectSame(Interpolate(real_.api, real, primitive, u, v, buffer, 3),
                   Interpolate(ours_.api, ours, primitive, u, v, buffer, 3),
                   GetParam().derivative_ulps,
                   "u " + std::to_string(u) + ", v " + std::to_string(v));
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST_P(InterpolateMesh, OutputsMayBeNull) {
  const RTCGeometry real = Real(), ours = Ours();
  const BufferChoice buffer{RTC_BUFFER_TYPE_VERTEX, 0};
  for (unsigned int wanted = 0; wanted < 64; ++wanted) {
    const bool du = wanted >> 1 & 1, dv = wanted >> 2 & 1;
    const bool duu = wanted >> 3 & 1, both = (wanted >> 4 & 3) == 3;
    const Outputs got = Interpolate(ours_.api, ours, 1, 0.25f, 0.5f, buffer, 3, wanted);
    if ((du && !dv) || (duu && !both)) {
      // The real library aborts.
      EXPECT_EQ(got[1][0] != kUntouched, du);
      EXPECT_EQ(got[3][0] != kUntouched, duu);
      continue;
    }
    ExpectSame(Interpolate(real_.api, real, 1, 0.25f, 0.5f, buffer, 3, wanted), got,
               GetParam().derivative_ulps, "outputs " + std::to_string(wanted));
  }
  EXPECT_EQ(ours_.TakeError(), RTC_ERROR_NONE);
}

Outputs InterpolateN(const Api& api, RTCGeometry mesh, const int* valid, unsigned int n,
                     const unsigned int* primitives, const float* u, const float* v,
                     unsigned int count, unsigned int wanted = 63) {
  Outputs outputs = MakeOutputs(std::size_t{n} * count);
  const auto to = Pointers(outputs, wanted);
  const RTCInterpolateNArguments args{
      mesh,  valid, primitives, u,     v,     n,    RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 2, to[0],
      to[1], to[2], to[3],      to[4], to[5], count};
  api.rtcInterpolateN(&args);
  return outputs;
}

TEST_P(InterpolateMesh, ManyAtOnce) {
  const RTCGeometry real = Real(), ours = Ours();
  std::uniform_real_distribution<float> parameter(0, Limit());
  // The manual asks for multiples of four; the real library takes any number.
  for (const unsigned int n : {0u, 1u, 3u, 4u, 8u, 13u, 64u}) {
    std::vector<unsigned int> primitives(n);
    std::vector<float> u(n), v(n);
    std::vector<int> valid(n);
    for (unsigned int i = 0; i < n; ++i) {
      primitives[i] = static_cast<unsigned int>(random_() % kPrimitives);
      u[i] = parameter(random_);
      v[i] = parameter(random_);
      const int flags[] = {0, -1, 1, std::numeric_limits<int>::min()};  // all but 0 are valid
      valid[i] = flags[random_() % 4];
      if (valid[i] == 0) primitives[i] = 1u << 30;  // not looked at
    }
    for (const unsigned int count : {1u, 3u, 4u, 6u, 256u}) {
      const auto run = [&](const Api& api, RTCGeometry mesh, unsigned int wanted) {
        return InterpolateN(api, mesh, valid.data(), n, primitives.data(), u.data(), v.data(),
                            count, wanted);
      };
      for (const unsigned int wanted : {63u, 0u, 1u, 6u, 7u, 56u}) {
        ExpectSame(run(real_.api, real, wanted), run(ours_.api, ours, wanted),
                   GetParam().derivative_ulps,
                   "N " + std::to_string(n) + ", count " + std::to_string(count));
        if (HasFatalFailure()) return;
      }
    }
    for (unsigned int& primitive : primitives) primitive %= kPrimitives;
    const auto run_all = [&](const Api& api, RTCGeometry mesh) {
      return InterpolateN(api, mesh, nullptr, n, primitives.data(), u.data(), v.data(), 3);
    };
    ExpectSame(run_all(real_.api, real), run_all(ours_.api, ours), GetParam().derivative_ulps,
               "no flags");
  }
  EXPECT_EQ(ours_.TakeError(), RTC_ERROR_NONE);
}

TEST_P(InterpolateMesh, TooManyValuesAtOnce) {
  const unsigned int primitive = 0;
  const float u = 0.25f;
  for (Session* s : {&real_, &ours_}) {
    const RTCGeometry mesh = TheSource().Mesh(*s, GetParam().type);
    const Outputs got = InterpolateN(s->api, mesh, nullptr, 1, &primitive, &u, &u, 257);
    EXPECT_EQ(s->TakeError(), RTC_ERROR_INVALID_OPERATION) << s->api.name;
    EXPECT_EQ(got[0][0], kUntouched);
  }
}

TEST_P(InterpolateMesh, UncommittedChangesCount) {
  const std::vector<float> other(kVertices * 3 + 4, 0.5f);
  for (Session* s : {&real_, &ours_}) {
    const RTCGeometry mesh = TheSource().Mesh(*s, GetParam().type);
    s->api.rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                      other.data(), 0, 12, kVertices);
    EXPECT_EQ(Interpolate(s->api, mesh, 1, 0.25f, 0.25f, {RTC_BUFFER_TYPE_VERTEX, 0}, 3)[0][0],
              0.5f);
  }
}

/// What the real library aborts on, or reads beyond the buffers for.
TEST_P(InterpolateMesh, BadArgumentsAreErrors) {
  const RTCGeometry mesh = Ours();
  const auto expect_refusal = [&](unsigned int primitive, BufferChoice buffer) {
    const Outputs got = Interpolate(ours_.api, mesh, primitive, 0.25f, 0.25f, buffer, 1);
    EXPECT_EQ(ours_.TakeError(), RTC_ERROR_INVALID_ARGUMENT) << buffer.type << " " << buffer.slot;
    for (const auto& output : got) EXPECT_EQ(output[0], kUntouched);
  };
  expect_refusal(kPrimitives, {RTC_BUFFER_TYPE_VERTEX, 0});
  expect_refusal(~0u, {RTC_BUFFER_TYPE_VERTEX, 0});
  expect_refusal(0, {RTC_BUFFER_TYPE_VERTEX, 2});
  expect_refusal(0, {RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 1});  // not set
  expect_refusal(0, {RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 3});
  for (const int type : {0, 3, 4, 8, 16, 17, 32, -1}) {
    expect_refusal(0, {static_cast<RTCBufferType>(type), 0});
  }
  // Vertices that the buffer does not have.
  ours_.api.rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                       TheSource().vertices[0].data(), 0, 12, 1);
  expect_refusal(0, {RTC_BUFFER_TYPE_VERTEX, 0});
}

TEST(Interpolate, OtherTypesAreRefused) {
  for (const Api* const api : {&RealEmbree(), &DropIn()}) {
    Session s(*api);
    for (const RTCGeometryType type : {RTC_GEOMETRY_TYPE_SPHERE_POINT, RTC_GEOMETRY_TYPE_DISC_POINT,
                                       RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT,
                                       RTC_GEOMETRY_TYPE_USER, RTC_GEOMETRY_TYPE_INSTANCE}) {
      const RTCGeometry geometry = s.Own(api->rtcNewGeometry(s.device, type));
      const Outputs got = Interpolate(*api, geometry, 0, 0, 0, {RTC_BUFFER_TYPE_VERTEX, 0}, 1);
      EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION) << api->name << " " << type;
      EXPECT_EQ(got[0][0], kUntouched);
      const unsigned int primitive = 0;
      const float u = 0;
      InterpolateN(*api, geometry, nullptr, 1, &primitive, &u, &u, 1);
      EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION) << api->name << " " << type;
      const int valid = 0;
      InterpolateN(*api, geometry, &valid, 1, &primitive, &u, &u, 1);
      EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE) << api->name << " " << type;
    }
  }
}

// At u = 1 the real library goes to the cell behind the last, at its near edge: the point is the
// same but for rounding, and the derivatives are those of vertices that are not the cell's.
TEST(Interpolate, TheFarEdgesOfAGrid) {
  Session real(RealEmbree()), ours(DropIn());
  const Source& source = TheSource();
  const RTCGeometry real_mesh = source.Mesh(real, RTC_GEOMETRY_TYPE_GRID);
  const RTCGeometry ours_mesh = source.Mesh(ours, RTC_GEOMETRY_TYPE_GRID);
  const BufferChoice buffer{RTC_BUFFER_TYPE_VERTEX, 1};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (unsigned int primitive = 0; primitive < kPrimitives; ++primitive) {
    const RTCGrid& grid = source.grids[primitive];
    for (const auto& [u, v] : std::vector<std::array<float, 2>>{
             {1, 1}, {1, 0}, {0, 1}, {1, 0.3f}, {0.7f, 1}, {1.5f, 0.3f}, {nan, nan}}) {
      const Outputs want = Interpolate(real.api, real_mesh, primitive, u, v, buffer, 3);
      const Outputs got = Interpolate(ours.api, ours_mesh, primitive, u, v, buffer, 3);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[0][i], want[0][i], 1e-6f);
    }
    // At the corner the derivatives are those of the last cell's far triangle.
    const Outputs corner = Interpolate(ours.api, ours_mesh, primitive, 1, 1, buffer, 3);
    const auto vertex = [&](unsigned int x, unsigned int y) {
      return source.vertices[1].data() + 8 * (grid.startVertexID + y * grid.stride + x);
    };
    const unsigned int x = grid.width - 1u, y = grid.height - 1u;
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(corner[0][i], vertex(x, y)[i]);
      EXPECT_EQ(corner[1][i], (vertex(x, y)[i] - vertex(x - 1, y)[i]) / static_cast<float>(x));
      EXPECT_EQ(corner[2][i], (vertex(x, y)[i] - vertex(x, y - 1)[i]) / static_cast<float>(y));
    }
  }
}

}  // namespace
}  // namespace dacrt::tests

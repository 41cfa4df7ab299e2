// What the unit tests share: random numbers, memory with guard pages, meshes, rays, a batch over
// memory of its own, and the triangle test in double precision.
//
// A test of a step that is written for SIMD is compiled once for each instruction set by Highway's
// foreach_target.h and runs as Suite.Test/AVX2, .../SCALAR and so on for each that the machine has.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <vector>

#include "dacrt/dacrt.h"
#include "geometry/box.h"
#include "geometry/geometry_table.h"
#include "geometry/triangle_refs.h"
#include "paper/ray_batch.h"
#include "random.h"

namespace dacrt::unit {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

using Float3 = std::array<float, 3>;

/// The tests' generator, and what geometry wants of it.
class Random : public tests::Random {
 public:
  using tests::Random::Random;

  Float3 InCube(float lower, float upper) {
    return {Uniform(lower, upper), Uniform(lower, upper), Uniform(lower, upper)};
  }

  /// Of length 1, every direction alike.
  Float3 Direction() {
    for (;;) {
      const Float3 d = InCube(-1, 1);
      const float square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      if (square < 0.01f || square > 1) continue;
      const float scale = 1 / std::sqrt(square);
      return {d[0] * scale, d[1] * scale, d[2] * scale};
    }
  }

  /// Any sign, any magnitude from `smallest` to `largest`, every power of two alike.
  float AnyMagnitude(float smallest, float largest) {
    const float magnitude = std::exp2(Uniform(std::log2(smallest), std::log2(largest)));
    return Next() & 1 ? magnitude : -magnitude;
  }
};

/// An array between two pages that may not be touched. Its end is at the second one; its start is
/// aligned to `alignment` (for which up to that many bytes may stay free before the second page).
template <class T>
class GuardedArray {
 public:
  explicit GuardedArray(std::size_t count, std::size_t alignment = alignof(T)) : count_(count) {
    const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t bytes = (count * sizeof(T) + alignment - 1) / alignment * alignment;
    const std::size_t inner = (bytes + page - 1) / page * page;
    mapped_bytes_ = inner + 2 * page;
    mapped_ = mmap(nullptr, mapped_bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped_ == MAP_FAILED) throw std::bad_alloc();
    char* start = static_cast<char*>(mapped_) + page;
    if (inner > 0 && mprotect(start, inner, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
    data_ = reinterpret_cast<T*>(start + inner - bytes);
  }
  ~GuardedArray() { munmap(mapped_, mapped_bytes_); }
  GuardedArray(const GuardedArray&) = delete;
  GuardedArray& operator=(const GuardedArray&) = delete;

  T* data() const { return data_; }
  std::size_t size() const { return count_; }
  T* begin() const { return data_; }
  T* end() const { return data_ + count_; }
  T& operator[](std::size_t i) const { return data_[i]; }

 private:
  std::size_t count_;
  void* mapped_;
  std::size_t mapped_bytes_;
  T* data_;
};

/// A mesh with memory of its own.
struct Mesh {
  std::vector<Float3> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  uint32_t geometry_id = 0;
  uint32_t mask = UINT32_MAX;

  void Add(const Float3& a, const Float3& b, const Float3& c) {
    const uint32_t first = static_cast<uint32_t>(vertices.size());
    vertices.insert(vertices.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }

  TriangleMesh View() const {
    return {vertices.data(),      sizeof(Float3),   vertices.size(), triangles.data(),
            3 * sizeof(uint32_t), triangles.size(), geometry_id,     mask};
  }

  /// Corner `corner` of a triangle whose indices are legal.
  const Float3& Corner(std::size_t triangle, int corner) const {
    return vertices[triangles[triangle][static_cast<std::size_t>(corner)]];
  }
};

/// The mesh where it lies.
inline Geometry GeometryOf(const Mesh& mesh) {
  Geometry geometry;
  geometry.geometry_id = mesh.geometry_id;
  geometry.mask = mesh.mask;
  geometry.vertices = {{mesh.vertices.data(), sizeof(Float3)}};
  geometry.vertex_count = mesh.vertices.size();
  geometry.primitives = {mesh.triangles.data(), 3 * sizeof(uint32_t)};
  geometry.primitive_count = mesh.triangles.size();
  return geometry;
}

inline std::vector<TriangleMesh> Views(const std::vector<Mesh>& meshes) {
  std::vector<TriangleMesh> views;
  for (const Mesh& mesh : meshes) views.push_back(mesh.View());
  return views;
}

/// `count` triangles of up to `size` in [-extent, extent]^3.
inline Mesh MakeSoup(Random& random, std::size_t count, float extent, float size) {
  Mesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const Float3 a = random.InCube(-extent, extent);
    Float3 b = random.InCube(-size, size), c = random.InCube(-size, size);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      b[axis] += a[axis];
      c[axis] += a[axis];
    }
    mesh.Add(a, b, c);
  }
  return mesh;
}

/// The range [begin, end) of refs with its bounds, one float at a time.
inline TriangleRange RangeOf(const std::vector<TriangleRef>& refs, std::size_t begin,
                             std::size_t end) {
  TriangleRange range{begin, end, Box::Empty(), Box::Empty()};
  for (std::size_t i = begin; i < end; ++i) {
    range.bounds.Extend(refs[i].lower);
    range.bounds.Extend(refs[i].upper);
    float center[3];
    for (int axis = 0; axis < 3; ++axis) center[axis] = refs[i].lower[axis] + refs[i].upper[axis];
    range.centers.Extend(center);
  }
  return range;
}

/// A ray and its hit as a caller may keep them: an array of records.
struct Ray {
  Float3 org{};
  float tnear = 0;
  Float3 dir{};
  float tfar = kInfinity;
  uint32_t mask = UINT32_MAX;
  Float3 ng{};
  float u = 0, v = 0;
  uint32_t primitive_id = UINT32_MAX, geometry_id = UINT32_MAX, instance_id = UINT32_MAX;

  bool IsHit() const { return geometry_id != UINT32_MAX; }
};

inline bool SameBits(const Ray& a, const Ray& b) { return std::memcmp(&a, &b, sizeof(Ray)) == 0; }

/// All components of an array of records.
inline RayView ViewOf(std::span<Ray> rays) {
  Ray* ray = rays.data();
  const auto address = [](const void* p) { return reinterpret_cast<RayView::Component>(p); };
  RayView view;
  view.count = rays.size();
  view.packet_stride = sizeof(Ray);
  view.org_x = address(&ray->org[0]);
  view.org_y = address(&ray->org[1]);
  view.org_z = address(&ray->org[2]);
  view.dir_x = address(&ray->dir[0]);
  view.dir_y = address(&ray->dir[1]);
  view.dir_z = address(&ray->dir[2]);
  view.tnear = address(&ray->tnear);
  view.tfar = address(&ray->tfar);
  view.mask = address(&ray->mask);
  view.ng_x = address(&ray->ng[0]);
  view.ng_y = address(&ray->ng[1]);
  view.ng_z = address(&ray->ng[2]);
  view.u = address(&ray->u);
  view.v = address(&ray->v);
  view.primitive_id = address(&ray->primitive_id);
  view.geometry_id = address(&ray->geometry_id);
  view.instance_id = address(&ray->instance_id);
  return view;
}

inline Ray MakeRay(const Float3& org, const Float3& dir, float tnear = 0, float tfar = kInfinity) {
  Ray ray;
  ray.org = org;
  ray.dir = dir;
  ray.tnear = tnear;
  ray.tfar = tfar;
  return ray;
}

/// Rays from points of [-extent, extent]^3 in all directions.
inline std::vector<Ray> MakeRays(Random& random, std::size_t count, float extent) {
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) ray = MakeRay(random.InCube(-extent, extent), random.Direction());
  return rays;
}

/// A RayBatch over guarded memory.
class BatchMemory {
 public:
  /// `capacity` slots, a multiple of kMaxLanes; names for `rays` rays.
  BatchMemory(std::size_t capacity, std::size_t rays)
      : floats_(8 * capacity, 64),
        indices_(capacity, 64),
        bits_(capacity / 8),
        hits_(rays),
        masks_(rays) {
    std::fill(floats_.begin(), floats_.end(), kNaN);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.org[axis] = floats_.data() + axis * capacity;
      batch.dir[axis] = floats_.data() + (3 + axis) * capacity;
    }
    batch.tnear = floats_.data() + 6 * capacity;
    batch.tfar = floats_.data() + 7 * capacity;
    batch.index = indices_.data();
    batch.capacity = capacity;
    batch.lane_bits = bits_.data();
    batch.bits_capacity = capacity / 8;
    batch.hits = hits_.data();
    batch.ray_masks = masks_.data();
  }

  /// Puts `rays`, all of which must be active, on the stack. They are numbered from `number` on.
  RayBlock Push(std::span<const Ray> rays, std::size_t number = 0) {
    const RayBlock block{batch.top, rays.size()};
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::size_t slot = block.begin + i;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        batch.org[axis][slot] = rays[i].org[axis];
        batch.dir[axis][slot] = rays[i].dir[axis];
      }
      batch.tnear[slot] = rays[i].tnear;
      batch.tfar[slot] = rays[i].tfar;
      batch.index[slot] = static_cast<uint32_t>(number + i);
      batch.ray_masks[number + i] = rays[i].mask;
      batch.hits[number + i] = {PaperHit::kNone, PaperHit::kNone};
    }
    PadWithInactive(batch, block.begin + rays.size());
    batch.top = (block.begin + rays.size() + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
    return block;
  }

  RayBatch batch{};

 private:
  GuardedArray<float> floats_;
  GuardedArray<uint32_t> indices_;
  GuardedArray<uint8_t> bits_;
  GuardedArray<PaperHit> hits_;
  GuardedArray<uint32_t> masks_;
};

/// The test of Moeller and Trumbore in double precision, on the plane's whole line: whether t lies
/// in the ray's interval is for the caller to say.
struct ExactHit {
  double t = std::numeric_limits<double>::quiet_NaN();
  double u = 0, v = 0;

  /// How far inside the triangle the ray passes, in barycentric units; negative if outside, and if
  /// the ray is parallel to the plane.
  double inside = -std::numeric_limits<double>::infinity();
};

inline ExactHit IntersectExactly(const Ray& ray, const Float3& v0, const Float3& v1,
                                 const Float3& v2) {
  using Double3 = std::array<double, 3>;
  const auto subtract = [](const Float3& a, const Float3& b) {
    return Double3{double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]};
  };
  const auto cross = [](const Double3& a, const Double3& b) {
    return Double3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const Double3& a, const Double3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const Double3 dir{ray.dir[0], ray.dir[1], ray.dir[2]};
  const Double3 edge1 = subtract(v1, v0), edge2 = subtract(v2, v0), from_v0 = subtract(ray.org, v0);
  const Double3 p = cross(dir, edge2), q = cross(from_v0, edge1);
  const double determinant = dot(edge1, p);
  ExactHit hit;
  if (determinant == 0) return hit;
  hit.t = dot(edge2, q) / determinant;
  hit.u = dot(from_v0, p) / determinant;
  hit.v = dot(dir, q) / determinant;
  hit.inside = std::min({hit.u, hit.v, 1 - hit.u - hit.v});
  return hit;
}

inline ExactHit IntersectExactly(const Ray& ray, const Mesh& mesh, std::size_t triangle) {
  return IntersectExactly(ray, mesh.Corner(triangle, 0), mesh.Corner(triangle, 1),
                          mesh.Corner(triangle, 2));
}

}  // namespace dacrt::unit

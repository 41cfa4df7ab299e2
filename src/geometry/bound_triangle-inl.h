// Bounds of triangles, four coordinates at a time: BoundTriangle of triangle_refs.h for the passes
// over all triangles.

#if defined(DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
#undef DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
#else
#define DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
#endif

#include <hwy/cache_control.h>

#include <cstdint>
#include <cstring>

#include "geometry/corner-inl.h"
#include "geometry/triangle_refs.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The corners of a box; the fourth lanes are scrap.
struct CornerBox {
  Corner lower;
  Corner upper;
};

/// What is read of a geometry to load the corners of its triangles.
class CornerSource {
 public:
  CornerSource() = default;
  CornerSource(const GeometryTable& geometries, uint32_t geometry) {
    const TriangleMesh& mesh = geometries[geometry];
    indices_ = static_cast<const char*>(mesh.triangles);
    vertices_ = static_cast<const char*>(mesh.vertices);
    triangle_stride_ = mesh.triangle_stride;
    vertex_stride_ = mesh.vertex_stride;
    // With a stride of 0 every vertex is the last one.
    const bool has_followed =
        geometries.HasTriangles(geometry) && mesh.vertex_count > 0 && mesh.vertex_stride > 0;
    followed_vertices_ = has_followed ? mesh.vertex_count - 1 : 0;
  }

  /// Loads the corners of a triangle, three coordinates each with something behind. False if that
  /// takes another way: the geometry is not of still triangles, an index is outside the vertices,
  /// or the last one, behind which there may be nothing.
  HWY_INLINE bool Load(uint32_t primitive, Corner* corners) const {
    if (HWY_UNLIKELY(followed_vertices_ == 0)) return false;
    uint32_t index[3];
    ReadIndices(primitive, index);
    return Load(index, corners);
  }
  /// The same where its indices are known; they are not read if the geometry is not of still
  /// triangles.
  HWY_INLINE bool Load(const uint32_t* index, Corner* corners) const {
    if (HWY_UNLIKELY(followed_vertices_ == 0)) return false;
    if (HWY_UNLIKELY(HWY_MAX(HWY_MAX(index[0], index[1]), index[2]) >= followed_vertices_)) {
      return false;
    }
    for (int i = 0; i < 3; ++i) {
      corners[i] = Corner::LoadUnaligned(reinterpret_cast<const float*>(VertexOf(index[i])));
    }
    return true;
  }

  /// Fetches what will soon be read.
  HWY_INLINE void FetchIndices(uint32_t primitive) const {
    if (HWY_LIKELY(followed_vertices_ > 0)) hwy::Prefetch(IndicesOf(primitive));
  }
  /// Reads the indices, which should have been fetched.
  HWY_INLINE void FetchVertices(uint32_t primitive) const {
    if (HWY_UNLIKELY(followed_vertices_ == 0)) return;
    uint32_t index[3];
    ReadIndices(primitive, index);
    FetchVertices(index);
  }
  HWY_INLINE void FetchVertices(const uint32_t* index) const {
    for (int i = 0; i < 3; ++i) hwy::Prefetch(VertexOf(index[i]));
  }
  /// Of still triangles.
  HWY_INLINE void ReadIndices(uint32_t primitive, uint32_t* index) const {
    memcpy(index, IndicesOf(primitive), 3 * sizeof(uint32_t));
  }

 private:
  HWY_INLINE const char* IndicesOf(uint32_t primitive) const {
    return indices_ + size_t{primitive} * triangle_stride_;
  }
  /// Wherever that is: to fetch does not fail, whatever the address.
  HWY_INLINE const char* VertexOf(uint32_t index) const {
    return reinterpret_cast<const char*>(reinterpret_cast<std::uintptr_t>(vertices_) +
                                         index * vertex_stride_);
  }

  const char* indices_ = nullptr;
  const char* vertices_ = nullptr;
  size_t triangle_stride_ = 0, vertex_stride_ = 0;
  size_t followed_vertices_ = 0;  ///< those before the last one; 0 if nothing is read this way
};

HWY_INLINE CornerBox BoundCorners(const Corner* c) {
  return {Min(Min(c[0], c[1]), c[2]), Max(Max(c[0], c[1]), c[2])};
}

/// Bounds of a triangle that can be hit.
HWY_INLINE CornerBox BoundUsable(const GeometryTable& geometries, const CornerSource& source,
                                 GeometryTable::Name name) {
  Corner corners[3];
  if (HWY_LIKELY(source.Load(name.primitive, corners))) return BoundCorners(corners);
  TriangleRef ref{};
  BoundTriangle(geometries, name, ref);
  return {Corner::Load(ref.lower), Corner::Load(ref.upper)};
}

/// Whether no coordinate is too large, infinite, or not a number.
HWY_INLINE bool IsUsable(const Corner* corners) {
  HWY_ALIGN static constexpr uint32_t kXyz[4] = {~0u, ~0u, ~0u, 0};
  const Corner mask = Corner::Load(reinterpret_cast<const float*>(kXyz));
  const auto limit = hn::Set(kCornerTag, kLargestCoordinate);
  bool usable = true;
  for (size_t i = 0; i < kCornerParts; ++i) {
    const auto within = [&](const Corner& corner) HWY_ATTR {
      return hn::Le(hn::Abs(hn::And(corner.part[i], mask.part[i])), limit);
    };
    usable &= hn::AllTrue(
        kCornerTag, hn::And(within(corners[0]), hn::And(within(corners[1]), within(corners[2]))));
  }
  return usable;
}

/// Bounds of a triangle, if it can be hit.
HWY_INLINE bool BoundIfUsable(const GeometryTable& geometries, const CornerSource& source,
                              GeometryTable::Name name, CornerBox& box) {
  Corner corners[3];
  if (HWY_LIKELY(source.Load(name.primitive, corners))) {
    box = BoundCorners(corners);
    return IsUsable(corners);
  }
  TriangleRef ref;
  if (!BoundTriangle(geometries, name, ref)) return false;
  box = {Corner::Load(ref.lower), Corner::Load(ref.upper)};
  return true;
}
HWY_INLINE bool BoundIfUsable(const GeometryTable& geometries, GeometryTable::Name name,
                              CornerBox& box) {
  return BoundIfUsable(geometries, CornerSource(geometries, name.geometry), name, box);
}

/// Finds triangles by their numbers. Many that follow each other are of one geometry: what is
/// looked up of it is kept.
class TriangleFinder {
 public:
  explicit TriangleFinder(const GeometryTable& geometries) : geometries_(geometries) {}

  HWY_INLINE GeometryTable::Name Find(uint32_t number) {
    if (HWY_UNLIKELY(number - first_ >= count_)) Enter(geometries_.Locate(number).geometry);
    return {geometry_, number - first_};
  }

  /// Of the geometry of the triangle that was found last.
  const CornerSource& source() const { return source_; }

  HWY_INLINE CornerBox BoundUsable(uint32_t number) {
    const GeometryTable::Name name = Find(number);
    return HWY_NAMESPACE::BoundUsable(geometries_, source_, name);
  }
  HWY_INLINE bool BoundIfUsable(uint32_t number, CornerBox& box) {
    const GeometryTable::Name name = Find(number);
    return HWY_NAMESPACE::BoundIfUsable(geometries_, source_, name, box);
  }

 private:
  HWY_NOINLINE void Enter(uint32_t geometry) {
    geometry_ = geometry;
    first_ = geometries_.Number(geometry, 0);
    count_ = static_cast<uint32_t>(geometries_[geometry].triangle_count);
    source_ = CornerSource(geometries_, geometry);
  }

  const GeometryTable& geometries_;
  CornerSource source_;
  uint32_t geometry_ = 0, first_ = 0, count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_

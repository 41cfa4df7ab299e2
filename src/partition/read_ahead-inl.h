// Going through triangles in the kept order, which is not that of their geometries: what will be
// read of them is fetched some triangles ahead.

#if defined(DACRT_PARTITION_READ_AHEAD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_READ_AHEAD_INL_H_
#undef DACRT_PARTITION_READ_AHEAD_INL_H_
#else
#define DACRT_PARTITION_READ_AHEAD_INL_H_
#endif

#include <span>

#include "geometry/bound_triangle-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Calls `body(i, name, source)` for triangle i of some, where `source` is that of its geometry;
/// those behind are on their way from memory meanwhile.
template <class Body>
HWY_INLINE void ForEachReadAhead(const GeometryTable& geometries, std::span<const uint32_t> order,
                                 const Body& body) {
  // Triangles ahead of which indices are fetched, and vertices.
  constexpr size_t kFar = 128, kNear = 48;
  // Neighbours are mostly of one geometry: what is looked up of it stays in registers.
  for (size_t i = 0; i < order.size();) {
    const uint32_t geometry = geometries.Locate(KeptOrder::NumberOf(order[i])).geometry;
    const uint32_t first = geometries.Number(geometry, 0);
    const auto count = static_cast<uint32_t>(geometries[geometry].triangle_count);
    const CornerSource source(geometries, geometry);
    const auto primitive_at = [&](size_t place) {
      return KeptOrder::NumberOf(order[HWY_MIN(place, order.size() - 1)]) - first;
    };
    for (; i < order.size(); ++i) {
      const uint32_t primitive = primitive_at(i);
      if (primitive >= count) break;
      const uint32_t far = primitive_at(i + kFar), near = primitive_at(i + kNear);
      if (HWY_LIKELY(far < count)) source.FetchIndices(far);
      if (HWY_LIKELY(near < count)) source.FetchVertices(near);
      body(i, GeometryTable::Name{geometry, primitive}, source);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_READ_AHEAD_INL_H_

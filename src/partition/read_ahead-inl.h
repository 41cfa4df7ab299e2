// Going through triangles in the kept order, which is not that of their geometries: what will be
// read of them is fetched some triangles ahead.

#if defined(DACRT_PARTITION_READ_AHEAD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_READ_AHEAD_INL_H_
#undef DACRT_PARTITION_READ_AHEAD_INL_H_
#else
#define DACRT_PARTITION_READ_AHEAD_INL_H_
#endif

#include <span>

#include "geometry/fetch_corners.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Names of triangles of which many that follow each other are of one geometry.
class NameFinder {
 public:
  explicit NameFinder(const GeometryTable& geometries) : geometries_(geometries) {}

  HWY_INLINE GeometryTable::Name Find(uint32_t number) {
    if (HWY_UNLIKELY(number - first_ >= count_)) {
      geometry_ = geometries_.Locate(number).geometry;
      first_ = geometries_.Number(geometry_, 0);
      count_ = static_cast<uint32_t>(geometries_[geometry_].triangle_count);
    }
    return {geometry_, number - first_};
  }

 private:
  const GeometryTable& geometries_;
  uint32_t geometry_ = 0, first_ = 0, count_ = 0;
};

class ReadAhead {
 public:
  ReadAhead(const GeometryTable& geometries, std::span<const uint32_t> order)
      : geometries_(geometries),
        order_(order),
        now_(geometries),
        near_(geometries),
        far_(geometries) {}

  /// The name of the next triangle.
  HWY_INLINE GeometryTable::Name Next() {
    if (next_ + kFar < order_.size()) {
      const GeometryTable::Name name = far_.Find(KeptOrder::NumberOf(order_[next_ + kFar]));
      if (geometries_.HasTriangles(name.geometry)) FetchIndices(geometries_, name);
    }
    if (next_ + kNear < order_.size()) {
      const GeometryTable::Name name = near_.Find(KeptOrder::NumberOf(order_[next_ + kNear]));
      if (geometries_.HasTriangles(name.geometry)) FetchCorners(geometries_, name);
    }
    return now_.Find(KeptOrder::NumberOf(order_[next_++]));
  }

 private:
  /// Triangles ahead of which indices are fetched, and vertices.
  static constexpr size_t kFar = 24, kNear = 12;

  const GeometryTable& geometries_;
  const std::span<const uint32_t> order_;
  size_t next_ = 0;
  NameFinder now_, near_, far_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_READ_AHEAD_INL_H_

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

class ReadAhead {
 public:
  ReadAhead(const GeometryTable& geometries, std::span<const uint32_t> order)
      : order_(order), now_(geometries), near_(geometries), far_(geometries) {}

  /// The name of the next triangle.
  HWY_INLINE GeometryTable::Name Next() {
    if (next_ + kFar < order_.size()) {
      const auto name = far_.Find(KeptOrder::NumberOf(order_[next_ + kFar]));
      far_.source().FetchIndices(name.primitive);
    }
    if (next_ + kNear < order_.size()) {
      const auto name = near_.Find(KeptOrder::NumberOf(order_[next_ + kNear]));
      near_.source().FetchVertices(name.primitive);
    }
    return now_.Find(KeptOrder::NumberOf(order_[next_++]));
  }
  /// Of the geometry of that triangle.
  const CornerSource& source() const { return now_.source(); }

 private:
  /// Triangles ahead of which indices are fetched, and vertices.
  static constexpr size_t kFar = 24, kNear = 12;

  const std::span<const uint32_t> order_;
  size_t next_ = 0;
  TriangleFinder now_, near_, far_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_READ_AHEAD_INL_H_

// Going through triangles in the kept order, which is not that of their meshes: what will be read
// of them is fetched some triangles ahead.

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

/// Names of triangles of which many that follow each other are of one mesh.
class NameFinder {
 public:
  explicit NameFinder(const MeshTable& meshes) : meshes_(meshes) {}

  HWY_INLINE MeshTable::Name Find(uint32_t number) {
    if (HWY_UNLIKELY(number - first_ >= count_)) {
      mesh_ = meshes_.Locate(number).mesh;
      first_ = meshes_.Number(mesh_, 0);
      count_ = static_cast<uint32_t>(meshes_[mesh_].triangle_count);
    }
    return {mesh_, number - first_};
  }

 private:
  const MeshTable& meshes_;
  uint32_t mesh_ = 0, first_ = 0, count_ = 0;
};

class ReadAhead {
 public:
  ReadAhead(const MeshTable& meshes, std::span<const uint32_t> order)
      : meshes_(meshes), order_(order), now_(meshes), near_(meshes), far_(meshes) {}

  /// The name of the next triangle.
  HWY_INLINE MeshTable::Name Next() {
    if (next_ + kFar < order_.size()) {
      const MeshTable::Name name = far_.Find(KeptOrder::NumberOf(order_[next_ + kFar]));
      if (meshes_.HasTriangles(name.mesh)) FetchIndices(meshes_, name);
    }
    if (next_ + kNear < order_.size()) {
      const MeshTable::Name name = near_.Find(KeptOrder::NumberOf(order_[next_ + kNear]));
      if (meshes_.HasTriangles(name.mesh)) FetchCorners(meshes_, name);
    }
    return now_.Find(KeptOrder::NumberOf(order_[next_++]));
  }

 private:
  /// Triangles ahead of which indices are fetched, and vertices.
  static constexpr size_t kFar = 24, kNear = 12;

  const MeshTable& meshes_;
  const std::span<const uint32_t> order_;
  size_t next_ = 0;
  NameFinder now_, near_, far_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_READ_AHEAD_INL_H_

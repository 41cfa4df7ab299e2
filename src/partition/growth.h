// Growth: where geometries have been attached behind those of the last commit, the old partition
// gets a subset more, of their triangles, and nothing that it has is split again.
//
// The new subset is split where rays come, as any other. A refit puts it among the others
// (insert_subset-inl.h), where it stays: so the more triangles have come the more volumes overlap,
// and a partition that has grown by half is made anew the next time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "geometry/geometry_table.h"
#include "partition/kept_partition.h"
#include "runtime/pages.h"
#include "runtime/tasks.h"

namespace dacrt {

namespace growth {

/// How many triangles may have come, as a part of those that a partition was made of. Made anew
/// each time that this many have come it costs, a triangle that comes, what three are split for.
/// Once they had come, in 500 meshes among 1,000 others of 288 triangles each, rays took no longer
/// than in a scene made anew; in 12 sheets across one of 288,800 triangles 1.15 times as long.
inline constexpr std::size_t Most(std::size_t made) { return made / 2; }

}  // namespace growth

/// What a partition will grow by. To make it changes nothing; to carry it out cannot fail.
class Growth {
 public:
  /// Of `kept`, which can grow so. The new triangles are listed on the threads of `tasks`. Throws
  /// std::bad_alloc.
  Growth(const KeptPartition& kept, const GeometryTable& now, std::size_t bytes, ListFunction list,
         TaskPool& tasks);

  /// Triangles that come and can be hit.
  std::size_t triangle_count() const { return listed_.count; }

  /// A copy of the partition with addresses enough, which grows in its stead; null if it has them.
  std::unique_ptr<KeptPartition> TakeCopy() { return std::move(copy_); }

  /// Of the partition, or of that copy.
  void CarryOut(KeptPartition& kept, const GeometryTable& now) noexcept {
    kept.Grow(now, listed_, numbers(), std::move(more_));
  }

 private:
  std::span<uint32_t> numbers() const {
    return {reinterpret_cast<uint32_t*>(memory_.data()), memory_.bytes() / sizeof(uint32_t)};
  }

  Pages memory_;  ///< the numbers of the new triangles
  ListedTriangles listed_;
  MemoryClaim more_;  ///< that the partition will have
  std::unique_ptr<KeptPartition> copy_;
};

}  // namespace dacrt

// Rent or buy: when a small subset gets nodes of least surface, and leaves that carry their
// geometry.
//
// When rays first come to a small subset its nodes are packed along a curve
// (pack_along_curve-inl.h) and its leaves gather their triangles from the mesh for each ray or list
// that comes: that costs next to nothing beforehand, and each ray pays rent. Once that has come to
// what better nodes and the copies of leaves cost, these are bought (buy_nodes-inl.h). So no subset
// costs more than twice what the best choice would have, had one known how many rays come: nothing
// but rent for fewer rays than that; for more, rent that costs as much as what is bought then.
// Karlin, Manasse, Rudolph, Sleator, "Competitive snoopy caching", Algorithmica 1988.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "geometry/wide_node.h"
#include "partition/kept_partition.h"

namespace dacrt::rent_or_buy {

/// Nanoseconds: what it costs to buy, a triangle, and the rent of a ray that comes. Measured on Zen
/// 5 with AVX-512: nodes 35 to 40, copies some 10; of rays that rent wherever they come, those of
/// the dragon and the kitchen, in calls of 65,536, pay 230 and 110 a subset, those of Sponza and a
/// hall, which come together, 30, single rays 70, and the few that come to places where no others
/// do, several hundred. The rent is taken to be high, since most scenes to which some rays come are
/// traced again.
inline constexpr uint32_t kPrice = 50, kRent = 400;

/// Subsets of up to so many triangles are not rented: what they cost is next to nothing.
inline constexpr uint32_t kFewTriangles = 512;

/// Rays that a subset of `triangles` is rented for.
constexpr uint32_t RaysFor(uint32_t triangles) {
  return triangles <= kFewTriangles ? 0 : 1 + triangles * kPrice / kRent;
}

/// Counts rays that come to a rented subset. True for whom it falls to to buy.
inline bool IsDue(Subset& subset, std::size_t rays) {
  const uint32_t most = RaysFor(subset.count);
  if (subset.rays.load(std::memory_order_relaxed) >= most) return false;  // another thread's
  const auto coming = static_cast<uint32_t>(std::min<std::size_t>(rays, most));
  const uint32_t before = subset.rays.fetch_add(coming, std::memory_order_relaxed);
  return before < most && coming >= most - before;
}

/// Gives the nodes back that were rented, once others have been bought and nobody is in them.
inline void GiveBackRented(KeptPartition& kept, Subset& subset) {
  // In this order: once it is bought nobody comes in any more.
  if (Subset::IsRented(subset.root) || subset.inside != 0) return;
  const uint64_t rented = subset.rented.exchange(0);
  if (rented != 0) kept.Free(NodeRun::Of(rented));
}

/// Rays in the rented nodes of a subset, which stay there meanwhile.
class Stay {
 public:
  Stay(KeptPartition& kept, Subset& subset) : kept_(kept), subset_(subset) {
    ++subset.inside;
    const uint32_t root = subset.root;
    if (Subset::IsRented(root)) root_ = ChildWord::Inner(Subset::NodeOf(root));
  }
  ~Stay() {
    if (--subset_.inside == 0) GiveBackRented(kept_, subset_);
  }
  Stay(const Stay&) = delete;
  Stay& operator=(const Stay&) = delete;

  /// The first of them; none if others have been bought.
  const std::optional<ChildWord>& root() const { return root_; }

 private:
  KeptPartition& kept_;
  Subset& subset_;
  std::optional<ChildWord> root_;
};

}  // namespace dacrt::rent_or_buy

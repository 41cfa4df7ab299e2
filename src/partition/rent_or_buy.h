// Rent or buy: when a small subset gets nodes of least surface, and when its leaves get copies of
// their geometry.
//
// When rays first come to a small subset its nodes are packed along a curve
// (pack_along_curve-inl.h) and its leaves gather their triangles from the mesh: that costs next to
// nothing beforehand, and rays pay rent, for nodes that are not the best and for bare leaves. Once
// the rent has come to what better ones cost, they are bought. So neither costs more than twice
// what the best choice would have, had one known how many rays come: nothing but rent for fewer
// rays than that; for more, rent that costs as much as what is bought then. Karlin, Manasse,
// Rudolph, Sleator, "Competitive snoopy caching", Algorithmica 1988.
//
// Where a program lets expect many rays (SceneOptions::splits_with_care) nodes are bought at once,
// over leaves that no later purchase can change: with AVX2, 64K rays a call, the kitchen's primary
// rays took 142 ns with what is rented, 132 with nodes alone and 122 with both; the first call of
// diffuse rays 149, 228 and 365 ms.
//
// For nodes rays are counted, and others are made over the same leaves (buy_nodes-inl.h). Of a bare
// leaf it is the list of rays that pays, or the group, or the ray alone, two thirds to four fifths
// of what a copy costs: so each leaf has its copy when rays come to it the second time
// (trace/give_leaves.h). With copies the first time Sponza's first call of 64K primary rays took
// 51 ms instead of 45, the dragon's 83 to 94 instead of 72. With copies once half as many rays had
// come to a subset as it has triangles, 64K in the dragon's next calls took 27 ms, primary, and 17,
// diffuse, instead of 12 and 6: where few rays come together no two are in a leaf.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "geometry/wide_node.h"
#include "partition/kept_partition.h"

namespace dacrt::rent_or_buy {

/// Nanoseconds: what it costs to buy, a triangle, and the rent of a ray that comes.
struct Offer {
  uint32_t price, rent;

  /// Rays for which a subset of so many triangles is rented.
  constexpr uint32_t RaysFor(uint32_t triangles) const { return 1 + triangles * price / rent; }
};

/// Measured on Zen 4 with AVX2: in streams of 65,536 rays packed nodes cost a ray some 8 in Sponza,
/// a hall and the dragon, and more where few come together. They are bought a little early, since
/// most scenes to which so many rays come are traced again.
inline constexpr Offer kNodes{24, 16};

/// One ray or a few pay as much as so many that come together: most of it is for the way in.
inline constexpr std::size_t kFewestRays = 8;

/// Counts rays that come to a rented subset. Whether nodes are due, which falls to the caller then,
/// and to nobody else.
inline bool CountRays(Subset& subset, std::size_t rays) {
  const uint32_t most = kNodes.RaysFor(subset.count);
  if (subset.rays.load(std::memory_order_relaxed) >= most) return false;
  const auto coming = static_cast<uint32_t>(std::clamp<std::size_t>(rays, kFewestRays, most));
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

// Rent or buy: when the leaves of a small subset get copies of their geometry, and when it gets
// nodes of least surface.
//
// When rays first come to a small subset its nodes are packed along a curve
// (pack_along_curve-inl.h) and its leaves gather their triangles from the mesh for each ray or list
// that comes: that costs next to nothing beforehand, and each ray pays rent, for bare leaves and
// for nodes that are not the best. Once the rent for one of them has come to what it costs, it is
// bought: leaves may have copies (trace/give_leaves.h), better nodes are made over the same leaves
// (buy_nodes-inl.h). So neither costs more than twice what the best choice would have, had one
// known how many rays come: nothing but rent for fewer rays than that; for more, rent that costs as
// much as what is bought then. Karlin, Manasse, Rudolph, Sleator, "Competitive snoopy caching",
// Algorithmica 1988.
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

/// Measured on Zen 4 with AVX2: in streams of 65,536 rays bare leaves cost a ray some 20 in Sponza,
/// a hall and the dragon, nodes 8, and more where few come together. Nodes are bought a little
/// early, since most scenes to which so many rays come are traced again.
inline constexpr Offer kCopies{10, 20}, kNodes{24, 16};

/// One ray or a few pay as much as so many that come together: most of it is for the way in.
inline constexpr std::size_t kFewestRays = 8;

/// What is due when rays come.
enum class Due { kNothing, kCopies, kNodes };

/// Counts rays that come to a rented subset. What is due falls to the caller, and to nobody else.
inline Due CountRays(Subset& subset, std::size_t rays) {
  const uint32_t most = kNodes.RaysFor(subset.count);
  if (subset.rays.load(std::memory_order_relaxed) >= most) return Due::kNothing;
  const auto coming = static_cast<uint32_t>(std::clamp<std::size_t>(rays, kFewestRays, most));
  const uint32_t before = subset.rays.fetch_add(coming, std::memory_order_relaxed);
  const auto passes = [&](uint32_t count) { return before < count && coming >= count - before; };
  if (passes(most)) return Due::kNodes;
  return passes(kCopies.RaysFor(subset.count)) ? Due::kCopies : Due::kNothing;
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

  /// Says that their leaves may have copies.
  void BuyCopies() const {
    if (root_) SetLeavesBare(root_->number());
  }

 private:
  void SetLeavesBare(uint32_t number) const {
    WideNode& node = kept_.node(number);
    node.SetLeavesBare();
    for (std::size_t k = 0; k < node.count; ++k) {
      if (node.Child(k).IsInner()) SetLeavesBare(node.Child(k).number());
    }
  }

  KeptPartition& kept_;
  Subset& subset_;
  std::optional<ChildWord> root_;
};

}  // namespace dacrt::rent_or_buy

#include "trace/give_leaves.h"

#include <hwy/cache_control.h>

#include <array>
#include <bit>
#include <cstring>
#include <span>

#include "leaf/leaf_block.h"
#include "leaf/make_leaf.h"
#include "runtime/ordinary_arithmetic.h"
#include "trace/policy.h"

namespace dacrt {
namespace {

/// A leaf that is to have a copy.
struct BareLeaf {
  std::size_t child;
  uint32_t first;  ///< place of its first item in the order
  LeafItems items;
};

/// Renews a copy. If the geometry has no room in it any more, the leaf goes without.
void Renew(KeptPartition& kept, WideNode& node, const BareLeaf& leaf, PrepareFunction prepare) {
  const uint32_t place = node.Child(leaf.child).block();
  const std::size_t room = kept.RoomOfLeaf(place);
  if (RenewLeaf(kept.geometries(), leaf.items, room, kept.leaf(place))) {
    auto& block = *reinterpret_cast<LeafBlock*>(kept.leaf(place));
    if (block.is_prepared) prepare(block, block.prepared());
    return;
  }
  kept.Lose(room);
  node.SetChild(leaf.child, ChildWord::Range(leaf.first));
}

/// Prepares the copy where there may be `prepared` ones and the scene is small.
void Copy(KeptPartition& kept, WideNode& node, const BareLeaf& leaf, bool prepared,
          PrepareFunction prepare) {
  alignas(LeafBlock) std::byte blocks[kMostLeafBytes];
  auto& block = *reinterpret_cast<LeafBlock*>(blocks);
  const GeometryTable& geometries = kept.geometries();
  const std::size_t shares = geometries.shares();
  const bool prepares = prepared && shares <= policy::kPreparedScene;
  const bool repeats =
      prepares || (shares > policy::kPreparedScene && shares <= policy::kRepeatingScene &&
                   kept.BytesReserved() >= policy::kRepeatingBytes * shares);
  uint32_t place;
  const auto make = [&](SharedVertices shared) {
    MadeLeaf made = MakeLeaf(geometries, leaf.items, leaf.first, shared, blocks);
    // The robust test wants the corners themselves.
    if (prepares && shared == SharedVertices::kRepeat && block.IsPlain() &&
        !geometries.shapes().robust()) {
      block.is_prepared = true;
      made.bytes = block.Bytes();
      prepare(block, block.prepared());
    }
    if (!made.is_whole || !kept.AllocateLeaf(made.bytes, place)) return false;
    std::memcpy(kept.leaf(place), blocks, made.bytes);
    return true;
  };
  if (!(repeats && make(SharedVertices::kRepeat)) && !make(SharedVertices::kFind)) return;
  node.SetChild(leaf.child, ChildWord::Block(place));
}

/// Finds the items of some leaves of a node. What they are made of is being fetched then.
std::span<BareLeaf> FindBareLeaves(KeptPartition& kept, const WideNode& node, uint32_t bare,
                                   std::span<BareLeaf, WideNode::kWidth> all) {
  std::size_t count = 0;
  for (uint32_t left = bare; left != 0; left &= left - 1) {
    const auto child = static_cast<std::size_t>(std::countr_zero(left));
    all[count++].child = child;
    if (node.Child(child).IsBlock()) hwy::Prefetch(kept.leaf(node.Child(child).block()));
  }
  const std::span<BareLeaf> leaves = all.first(count);
  const GeometryTable& geometries = kept.geometries();
  const uint32_t* const order = kept.triangles().data();
  for (BareLeaf& leaf : leaves) {
    leaf.first = kept.PlaceOfLeaf(node.Child(leaf.child));
    hwy::Prefetch(order + leaf.first);
  }
  for (BareLeaf& leaf : leaves) {
    leaf.items = FindItems(geometries, order, leaf.first, kLeafLanes);
    FetchIndices(geometries, leaf.items);
  }
  for (const BareLeaf& leaf : leaves) FetchVertices(geometries, leaf.items);
  return leaves;
}

}  // namespace

void GiveLeavesGeometry(const TraceTask& task, WideNode& node, uint32_t entered,
                        PrepareFunction prepare) {
  const uint32_t unvisited = node.UnvisitedLeaves(entered);
  if (unvisited != 0) {
    node.SetLeavesVisited(unvisited);
    entered &= ~unvisited;
    if (node.BareLeaves(entered) == 0) return;
  }
  while (!node.TryLockLeaves()) {
    // What others give is welcome, but only wrong copies must be waited for.
    if (node.StaleLeaves(entered) == 0) return;
    node.WaitForLeaves();
  }
  const OrdinaryArithmetic ordinary;  // prepared triangles are kept
  KeptPartition& kept = *task.scene.kept;
  const uint32_t bare = node.BareLeaves(entered);
  const uint32_t stale = node.StaleLeaves(bare);
  std::array<BareLeaf, WideNode::kWidth> room;
  for (const BareLeaf& leaf : FindBareLeaves(kept, node, kept.HasLeafRoom() ? bare : stale, room)) {
    if (stale >> leaf.child & 1) Renew(kept, node, leaf, prepare);
    if (node.Child(leaf.child).IsRange() && kept.HasLeafRoom()) {
      Copy(kept, node, leaf, task.scene.prepares_leaves, prepare);
    }
  }
  node.SetLeavesDone(bare);
  node.UnlockLeaves();
}

}  // namespace dacrt

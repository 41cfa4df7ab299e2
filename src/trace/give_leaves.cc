#include "trace/give_leaves.h"

#include <bit>
#include <cstring>

#include "leaf/leaf_block.h"
#include "leaf/make_leaf.h"
#include "trace/policy.h"

namespace dacrt {
namespace {

/// Renews a copy. If the geometry has no room in it any more, the leaf goes without.
void Renew(KeptPartition& kept, WideNode& node, std::size_t i) {
  const uint32_t place = node.Child(i).block();
  std::byte* const blocks = kept.leaf(place);
  const uint32_t first = reinterpret_cast<const LeafBlock*>(blocks)->first;
  const std::size_t room = kept.RoomOfLeaf(place);
  if (RenewLeaf(kept.meshes(), kept.triangles().data(), room, blocks)) return;
  kept.Lose(room);
  node.SetChild(i, ChildWord::Range(first));
}

void Copy(KeptPartition& kept, WideNode& node, std::size_t i) {
  alignas(LeafBlock) std::byte blocks[kMostLeafBytes];
  MadeLeaf leaf;
  uint32_t place;
  const auto make = [&](SharedVertices shared) {
    leaf = MakeLeaf(kept.meshes(), kept.triangles().data(), node.Child(i).range(), kLeafLanes,
                    shared, blocks);
    return leaf.is_whole && kept.AllocateLeaf(leaf.bytes, place);
  };
  const bool is_small = kept.triangle_count() <= policy::kSmallScene;
  if (!(is_small && make(SharedVertices::kRepeat)) && !make(SharedVertices::kFind)) return;
  std::memcpy(kept.leaf(place), blocks, leaf.bytes);
  node.SetChild(i, ChildWord::Block(place));
}

}  // namespace

void GiveLeavesGeometry(const TraceTask& task, WideNode& node, uint32_t entered) {
  while (!node.TryLockLeaves()) {
    // What others give is welcome, but only wrong copies must be waited for.
    if (node.StaleLeaves(entered) == 0) return;
    node.WaitForLeaves();
  }
  KeptPartition& kept = *task.scene.kept;
  for (uint32_t left = node.BareLeaves(entered); left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    if (node.StaleLeaves(1u << i) != 0) Renew(kept, node, i);
    if (node.Child(i).IsRange() && kept.HasLeafRoom()) Copy(kept, node, i);
    node.SetLeavesDone(1u << i);
  }
  node.UnlockLeaves();
}

}  // namespace dacrt

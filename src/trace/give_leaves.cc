#include "trace/give_leaves.h"

#include <cstring>

#include "leaf/leaf_block.h"
#include "leaf/make_leaf.h"

namespace dacrt {

void GiveLeavesGeometry(const TraceTask& task, WideNode& node) {
  if (!node.ClaimLeaves()) return;
  KeptPartition& kept = *task.scene.kept;
  for (std::size_t i = 0; i < node.count && kept.HasLeafRoom(); ++i) {
    const ChildWord child = node.Child(i);
    if (!child.IsRange()) continue;
    alignas(LeafBlock) std::byte blocks[kMostLeafBytes];
    const MadeLeaf leaf = MakeLeaf(task.scene.meshes, kept.triangles().data(), child.range(),
                                   kLeafLanes, SharedVertices::kFind, blocks);
    uint32_t place;
    if (!leaf.is_whole || !kept.AllocateLeaf(leaf.bytes, place)) continue;
    std::memcpy(kept.leaf(place), blocks, leaf.bytes);
    node.SetChild(i, ChildWord::Block(place));
  }
  node.SetLeavesDone();
}

}  // namespace dacrt

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
    const std::size_t bytes = MakeLeaf(task.scene.meshes, kept.triangles().data(), child.range(),
                                       kLeafLanes, blocks);
    uint32_t place;
    if (!kept.AllocateLeaf(bytes, place)) break;
    std::memcpy(kept.leaf(place), blocks, bytes);
    node.SetChild(i, ChildWord::Block(place));
  }
  node.SetLeavesDone();
}

}  // namespace dacrt

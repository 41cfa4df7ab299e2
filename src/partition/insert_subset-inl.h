// Where a new subset stands among those of an old partition: it is inserted from the top down,
// always into the volume that grows least.
// Goldsmith, Salmon, "Automatic creation of object hierarchies for ray tracing", IEEE Computer
// Graphics and Applications 7(5), 1987; here a free place is taken as soon as there is one, since
// all children of a node are tested at once.

#if defined(DACRT_PARTITION_INSERT_SUBSET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_INSERT_SUBSET_INL_H_
#undef DACRT_PARTITION_INSERT_SUBSET_INL_H_
#else
#define DACRT_PARTITION_INSERT_SUBSET_INL_H_
#endif

#include <cmath>

#include "geometry/wide_node-inl.h"
#include "partition/build_nodes-inl.h"
#include "partition/kept_partition.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Whether a subset has no others in it.
inline bool IsUnit(const Subset& subset) {
  return !Subset::HasNodes(subset.root) || subset.count <= SubsetScratch::kTriangles;
}

/// The child of a node whose volume, as it stands there, gets the least surface more if it is to
/// hold a box.
inline size_t LeastGrown(const WideNode& node, const Box& box) {
  const ChildPlanes planes(node, PlaneOffsets(0));
  HWY_ALIGN float face[2][3][WideNode::kWidth];
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t part = 0; part < kParts; ++part) {
      hn::Store(planes.near[part][axis], kEightTag, face[0][axis] + part * kPartLanes);
      hn::Store(planes.far[part][axis], kEightTag, face[1][axis] + part * kPartLanes);
    }
  }
  size_t least = 0;
  float least_growth = HUGE_VALF;
  for (size_t k = 0; k < node.count; ++k) {
    Box child{{face[0][0][k], face[0][1][k], face[0][2][k]},
              {face[1][0][k], face[1][1][k], face[1][2][k]}};
    const float before = child.HalfArea();
    child.Extend(box);
    const float growth = child.HalfArea() - before;
    if (growth >= least_growth) continue;
    least = k;
    least_growth = growth;
  }
  return least;
}

/// Puts a new subset below the root, among children that are subsets wherever they can be. There is
/// room for a node. Volumes are not renewed.
inline void InsertSubset(KeptPartition& kept, uint32_t number) {
  const auto stands_at = [&](uint32_t subset, uint32_t node, size_t k) {
    kept.subset(subset).parent = static_cast<uint32_t>(node * WideNode::kWidth + k);
  };
  Subset& added = kept.subset(number);
  for (uint32_t at = kept.subset(0).root;;) {
    WideNode& node = kept.node(at);
    if (node.count < WideNode::kWidth) {
      const size_t k = node.count++;
      node.SetChild(k, ChildWord::Subset(number));
      return stands_at(number, at, k);
    }
    const size_t k = LeastGrown(node, added.bounds());
    const ChildWord child = node.Child(k);
    if (child.IsInner()) {
      at = child.number();
    } else if (!IsUnit(kept.subset(child.number()))) {
      at = kept.subset(child.number()).root;
    } else {
      uint32_t pair, no_subset;
      [[maybe_unused]] const bool has_room = kept.Allocate(1, 0, pair, no_subset);
      DACRT_ASSERT(has_room);
      const ChildWord both[] = {child, ChildWord::Subset(number)};
      kept.node(pair).count = 2;
      kept.node(pair).is_exact = false;
      SetChildren(both, 2, kept.node(pair));
      node.SetChild(k, ChildWord::Inner(pair));
      stands_at(child.number(), pair, 0);
      return stands_at(number, pair, 1);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_INSERT_SUBSET_INL_H_

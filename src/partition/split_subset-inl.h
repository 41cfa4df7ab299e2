// Splitting a small subset of the kept partition, in the private memory of a thread.

#if defined(DACRT_PARTITION_SPLIT_SUBSET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#undef DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#else
#define DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#endif

#include "geometry/bound_triangle-inl.h"
#include "partition/build_nodes-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Makes the references of a subset of at most SubsetScratch::kTriangles triangles in
/// scratch.refs, in the kept order.
inline TriangleRange ReferSubset(KeptPartition& kept, const Subset& subset,
                                 SubsetScratch& scratch) {
  const auto triangles = kept.triangles().subspan(subset.begin, subset.count);
  for (size_t i = 0; i < triangles.size(); ++i) {
    const MeshTable::Name name = kept.meshes().Locate(triangles[i]);
    const auto [lower, upper] = BoundUsable(kept.meshes(), name);
    TriangleRef& ref = scratch.refs[i];
    lower.Store(ref.lower);
    upper.Store(ref.upper);
    ref.primitive = name.primitive;
    ref.mesh = name.mesh;
  }
  return MeasureTriangles(scratch.refs, 0, triangles.size());
}

/// Appends nodes whose numbers count from the first of them, and makes room for `subset_count`
/// subsets, whose numbers do, too. Returns the number of the first node, or Subset::kNoRoom.
inline uint32_t KeepNodes(KeptPartition& kept, std::span<const WideNode> nodes, size_t subset_count,
                          uint32_t& first_subset) {
  uint32_t first_node;
  if (!kept.Allocate(nodes.size(), subset_count, first_node, first_subset)) return Subset::kNoRoom;
  for (size_t i = 0; i < nodes.size(); ++i) {
    WideNode& node = kept.new_node(static_cast<uint32_t>(first_node + i));
    node = nodes[i];
    node.first_node += first_node;
    if (subset_count > 0) node.first_other += first_subset;
  }
  return first_node;
}

/// Leaves with a few triangles.
struct TriangleLeaves {
  // In a hall of 268,000 triangles partition and triangles took 9.0 bytes a triangle with leaves of
  // at most 8, 8.2 with 10, 7.4 with 12, and diffuse rays were as fast with each.
  static constexpr size_t kMost = 12;

  size_t most() const { return kMost; }
  bool IsLeaf(const WeighedRange& child) const { return child.weight <= kMost; }
  uint16_t Child(const WeighedRange& child) const {
    return WideNode::Child(child.weight, child.range.begin);
  }
  uint32_t first_other() const { return first_triangle; }

  uint32_t first_triangle;
};
static_assert(SubsetScratch::kTriangles <= size_t{1} << WideNode::kOffsetBits);

/// Returns the number of the root, or Subset::kNoRoom.
inline uint32_t SplitSmallSubset(KeptPartition& kept, const Subset& subset,
                                 SubsetScratch& scratch) {
  const WeighedRange all{ReferSubset(kept, subset, scratch), subset.count};
  TriangleLeaves leaves{subset.begin};
  const std::span<WideNode> nodes(scratch.nodes);
  const size_t count =
      NodeBuilder<Triangles, TriangleLeaves>(scratch.refs, leaves, nodes, scratch).Build(all);
  if (count == 0) return Subset::kNoRoom;
  uint32_t no_subset;
  const uint32_t root = KeepNodes(kept, nodes.first(count), 0, no_subset);
  if (root == Subset::kNoRoom) return root;
  const auto triangles = kept.triangles().subspan(subset.begin, subset.count);
  for (size_t i = 0; i < triangles.size(); ++i) {
    triangles[i] = kept.meshes().Number(scratch.refs[i].mesh, scratch.refs[i].primitive);
  }
  return root;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_SUBSET_INL_H_

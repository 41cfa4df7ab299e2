// A kept partition with all that it needs, and a walk over the whole of it that checks what a
// solver relies on.

#if defined(DACRT_UNIT_KEPT_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_UNIT_KEPT_WALK_INL_H_
#undef DACRT_UNIT_KEPT_WALK_INL_H_
#else
#define DACRT_UNIT_KEPT_WALK_INL_H_
#endif

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "partition/buy_nodes-inl.h"
#include "partition/kept_partition.h"
#include "partition/list_triangles-inl.h"
#include "partition/split_by_grid-inl.h"
#include "scene/scene_parts.h"
#include "unit_test.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Mesh;

constexpr size_t kPlenty = size_t{1} << 24;

/// How subsets get their nodes: for so few rays that they are rented, for so many that they are
/// bought at once, one after the other, or for many that are yet to come.
enum class Rays { kFew, kMany, kMore, kExpected };
constexpr Rays kAllRays[] = {Rays::kFew, Rays::kMany, Rays::kMore, Rays::kExpected};

/// A partition with all that it needs.
class Kept {
 public:
  /// `account` and `spare` as for KeptPartition.
  Kept(std::vector<Mesh> meshes, size_t budget, const MemoryAccount* account = nullptr,
       size_t threads = 1, SparePages* spare = nullptr)
      : meshes_(std::move(meshes)),
        table_(unit::Views(meshes_)),
        tasks_(threads),
        partition(table_, budget, kFirstLook, tasks_, account, spare),
        scratch(std::make_unique<SubsetScratch>()) {}

  /// Of geometries of every shape, whose memory is the caller's.
  Kept(std::span<const Geometry> geometries, size_t budget)
      : table_(geometries, std::vector<const SceneParts*>(geometries.size()), false),
        tasks_(1),
        partition(table_, budget, kFirstLook, tasks_),
        scratch(std::make_unique<SubsetScratch>()) {}

  uint32_t Root(uint32_t number) {
    const size_t count = rays == Rays::kMany ? UINT32_MAX : 0;
    if (rays == Rays::kExpected) partition.SplitWithCare();
    const auto no_memory = [] { FAIL() << "no memory"; };
    const uint32_t root = *RootOf(partition, number, count, scratch.get(), nullptr, no_memory);
    Subset& subset = partition.subset(number);
    if (rays == Rays::kMore && Subset::IsRented(root)) BuyNodes(partition, subset, *scratch);
    return subset.root;
  }
  const GeometryTable& table() const { return table_; }

 private:
  std::vector<Mesh> meshes_;
  GeometryTable table_;
  TaskPool tasks_;

 public:
  KeptPartition partition;
  std::unique_ptr<SubsetScratch> scratch;
  Rays rays = Rays::kFew;
};

/// What a partition is made of.
struct Counts {
  size_t nodes = 0;
  size_t children = 0;
  size_t leaves = 0;
  size_t subsets = 0;
  size_t without_room = 0;
  size_t rented = 0;
  size_t deepest = 0;
};

/// Walks the whole partition, splits what is not split, and checks what a solver relies on.
class Walker : public Counts {
 public:
  explicit Walker(Kept& kept) : kept_(kept) {}

  /// Whether every subset is expected to find room.
  void Walk(bool has_room) {
    has_room_ = has_room;
    Subset& all = kept_.partition.subset(0);
    ASSERT_EQ(all.begin, 0u);
    ASSERT_EQ(all.count, kept_.partition.triangle_count());
    WalkSubset(0, {}, 1);
    if (testing::Test::HasFatalFailure()) return;
    ExpectEachOnce();
    EXPECT_LE(kept_.partition.BytesUsed(), kept_.partition.BytesReserved());
  }

 private:
  struct Volume {
    float lower[3];
    float upper[3];
  };
  using Volumes = std::vector<Volume>;

  /// The nodes of a subset hold just its triangles.
  void WalkSubset(uint32_t number, const Volumes& above, size_t depth) {
    ++subsets;
    ASSERT_TRUE(seen_subsets_.insert(number).second) << "a subset with two parents";
    const uint32_t root = kept_.Root(number);
    Subset& subset = kept_.partition.subset(number);
    ASSERT_EQ(root, subset.root.load());
    ASSERT_EQ(root, kept_.Root(number)) << "what is split stays";
    const size_t begin = subset.begin, end = begin + subset.count;
    ASSERT_GE(subset.count, 1u);
    if (root == Subset::kNoRoom) {
      ASSERT_FALSE(has_room_);
      ++without_room;
      AddTriangles(begin, subset.count, above);
      return;
    }
    ASSERT_TRUE(Subset::HasNodes(root));
    is_rented_ = Subset::IsRented(root);
    if (is_rented_) ++rented;
    copies_wait_ = is_rented_ || (kept_.rays == Rays::kExpected &&
                                  HasCurve(subset.count, kept_.partition.leaf_lanes()));
    const size_t before = count_;
    WalkNode(Subset::NodeOf(root), above, depth, begin, end);
    ASSERT_EQ(count_ - before, subset.count);
  }

  void WalkNode(uint32_t number, const Volumes& above, size_t depth, size_t begin, size_t end) {
    ++nodes;
    ASSERT_LT(depth, 3000u);
    deepest = std::max(deepest, depth);
    ASSERT_TRUE(seen_nodes_.insert(number).second) << "a node with two parents";
    const WideNode& node = kept_.partition.node(number);
    ASSERT_GE(node.count, 1u);
    ASSERT_LE(node.count, WideNode::kWidth);
    children += node.count;
    const ChildPlanes planes(node, PlaneOffsets(0));
    HWY_ALIGN float lower[3][WideNode::kWidth], upper[3][WideNode::kWidth];
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t part = 0; part < kParts; ++part) {
        hn::Store(planes.near[part][axis], kEightTag, lower[axis] + part * kPartLanes);
        hn::Store(planes.far[part][axis], kEightTag, upper[axis] + part * kPartLanes);
      }
    }
    for (size_t i = 0; i < node.count; ++i) {
      Volumes volumes = above;
      Volume& own = volumes.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        own.lower[axis] = lower[axis][i];
        own.upper[axis] = upper[axis][i];
      }
      const ChildWord child = node.Child(i);
      if (child.IsLeaf()) {
        ASSERT_TRUE(node.bare >> i & 1) << "no rays have come";
        WalkLeaf(child, node.UnvisitedLeaves(1u << i) != 0, volumes, begin, end);
      } else if (child.IsSubset()) {
        Subset& subset = kept_.partition.subset(child.number());
        ASSERT_GE(subset.begin, begin);
        ASSERT_LE(subset.begin + subset.count, end);
        ASSERT_EQ(subset.parent, number * WideNode::kWidth + i);
        WalkSubset(child.number(), volumes, depth + 1);
        // Once there is nothing more to do for it, the way to it is the shorter one.
        const uint32_t root = subset.root;
        ASSERT_EQ(node.Child(i).bits(),
                  Subset::IsNode(root) ? ChildWord::Inner(root).bits() : child.bits());
      } else {
        const Subset* const subset = SubsetWithRoot(child.number());
        WalkNode(child.number(), volumes, depth + 1, subset ? subset->begin : begin,
                 subset ? subset->begin + subset->count : end);
      }
      if (testing::Test::HasFatalFailure()) return;
    }
  }

  /// The subset that a node is the first one of; null if it is in the middle of one.
  const Subset* SubsetWithRoot(uint32_t node) {
    for (const uint32_t number : seen_subsets_) {
      const Subset& subset = kept_.partition.subset(number);
      if (Subset::HasNodes(subset.root) && Subset::NodeOf(subset.root) == node) return &subset;
    }
    return nullptr;
  }

  /// Of one item or of at most kLeafLanes lanes, of which the last item is marked, and no other.
  void WalkLeaf(ChildWord leaf, bool is_unvisited, const Volumes& volumes, size_t begin,
                size_t end) {
    ++leaves;
    ASSERT_TRUE(leaf.IsRange());
    ASSERT_EQ(is_unvisited, copies_wait_) << "what is bought for rays gets copies at once";
    size_t place = leaf.range(), lanes = 0, count = 0;
    ASSERT_GE(place, begin);
    for (bool is_last = false; !is_last; ++place, ++count) {
      ASSERT_LT(place, end) << "no mark in the subset";
      const uint32_t entry = kept_.partition.view().order[place];
      is_last = (entry & KeptOrder::kLastOfLeaf) != 0;
      lanes += kept_.table().LanesOf(kept_.table().Locate(KeptOrder::NumberOf(entry)).geometry);
    }
    ASSERT_LE(lanes, kept_.partition.leaf_lanes());
    AddTriangles(leaf.range(), count, volumes);
  }

  /// Triangles of a leaf, which every volume on the way there must hold.
  void AddTriangles(size_t begin, size_t count, const Volumes& volumes) {
    for (size_t place = begin; place < begin + count; ++place) {
      const uint32_t number = KeptOrder::NumberOf(kept_.partition.view().order[place]);
      ++count_;
      ASSERT_TRUE(places_.insert(place).second) << "two leaves for a place";
      ASSERT_TRUE(numbers_.insert(number).second) << "two places for a triangle";
      TriangleRef ref;
      ASSERT_TRUE(BoundTriangle(kept_.table(), kept_.table().Locate(number), ref));
      const WideBox wide = Widen(ref.lower, ref.upper);
      for (const Volume& volume : volumes) {
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_LE(volume.lower[axis], hn::GetLane(wide.lower[axis]));
          ASSERT_GE(volume.upper[axis], hn::GetLane(wide.upper[axis]));
        }
      }
    }
  }

  void ExpectEachOnce() const {
    size_t expected = 0;
    const GeometryTable& meshes = kept_.table();
    for (uint32_t mesh = 0; mesh < meshes.size(); ++mesh) {
      for (uint32_t primitive = 0; primitive < meshes[mesh].triangle_count; ++primitive) {
        TriangleRef ref;
        const bool can_be_hit = BoundTriangle(kept_.table(), mesh, primitive, ref);
        expected += can_be_hit;
        ASSERT_EQ(numbers_.contains(kept_.table().Number(mesh, primitive)), can_be_hit);
      }
    }
    ASSERT_EQ(kept_.partition.triangle_count(), expected);
    ASSERT_EQ(count_, expected);
  }

  Kept& kept_;
  bool has_room_ = true;
  bool is_rented_ = false;    ///< the subset whose nodes are being walked
  bool copies_wait_ = false;  ///< of its leaves, for rays that come the second time
  size_t count_ = 0;
  std::set<uint32_t> seen_subsets_, seen_nodes_, numbers_;
  std::set<size_t> places_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard

// The leaf test of a group.

#if defined(DACRT_TRACE_GROUP_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_LEAF_INL_H_
#undef DACRT_TRACE_GROUP_LEAF_INL_H_
#else
#define DACRT_TRACE_GROUP_LEAF_INL_H_
#endif

#include "trace/group_facets-inl.h"
#include "trace/group_items-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery, size_t kMost>
class GroupLeafTest {
 public:
  explicit GroupLeafTest(RayGroup<kMost>& rays)
      : rays_(rays),
        task_(rays.task()),
        facets_(rays),
        items_(rays),
        tests_in_lanes_(task_.keeps_leaf_hits && !task_.scene.geometries.shapes().robust()),
        asks_filters_(task_.AsksFilters(kQuery)),
        asks_(asks_filters_ || task_.checks_masks) {}

  /// `enter` says of boxes which of them rays may enter (see enter_group-inl.h).
  template <class Enter>
  HWY_INLINE void Test(ChildWord leaf, LaneMask active, ListMemory memory, const Enter& enter) {
    const LeafBlock* const block = PlainBlock(task_.partition, leaf);
    if (HWY_LIKELY(tests_in_lanes_ && block && !asks_)) {
      return facets_.Test(leaf, *block, active, enter);
    }
    if (!tests_in_lanes_) {
      return rays_.TestRecords(active, [&](const RayNumber* list, size_t count) {
        TestLeaf<kQuery>(task_, leaf, list, count, memory);
      });
    }
    if (HWY_UNLIKELY(leaf.IsRange())) return TestRange(leaf, active, memory, enter);
    TestRow(leaf, task_.partition.FirstBlock(leaf), active, memory, enter);
  }

 private:
  /// A leaf that carries no geometry.
  template <class Enter>
  HWY_NOINLINE void TestRange(ChildWord range, LaneMask active, ListMemory memory,
                              const Enter& enter) {
    ForEachMadeLeaf(task_, range.range(), SIZE_MAX, [&](ChildWord leaf, const LeafBlock* first) {
      TestRow(leaf, first, active, memory, enter);
    });
  }

  /// The blocks of a leaf of any kind.
  template <class Enter>
  HWY_NOINLINE void TestRow(ChildWord leaf, const LeafBlock* block, LaneMask active,
                            ListMemory memory, const Enter& enter) {
    for (;; block = block->Next()) {
      if (HWY_LIKELY(!task_.checks_masks)) {
        TestInLanes(leaf, *block, active, memory, enter);
      } else if (IsStillFacets(*block) && block->geometry != LeafBlock::kSeveral) {
        const uint32_t mask = task_.scene.geometries[block->geometry].mask;
        const LaneMask accepting = rays_.lanes().Accepting(mask, active);
        if (accepting != 0) TestInLanes(leaf, *block, accepting, memory, enter);
      } else {
        TestByRecords(leaf, *block, active, memory);
      }
      if (block->is_last) return;
    }
  }

  /// A block against rays whose masks exclude nothing in it.
  template <class Enter>
  HWY_INLINE void TestInLanes(ChildWord leaf, const LeafBlock& block, LaneMask active,
                              ListMemory memory, const Enter& enter) {
    if (IsStillFacets(block) && !IsFiltered(block)) {
      facets_.Test(leaf, block, active, enter);
    } else if (IsStillFacets(block) && rays_.CanCall() && !HasGrids(block)) {
      facets_.TestFiltered(leaf, block, active, enter);
    } else if (!block.is_timed && block.kind == LeafKind::kUser && rays_.CanCall()) {
      items_.TestUserPrimitives(block, active);
    } else if (!block.is_timed && block.kind == LeafKind::kInstances) {
      items_.TestInstances(block, active, memory);
    } else {
      TestByRecords(leaf, block, active, memory);
    }
  }

  void TestByRecords(ChildWord leaf, const LeafBlock& block, LaneMask active, ListMemory memory) {
    rays_.TestRecords(active, [&](const RayNumber* list, size_t count) {
      TestBlock<kQuery>(task_, leaf, block, list, count, memory);
    });
  }

  static bool IsStillFacets(const LeafBlock& block) {
    return !block.is_timed && block.kind == LeafKind::kFacets;
  }

  bool HasGrids(const LeafBlock& block) const {
    return HasGeometry(block, [](const Geometry& g) { return g.shape == Shape::kGrids; });
  }

  /// Whether filter functions are to be asked about hits in a leaf.
  bool IsFiltered(const LeafBlock& block) const {
    return asks_filters_ && HasGeometry(block, [](const Geometry& g) {
             return static_cast<bool>(FilterOf<kQuery>(g));
           });
  }

  /// Whether something in a block is of a geometry that `is` so.
  template <class Is>
  HWY_NOINLINE bool HasGeometry(const LeafBlock& block, const Is& is) const {
    const size_t lanes = block.geometry == LeafBlock::kSeveral ? block.lanes : 1;
    for (size_t i = 0; i < lanes; ++i) {
      if (is(task_.scene.geometries.shapes()[GeometryOfLane(task_, block, i)])) return true;
    }
    return false;
  }

  RayGroup<kMost>& rays_;
  const TraceTask& task_;
  GroupFacets<kQuery, kMost> facets_;
  GroupItems<kQuery, kMost> items_;
  const bool tests_in_lanes_;
  const bool asks_filters_;
  const bool asks_;  ///< these, or masks
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_LEAF_INL_H_

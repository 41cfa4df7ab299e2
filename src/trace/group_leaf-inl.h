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
        robust_facets_(rays),
        items_(rays),
        is_robust_(task_.scene.geometries.shapes().robust()),
        tests_plainly_(task_.keeps_leaf_hits && !is_robust_),
        asks_filters_(task_.AsksFilters(kQuery)),
        asks_(asks_filters_ || task_.checks_masks) {}

  /// `enter` says of boxes which of them rays may enter (see enter_group-inl.h).
  template <class Enter>
  HWY_INLINE void Test(ChildWord leaf, LaneMask active, ListMemory memory, const Enter& enter) {
    const LeafBlock* const block = PlainBlock(task_.partition, leaf);
    if (HWY_LIKELY(tests_plainly_ && block && !asks_)) {
      return facets_.template Test<false>(leaf, *block, active, enter);
    }
    if (!task_.keeps_leaf_hits) {
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
      } else if (IsStillFacets(*block) || MayBlockByMoving(*block)) {
        const LaneMask accepting = Accepting(*block, active);
        if (accepting != 0) TestInLanes(leaf, *block, accepting, memory, enter);
      } else {
        TestByRecords(leaf, *block, active, memory);
      }
      if (block->is_last) return;
    }
  }

  /// Those of some lanes whose masks do not exclude all of a block; of several geometries it is
  /// asked what is met.
  HWY_INLINE LaneMask Accepting(const LeafBlock& block, LaneMask active) const {
    if (AsksMasksOfEach(task_, block)) return active;
    return rays_.lanes().Accepting(task_.scene.geometries[block.geometry].mask, active);
  }

  /// A block against rays whose masks do not exclude all of it.
  template <class Enter>
  HWY_INLINE void TestInLanes(ChildWord leaf, const LeafBlock& block, LaneMask active,
                              ListMemory memory, const Enter& enter) {
    if (IsStillFacets(block)) {
      TestFacets(leaf, block, active, memory, enter);
    } else if (MayBlockByMoving(block)) {
      WithFacets([&](auto& facets) HWY_ATTR { facets.BlockByMoving(block, active); });
    } else if (!block.is_timed && block.kind == LeafKind::kUser && rays_.CanCall()) {
      items_.TestUserPrimitives(block, active);
    } else if (!block.is_timed && block.kind == LeafKind::kInstances) {
      items_.TestInstances(block, active, memory);
    } else {
      TestByRecords(leaf, block, active, memory);
    }
  }

  template <class Enter>
  HWY_INLINE void TestFacets(ChildWord leaf, const LeafBlock& block, LaneMask active,
                             ListMemory memory, const Enter& enter) {
    const bool is_filtered = IsFiltered(block);
    if (is_filtered && (!rays_.CanCall() || HasGrids(block))) {
      return TestByRecords(leaf, block, active, memory);
    }
    WithFacets([&](auto& facets) HWY_ATTR {
      if (is_filtered || AsksMasksOfEach(task_, block)) {
        facets.template Test<true>(leaf, block, active, enter);
      } else {
        facets.template Test<false>(leaf, block, active, enter);
      }
    });
  }

  /// Calls `test` with the test of facets that the scene wants.
  template <class Test>
  HWY_INLINE void WithFacets(const Test& test) {
    if (HWY_UNLIKELY(is_robust_)) return test(robust_facets_);
    test(facets_);
  }

  void TestByRecords(ChildWord leaf, const LeafBlock& block, LaneMask active, ListMemory memory) {
    rays_.TestRecords(active, [&](const RayNumber* list, size_t count) {
      TestBlock<kQuery>(task_, leaf, block, list, count, memory);
    });
  }

  static bool IsStillFacets(const LeafBlock& block) {
    return !block.is_timed && block.kind == LeafKind::kFacets;
  }

  bool MayBlockByMoving(const LeafBlock& block) const {
    return kQuery == Query::kAny && block.kind == LeafKind::kMovingFacets && !IsFiltered(block);
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
  GroupFacets<kQuery, kMost, false> facets_;
  GroupFacets<kQuery, kMost, true> robust_facets_;
  GroupItems<kQuery, kMost> items_;
  const bool is_robust_;
  const bool tests_plainly_;
  const bool asks_filters_;
  const bool asks_;  ///< these, or masks
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_LEAF_INL_H_

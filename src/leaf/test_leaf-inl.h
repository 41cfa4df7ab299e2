// The leaf test: a list of rays against a leaf of any kind.

#if defined(DACRT_LEAF_TEST_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_TEST_LEAF_INL_H_
#undef DACRT_LEAF_TEST_LEAF_INL_H_
#else
#define DACRT_LEAF_TEST_LEAF_INL_H_
#endif

#include "leaf/facets-inl.h"
#include "leaf/instances-inl.h"
#include "leaf/points-inl.h"
#include "leaf/user.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery>
void TestUserPrimitives(const TraceTask& task, const LeafBlock& block, const RayNumber* list,
                        size_t count) {
  const size_t most = task.frame.options.callback_width;
  for (size_t lane = 0; lane < block.lanes; ++lane) {
    const GeometryTable::Name item = NameOfLane(task, block, lane);
    RayNumber rays[16];
    size_t entered = 0;
    const auto call = [&] {
      CallUserFunction(kQuery, task, item.geometry, item.primitive, {rays, entered});
      entered = 0;
    };
    ForEachEntering(task, block, lane, item, list, count, [&](RayNumber ray) {
      if (kQuery == Query::kAny && task.rays[ray].tfar < 0) return;
      rays[entered++] = ray;
      if (entered == most) call();
    });
    call();
  }
}

template <Query kQuery>
void TestInstances(const TraceTask& task, const LeafBlock& block, const RayNumber* list,
                   size_t count, ListMemory memory) {
  if (task.instance_memory.count == 0) return;  // There is one level of instances.
  DACRT_ASSERT(block.lanes == 1);
  if (HWY_LIKELY(!block.is_timed)) FetchScene(InstanceLeaf::In(block));
  InstanceRays<kQuery> entering(task, block, block.geometry, memory);
  ForEachEntering(task, block, 0, {block.geometry, 0}, list, count,
                  [&](RayNumber ray) { entering.Add(ray); });
  entering.Trace();
}

/// What is not a facet; apart, so that the common way stays short.
template <Query kQuery>
HWY_NOINLINE void TestOddBlock(const TraceTask& task, const LeafBlock& block, const RayNumber* list,
                               size_t count, ListMemory memory) {
  switch (block.kind) {
    case LeafKind::kUser:
      return TestUserPrimitives<kQuery>(task, block, list, count);
    case LeafKind::kInstances:
      return TestInstances<kQuery>(task, block, list, count, memory);
    default:
      return PointTest<kQuery>(task, block).Test(list, count);
  }
}

template <Query kQuery>
HWY_INLINE void TestBlock(const TraceTask& task, ChildWord leaf, const LeafBlock& block,
                          const RayNumber* list, size_t count, ListMemory memory) {
  if (HWY_UNLIKELY(block.kind > LeafKind::kMovingFacets)) {
    TestOddBlock<kQuery>(task, block, list, count, memory);
  } else if (HWY_UNLIKELY(task.scene.geometries.shapes().robust())) {
    FacetTest<kQuery, true>(task, leaf, block).Test(list, count);
  } else {
    FacetTest<kQuery, false>(task, leaf, block).Test(list, count);
  }
}

template <Query kQuery>
HWY_INLINE void TestBlocks(const TraceTask& task, ChildWord leaf, const LeafBlock* block,
                           const RayNumber* list, size_t count, ListMemory memory) {
  for (;; block = block->Next()) {
    TestBlock<kQuery>(task, leaf, *block, list, count, memory);
    if (HWY_LIKELY(block->is_last)) return;
  }
}

/// The same with room on the stack, and without an end before the last one.
template <class Body>
HWY_INLINE void ForEachMadeLeaf(const TraceTask& task, uint32_t first, size_t most,
                                const Body& body) {
  alignas(64) std::byte blocks[kMostLeafBytes];
  ForEachMadeLeaf(
      task.scene.geometries, task.partition.order, first, most, [&] { return blocks; },
      [&](ChildWord leaf, const LeafBlock* block) {
        body(leaf, block);
        return true;
      });
}

template <Query kQuery>
HWY_NOINLINE void TestRange(const TraceTask& task, uint32_t first, size_t most,
                            const RayNumber* list, size_t count, ListMemory memory) {
  ForEachMadeLeaf(task, first, most, [&](ChildWord leaf, const LeafBlock* block) {
    TestBlocks<kQuery>(task, leaf, block, list, count, memory);
  });
}

template <Query kQuery>
HWY_INLINE void TestLeaf(const TraceTask& task, ChildWord leaf, const RayNumber* list, size_t count,
                         ListMemory memory) {
  if (HWY_UNLIKELY(leaf.IsRange())) {
    return TestRange<kQuery>(task, leaf.range(), SIZE_MAX, list, count, memory);
  }
  TestBlocks<kQuery>(task, leaf, task.partition.FirstBlock(leaf), list, count, memory);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_TEST_LEAF_INL_H_

// Divide-and-conquer ray tracing over the kept partition, on lists of ray numbers: nothing is
// copied and nothing written back. All rays of a list run in the same octant of directions.
//
// Tsakok, "Faster incoherent rays: multi-BVH ray stream tracing", HPG 2009; Barringer,
// Akenine-Möller, "Dynamic ray stream traversal", ACM TOG 33(4), 2014; Fuetterling, Lojewski,
// Pfreundt, Hamann, Ebert, "Accelerated single ray tracing for wide vector units", HPG 2017. What
// is different here: a byte of masks a ray and node is all that is kept, and the order of the
// children is that of sample rays.

#if defined(DACRT_TRACE_TRACE_LIST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_LIST_INL_H_
#undef DACRT_TRACE_TRACE_LIST_INL_H_
#else
#define DACRT_TRACE_TRACE_LIST_INL_H_
#endif

#include "trace/order_children-inl.h"
#include "trace/ray_lists-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery>
class ListTracer {
 public:
  ListTracer(const TraceTask& task, uint32_t octant) : task_(task), offsets_(octant) {}

  void Trace(ChildWord child, const RayNumber* list, size_t count, ListMemory memory) const {
    if (child.IsLeaf()) {
      if (task_.statistics) {
        ++task_.statistics->direct_solves;
        task_.statistics->direct_rays += count;
      }
      return TestLeaf<kQuery>(task_, child, list, count, memory);
    }
    if (count <= policy::kFewRays || !HasRoom(memory, ListBytes(count))) {
      return OneTracer<kQuery>(task_).TraceAll(child, list, count, memory);
    }
    if (HWY_UNLIKELY(child.IsSubset())) {
      const auto opened = OpenSubset<kQuery>(
          task_, child.number(), list, count, memory, [&](const TraceTask& own, ChildWord root) {
            ListTracer(own, offsets_).Trace(root, list, count, memory);
          });
      if (!opened) return;
      child = *opened;
    }
    VisitNode(task_.partition.nodes[child.number()], list, count, memory);
  }

 private:
  ListTracer(const TraceTask& task, const PlaneOffsets& offsets) : task_(task), offsets_(offsets) {}

  void VisitNode(WideNode& node, const RayNumber* list, size_t count, ListMemory memory) const {
    if (task_.statistics) {
      ++task_.statistics->subproblems;
      task_.statistics->box_tests += count * node.count;
    }
    uint8_t* const masks = CutList<uint8_t>(memory, count + kListSlack);
    uint8_t order[WideNode::kWidth];
    uint32_t entered = EnterAll(node, list, count, masks, order) & node.UsedChildren();
    if (entered == 0) return;
    if (HWY_UNLIKELY(node.BareLeaves(entered)))
      GiveLeavesGeometry(task_, node, entered, PrepareFacets);
    ForEachLane(entered, [&](size_t i) { PrefetchChild(task_.partition, node.Child(i)); });
    for (const uint8_t i : order) {
      if (!(entered >> i & 1)) continue;
      ListMemory rest = memory;
      RayNumber* const filtered = CutList<RayNumber>(rest, count + kListSlack);
      const size_t rays = FilterList(list, masks, count, i, filtered);
      rest = memory;
      CutList<RayNumber>(rest, rays + kListSlack);
      Trace(node.Child(i), filtered, rays, rest);
    }
  }

  /// Writes for each ray which children it enters. Returns what any of them does, and the order in
  /// which the children are to be visited.
  HWY_INLINE uint32_t EnterAll(const WideNode& node, const RayNumber* HWY_RESTRICT list,
                               size_t count, uint8_t* HWY_RESTRICT masks,
                               uint8_t* HWY_RESTRICT order) const {
    const ChildPlanes planes(node, offsets_);
    const RayRecord* const rays = task_.rays;
    uint32_t any = 0;
    for (size_t i = 0; i < count; ++i) {
      hwy::Prefetch(rays + list[i + policy::kFetchAhead]);  // which may be beyond the end
      const RayRecord& ray = rays[list[i]];
      const uint32_t mask = EnterChildren(planes, SlabRay(ray), ray.tfar, [](size_t, EightPart) {});
      masks[i] = static_cast<uint8_t>(mask);
      any |= mask;
    }
    memset(masks + count, 0, kListSlack);
    // The nearest hit wants the nearest children first.
    const ChildOrder by = kQuery == Query::kAny ? task_.any_hit_order : ChildOrder::kNearestFirst;
    if (by == ChildOrder::kAsStored) {
      for (size_t i = 0; i < WideNode::kWidth; ++i) order[i] = static_cast<uint8_t>(i);
    } else {
      OrderChildren(planes, rays, list, count, order);
      if (by == ChildOrder::kFarthestFirst) std::reverse(order, order + WideNode::kWidth);
    }
    return any;
  }

  const TraceTask& task_;
  const PlaneOffsets offsets_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_LIST_INL_H_

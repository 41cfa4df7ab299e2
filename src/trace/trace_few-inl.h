// A few rays that go their own ways, some of them side by side: what one waits for, its node and
// what follows from it step by step, the others need not.

#if defined(DACRT_TRACE_TRACE_FEW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_FEW_INL_H_
#undef DACRT_TRACE_TRACE_FEW_INL_H_
#else
#define DACRT_TRACE_TRACE_FEW_INL_H_
#endif

#include <cstddef>
#include <new>

#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Where one of the rays is: at a node.
struct RayAtNode {
  HWY_INLINE RayAtNode(const RayRecord& record, RayNumber ray_number, ChildWord root)
      : ray(record),
        slab_ray(SlabRay(record)),
        offsets(kPlaneOffsets[record.Octant()]),
        number(ray_number),
        node(root) {}

  const RayRecord& ray;
  const LoneSlabRay slab_ray;
  const PlaneOffsets& offsets;
  const RayNumber number;
  ChildWord node;
  OpenChildren open;
};

/// The rays have so little in common that no processor foresees how many children of a node they
/// enter, and which is nearest: so no branch depends on it.
template <Query kQuery>
class FewTracer {
 public:
  explicit FewTracer(const TraceTask& task) : task_(task), one_(task) {}

  /// The rays list[0] to list[count - 1] of the task, from `root` on.
  void Trace(ChildWord root, const RayNumber* list, size_t count, ListMemory memory) const {
    if (root.IsInner() && count >= 4) return TraceAbreast<4>(root, list, count, memory);
    if (root.IsInner() && count >= 2) return TraceAbreast<2>(root, list, count, memory);
    one_.TraceAll(root, list, count, memory);
  }

 private:
  /// So many of the rays side by side, of which there are not less. When one is done the next takes
  /// its place; the last ones go on alone.
  template <size_t kWays>
  HWY_NOINLINE void TraceAbreast(ChildWord root, const RayNumber* list, size_t count,
                                 ListMemory memory) const {
    alignas(RayAtNode) std::byte room[kWays][sizeof(RayAtNode)];
    RayAtNode* ways[kWays];
    size_t next = 0;
    const auto begin = [&](size_t i) HWY_ATTR {
      ways[i] = new (room[i]) RayAtNode(task_.rays[list[next]], list[next], root);
      ++next;
    };
    for (size_t i = 0; i < kWays; ++i) begin(i);
    for (bool all = true; all;) {
      HWY_ALIGN float distances[kWays][WideNode::kWidth];
      uint32_t entered[kWays];
      // All before the first branch: no processor foresees where a ray goes, and what was begun
      // behind a wrong guess is lost.
      for (size_t i = 0; i < kWays; ++i) entered[i] = EnterNode(*ways[i], distances[i]);
      for (size_t i = 0; i < kWays; ++i) {
        if (HWY_LIKELY(GoOn(*ways[i], entered[i], distances[i], memory))) continue;
        if (next < count) {
          begin(i);
        } else {
          ways[i] = nullptr;
          all = false;
        }
      }
    }
    for (RayAtNode* const way : ways) {
      if (way) one_.Resume(way->node, way->open, way->number, memory);
    }
  }

  HWY_INLINE uint32_t EnterNode(const RayAtNode& way, float* distances) const {
    return EnterAlone<kQuery>(task_.partition.nodes[way.node.number()], way.slab_ray, way.offsets,
                              way.ray.tfar, distances);
  }

  /// To the next node of a ray, which enters some children of the one where it is; false if there
  /// is none.
  HWY_INLINE bool GoOn(RayAtNode& way, uint32_t entered, const float* distances,
                       ListMemory memory) const {
    const typename OneTracer<kQuery>::Host host{one_, way.number, memory};
    ChildWord& child = way.node;
    WideNode& node = task_.partition.nodes[child.number()];
    host.Enter(node, entered);
    OpenStack<> open(way.open);
    open.PushAll<kQuery>(node, entered, distances);
    if (!open.Next<kQuery>(way.ray.tfar, child)) return false;
    PrefetchChild(task_.partition, child);
    if (HWY_UNLIKELY(open.IsFull())) {
      one_.TraceEach(child, way.open, way.number, memory);
      return false;
    }
    while (!child.IsInner()) {
      const WalkStep step = host.Solve(child);
      if (step == WalkStep::kVisit) continue;
      if (step == WalkStep::kStop) return false;
      if (!open.Next<kQuery>(way.ray.tfar, child)) return false;
    }
    return true;
  }

  const TraceTask& task_;
  const OneTracer<kQuery> one_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_FEW_INL_H_

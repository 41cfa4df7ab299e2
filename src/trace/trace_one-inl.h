// A ray that goes its own way: the children of a node side by side in a vector, and a stack with
// distances.

#if defined(DACRT_TRACE_TRACE_ONE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_ONE_INL_H_
#undef DACRT_TRACE_TRACE_ONE_INL_H_
#else
#define DACRT_TRACE_TRACE_ONE_INL_H_
#endif

#include "trace/enter_children-inl.h"
#include "trace/give_leaves.h"
#include "trace/policy.h"
#include "trace/unsplit-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What a ray has still to look at, the nearest last.
struct OpenChildren {
  static constexpr size_t kMost = 256;

  float distance[kMost];
  uint32_t word[kMost];
  size_t count = 0;

  HWY_INLINE void Push(float d, ChildWord child) {
    distance[count] = d;
    word[count++] = child.bits();
  }

  /// Sorts those from `bottom` on, of which there are a few.
  HWY_INLINE void Sort(size_t bottom) {
    for (size_t i = bottom + 1; i < count; ++i) {
      const float d = distance[i];
      const uint32_t w = word[i];
      size_t place = i;
      for (; place > bottom && distance[place - 1] < d; --place) {
        distance[place] = distance[place - 1];
        word[place] = word[place - 1];
      }
      distance[place] = d;
      word[place] = w;
    }
  }
};

template <Query kQuery>
class OneTracer {
 public:
  explicit OneTracer(const TraceTask& task) : task_(task) {}

  void Trace(ChildWord child, RayNumber number, ListMemory memory) const {
    const RayRecord& ray = task_.rays[number];
    const SlabRay slab_ray(ray);
    const PlaneOffsets offsets(ray.Octant());
    OpenChildren open;
    for (;;) {
      if (HWY_LIKELY(child.IsInner())) {
        WideNode& node = task_.partition.nodes[child.number()];
        if (HWY_UNLIKELY(node.HasBareLeaves()) &&
            node.CountVisit() >= policy::kVisitsBeforeLeaves) {
          GiveLeavesGeometry(task_, node);
        }
        HWY_ALIGN float distance[WideNode::kWidth];
        uint32_t entered =
            EnterChildren(ChildPlanes(node, offsets), slab_ray, ray.tfar,
                          [&](size_t part, EightPart entry) HWY_ATTR {
                            hn::Store(entry, kEightTag, distance + part * kPartLanes);
                          }) &
            node.UsedChildren();
        if (entered != 0) {
          const size_t first = hwy::Num0BitsBelowLS1Bit_Nonzero32(entered);
          entered &= entered - 1;
          child = node.Child(first);
          if (entered == 0) continue;
          const size_t second = hwy::Num0BitsBelowLS1Bit_Nonzero32(entered);
          entered &= entered - 1;
          const ChildWord other = node.Child(second);
          PrefetchChild(task_.partition, other);
          PrefetchChild(task_.partition, child);
          if (HWY_LIKELY(entered == 0)) {
            const bool swap = distance[second] < distance[first];
            open.Push(distance[swap ? first : second], swap ? child : other);
            child = swap ? other : child;
            if (HWY_UNLIKELY(open.count + WideNode::kWidth > OpenChildren::kMost)) {
              return TraceDeep(open, child, number, memory);
            }
            continue;
          }
          const size_t bottom = open.count;
          open.Push(distance[first], child);
          open.Push(distance[second], other);
          ForEachLane(entered, [&](size_t i) {
            const ChildWord next = node.Child(i);
            PrefetchChild(task_.partition, next);
            open.Push(distance[i], next);
          });
          open.Sort(bottom);
          child = ChildWord(open.word[--open.count]);
          if (HWY_UNLIKELY(open.count + WideNode::kWidth > OpenChildren::kMost)) {
            return TraceDeep(open, child, number, memory);
          }
          continue;
        }
      } else if (HWY_LIKELY(child.IsLeaf())) {
        TestLeaf<kQuery>(task_, child, &number, 1, memory);
        if (kQuery == Query::kAny && ray.tfar < 0) return;
      } else {
        const auto trace = [&](const TraceTask& own, ChildWord root) {
          OneTracer(own).Trace(root, number, memory);
        };
        const auto opened =
            OpenSubset<kQuery>(task_, child.number(), &number, 1, memory, trace);
        if (opened) {
          child = *opened;
          continue;
        }
        if (kQuery == Query::kAny && ray.tfar < 0) return;
      }
      do {
        if (open.count == 0) return;
        --open.count;
      } while (!(open.distance[open.count] <= ray.tfar));
      child = ChildWord(open.word[open.count]);
    }
  }

 private:
  /// Where the stack is full, which no sound partition comes to: each open child on a stack of its
  /// own.
  HWY_NOINLINE void TraceDeep(OpenChildren& open, ChildWord child, RayNumber number,
                              ListMemory memory) const {
    const RayRecord& ray = task_.rays[number];
    for (;;) {
      Trace(child, number, memory);
      do {
        if (open.count == 0) return;
        --open.count;
      } while (!(open.distance[open.count] <= ray.tfar));
      child = ChildWord(open.word[open.count]);
    }
  }

  const TraceTask& task_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_ONE_INL_H_

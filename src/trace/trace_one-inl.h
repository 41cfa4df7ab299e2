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
  /// Where no order is asked for.
  HWY_INLINE void Push(ChildWord child) { word[count++] = child.bits(); }

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
  /// If `last` is not null, it gets the facets that a ray hits (see LastFacets).
  explicit OneTracer(const TraceTask& task, LastFacets* last = nullptr)
      : task_(task), last_(last) {}

  void Trace(ChildWord child, RayNumber number, ListMemory memory) const {
    const RayRecord& ray = task_.rays[number];
    const SlabRay slab_ray(ray);
    const PlaneOffsets& offsets = kPlaneOffsets[ray.Octant()];
    const bool keeps_leaf_hits = task_.keeps_leaf_hits && !task_.scene.meshes.shapes().robust();
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
                            if constexpr (kOrders) {
                              hn::Store(entry, kEightTag, distance + part * kPartLanes);
                            }
                          }) &
            node.UsedChildren();
        if (entered != 0) {
          child = NextChild(node, entered, distance, open);
          if (HWY_UNLIKELY(open.count + WideNode::kWidth > OpenChildren::kMost)) {
            return TraceDeep(open, child, number, memory);
          }
          continue;
        }
      } else if (HWY_LIKELY(child.IsLeaf())) {
        if (const LeafBlock* const block = PlainLeaf(child);
            HWY_LIKELY(block != nullptr && keeps_leaf_hits)) {
          FacetTest<kQuery, false>(task_, child, *block).TestOne(number, last_);
        } else {
          TestLeaf<kQuery>(task_, child, &number, 1, memory);
        }
        if (kQuery == Query::kAny && ray.tfar < 0) return;
      } else {
        const auto trace = [&](const TraceTask& own, ChildWord root) {
          OneTracer(own).Trace(root, number, memory);
        };
        const auto opened = OpenSubset<kQuery>(task_, child.number(), &number, 1, memory, trace);
        if (opened) {
          child = *opened;
          continue;
        }
        if (kQuery == Query::kAny && ray.tfar < 0) return;
      }
      if (!Pop(open, ray, child)) return;
    }
  }

 private:
  /// The nearest hit wants the nearest children first; to be blocked, any order will do.
  static constexpr bool kOrders = kQuery == Query::kClosest;

  /// The block of a leaf that holds nothing but still facets; null for others.
  HWY_INLINE const LeafBlock* PlainLeaf(ChildWord leaf) const {
    if (HWY_UNLIKELY(!leaf.IsBlock())) return nullptr;
    const auto* const block = reinterpret_cast<const LeafBlock*>(
        task_.partition.leaves + size_t{leaf.block()} * KeptPartition::kLeafUnit);
    return block->IsPlain() ? block : nullptr;
  }

  /// The child to go to of those that are entered, of which there is one; the others are open then.
  HWY_INLINE ChildWord NextChild(const WideNode& node, uint32_t entered, const float* distance,
                                 OpenChildren& open) const {
    const size_t first = hwy::Num0BitsBelowLS1Bit_Nonzero32(entered);
    const ChildWord child = node.Child(first);
    entered &= entered - 1;
    if (entered == 0) return child;
    PrefetchChild(task_.partition, child);
    if constexpr (!kOrders) {
      for (; entered != 0; entered &= entered - 1) {
        const ChildWord next = node.Child(hwy::Num0BitsBelowLS1Bit_Nonzero32(entered));
        PrefetchChild(task_.partition, next);
        open.Push(next);
      }
      return child;
    }
    const size_t second = hwy::Num0BitsBelowLS1Bit_Nonzero32(entered);
    const ChildWord other = node.Child(second);
    entered &= entered - 1;
    PrefetchChild(task_.partition, other);
    if (HWY_LIKELY(entered == 0)) {
      const bool swap = distance[second] < distance[first];
      open.Push(distance[swap ? first : second], swap ? child : other);
      return swap ? other : child;
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
    return ChildWord(open.word[--open.count]);
  }

  /// The next open child that may still hold what the ray looks for. False if there is none.
  static HWY_INLINE bool Pop(OpenChildren& open, const RayRecord& ray, ChildWord& child) {
    do {
      if (open.count == 0) return false;
      --open.count;
    } while (kOrders && !(open.distance[open.count] <= ray.tfar));
    child = ChildWord(open.word[open.count]);
    return true;
  }

  /// Where the stack is full, which no sound partition comes to: each open child on a stack of its
  /// own.
  HWY_NOINLINE void TraceDeep(OpenChildren& open, ChildWord child, RayNumber number,
                              ListMemory memory) const {
    const RayRecord& ray = task_.rays[number];
    for (;;) {
      Trace(child, number, memory);
      if (!Pop(open, ray, child)) return;
      if (kQuery == Query::kAny && ray.tfar < 0) return;
    }
  }

  const TraceTask& task_;
  LastFacets* const last_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_ONE_INL_H_

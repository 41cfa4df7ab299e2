// A ray that goes its own way: the children of a node side by side in a vector, and a stack with
// distances.

#if defined(DACRT_TRACE_TRACE_ONE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_ONE_INL_H_
#undef DACRT_TRACE_TRACE_ONE_INL_H_
#else
#define DACRT_TRACE_TRACE_ONE_INL_H_
#endif

#include "trace/child_guesses.h"
#include "trace/enter_children-inl.h"
#include "trace/give_leaves.h"
#include "trace/policy.h"
#include "trace/unsplit-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

// Where the children of a node are one vector, which can be sorted, and no checker of threads asks
// word by word who else may change it.
#undef DACRT_SORTS_CHILDREN
#if HWY_TARGET <= HWY_AVX2 && !HWY_IS_TSAN
#define DACRT_SORTS_CHILDREN 1
#else
#define DACRT_SORTS_CHILDREN 0
#endif

/// What a ray has still to look at, the nearest last.
struct OpenChildren {
  static constexpr size_t kMost = 256;

  float distance[kMost];
  uint32_t word[kMost];
  size_t count = 0;
};

/// The same while a ray is on its way. `Count` is where their number is meanwhile: size_t, in a
/// register, for a walk that calls nobody and goes on then, or a reference.
template <class Count = size_t&>
class OpenStack {
 public:
  HWY_INLINE explicit OpenStack(OpenChildren& open) : open_(open), count_(open.count) {}
  HWY_INLINE ~OpenStack() { open_.count = count_; }
  OpenStack(const OpenStack&) = delete;
  OpenStack& operator=(const OpenStack&) = delete;

  /// The one of the children that are entered, of which there is one, to which a ray goes first;
  /// the others are open then.
  template <Query kQuery>
  HWY_INLINE ChildWord Take(const PartitionView& partition, const WideNode& node, uint32_t entered,
                            const float* distances) {
    return kQuery == Query::kClosest ? Nearest(partition, node, entered, distances)
                                     : First(partition, node, entered);
  }

  /// All of the children that are entered, the nearest on top. No branch asks how many there are
  /// and which of them is nearest: that is hard to foresee.
  HWY_INLINE void PushAll(const WideNode& node, uint32_t entered, const float* distances) {
#if DACRT_SORTS_CHILDREN
    const auto order = PushSorted(entered, distances);
    // Other threads may change words meanwhile, each as a whole.
    const auto words = hn::LoadU(ChildTag(), node.child);
    hn::StoreU(hn::TableLookupLanes(words, hn::IndicesFromVec(ChildTag(), order)), ChildTag(),
               open_.word + count_);
    count_ += hwy::PopCount(entered);
#else
    const size_t bottom = count_;
    ForEachLane(entered, [&](size_t i) { Push(distances[i], node.Child(i)); });
    Sort(bottom);
#endif
  }

  /// Whether the children of another node may find no room.
  bool IsFull() const { return count_ + WideNode::kWidth > OpenChildren::kMost; }

  /// The next one that a ray which ends at `tfar` has to look at; false if there is none.
  template <Query kQuery>
  HWY_INLINE bool Next(float tfar, ChildWord& next) {
    // Where any hit will do there are no distances.
    do {
      if (count_ == 0) return false;
      --count_;
    } while (kQuery == Query::kClosest && !(open_.distance[count_] <= tfar));
    next = ChildWord(open_.word[count_]);
    return true;
  }

  HWY_INLINE void Push(float d, ChildWord child) {
    open_.distance[count_] = d;
    open_.word[count_++] = child.bits();
  }

 private:
  /// The nearest, of closest hits; of several the last one.
  HWY_INLINE ChildWord Nearest(const PartitionView& partition, const WideNode& node,
                               uint32_t entered, const float* distances) {
    const uint32_t all = entered;
    const size_t first = hwy::Num0BitsBelowLS1Bit_Nonzero32(entered);
    const ChildWord child = node.Child(first);
    entered &= entered - 1;
    if (entered == 0) return child;
    const size_t second = hwy::Num0BitsBelowLS1Bit_Nonzero32(entered);
    const ChildWord other = node.Child(second);
    entered &= entered - 1;
    if (HWY_LIKELY(entered == 0)) {
      const bool swap = distances[second] <= distances[first];
      const ChildWord far = swap ? child : other;
      PrefetchChild(partition, far);
      Push(distances[swap ? first : second], far);
      return swap ? other : child;
    }
    PrefetchChild(partition, other);
    PrefetchChild(partition, child);
    ForEachLane(entered, [&](size_t i) { PrefetchChild(partition, node.Child(i)); });
    PushAll(node, all, distances);
    return ChildWord(open_.word[--count_]);
  }

#if DACRT_SORTS_CHILDREN
  using ChildTag = hn::RebindToUnsigned<EightTag>;
  using ChildLanes = hn::Vec<ChildTag>;

  /// The numbers of the children that are entered in the first lanes, from the farthest to the
  /// nearest, and of equally near ones to the last; pushes their distances. By a network: Batcher,
  /// "Sorting networks and their applications", AFIPS 1968.
  HWY_INLINE ChildLanes PushSorted(uint32_t entered, const float* distances) {
    const hn::RebindToSigned<EightTag> d;
    // Distances compare as their bits do, of which the lowest make room for what the number of the
    // child is less than seven.
    const auto bits = hn::BitCast(d, hn::Load(kEightTag, distances));
    const auto number = hn::Set(d, 7);
    auto keys = hn::IfThenElse(hn::RebindMask(d, MaskOf(kEightTag, entered)),
                               hn::Or(hn::AndNot(number, bits), hn::Xor(hn::Iota(d, 0), number)),
                               hn::Set(d, -1));
    const auto sort_pairs = [&](auto with) HWY_ATTR {
      keys = hn::OddEven(hn::Min(keys, with), hn::Max(keys, with));
    };
    const auto sort_fours = [&](auto with) HWY_ATTR {
      const hn::Repartition<int64_t, EightTag> d2;
      keys = hn::BitCast(d, hn::OddEven(hn::BitCast(d2, hn::Min(keys, with)),
                                        hn::BitCast(d2, hn::Max(keys, with))));
    };
    sort_pairs(hn::Shuffle2301(keys));
    sort_fours(hn::Shuffle0123(keys));
    sort_pairs(hn::Shuffle2301(keys));
    const auto reversed = hn::Reverse(d, keys);
    keys = hn::ConcatUpperLower(d, hn::Min(keys, reversed), hn::Max(keys, reversed));
    sort_fours(hn::Shuffle1032(keys));
    sort_pairs(hn::Shuffle2301(keys));
    hn::StoreU(hn::BitCast(kEightTag, hn::AndNot(number, keys)), kEightTag,
               open_.distance + count_);
    return hn::BitCast(ChildTag(), hn::AndNot(keys, number));
  }
#endif

  /// The first as they are stored, of any hits.
  HWY_INLINE ChildWord First(const PartitionView& partition, const WideNode& node,
                             uint32_t entered) {
    for (uint32_t rest = entered & (entered - 1); rest != 0;) {
      const size_t last = 31 - hwy::Num0BitsAboveMS1Bit_Nonzero32(rest);
      const ChildWord child = node.Child(last);
      rest ^= 1u << last;
      PrefetchChild(partition, child);
      open_.word[count_++] = child.bits();
    }
    // Most often it is the first of all, where the processor is before it knows which are entered.
    if (entered & 1) return ByBranch(node.Child(0));
    return node.Child(hwy::Num0BitsBelowLS1Bit_Nonzero32(entered));
  }

  /// Sorts those from `bottom` on, of which there are a few.
  HWY_INLINE void Sort(size_t bottom) {
    for (size_t i = bottom + 1; i < count_; ++i) {
      const float d = open_.distance[i];
      const uint32_t w = open_.word[i];
      size_t place = i;
      for (; place > bottom && open_.distance[place - 1] < d; --place) {
        open_.distance[place] = open_.distance[place - 1];
        open_.word[place] = open_.word[place - 1];
      }
      open_.distance[place] = d;
      open_.word[place] = w;
    }
  }

  OpenChildren& open_;
  Count count_;
};

/// The block of a leaf that holds still facets and nothing else, as most do; else null.
HWY_INLINE const LeafBlock* PlainBlock(const PartitionView& partition, ChildWord leaf) {
  if (HWY_UNLIKELY(!leaf.IsBlock())) return nullptr;
  const LeafBlock* const block = partition.FirstBlock(leaf);
  return HWY_LIKELY(block->IsPlain()) ? block : nullptr;
}

/// The children of a node that a ray enters which goes its own way, a bit each, and, of closest
/// hits, where: the nearest hit wants the nearest children first; to be blocked, any order will do.
template <Query kQuery>
HWY_INLINE uint32_t EnterAlone(const WideNode& node, const LoneSlabRay& ray,
                               const PlaneOffsets& offsets, float tfar, float* distances) {
  const auto store = [&](size_t part, EightPart entry) HWY_ATTR {
    if constexpr (kQuery == Query::kClosest) {
      hn::Store(entry, kEightTag, distances + part * kPartLanes);
    }
  };
  return ray.Enter(node, offsets, tfar, store) & node.UsedChildren();
}

/// What comes of a leaf or a subset.
enum class WalkStep {
  kNext,   ///< the next open child
  kVisit,  ///< the node that stands in its place now
  kStop,   ///< the ray looks for nothing more
  kLeave,  ///< somebody else goes on from here
};

/// Takes one ray through nodes, from `from` on, until nothing is open. `host` has
///   bool Enter(WideNode&, uint32_t entered)   before children of a node are visited; false: leave
///   WalkStep Solve(ChildWord&)                a child that is not a node
///   OpenCount                                 see OpenStack
/// False if the host has left; `from` and `open_children` then say where.
template <Query kQuery, class Host>
HWY_INLINE bool WalkOne(const PartitionView& partition, const RayRecord& ray, ChildWord& from,
                        OpenChildren& open_children, const Host& host) {
  OpenStack<typename Host::OpenCount> open(open_children);
  ChildWord child = from;
  const auto leave = [&]() HWY_ATTR {
    from = child;
    return false;
  };
  const LoneSlabRay slab_ray{SlabRay(ray)};
  const PlaneOffsets& offsets = kPlaneOffsets[ray.Octant()];
  ChildGuesses& guesses = ChildGuesses::OfThisStack();
  for (;;) {
    if (HWY_LIKELY(child.IsInner())) {
      const uint32_t number = child.number();
      WideNode& node = partition.nodes[number];
      HWY_ALIGN float distances[WideNode::kWidth];
      const uint32_t entered = EnterAlone<kQuery>(node, slab_ray, offsets, ray.tfar, distances);
      if (entered != 0) {
        if (HWY_UNLIKELY(!host.Enter(node, entered))) return leave();
        child = open.template Take<kQuery>(partition, node, entered, distances);
        // Of any hits the first one is a guess as good (see OpenStack::First).
        if (kQuery == Query::kClosest || !(entered & 1)) child = guesses.Take(number, child);
        if (HWY_UNLIKELY(open.IsFull())) return leave();
        continue;
      }
    } else {
      const WalkStep step = host.Solve(child);
      if (step == WalkStep::kVisit) continue;
      if (HWY_UNLIKELY(step == WalkStep::kLeave)) return leave();
      if (step == WalkStep::kStop) return true;
    }
    if (!open.template Next<kQuery>(ray.tfar, child)) return true;
  }
}

template <Query kQuery>
class OneTracer {
 public:
  explicit OneTracer(const TraceTask& task)
      : task_(task),
        tests_plainly_(task.keeps_leaf_hits && !task.scene.geometries.shapes().robust()) {}

  void Trace(ChildWord child, RayNumber number, ListMemory memory) const {
    OpenChildren open;
    Resume(child, open, number, memory);
  }

  /// The rays list[0] to list[count - 1], one after the other.
  void TraceAll(ChildWord child, const RayNumber* list, size_t count, ListMemory memory) const {
    for (size_t i = 0; i < count; ++i) Trace(child, list[i], memory);
  }

  /// Goes on where others have left.
  void Resume(ChildWord child, OpenChildren& open, RayNumber number, ListMemory memory) const {
    const Host host{*this, number, memory};
    if (HWY_LIKELY(WalkOne<kQuery>(task_.partition, task_.rays[number], child, open, host))) return;
    TraceEach(child, open, number, memory);
  }

 private:
  /// What a walk of one of the rays asks.
  struct Host {
    using OpenCount = size_t&;

    HWY_INLINE bool Enter(WideNode& node, uint32_t entered) const {
      if (HWY_UNLIKELY(node.BareLeaves(entered))) {
        GiveLeavesGeometry(tracer.task_, node, entered, PrepareFacets);
      }
      return true;
    }

    HWY_INLINE WalkStep Solve(ChildWord& child) const {
      const TraceTask& task = tracer.task_;
      const LeafBlock* const block = PlainBlock(task.partition, child);
      if (HWY_LIKELY(block != nullptr && tracer.tests_plainly_)) {
        FacetTest<kQuery, false>(task, child, *block).TestOne(number);
      } else if (HWY_LIKELY(child.IsLeaf())) {
        TestLeaf<kQuery>(task, child, &number, 1, memory);
      } else {
        const auto trace = [&](const TraceTask& own, ChildWord root) {
          OneTracer(own).Trace(root, number, memory);
        };
        const auto opened = OpenSubset<kQuery>(task, child.number(), &number, 1, memory, trace);
        if (opened) {
          child = *opened;
          return WalkStep::kVisit;
        }
      }
      return kQuery == Query::kAny && task.rays[number].tfar < 0 ? WalkStep::kStop
                                                                 : WalkStep::kNext;
    }

    const OneTracer& tracer;
    const RayNumber number;
    const ListMemory memory;
  };

  /// A full stack, which no sound partition comes to: `child` and each open one on one of its own.
  HWY_NOINLINE void TraceEach(ChildWord child, OpenChildren& open, RayNumber number,
                              ListMemory memory) const {
    OpenStack<>(open).Push(-1, child);
    for (size_t i = open.count; i-- > 0;) {
      if (kQuery == Query::kAny && task_.rays[number].tfar < 0) return;
      if (kQuery == Query::kAny || open.distance[i] <= task_.rays[number].tfar) {
        Trace(ChildWord(open.word[i]), number, memory);
      }
    }
  }

  const TraceTask& task_;
  const bool tests_plainly_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_ONE_INL_H_

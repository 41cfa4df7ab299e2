// A call of one ray. There is no task, because to describe the call would cost as much as to answer
// it: not before the ray comes to what only a task can be asked about.

#if defined(DACRT_TRACE_TRACE_LONE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_LONE_INL_H_
#undef DACRT_TRACE_TRACE_LONE_INL_H_
#else
#define DACRT_TRACE_TRACE_LONE_INL_H_
#endif

#include <type_traits>

#include "leaf/user.h"
#include "trace/ask_last-inl.h"
#include "trace/last_blocker.h"
#include "trace/lone_ray-inl.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery, bool kRobust>
class LoneTracer;

/// Traces the ray of a call through a scene, that of the call or one in an instance.
template <Query kQuery>
HWY_INLINE void TraceLone(LoneCall& call, const SceneParts& scene, uint32_t instance_id,
                          RayRecord& ray) {
  if (HWY_UNLIKELY(scene.geometries.shapes().robust())) {
    LoneTracer<kQuery, true>(call, scene, instance_id, ray).TraceApart();
  } else {
    LoneTracer<kQuery, false>(call, scene, instance_id, ray).Trace();
  }
}
template <Query kQuery>
HWY_NOINLINE void TraceLoneInInstance(LoneCall& call, const SceneParts& scene, uint32_t instance_id,
                                      RayRecord& ray) {
  TraceLone<kQuery>(call, scene, instance_id, ray);
}

template <Query kQuery, bool kRobust>
class LoneTracer : LoneRay<kQuery> {
 public:
  LoneTracer(LoneCall& call, const SceneParts& scene, uint32_t instance_id, RayRecord& ray)
      : LoneRay<kQuery>(call, scene, instance_id, ray) {}

  HWY_INLINE void Trace() {
    // Packets that callbacks see may be of more than one lane.
    const bool calls_back_alone = !scene_.has_callbacks || call_.options.callback_width == 1;
    if (HWY_UNLIKELY(!scene_.kept || !calls_back_alone)) return TraceAsTask();
    const bool has_filters = scene_.geometries.shapes().has_filters(kQuery);
    if (has_filters || call_.checks_masks) return has_filters ? TraceAsking() : TraceMasked();
    Trace<Asks::kNobody>();
  }
  HWY_NOINLINE void TraceApart() { Trace(); }

 private:
  using Ray = LoneRay<kQuery>;
  using Ray::Accepts, Ray::Block, Ray::PassesFilter, Ray::TakeAsking;
  using Ray::call_, Ray::scene_, Ray::partition_, Ray::instance_id_, Ray::ray_, Ray::asks_filters_;

  /// Where a ray meets triangles, who decides whether it has hit one: masks, filter functions and
  /// names are asked where there are such.
  enum class Asks {
    kNobody,  ///< its distance and its own box, and where these are not enough, others
    kMasks,   ///< the same, but only of triangles that its mask accepts
    kOthers,  ///< others, to whom the walk leaves it
    kAtOnce,  ///< it is asked here
  };

  template <Asks kAsks>
  struct Host {
    // Shorter vectors leave closest hits no register for it.
    using OpenCount = std::conditional_t<kQuery == Query::kAny || kParts == 1, size_t, size_t&>;

    HWY_INLINE bool Enter(const WideNode& node, uint32_t entered) const {
      return node.BareLeaves(entered) == 0;
    }
    HWY_INLINE WalkStep Solve(ChildWord child) const { return tracer.template Test<kAsks>(child); }

    LoneTracer& tracer;
  };

  HWY_NOINLINE void TraceMasked() { Trace<Asks::kMasks>(); }
  HWY_INLINE void TraceAsking() {
    if constexpr (kQuery == Query::kClosest) {
      if (scene_.closest_filters_may_wait && !call_.in_instance) {
        call_.filter_answers = &FilterAnswers::Of(scene_.kept->edition());
        if (call_.filter_answers->AcceptMost()) return TraceAskingLast();
      }
    }
    TraceAskingOthers();
  }
  HWY_NOINLINE void TraceAskingOthers() { Trace<Asks::kOthers>(); }

  /// Filter functions are asked about the hit that the ray has in the end (see ask_last-inl.h).
  HWY_NOINLINE void TraceAskingLast() {
    asks_filters_ = false;
    if (HWY_UNLIKELY(call_.checks_masks)) {
      Trace<Asks::kMasks>();
    } else {
      Trace<Asks::kNobody>();
    }
    asks_filters_ = true;
    if (!(ray_.state & RayRecord::kHasHit)) return;
    const uint32_t geometry = call_.hit.geometry();
    const Callback& filter = FilterOf<kQuery>(scene_.geometries.shapes()[geometry]);
    if (!filter) return;
    const FullHit shown = call_.hit.Get();
    FullHit hit = shown;
    const bool is_accepted = PassesFilter(filter, hit);
    if (HWY_LIKELY(is_accepted && IsSame(hit, shown))) return;
    // One that was moved away gives way to what is nearer now.
    const bool is_final = is_accepted && hit.t <= shown.t;
    if (!is_final) {
      LoadRecord(static_cast<const float*>(call_.packet.values), call_.packet.has_masks, ray_);
    }
    if (is_accepted) {
      SetHit(ray_, hit.t, 0, geometry);
      call_.hit.Set(hit, geometry);
    }
    if (is_final) return;
    call_.asked = &shown;
    TraceAskingOthers();
    call_.asked = nullptr;
  }

  template <Asks kAsks>
  HWY_INLINE void Trace() {
    constexpr bool kRemembersBlocker = kQuery == Query::kAny && kAsks != Asks::kOthers;
    // To walk through a small scene costs no more than the leaf.
    if (kRemembersBlocker && !scene_.is_small && IsBlockedAgain<kAsks>()) return;
    OpenChildren open;
    ChildWord child = scene_.kept->root();
    // A walk that calls other functions and goes on then would have no registers left: so it ends
    // where there is something to ask, and begins anew behind it.
    do {
      const Host<kAsks> host{*this};
      if (HWY_LIKELY(WalkOne<kQuery>(partition_, ray_, child, open, host))) break;
    } while (Ask(child, open));
  }

  template <Asks kAsks>
  HWY_INLINE WalkStep Test(ChildWord leaf) {
    const LeafBlock* const block = PlainBlock(partition_, leaf);
    if (HWY_UNLIKELY(block == nullptr)) return WalkStep::kLeave;
    if (kAsks != Asks::kNobody && IsExcluded(*block)) return WalkStep::kNext;
    const WalkStep step = TestFacets<kAsks>(*block);
    if (kQuery == Query::kAny && step == WalkStep::kStop) {
      LastBlocker::OfThisStack().Remember(scene_.kept->edition(), leaf);
    }
    return step;
  }

  /// Whether the leaf in which a ray was blocked just before blocks this one, too.
  template <Asks kAsks>
  HWY_INLINE bool IsBlockedAgain() {
    LastBlocker& last = LastBlocker::OfThisStack();
    const std::optional<ChildWord> leaf = last.In(scene_.kept->edition());
    if (HWY_LIKELY(!leaf)) return false;
    if (TestFacets<kAsks>(*partition_.FirstBlock(*leaf)) == WalkStep::kStop) return true;
    last.Forget();
    return false;
  }

  /// Solves what the walk has left, be it that there is something to ask or another kind of leaf,
  /// and such leaves that come next. Then `child` is the next open one; false if there is none.
  HWY_NOINLINE bool Ask(ChildWord& child, OpenChildren& open) {
    do {
      const WalkStep step = AskLeaf(child);
      if (step == WalkStep::kStop) return false;
      if (step == WalkStep::kLeave) {
        ResumeAsTask(child, open);
        return false;
      }
      if (!OpenStack<>(open).Next<kQuery>(ray_.tfar, child)) return false;
    } while (child.IsRange() || (child.IsBlock() && !partition_.FirstBlock(child)->IsPlain()));
    return true;
  }

  template <Asks kAsks>
  HWY_INLINE WalkStep TestFacets(const LeafBlock& block) {
    switch (LayoutOf(block)) {
      case CornerLayout::kFew:
        return TestFacets<kAsks, CornerLayout::kFew>(block);
      case CornerLayout::kPrepared:
        // The robust test wants the corners themselves.
        if constexpr (!kRobust) return TestFacets<kAsks, CornerLayout::kPrepared>(block);
        [[fallthrough]];
      case CornerLayout::kByLane:
        return TestFacets<kAsks, CornerLayout::kByLane>(block);
      default:
        return TestFacets<kAsks, CornerLayout::kMany>(block);
    }
  }

  template <Asks kAsks, CornerLayout kLayout>
  HWY_INLINE WalkStep TestFacets(const LeafBlock& block) {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) break;
      const LeafCorners<kLayout> corners{block, part};
      const WalkStep step = TestPart<kAsks>(block, part, corners.Triangles(), corners.Again());
      if (step != WalkStep::kNext) return step;
    }
    return WalkStep::kNext;
  }

  HWY_NOINLINE WalkStep TestMovingFacets(const LeafBlock& block) {
    const std::optional<Moment> moment =
        scene_.geometries.shapes().MomentAt(block.geometry, ray_.time);
    if (!moment) return WalkStep::kNext;
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) break;
      const CornerLanes corners = CornersAt(block, part, *moment);
      const WalkStep step = TestPart<Asks::kAtOnce>(block, part, corners.Triangles(), corners);
      if (step != WalkStep::kNext) return step;
    }
    return WalkStep::kNext;
  }

  HWY_NOINLINE WalkStep TestPoints(const LeafBlock& block) {
    WalkStep step = WalkStep::kNext;
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) break;
      CrossPoints(block.kind, PointPart(block, part), SpreadRay{ray_},
                  [&](const FacetCrossing& crossing, EightPart keys, const EightPart* ng) HWY_ATTR {
                    if (step == WalkStep::kStop) return;
                    call_.candidates.Keep(scene_, instance_id_, block, part, crossing, keys, ng);
                    step = TakeAsking();
                  });
      if (step == WalkStep::kStop) break;
    }
    return step;
  }

  template <Asks kAsks, class Corners>
  HWY_INLINE WalkStep TestPart(const LeafBlock& block, size_t part,
                               const TestTrianglesOf<EightPart>& triangles,
                               const Corners& corners) {
    FacetCrossing crossing = CrossFacets<kRobust>(SpreadRay{ray_}, triangles, corners);
    if (HWY_LIKELY(crossing.lanes == 0)) return WalkStep::kNext;
    if constexpr (kAsks == Asks::kMasks) {
      crossing.lanes = LanesOfMask(scene_.geometries, partition_.order, block, part * kPartLanes,
                                   ray_.mask, crossing.lanes);
      if (crossing.lanes == 0) return WalkStep::kNext;
    }
    if (kAsks == Asks::kAtOnce || (kAsks == Asks::kOthers && HasToAsk(block))) {
      const EightPart key = KeepInOwnBoxes(SpreadRay{ray_}, corners, crossing);
      if (crossing.lanes == 0) return WalkStep::kNext;
      call_.candidates.Keep(scene_, instance_id_, block, part, crossing, key, triangles.ng);
      return kAsks == Asks::kAtOnce ? TakeAsking() : WalkStep::kLeave;
    }
    float limit;
    size_t taken;
    if (HWY_UNLIKELY(!crossing.FindFirst<kQuery>(ray_, limit, taken))) return WalkStep::kLeave;
    if (taken == kPartLanes) return WalkStep::kNext;
    const size_t block_lane = part * kPartLanes + taken;
    if (HWY_UNLIKELY(!EntersOwnBox(SpreadRay{ray_}, corners, block, block_lane, limit))) {
      return WalkStep::kLeave;
    }
    if constexpr (kQuery == Query::kAny) return Block();
    SetHit(ray_, limit, 0, 0);
    call_.hit.Keep(scene_, instance_id_, block, part, taken, crossing, triangles.ng);
    return WalkStep::kNext;
  }

  /// Whether the mask of the ray excludes all of a block, which is of one geometry.
  HWY_INLINE bool IsExcluded(const LeafBlock& block) const {
    return block.geometry != LeafBlock::kSeveral && !Accepts(block.geometry);
  }

  /// Whether there is anything to ask but distances where a block is hit that is not excluded.
  HWY_INLINE bool HasToAsk(const LeafBlock& block) const {
    return block.geometry == LeafBlock::kSeveral ||
           (asks_filters_ && FilterOf<kQuery>(scene_.geometries.shapes()[block.geometry]));
  }

  HWY_INLINE WalkStep AskLeaf(ChildWord child) {
    // The walk has tested all of the leaf, if it is one part.
    if (kParts == 1 && !call_.candidates.is_empty()) return TakeAsking();
    call_.candidates.Clear();
    if (child.IsRange()) return TestMade(child.range());
    if (!child.IsBlock()) return WalkStep::kLeave;
    const LeafBlock* const block = partition_.FirstBlock(child);
    return HWY_LIKELY(block->HoldsItems()) ? TestItems(*block) : TestRow(block);
  }

  /// A leaf without its geometry, which is made for this visit; kLeave where it holds anything but
  /// still facets, or callbacks would be asked twice about what a task tests again.
  HWY_NOINLINE WalkStep TestMade(uint32_t first) {
    if (scene_.has_callbacks) return WalkStep::kLeave;
    WalkStep step = WalkStep::kNext;
    ForEachMadeLeaf(
        scene_.geometries, partition_.order, first, SIZE_MAX,
        [&] { return call_.made_leaves.Free(call_.hit); },
        [&](ChildWord, const LeafBlock* block) HWY_ATTR {
          step = block->IsPlain() ? TestMade(*block) : WalkStep::kLeave;
          return step == WalkStep::kNext;
        });
    return step;
  }
  HWY_INLINE WalkStep TestMade(const LeafBlock& block) {
    if (!call_.checks_masks) {
      const WalkStep step = TestFacets<Asks::kNobody>(block);
      if (HWY_LIKELY(step != WalkStep::kLeave)) return step;
    }
    return TestFacets<Asks::kAtOnce>(block);
  }

  /// The blocks of a leaf, whatever they hold; kLeave, and nothing was done, where only a task can
  /// be asked. Apart, so that the common way stays short.
  HWY_NOINLINE WalkStep TestRow(const LeafBlock* first) {
    for (const LeafBlock* block = first;; block = block->Next()) {
      if (!IsKnown(*block)) return WalkStep::kLeave;
      if (block->is_last) break;
    }
    for (const LeafBlock* block = first;; block = block->Next()) {
      if (TestBlock(*block) == WalkStep::kStop) return WalkStep::kStop;
      if (block->is_last) return WalkStep::kNext;
    }
  }

  static HWY_INLINE bool IsKnown(const LeafBlock& block) {
    return !block.is_timed || block.kind == LeafKind::kInstances ||
           block.kind == LeafKind::kMovingFacets;
  }

  HWY_INLINE WalkStep TestBlock(const LeafBlock& block) {
    if (block.kind == LeafKind::kFacets) return TestFacets<Asks::kAtOnce>(block);
    if (block.kind == LeafKind::kMovingFacets) return TestMovingFacets(block);
    if (block.HoldsPoints()) return TestPoints(block);
    return block.is_timed ? TestMovingInstance(block.geometry) : TestItems(block);
  }

  /// The ray has come to where the instance is at some time.
  HWY_NOINLINE WalkStep TestMovingInstance(uint32_t geometry) {
    const Shapes& shapes = scene_.geometries.shapes();
    if (!Accepts(geometry) || !shapes.MomentAt(geometry, ray_.time)) return WalkStep::kNext;
    EnterInstance(geometry, *shapes.InstancedScene(geometry),
                  shapes.ToInstance(geometry, ray_.time));
    return AfterItem();
  }

  HWY_INLINE WalkStep TestItems(const LeafBlock& block) {
    if (HWY_LIKELY(block.lanes == 1)) {
      if (!EntersOnlyItem(block, ray_)) return WalkStep::kNext;
      return block.kind == LeafKind::kInstances ? TestInstance(block) : TestUserPrimitive(block, 0);
    }
    HWY_ALIGN float entry[kLeafLanes];
    for (uint32_t entered = EnterItems(block, ray_, entry); entered != 0;) {
      const size_t lane = NearestLane(entered, entry);
      entered &= ~(1u << lane);
      if (!(entry[lane] <= ray_.tfar)) break;
      if (TestUserPrimitive(block, lane) == WalkStep::kStop) return WalkStep::kStop;
    }
    return WalkStep::kNext;
  }

  HWY_INLINE WalkStep TestUserPrimitive(const LeafBlock& block, size_t lane) {
    const GeometryTable::Name item = NameOfLane(scene_.geometries, partition_.order, block, lane);
    if (!Accepts(item.geometry)) return WalkStep::kNext;
    CallUserFunction(item);
    return AfterItem();
  }
  HWY_INLINE WalkStep TestInstance(const LeafBlock& block) {
    if (!Accepts(block.geometry)) return WalkStep::kNext;
    const InstanceLeaf& leaf = InstanceLeaf::In(block);
    FetchScene(leaf);
    EnterInstance(block.geometry, *leaf.scene, leaf.to_instance);
    return AfterItem();
  }
  HWY_INLINE WalkStep AfterItem() const {
    return kQuery == Query::kAny && ray_.tfar < 0 ? WalkStep::kStop : WalkStep::kNext;
  }

  HWY_INLINE void CallUserFunction(const GeometryTable::Name& item) {
    const Geometry& user = scene_.geometries.shapes()[item.geometry];
    const Callback& function = UserFunctionOf(kQuery, user);
    if (!function) return;
    const bool has_hit = kQuery == Query::kClosest && (ray_.state & RayRecord::kHasHit);
    const FullHit& before = has_hit ? call_.hit.Full() : kNoHit;
    LonePacket packet(call_.packet, ray_);
    packet.CopyHit(before, ray_.tfar);
    function(packet.Arguments(kQuery, user.geometry_id, item.primitive, instance_id_,
                              call_.options.call));
    if constexpr (kQuery == Query::kAny) {
      if (packet.tfar() < 0) ray_.tfar = packet.tfar();
      return;
    }
    if (HWY_LIKELY(packet.HasStill(before, ray_.tfar))) return;
    const FullHit now = packet.Hit();
    ray_.state = RayRecord::kHasHit;
    ray_.tfar = std::min(ray_.tfar, now.t);
    call_.hit.Set(now, item.geometry);
  }

  HWY_INLINE void EnterInstance(uint32_t geometry, const SceneParts& shown,
                                const AffineTransform& to_instance) {
    if (call_.in_instance) return;  // There is one level of instances.
    InstanceTransform transform;
    transform.Set(to_instance);
    RayRecord ray;
    transform.Apply(ray_, ray);
    call_.in_instance = true;
    TraceLoneInInstance<kQuery>(call_, shown, scene_.geometries[geometry].geometry_id, ray);
    call_.in_instance = false;
    ray_.tfar = ray.tfar;
    ray_.state = ray.state;
  }

  /// All of the way.
  HWY_NOINLINE void TraceAsTask() {
    AsTask([](const TraceTask& task) { TraceRays<kQuery>(task, 1, ListMemory{}); });
  }
  /// The rest of it, from `child` and the open children on.
  HWY_NOINLINE void ResumeAsTask(ChildWord child, OpenChildren& open) {
    AsTask([&](const TraceTask& task) {
      OneTracer<kQuery>(task).Resume(child, open, 0, ListMemory{});
    });
  }

  template <class Trace>
  HWY_INLINE void AsTask(const Trace& trace) {
    const bool has_hit = kQuery == Query::kClosest && (ray_.state & RayRecord::kHasHit);
    FullHit hit;
    if (has_hit) {
      hit = call_.hit.Get();
      ray_.hit = call_.hit.geometry();
    }
    RayRecord instance_ray;
    FullHit instance_hit;
    RayNumber outer_ray;
    const CallFrame frame{nullptr, &call_.packet, 0, call_.options, call_.packet.instance_value};
    SplitMemory split_memory(call_.pool);
    TraceTask task{scene_,
                   partition_,
                   &ray_,
                   &hit,
                   call_.checks_masks,
                   /*keeps_leaf_hits=*/true,
                   frame,
                   split_memory,
                   {&instance_ray, &instance_hit, &outer_ray, call_.in_instance ? 0u : 1u},
                   nullptr,
                   FinishHit,
                   instance_id_};
    task.asks_filters_last = !asks_filters_;
    task.asked = call_.asked;
    task.filter_answers = call_.filter_answers;
    trace(task);
    if constexpr (kQuery == Query::kClosest) {
      if (!(ray_.state & RayRecord::kHasHit)) return;
      uint32_t geometry;
      const FullHit found = task.HitOf(0, geometry);
      call_.hit.Set(found, geometry);
      ray_.state &= ~RayRecord::kInLeaf;
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_LONE_INL_H_

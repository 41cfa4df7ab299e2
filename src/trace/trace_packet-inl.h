// A packet or a single ray in the caller's memory.

#if defined(DACRT_TRACE_TRACE_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_PACKET_INL_H_
#undef DACRT_TRACE_TRACE_PACKET_INL_H_
#else
#define DACRT_TRACE_TRACE_PACKET_INL_H_
#endif

#include <cmath>

#include "leaf/finish_hit-inl.h"
#include "rays/load_records-inl.h"
#include "rays/write_record-inl.h"
#include "trace/ask_last-inl.h"
#include "trace/group_hits-inl.h"
#include "trace/learnt.h"
#include "trace/policy.h"
#include "trace/stack_memory.h"
#include "trace/trace_handful-inl.h"
#include "trace/trace_lone-inl.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery>
void TraceSingle(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                 WorkspacePool& pool) {
  float* const record = static_cast<float*>(packet.values);
  RayRecord ray;
  if (packet.valid && *packet.valid != -1) return;
  if (!LoadRecord(record, packet.has_masks, ray)) return;
  LoneCall call(packet, options, pool, !scene.geometries.AllAccept(ray.mask));
  TraceLone<kQuery>(call, scene, packet.instance_value, ray);
  if constexpr (kQuery == Query::kAny) {
    if (ray.tfar < 0) RecordLayout::WriteBlocked(packet, 0);
  } else if (ray.state & RayRecord::kHasHit) {
    call.hit.Write(record);
  }
}

/// Rays in a vector.
constexpr size_t kVectorRays = hn::MaxLanes(D());

/// Whether leaves are made anew for each visit: a group makes them once for all its rays. Packets
/// of 4 of a COMPACT scene, one by one and as groups (Zen 3): Sponza's shadow rays took 969 and 599
/// ns a ray, ambient ones 890 and 711.
HWY_INLINE bool MakesLeaves(const SceneParts& scene) {
  return scene.kept && scene.kept->leaf_lanes() > kLeafLanes;
}

/// Whether the rays of a packet, which have nothing to call, cost less one by one than as a group,
/// whatever they are: a group takes several vectors where one does not hold it, and these fill no
/// more than half of one. Packets of 4 with AVX2, one by one and as groups, ns a ray, primary,
/// shadow, ambient, diffuse: a box of 36 triangles 147 and 168, 110 and 116, 59 and 82, 118 and
/// 138; Sponza's shadow and ambient rays 212 and 319, 371 and 421. Packets of 4 with SSE4.2
/// took 1.05 to 1.7 times as long one by one. Instances are entered once by a group: in a thousand
/// of Sponza shadow rays took 2,500 ns one by one and 1,760 so, ambient ones 2,620 and 2,800, of a
/// hall 1,330 and 1,200, 860 and 810 (Zen 3).
template <Query kQuery>
HWY_INLINE bool IsBetterAlone(const SceneParts& scene, const RayPacket& packet) {
  return kVectorRays < kPacketRays && 2 * packet.lanes <= kVectorRays &&
         (scene.is_small || kQuery == Query::kAny) && !scene.has_instances && !MakesLeaves(scene);
}

/// Whether the rays of some lanes, which have nothing to call, cost less one by one than as a
/// group, because there are few of them and they run in several octants. A group tests one ray
/// against all children at once where eight fit a vector, and is seldom worse then. With AVX2 only
/// (Zen 3), packets of 16 one by one and as groups: ambient rays 201 and 128 ns a ray in the
/// kitchen, 443 and 327 in Sponza, 196 and 141 in Sibenik, diffuse ones 482 and 373, 966 and 845,
/// 486 and 436. Packets of 4 of closest hits leave half of the vectors empty, in which their rays
/// are tested against triangles: diffuse ones, as groups and one by one (Zen 1), 470 and 426, 1,136
/// and 1,042, 665 and 590. With AVX-512 (Sapphire Rapids), ambient and diffuse rays, of seven
/// scenes in the mean: as groups, packets of 16 took .81 and .90 times as long as one by one, of 8
/// .96 and 1.07, of 4 1.10 and 1.16. With SSE4.2 (Zen 3), in three scenes, of 8 1.25 and 1.29, of
/// 4 1.40 and 1.43.
template <Query kQuery>
HWY_INLINE bool AreBetterAlone(const SceneParts& scene, const GroupLanes<kPacketRays>& lanes,
                               LaneMask active) {
  constexpr bool kIsAny = kQuery == Query::kAny;
  constexpr size_t kFew = kParts > 1 ? policy::kFewApart
                          : kVectorRays < kPacketRays
                              ? (kIsAny ? policy::kFewRays : kVectorRays / 2)
                          : kIsAny ? policy::kFewOfAnyInVector
                                   : policy::kFewApart;
  // Of any hits in a small scene all are soon found.
  constexpr size_t kFewInSmall = kIsAny ? 0 : HWY_MIN(kFew, policy::kFewInSmallScene);
  const size_t count = hwy::PopCount(active);
  if (count <= policy::kFewRays) return true;
  if (count > (scene.is_small ? kFewInSmall : kFew) || MakesLeaves(scene)) return false;
  uint32_t octant;
  return (active & ~lanes.LanesOfOctant(active, octant)) != 0;
}

/// What has come of the ray of a lane; `hit()` says where it is, if there is a closest one.
template <Query kQuery, class Hit>
HWY_INLINE void WriteAnswer(const RayPacket& packet, size_t lane, const RayRecord& ray,
                            const Hit& hit) {
  const auto place = static_cast<uint32_t>(lane);
  if constexpr (kQuery == Query::kAny) {
    if (ray.tfar < 0) RecordLayout::WriteBlocked(packet, place);
  } else if (ray.state & RayRecord::kHasHit) {
    RecordLayout::WriteLane(packet, place, hit());
  }
}

/// The rays of some lanes, each of which `load(lane, ray)` loads, which says whether it is active.
template <Query kQuery, class Load>
HWY_NOINLINE void TraceOneByOne(const SceneParts& scene, const RayPacket& packet,
                                const CallOptions& options, WorkspacePool& pool, LaneMask active,
                                const Load& load) {
  ForEachLane(active, [&](size_t lane) HWY_ATTR {
    RayRecord ray;
    if (!load(lane, ray)) return;
    LoneCall call(packet, options, pool, !scene.geometries.AllAccept(ray.mask));
    TraceLone<kQuery>(call, scene, packet.instance_value, ray);
    WriteAnswer<kQuery>(packet, lane, ray, [&] { return call.hit.Get(); });
  });
}

/// Whether the rays of a packet may go as a handful (see trace_handful-inl.h). In robust scenes, of
/// which leaves are not prepared, eight any-hit rays that run close together are better off as a
/// group: shadow rays of a box took 34 ns so, 49 as a handful.
HWY_INLINE bool MayBeHandful(const SceneParts& scene, const RayPacket& packet) {
  const bool is_robust = scene.geometries.shapes().robust();
  return packet.lanes <= (is_robust ? policy::kFewInSmallScene : HandfulAnswers::kMostRays) &&
         scene.is_small && scene.prepares_leaves && !scene.has_callbacks;
}

/// Whether these rays are better off as a group: of closest hits, which go through as many leaves
/// as they come to, where the first and the last of eight run close together. Primary rays of a box
/// took 31 ns as groups, 44 as handfuls, diffuse ones 64 and 52, and any hits 24 to 32 and 20. What
/// moves is tested ray by ray by groups, too, and what instances show is written once more:
/// primary rays of a box that moves took 129 ns as groups, 84 as handfuls, of one in an instance 77
/// and 67.
template <Query kQuery>
HWY_INLINE bool IsGroup(const SceneParts& scene, const RayPacket& packet,
                        const GroupLanes<kPacketRays>& lanes) {
  if (kQuery == Query::kAny || packet.lanes <= policy::kFewInSmallScene) return false;
  if (scene.has_instances || scene.has_motion) return false;
  float longest = 0, apart = 0;
  for (const auto& dir : lanes.dir) {
    longest = HWY_MAX(longest, std::abs(dir[0]));
    apart = HWY_MAX(apart, std::abs(dir[packet.lanes - 1] - dir[0]));
  }
  return apart <= policy::kNarrowDirections * longest;
}

/// False, and nothing was written, if they go otherwise.
template <Query kQuery>
HWY_NOINLINE bool TraceHandful(const SceneParts& scene, const RayPacket& packet) {
  GroupLanes<kPacketRays> lanes;
  const LaneMask active = lanes.LoadPacket(packet);
  if (active == 0) return true;
  if (IsGroup<kQuery>(scene, packet, lanes)) return false;
  return HWY_UNLIKELY(scene.geometries.shapes().robust())
             ? TraceAsHandful<kQuery, true>(scene, packet, lanes, active)
             : TraceAsHandful<kQuery, false>(scene, packet, lanes, active);
}

/// The lanes of a packet, as a handful, one by one, or as one group.
template <Query kQuery>
void TraceLanes(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                WorkspacePool& pool) {
  if constexpr (kParts == 1) {
    if (MayBeHandful(scene, packet) && TraceHandful<kQuery>(scene, packet)) return;
  }
  if (!scene.has_callbacks && IsBetterAlone<kQuery>(scene, packet)) {
    return TraceOneByOne<kQuery>(scene, packet, options, pool, FirstLanes(packet.lanes),
                                 [&](size_t lane, RayRecord& ray) HWY_ATTR {
                                   if (packet.valid && packet.valid[lane] != -1) return false;
                                   RecordLayout::ReadLane(packet, lane, ray);
                                   return FinishRecord(ray);
                                 });
  }
  GroupLanes<kPacketRays> lanes;
  const LaneMask active = lanes.LoadPacket(packet);
  if (active == 0) return;
  if (!scene.has_callbacks && AreBetterAlone<kQuery>(scene, lanes, active)) {
    return TraceOneByOne<kQuery>(scene, packet, options, pool, active,
                                 [&](size_t lane, RayRecord& ray) HWY_ATTR {
                                   lanes.Store(lane, ray);
                                   return true;
                                 });
  }
  StackMemory<kPacketRays> memory;
  const CallFrame frame{nullptr, &packet, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  TraceTask task{scene,
                 scene.partition(),
                 memory.rays,
                 memory.hits,
                 !scene.geometries.AllAccept(lanes.CommonMask(active)),
                 /*keeps_leaf_hits=*/true,
                 frame,
                 split_memory,
                 memory.ForInstances(),
                 nullptr,
                 FinishHit,
                 packet.instance_value};
  ChooseWhenToAsk<kQuery>(task);
  TraceGroup<kQuery>(task, lanes, active, memory.Lists(),
                     LearntOfGroups<kQuery>(scene, &Learnt::order_of_packets));
  if constexpr (kQuery == Query::kAny) {
    ForEachLane(lanes.Blocked(active), [&](size_t lane) {
      RecordLayout::WriteBlocked(packet, static_cast<uint32_t>(lane));
    });
  } else {
    GroupHits<kPacketRays> found(task, lanes, active);
    if (HWY_UNLIKELY(task.asks_filters_last)) {
      AskLast(task, lanes, active, memory.Lists(), found);
    }
    found.Write(packet);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_PACKET_INL_H_

// The ray of a call of one ray, in the scene or in an instance in it, and who is asked about what
// it hits there: masks, filter functions and names.

#if defined(DACRT_TRACE_LONE_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_LONE_RAY_INL_H_
#undef DACRT_TRACE_LONE_RAY_INL_H_
#else
#define DACRT_TRACE_LONE_RAY_INL_H_
#endif

#include <limits>

#include "leaf/lone_packet-inl.h"
#include "leaf/take_hit.h"
#include "trace/filter_answers.h"
#include "trace/lone_hit-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Leaves that are made for one visit. What the nearest hit so far is in stays where it is.
class MadeLeaves {
 public:
  MadeLeaves() {}  // nothing is cleared

  HWY_INLINE std::byte* Free(const LoneHit& hit) {
    return blocks_[hit.IsIn(reinterpret_cast<const LeafBlock*>(blocks_[0])) ? 1 : 0];
  }

 private:
  alignas(64) std::byte blocks_[2][kMostLeafBytes];
};

/// The call, from the scene itself to the instances in it.
struct LoneCall {
  LoneCall(const RayPacket& call_packet, const CallOptions& call_options, WorkspacePool& call_pool,
           bool call_checks_masks)
      : packet(call_packet),
        options(call_options),
        pool(call_pool),
        checks_masks(call_checks_masks) {}

  const RayPacket& packet;  ///< of one lane
  const CallOptions& options;
  WorkspacePool& pool;
  const bool checks_masks;
  bool in_instance = false;
  LoneHit hit;                              ///< of a closest-hit query
  FilterAnswers* filter_answers = nullptr;  ///< as in TraceTask, as is the next one
  const FullHit* asked = nullptr;
  LoneCandidates candidates;
  MadeLeaves made_leaves;
};

/// As it is in one of these scenes. Its hits are the call's.
template <Query kQuery>
class LoneRay {
 protected:
  LoneRay(LoneCall& call, const SceneParts& scene, uint32_t instance_id, RayRecord& ray)
      : call_(call),
        scene_(scene),
        partition_(scene.partition()),
        instance_id_(instance_id),
        ray_(ray) {}

  HWY_INLINE WalkStep Block() {
    ray_.tfar = -std::numeric_limits<float>::infinity();
    return WalkStep::kStop;
  }

  HWY_INLINE bool Accepts(uint32_t geometry) const {
    return !call_.checks_masks || (ray_.mask & scene_.geometries[geometry].mask) != 0;
  }

  /// Offers the ray the candidates, where names, masks or filter functions decide.
  HWY_INLINE WalkStep TakeAsking() {
    LoneCandidates& candidates = call_.candidates;
    const bool has_filters = asks_filters_ && scene_.geometries.shapes().has_filters(kQuery);
    while (!candidates.is_empty()) {
      // Near ones first, because a filter function may end the ray, and counts what it sees.
      const size_t lane = has_filters ? candidates.TakeNearest() : candidates.TakeAny();
      // Before the name is asked for, which is seldom in a cache.
      float key = candidates.key(lane);
      if constexpr (kQuery == Query::kAny) {
        if (!candidates.within_limit(lane)) continue;
      } else {
        const Closeness closeness = Compare(ray_, key, candidates.within_limit(lane));
        if (closeness == Closeness::kFarther) continue;
        if (closeness == Closeness::kEqual && !ComesFirst(lane)) continue;
      }
      if (call_.checks_masks && !Accepts(candidates.geometry(lane))) continue;
      const Callback* const filter = has_filters ? FilterAt(lane) : nullptr;
      if constexpr (kQuery == Query::kAny) {
        if (filter) {
          FullHit hit = candidates.Hit(lane);
          if (!PassesFilter(*filter, hit)) continue;
        }
        candidates.Clear();
        return Block();
      }
      if (filter) {
        FullHit hit = candidates.Hit(lane);
        const float t = hit.t;
        if (!PassesFilter(*filter, hit)) continue;
        if (hit.t != t) key = hit.t;
        call_.hit.Set(hit, candidates.geometry(lane));
      } else {
        candidates.CopyHit(lane, call_.hit);
      }
      SetHit(ray_, key, 0, 0);
    }
    return WalkStep::kNext;
  }

  HWY_INLINE bool PassesFilter(const Callback& filter, FullHit& hit) const {
    if (call_.asked && IsSame(hit, *call_.asked)) return false;
    LonePacket packet(call_.packet, ray_);
    packet.SetHit(hit);
    filter(packet.Arguments(kQuery, hit.geometry_id, hit.primitive_id, instance_id_,
                            call_.options.call));
    if (call_.filter_answers) call_.filter_answers->Count(1, packet.is_valid());
    if (!packet.is_valid()) return false;
    hit = packet.Hit();
    return true;
  }

  LoneCall& call_;
  const SceneParts& scene_;
  const PartitionView partition_;
  const uint32_t instance_id_;
  RayRecord& ray_;
  bool asks_filters_ = true;  ///< where hits are found

 private:
  /// The filter function of a candidate's geometry; null if it has none.
  HWY_INLINE const Callback* FilterAt(size_t lane) const {
    const uint32_t geometry = call_.candidates.geometry(lane);
    const Callback& filter = FilterOf<kQuery>(scene_.geometries.shapes()[geometry]);
    return filter ? &filter : nullptr;
  }

  /// Whether a candidate comes before the hit by name.
  HWY_INLINE bool ComesFirst(size_t lane) const {
    const LoneCandidates& candidates = call_.candidates;
    if (scene_.geometries.all_fill_one_lane() && call_.hit.IsIn(scene_, instance_id_)) {
      return candidates.number(lane) < call_.hit.number();
    }
    const FullHit hit = candidates.Hit(lane), other = call_.hit.Get();
    return dacrt::ComesFirst({hit, candidates.geometry(lane)}, {other, call_.hit.geometry()},
                             call_.packet.instance_value);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_LONE_RAY_INL_H_

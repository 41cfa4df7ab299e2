// Rays of a view in the caller's memory.

#if defined(DACRT_TRACE_TRACE_VIEW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_VIEW_INL_H_
#undef DACRT_TRACE_TRACE_VIEW_INL_H_
#else
#define DACRT_TRACE_TRACE_VIEW_INL_H_
#endif

#include "leaf/finish_hit-inl.h"
#include "rays/load_records-inl.h"
#include "runtime/ticks.h"
#include "trace/ask_last-inl.h"
#include "trace/group_hits-inl.h"
#include "trace/learnt.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays ahead of which the leaves are fetched that have been hit, and the caller's records to which
/// the hits are written.
constexpr size_t kFetchHits = 8, kFetchCallers = 16;

/// Writes what the loaded closest-hit rays have found to the caller's records. Returns how many
/// found something.
template <bool kAsksBoxes>
size_t StoreHits(const TraceTask& task, const LoadedRays& loaded, ListMemory lists) {
  const RecordLayout layout(*task.frame.view);
  const auto caller_of = [&](size_t ray) { return task.frame.first + task.callers[ray]; };
  const auto has_hit = [&](size_t ray) { return task.rays[ray].state & RayRecord::kHasHit; };
  FinishedHitsOf<EightTag, kAsksBoxes> finished(task);
  size_t stored = 0;
  const auto write = [&](RayNumber number, const FullHit* hit) {
    if (HWY_LIKELY(hit != nullptr)) {
      layout.WriteHit(caller_of(number), *hit);
    } else {
      --stored;
    }
  };
  ShownHit shown[finished.kMost];
  size_t shown_count = 0;
  const auto finish = [&]() HWY_ATTR {
    finished.Finish([&](size_t i, uint32_t geometry, const FullHit& found, bool counts = true)
                        HWY_ATTR {
                          const RayNumber number = finished.number(i);
                          FullHit hit;
                          if (HWY_UNLIKELY(!counts)) {
                            write(number, TraceAgain(task, number, lists, hit) ? &hit : nullptr);
                          } else if (HWY_UNLIKELY(task.asks_filters_last)) {
                            shown[shown_count++] = {number, geometry, found};
                          } else {
                            write(number, &found);
                          }
                        });
    AskLast(task, {shown, shown_count}, lists, write);
    shown_count = 0;
  };
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    const size_t end = loaded.end[octant];
    for (size_t i = loaded.begin[octant]; i < end; ++i) {
      const size_t next = i + kFetchCallers;
      if (next < end && has_hit(next)) layout.Prefetch(caller_of(next));
      if (!has_hit(i)) continue;
      if (task.rays[i].state & RayRecord::kInLeaf) {
        finished.Prefetch(task.rays[i + kFetchHits]);
        finished.Add(static_cast<RayNumber>(i));
        if (finished.count() == finished.kMost) finish();
      } else if (HWY_LIKELY(!task.asks_filters_last)) {
        layout.WriteHit(caller_of(i), task.hits[i]);
      } else {
        const ShownHit its{static_cast<RayNumber>(i), task.rays[i].hit, task.hits[i]};
        AskLast(task, {&its, 1}, lists, write);
      }
      ++stored;
    }
  }
  finish();
  return stored;
}

/// Writes which of the loaded any-hit rays are blocked. Returns how many are. Some are collected
/// before they are written: no processor foresees which they are.
inline size_t StoreBlocked(const TraceTask& task, const LoadedRays& loaded) {
  const RecordLayout layout(*task.frame.view);
  constexpr size_t kSome = 64;
  size_t stored = 0;
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    for (size_t begin = loaded.begin[octant]; begin < loaded.end[octant]; begin += kSome) {
      const size_t end = HWY_MIN(begin + kSome, loaded.end[octant]);
      size_t blocked[kSome], count = 0;
      for (size_t i = begin; i < end; ++i) {
        blocked[count] = task.frame.first + task.callers[i];
        count += task.rays[i].tfar < 0;
      }
      for (size_t i = 0; i < count; ++i) layout.Prefetch(blocked[i]);
      for (size_t i = 0; i < count; ++i) layout.WriteBlocked(blocked[i]);
      stored += count;
    }
  }
  return stored;
}

/// Origin and direction of a ray, of which the fourth lanes are anything.
struct Line {
  Corner org, dir;
};

HWY_INLINE Line ReadLine(const RecordLayout& layout, size_t i) {
  if (HWY_LIKELY(layout.has_records())) {
    const float* const record = layout.Record(i);
    return {Corner::LoadUnaligned(record),
            Corner::LoadUnaligned(record + static_cast<size_t>(PacketComponent::kDirX))};
  }
  RayRecord ray{};
  layout.Read(i, ray);
  return {Corner::Load(ray.org), Corner::Load(ray.dir)};
}

/// Whether rays run close together: by the directions and the origins of some rays of some groups
/// of neighbours.
inline bool AreCoherent(const RecordLayout& layout, size_t first, size_t count, const Box& bounds) {
  const float reach = bounds.LongestSide();
  const size_t groups = count / policy::kNeighbours;
  const size_t looks = HWY_MIN(groups, policy::kCoherenceLooks);
  size_t narrow = 0;
  for (size_t look = 0; look < looks; ++look) {
    const size_t begin = first + policy::kNeighbours * (look * groups / looks);
    CornerBounds origins, directions;
    for (size_t i = 0; i < policy::kNeighbours; i += 5) {
      const Line line = ReadLine(layout, begin + i);
      origins.Extend(line.org);
      directions.Extend(line.dir);
    }
    const Box from = origins.Get(), to = directions.Get();
    float apart = 0, spread = 0, length = 0;
    for (int axis = 0; axis < 3; ++axis) {
      apart = HWY_MAX(apart, from.upper[axis] - from.lower[axis]);
      spread = HWY_MAX(spread, to.upper[axis] - to.lower[axis]);
      length = HWY_MAX(length, HWY_MAX(-to.lower[axis], to.upper[axis]));
    }
    narrow +=
        apart <= policy::kNarrowOrigins * reach && spread <= policy::kNarrowDirections * length;
  }
  return policy::kRunsWithOneNarrow * narrow > looks;
}

/// The tags of loaded rays, kept by their numbers.
inline void KeepTags(TraceTask& task, const LoadedRays& loaded, RayTag* tags) {
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    for (size_t i = loaded.begin[octant]; i < loaded.end[octant]; ++i) {
      tags[i] = task.frame.Tag(task.callers[i]);
    }
  }
  task.tags = tags;
}

/// Rays of the view as lists of numbers of records. Tags are kept where there is memory for them.
template <Query kQuery>
void TraceByLists(TraceTask& task, size_t count, RayRecord* rays, uint32_t* callers,
                  ListMemory lists, RayTag* tags) {
  const LoadedRays loaded = LoadRecords(*task.frame.view, task.frame.first, count, rays, callers);
  if (task.statistics) task.statistics->rays += loaded.count;
  if (loaded.count == 0) return;
  if (tags) KeepTags(task, loaded, tags);
  task.checks_masks = !task.scene.geometries.AllAccept(loaded.common_mask);
  ChooseWhenToAsk<kQuery>(task);
  // Where nobody would see that a ray is traced twice.
  task.asks_boxes_last =
      kQuery == Query::kClosest && (!task.scene.has_callbacks || task.asks_filters_last);
  if constexpr (kQuery == Query::kAny) {
    // Without statistics the call is too short to learn from.
    LearntOrder& learnt = LearntAbout(task.scene.kept.get()).order_of_rays;
    task.any_hit_order = task.statistics ? learnt.Next() : learnt.best();
    const uint64_t start = task.statistics ? Ticks() : 0;
    TraceLoaded<kQuery>(task, loaded, lists);
    if (task.statistics) learnt.Count(Ticks() - start, static_cast<uint32_t>(loaded.count));
  } else {
    TraceLoaded<kQuery>(task, loaded, lists);
  }
  const size_t stored = kQuery == Query::kAny  ? StoreBlocked(task, loaded)
                        : task.asks_boxes_last ? StoreHits<true>(task, loaded, lists)
                                               : StoreHits<false>(task, loaded, lists);
  if (task.statistics) task.statistics->hits += stored;
}

/// How the rays of a call go.
enum class Walk {
  kLists,
  kAlone,          ///< each by itself
  kGroups,         ///< of neighbours that run close together, unless lists turn out to be quicker
  kLargestGroups,  ///< of neighbours that have next to nothing in common
};

/// How many rays go in a group: the more of their way they have in common, the more.
template <Query kQuery>
class GroupSize {
 public:
  explicit GroupSize(Walk walk)
      : learns_(walk == Walk::kGroups), rays_(learns_ ? 2 * kPacketRays : kMostGroupRays) {}

  size_t rays() const { return rays_; }

  /// Whether something was learnt.
  bool Learn(const GroupVisits& of_group) {
    if (!learns_) return false;
    visits_.count += of_group.count;
    visits_.lanes += of_group.lanes;
    if (++groups_ < policy::kGroupsToLearnFrom) return false;
    const float share = static_cast<float>(visits_.lanes) /
                        (static_cast<float>(visits_.count) * static_cast<float>(rays_));
    if (share > kShares.crowded) rays_ = HWY_MIN(2 * rays_, kMostGroupRays);
    if (share < kShares.sparse) rays_ = HWY_MAX(rays_ / 2, kPacketRays);
    visits_ = {};
    groups_ = 0;
    return true;
  }

 private:
  static constexpr policy::GroupShares kShares =
      kQuery == Query::kAny ? policy::kAnyShares : policy::kClosestShares;

  const bool learns_;
  size_t rays_;
  GroupVisits visits_;
  size_t groups_ = 0;
};

/// `count` neighbours from ray `begin` of the piece on as a group. Returns its visits.
template <Query kQuery, size_t kMost>
GroupVisits TraceNeighbours(TraceTask& task, const RecordLayout& layout, size_t begin, size_t count,
                            uint32_t* callers, ListMemory lists, LearntOrder* learnt) {
  const size_t first = task.frame.first + begin;
  GroupLanes<kMost> lanes;
  const LaneMask active = lanes.LoadView(layout, first, count);
  if (active == 0) return {};
  for (size_t lane = 0; lane < count; ++lane) callers[lane] = static_cast<uint32_t>(begin + lane);
  task.checks_masks = !task.scene.geometries.AllAccept(lanes.CommonMask(active));
  ChooseWhenToAsk<kQuery>(task);
  const GroupVisits visits = TraceGroup<kQuery>(task, lanes, active, lists, learnt);
  size_t hits = 0;
  if constexpr (kQuery == Query::kAny) {
    const LaneMask blocked = lanes.Blocked(active);
    hits = hwy::PopCount(blocked);
    ForEachLane(blocked, [&](size_t lane) { layout.WriteBlocked(first + lane); });
  } else {
    GroupHits<kMost> found(task, lanes, active);
    if (HWY_UNLIKELY(task.asks_filters_last)) AskLast(task, lanes, active, lists, found);
    hits = hwy::PopCount(found.lanes);
    found.Write(layout, first);
  }
  if (task.statistics) {
    task.statistics->rays += hwy::PopCount(active);
    task.statistics->hits += hits;
  }
  return visits;
}

/// The same, a group of neighbours at a time. Returns how many rays are done: less than all if
/// `choice` says that lists are quicker.
template <Query kQuery>
size_t TraceByGroups(TraceTask& task, size_t count, Walk walk, uint32_t* callers, ListMemory lists,
                     WalkChoice* choice) {
  const RecordLayout layout(*task.frame.view);
  LearntOrder* const learnt = LearntOfGroups<kQuery>(task.scene, &Learnt::order_of_groups);
  GroupSize<kQuery> size(walk);
  size_t timed = 0;
  uint64_t start = choice ? Ticks() : 0;
  for (size_t begin = 0; begin < count;) {
    const size_t rays = HWY_MIN(count - begin, size.rays());
    const auto trace = rays <= kPacketRays ? TraceNeighbours<kQuery, kPacketRays>
                                           : TraceNeighbours<kQuery, kMostGroupRays>;
    const bool has_learnt = size.Learn(trace(task, layout, begin, rays, callers, lists, learnt));
    begin += rays;
    if (!choice || !has_learnt) continue;
    const uint64_t now = Ticks();
    choice->CountGroups(begin - timed, now - start, size.rays() == kPacketRays);
    timed = begin;
    start = now;
    if (choice->rays_by_lists() > 0 && count - begin >= policy::kFewestByLists) return begin;
  }
  return count;
}

/// What a thread has learnt about rays of a call that run close together; null if they go by groups
/// in any case.
template <Query kQuery>
WalkChoice* WalkChoiceFor(const SceneParts& scene, size_t count) {
  if (scene.is_small || count < policy::kFewestByLists) return nullptr;
  return &LearntAbout(scene.kept.get()).Of(kQuery).walk;
}

/// Whether rays are taken to have most of their way in common.
inline bool GoTogether(const SceneParts& scene, const RecordLayout& layout, size_t first,
                       size_t count) {
  if (scene.is_small) return true;
  return count >= policy::kNeighbours && AreCoherent(layout, first, count, scene.bounds);
}

/// Rays `first` to `first + count` of the view, in the memory of a workspace or on the stack, where
/// there is none for tags.
template <Query kQuery>
void TraceView(const SceneParts& scene, const RayView& view, size_t first, size_t count, Walk walk,
               const CallOptions& options, SplitMemory& split_memory, RayRecord* rays,
               FullHit* hits, uint32_t* callers, const InstanceMemory& instance_memory,
               ListMemory lists, RayTag* tags, Statistics* statistics) {
  if (statistics) ++statistics->pieces;
  WalkChoice* const choice = walk == Walk::kGroups ? WalkChoiceFor<kQuery>(scene, count) : nullptr;
  for (size_t done = 0; done < count;) {
    const CallFrame frame{&view, nullptr, first + done, options, view.instance_value};
    TraceTask task{scene,
                   scene.partition(),
                   rays,
                   hits,
                   true,
                   /*keeps_leaf_hits=*/true,
                   frame,
                   split_memory,
                   instance_memory,
                   statistics,
                   FinishHit,
                   view.instance_value,
                   callers};
    const size_t left = count - done;
    size_t by_lists = walk == Walk::kLists || walk == Walk::kAlone ? count : 0;
    if (choice && left >= policy::kFewestByLists) by_lists = HWY_MIN(left, choice->rays_by_lists());
    if (by_lists == 0) {
      done += TraceByGroups<kQuery>(task, left, walk, callers, lists, choice);
      continue;
    }
    const uint64_t start = choice ? Ticks() : 0;
    // A ray for whose list there is no memory goes alone.
    TraceByLists<kQuery>(task, by_lists, rays, callers, walk == Walk::kAlone ? ListMemory{} : lists,
                         scene.has_callbacks ? tags : nullptr);
    if (choice) choice->CountLists(by_lists, Ticks() - start);
    done += by_lists;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_VIEW_INL_H_

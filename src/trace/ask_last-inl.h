// Filter functions that are asked last: not about every hit that is nearer than those before it,
// but, when all leaves have been tested, about the one that each ray has. Until then rays go as if
// there were no filter functions, and then several of them share a packet. A ray whose hit is
// accepted is done. One whose hit is rejected begins anew, and asks at once from then on, but not
// about that hit again: each is shown to a filter function once.
//
// So this is for closest hits, and for functions that accept most of them, as they are seen to do
// (filter_answers.h).

#if defined(DACRT_TRACE_ASK_LAST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_ASK_LAST_INL_H_
#undef DACRT_TRACE_ASK_LAST_INL_H_
#else
#define DACRT_TRACE_ASK_LAST_INL_H_
#endif

#include <span>

#include "leaf/callback_packet.h"
#include "leaf/take_hit.h"
#include "rays/load_records-inl.h"
#include "trace/filter_answers.h"
#include "trace/group_packets-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Says when the filter functions of a task are asked.
template <Query kQuery>
HWY_INLINE void ChooseWhenToAsk(TraceTask& task) {
  if (kQuery == Query::kAny || HWY_LIKELY(!task.scene.closest_filters_may_wait)) return;
  task.filter_answers = &FilterAnswers::Of(task.scene.kept->edition());
  task.asks_filters_last = task.filter_answers->AcceptMost();
}

/// Loads a ray once more from where the caller keeps it.
HWY_INLINE void Reload(const TraceTask& task, RayNumber number) {
  const CallFrame& frame = task.frame;
  RayRecord& ray = task.rays[number];
  if (frame.packet) {
    RecordLayout::ReadLane(*frame.packet, task.CallerOf(number), ray);
    FinishRecord(ray);
  } else {
    LoadRay(RecordLayout(*frame.view), frame.first + task.CallerOf(number), ray);
  }
}

/// Traces a closest-hit ray of the task from the beginning, so that all boxes and filter functions
/// are asked at once. `asked`, if there is one, is a hit of it that has been asked about, and
/// `accepted` what the function has made of it, null if it was rejected. Returns whether the ray
/// has a hit, and which.
HWY_NOINLINE bool TraceAgain(const TraceTask& task, RayNumber number, ListMemory lists,
                             FullHit& hit, const ShownHit* asked = nullptr,
                             const FullHit* accepted = nullptr) {
  TraceTask again = task;
  again.asks_boxes_last = false;
  again.asks_filters_last = false;
  if (asked) again.asked = &asked->hit;
  RayRecord& ray = task.rays[number];
  Reload(task, number);
  if (accepted) {
    SetHit(ray, accepted->t, 0, asked->geometry);
    task.hits[number] = *accepted;
  }
  OneTracer<Query::kClosest>(again).Trace(task.scene.kept->root(), number, lists);
  if (!(ray.state & RayRecord::kHasHit)) return false;
  uint32_t geometry;
  hit = again.HitOf(number, geometry);
  return true;
}

/// Asks the filter functions about the hits that some rays have. `take(number, hit)` is called for
/// each ray with what it has in the end, null if that is nothing.
template <class Take>
HWY_INLINE void AskLast(const TraceTask& task, std::span<const ShownHit> found, ListMemory lists,
                        const Take& take) {
  const size_t most = task.frame.options.callback_width;
  while (!found.empty()) {
    // Of one geometry, as many as a packet holds.
    size_t count = 1;
    while (count < HWY_MIN(most, found.size()) && found[count].geometry == found[0].geometry) {
      ++count;
    }
    const std::span<const ShownHit> shown = found.first(count);
    found = found.subspan(count);
    const Callback& filter =
        FilterOf<Query::kClosest>(task.scene.geometries.shapes()[shown[0].geometry]);
    if (!filter) {
      for (const ShownHit& its : shown) take(its.ray, &its.hit);
      continue;
    }
    FullHit answers[CallbackPacket::kMostLanes];
    const uint32_t accepted = ShowHits(task, filter, Query::kClosest, shown, answers);
    for (size_t i = 0; i < count; ++i) {
      const bool is_accepted = (accepted >> i & 1) != 0;
      // One that was moved away gives way to what is nearer now.
      if (HWY_LIKELY(is_accepted && answers[i].t <= shown[i].hit.t)) {
        take(shown[i].ray, &answers[i]);
        continue;
      }
      FullHit hit;
      const bool has_hit = TraceAgain(task, shown[i].ray, lists, hit, &shown[i],
                                      is_accepted ? &answers[i] : nullptr);
      take(shown[i].ray, has_hit ? &hit : nullptr);
    }
  }
}

/// The same about the hits that a group has found, whose rays are those of their lanes, where
/// functions can be called for the lanes as they are (see GroupPackets::CanBe).
template <size_t kMost>
void AskLastInLanes(const TraceTask& task, const GroupLanes<kMost>& lanes, LaneMask active,
                    ListMemory lists, GroupHits<kMost>& found) {
  found.SetNone();  // packets hold all lanes
  GroupPackets<kMost> packets(task, lanes, active);
  for (LaneMask left = found.lanes; left != 0;) {
    const size_t some_lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(left);
    const LaneMask shown = left & found.LanesIn(found.geometry_id[some_lane]);
    left &= ~shown;
    const uint32_t geometry = *task.scene.geometries.Find(found.geometry_id[some_lane]);
    const Callback& filter = FilterOf<Query::kClosest>(task.scene.geometries.shapes()[geometry]);
    if (!filter) continue;
    typename GroupPackets<kMost>::Answers answers;
    packets.Call(filter, Query::kClosest, {geometry, found.primitive_id[some_lane]}, shown, found.t,
                 found, answers);
    task.CountAnswers(answers.valid, hwy::PopCount(shown));
    LaneMask moved_away = 0;
    ForEachLane(answers.valid & answers.changed, [&](size_t lane) {
      if (answers.hits[lane].t <= found.t[lane]) {
        found.Set(lane, answers.hits[lane]);
      } else {
        moved_away |= LaneMask{1} << lane;
      }
    });
    ForEachLane(shown & (~answers.valid | moved_away), [&](size_t lane) {
      const auto number = static_cast<RayNumber>(lane);
      const ShownHit its{number, geometry, found.Get(lane)};
      FullHit hit;
      const bool has_hit = TraceAgain(task, number, lists, hit, &its,
                                      moved_away >> lane & 1 ? &answers.hits[lane] : nullptr);
      found.Take(lane, has_hit ? &hit : nullptr);
    });
  }
}

/// The same where packets are of other widths.
template <size_t kMost>
void AskLastByRecords(const TraceTask& task, const GroupLanes<kMost>& lanes, ListMemory lists,
                      GroupHits<kMost>& found) {
  ShownHit shown[kPacketRays];
  size_t count = 0;
  const auto ask = [&] {
    AskLast(task, {shown, count}, lists,
            [&](RayNumber lane, const FullHit* hit) { found.Take(lane, hit); });
    count = 0;
  };
  ForEachLane(found.lanes, [&](size_t lane) {
    const auto number = static_cast<RayNumber>(lane);
    lanes.Store(lane, task.rays[number]);
    shown[count++] = {number, *task.scene.geometries.Find(found.geometry_id[lane]),
                      found.Get(lane)};
    if (count == kPacketRays) ask();
  });
  ask();
}

template <size_t kMost>
HWY_NOINLINE void AskLast(const TraceTask& task, const GroupLanes<kMost>& lanes, LaneMask active,
                          ListMemory lists, GroupHits<kMost>& found) {
  if (found.lanes == 0) return;
  if (HWY_LIKELY(GroupPackets<kMost>::CanBe(task.frame.options.callback_width))) {
    AskLastInLanes(task, lanes, active, lists, found);
  } else {
    AskLastByRecords(task, lanes, lists, found);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_ASK_LAST_INL_H_

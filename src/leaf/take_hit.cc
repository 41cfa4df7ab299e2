#include "leaf/take_hit.h"

#include <tuple>

#include "leaf/callback_packet.h"

namespace dacrt {

bool ComesFirst(const NamedHit& a, const NamedHit& b, uint32_t no_instance) {
  const auto name = [&](const NamedHit& hit) {
    const bool in_instance = hit.hit.instance_id != no_instance;
    return std::tuple(in_instance ? hit.hit.instance_id : hit.hit.geometry_id, hit.hit.geometry_id,
                      hit.geometry, hit.hit.primitive_id, hit.hit.u, hit.hit.v);
  };
  return name(a) < name(b);
}

bool ComesFirst(const TraceTask& task, RayNumber number, const FullHit& found, uint32_t geometry) {
  uint32_t hit_geometry;
  const FullHit hit = task.HitOf(number, hit_geometry);
  return ComesFirst({found, geometry}, {hit, hit_geometry}, task.frame.no_instance);
}

namespace {

/// ShowHits; inline, because most are shown alone.
[[gnu::always_inline]] inline uint32_t Show(const TraceTask& task, const Callback& filter,
                                            Query query, std::span<const ShownHit> shown,
                                            FullHit* answers) {
  CallbackPacket packet(task);
  const auto lane_of = [&](std::size_t i) { return packet.LaneOf(shown[i].ray, i); };
  packet.Clear();
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const std::size_t lane = lane_of(i);
    packet.SetRay(lane, shown[i].ray, shown[i].hit.t);
    packet.SetHit(lane, shown[i].hit);
    packet.valid[lane] = -1;
  }
  filter(packet.Arguments(query, shown[0].geometry, shown[0].hit.primitive_id));
  uint32_t accepted = 0;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const std::size_t lane = lane_of(i);
    if (packet.valid[lane] == 0) continue;
    accepted |= 1u << i;
    answers[i] = packet.GetHit(lane);
  }
  task.CountAnswers(accepted, shown.size());
  return accepted;
}

}  // namespace

uint32_t ShowHits(const TraceTask& task, const Callback& filter, Query query,
                  std::span<const ShownHit> shown, FullHit* answers) {
  return Show(task, filter, query, shown, answers);
}

bool PassesFilter(const TraceTask& task, const Callback& filter, Query query, RayNumber ray,
                  uint32_t geometry, FullHit& hit) {
  if (task.asked && IsSame(hit, *task.asked)) return false;
  const ShownHit shown{ray, geometry, hit};
  return Show(task, filter, query, {&shown, 1}, &hit) != 0;
}

}  // namespace dacrt

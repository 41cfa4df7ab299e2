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

bool PassesFilter(const TraceTask& task, const Callback& filter, Query query, RayNumber ray,
                  uint32_t geometry, FullHit& hit) {
  CallbackPacket packet(task);
  const std::size_t lane = packet.LaneOf(ray, 0);
  packet.Clear();
  packet.SetRay(lane, ray, hit.t);
  packet.SetHit(lane, hit);
  packet.valid[lane] = -1;
  filter(packet.Arguments(query, geometry, hit.primitive_id));
  if (packet.valid[lane] == 0) return false;
  hit = packet.GetHit(lane);
  return true;
}

}  // namespace dacrt

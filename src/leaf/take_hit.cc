#include "leaf/take_hit.h"

#include <tuple>

#include "leaf/callback_packet.h"

namespace dacrt {

bool ComesFirst(const TraceTask& task, RayNumber number, const FullHit& found, uint32_t geometry) {
  uint32_t hit_geometry;
  const FullHit hit = task.HitOf(number, hit_geometry);
  const auto name = [&](const FullHit& h, uint32_t of_mesh) {
    const bool in_instance = h.instance_id != task.frame.no_instance;
    return std::tuple(in_instance ? h.instance_id : h.geometry_id, h.geometry_id, of_mesh,
                      h.primitive_id, h.u, h.v);
  };
  return name(found, geometry) < name(hit, hit_geometry);
}

bool PassesFilter(const TraceTask& task, const Callback& filter, Query query, RayNumber ray,
                  uint32_t geometry, FullHit& hit) {
  CallbackPacket packet(task);
  const uint32_t width = task.frame.options.callback_width;
  // The lane that the ray has in a packet of the caller's, where there are packets.
  const std::size_t lane = task.CallerOf(ray) % width;
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

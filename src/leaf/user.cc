#include "leaf/user.h"

#include <algorithm>

#include "leaf/callback_packet.h"

namespace dacrt {
namespace {

FullHit HitOf(const TraceTask& task, RayNumber number, Query query) {
  if (query == Query::kAny) return kNoHit;
  const RayRecord& ray = task.rays[number];
  uint32_t geometry;
  FullHit hit = ray.state & RayRecord::kHasHit ? task.HitOf(number, geometry) : kNoHit;
  hit.t = ray.tfar;
  return hit;
}

}  // namespace

void CallUserFunction(Query query, const TraceTask& task, uint32_t geometry, uint32_t primitive,
                      std::span<const RayNumber> rays) {
  const Geometry& user = task.scene.geometries.shapes()[geometry];
  const Callback& function = UserFunctionOf(query, user);
  if (!function || rays.empty()) return;
  CallbackPacket packet(task);
  const std::size_t width = task.frame.options.callback_width;
  const auto lane_of = [&](std::size_t i) { return packet.LaneOf(rays[i], i); };
  FullHit before[CallbackPacket::kMostLanes];
  uint32_t filled = 0;
  const auto fill = [&](std::size_t lane, RayNumber ray, const FullHit& hit, int valid) {
    packet.SetRay(lane, ray, task.rays[ray].tfar);
    packet.SetHit(lane, hit);
    packet.valid[lane] = valid;
    filled |= 1u << lane;
  };
  for (std::size_t i = 0; i < rays.size(); ++i) {
    before[i] = HitOf(task, rays[i], query);
    fill(lane_of(i), rays[i], before[i], -1);
  }
  // Lanes without a ray hold the first one.
  for (std::size_t lane = 0; lane < width; ++lane) {
    if (!(filled >> lane & 1)) fill(lane, rays[0], before[0], 0);
  }
  function(packet.Arguments(query, geometry, primitive));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    RayRecord& ray = task.rays[rays[i]];
    const FullHit now = packet.GetHit(lane_of(i));
    if (query == Query::kAny) {
      if (now.t < 0) ray.tfar = now.t;
      continue;
    }
    if (IsSame(now, before[i])) continue;
    ray.state = RayRecord::kHasHit;
    ray.hit = geometry;
    task.hits[rays[i]] = now;
    ray.tfar = std::min(ray.tfar, now.t);
  }
}

}  // namespace dacrt

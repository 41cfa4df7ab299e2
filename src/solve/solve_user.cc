#include "solve/solve_user.h"

#include <algorithm>
#include <cstring>

#include "solve/callback_packet.h"

namespace dacrt {
namespace {

FullHit HitOf(const SolveTask& task, std::size_t slot, Query query) {
  constexpr FullHit kNone{0, {0, 0, 0}, 0, 0, UINT32_MAX, UINT32_MAX, UINT32_MAX};
  if (query == Query::kAny) return kNone;
  const uint32_t ray = task.batch.index[slot];
  FullHit hit = task.batch.hits[ray].mesh == Hit::kNone ? kNone : task.batch.full_hits[ray];
  hit.t = task.batch.tfar[slot];
  return hit;
}

}  // namespace

void CallUserFunction(Query query, const SolveTask& task, uint32_t geometry, uint32_t primitive,
                      std::span<const std::size_t> slots) {
  const Geometry& user = task.meshes.shapes()[geometry];
  const Callback& function = query == Query::kClosest ? user.intersect : user.occluded;
  if (!function || slots.empty()) return;
  CallbackPacket& packet = task.scratch.packet;
  const std::size_t width = task.frame->options.callback_width;
  // Of a packet of the caller's each ray stays in its lane; rays of a stream have none.
  const bool is_packet = task.frame->view.count <= width;
  const auto lane_of = [&](std::size_t i) {
    return is_packet ? task.batch.index[slots[i]] % width : i;
  };
  const auto fill = [&](std::size_t lane, std::size_t slot, int valid) {
    PacketLane(task, lane).SetRay(task, slot, task.batch.tfar[slot]);
    PacketLane(task, lane).SetHit(HitOf(task, slot, query));
    packet.valid[lane] = valid;
  };
  // Lanes without a ray hold the first one.
  for (std::size_t lane = 0; lane < width; ++lane) fill(lane, slots[0], 0);
  for (std::size_t i = 0; i < slots.size(); ++i) fill(lane_of(i), slots[i], -1);
  function(ArgumentsFor(task, query, geometry, primitive));
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const std::size_t slot = slots[i];
    float& tfar = task.batch.tfar[slot];
    const FullHit now = PacketLane(task, lane_of(i)).GetHit();
    if (query == Query::kAny) {
      if (now.t < 0) tfar = now.t;
      continue;
    }
    const FullHit before = HitOf(task, slot, query);
    if (std::memcmp(&now, &before, sizeof(now)) == 0) continue;
    const uint32_t ray = task.batch.index[slot];
    task.batch.hits[ray] = {0, 0};
    task.batch.full_hits[ray] = now;
    tfar = std::min(tfar, now.t);
  }
}

}  // namespace dacrt

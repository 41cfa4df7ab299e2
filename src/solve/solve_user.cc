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
  for (std::size_t lane = 0; lane < width; ++lane) {
    // Lanes without a ray hold the first one.
    const std::size_t slot = slots[lane < slots.size() ? lane : 0];
    PacketLane(task, lane).SetRay(task, slot, task.batch.tfar[slot]);
    PacketLane(task, lane).SetHit(HitOf(task, slot, query));
    packet.valid[lane] = lane < slots.size() ? -1 : 0;
  }
  function(ArgumentsFor(task, query, geometry, primitive));
  for (std::size_t lane = 0; lane < slots.size(); ++lane) {
    const std::size_t slot = slots[lane];
    float& tfar = task.batch.tfar[slot];
    const FullHit now = PacketLane(task, lane).GetHit();
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

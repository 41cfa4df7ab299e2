#include "solve/offer_hit.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "solve/callback_packet.h"

namespace dacrt {
namespace {

/// How hits at equal distances are ordered. Cells of one grid differ in u and v only.
auto NameOf(const FullHit& hit, uint32_t no_instance) {
  const bool in_instance = hit.instance_id != no_instance;
  return std::tuple(in_instance ? hit.instance_id : hit.geometry_id, hit.geometry_id,
                    hit.primitive_id, hit.u, hit.v);
}

/// Whether `candidate` replaces what the ray has: `hit` at `tfar`, or nothing within its own tfar.
bool IsCloser(const Candidate& candidate, const FullHit& found, const Hit& hit,
              const FullHit& full_hit, float tfar, uint32_t no_instance) {
  if (candidate.key < tfar) return true;
  // As for triangles alone, see direct_solve-inl.h.
  if (!(hit.mesh & Hit::kAtLimit ? candidate.within_limit : candidate.key == tfar)) return false;
  if (hit.mesh == Hit::kNone) return true;
  return NameOf(found, no_instance) < NameOf(full_hit, no_instance);
}

/// Shows `hit` to the filter function, which may change it. Returns whether it accepts it.
bool PassesFilter(const SolveTask& task, const Callback& filter, Query query, std::size_t slot,
                  uint32_t geometry, FullHit& hit) {
  CallbackPacket& packet = task.scratch.packet;
  const uint32_t width = task.frame->options.callback_width;
  // The lane that the ray has in a packet of the caller's, where there are packets.
  const std::size_t lane = task.batch.index[slot] % width;
  for (std::size_t i = 0; i < width; ++i) {
    // The others hold the same, rather than what an earlier callback left.
    PacketLane(task, i).SetRay(task, slot, hit.t);
    PacketLane(task, i).SetHit(hit);
    packet.valid[i] = i == lane ? -1 : 0;
  }
  filter(ArgumentsFor(task, query, geometry, hit.primitive_id));
  if (packet.valid[lane] == 0) return false;
  hit = PacketLane(task, lane).GetHit();
  return true;
}

}  // namespace

bool MayMeet(const SolveTask& task, std::size_t slot, uint32_t geometry) {
  const RayBatch& batch = task.batch;
  return !batch.ray_masks || (batch.ray_masks[batch.index[slot]] & task.meshes[geometry].mask) != 0;
}

template <Query kQuery>
void OfferHit(const SolveTask& task, std::size_t slot, const Candidate& candidate) {
  if (!MayMeet(task, slot, candidate.geometry)) return;
  RayBatch& batch = task.batch;
  const Geometry& geometry = task.meshes.shapes()[candidate.geometry];
  float& tfar = batch.tfar[slot];
  FullHit found{candidate.t,
                {candidate.ng[0], candidate.ng[1], candidate.ng[2]},
                candidate.u,
                candidate.v,
                candidate.primitive_id,
                geometry.geometry_id,
                task.frame->instance_id};
  if constexpr (kQuery == Query::kAny) {
    if (!candidate.within_limit || tfar < 0) return;
    const Callback& filter = geometry.any_filter;
    if (filter && !PassesFilter(task, filter, kQuery, slot, candidate.geometry, found)) return;
    tfar = -std::numeric_limits<float>::infinity();
  } else {
    const uint32_t ray = batch.index[slot];
    Hit& hit = batch.hits[ray];
    FullHit& full_hit = batch.full_hits[ray];
    const uint32_t no_instance = task.frame->view.instance_value;
    if (!IsCloser(candidate, found, hit, full_hit, tfar, no_instance)) return;
    float key = candidate.key;
    const Callback& filter = geometry.closest_filter;
    if (filter) {
      if (!PassesFilter(task, filter, kQuery, slot, candidate.geometry, found)) return;
      if (found.t != candidate.t) key = found.t;
    }
    const bool at_limit = key >= tfar && (hit.mesh & Hit::kAtLimit);
    hit = {0, at_limit ? Hit::kAtLimit : 0};
    full_hit = found;
    tfar = std::min(key, tfar);
  }
}

template void OfferHit<Query::kClosest>(const SolveTask&, std::size_t, const Candidate&);
template void OfferHit<Query::kAny>(const SolveTask&, std::size_t, const Candidate&);

}  // namespace dacrt

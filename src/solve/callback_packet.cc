#include "solve/callback_packet.h"

namespace dacrt {

void PacketLane::SetRay(const SolveTask& task, std::size_t slot, float tfar) const {
  using enum PacketComponent;
  const RayBatch& batch = task.batch;
  const uint32_t ray = batch.index[slot];
  const CallFrame& frame = *task.frame;
  Set(kOrgX, batch.org[0][slot]);
  Set(kOrgY, batch.org[1][slot]);
  Set(kOrgZ, batch.org[2][slot]);
  Set(kTnear, batch.tnear[slot]);
  Set(kDirX, batch.dir[0][slot]);
  Set(kDirY, batch.dir[1][slot]);
  Set(kDirZ, batch.dir[2][slot]);
  Set(kTime, frame.TimeOf(ray));
  Set(kTfar, tfar);
  Set(kMask, frame.Read(frame.view.mask, ray, UINT32_MAX));
  Set(kId, frame.Read(frame.view.id, ray, UINT32_MAX));
  Set(kFlags, frame.Read(frame.view.flags, ray, UINT32_MAX));
}

void PacketLane::SetHit(const FullHit& hit) const {
  using enum PacketComponent;
  Set(kNgX, hit.ng[0]);
  Set(kNgY, hit.ng[1]);
  Set(kNgZ, hit.ng[2]);
  Set(kU, hit.u);
  Set(kV, hit.v);
  Set(kPrimitiveId, hit.primitive_id);
  Set(kGeometryId, hit.geometry_id);
  Set(kInstanceId, hit.instance_id);
}

FullHit PacketLane::GetHit() const {
  using enum PacketComponent;
  return {Get<float>(kTfar),
          {Get<float>(kNgX), Get<float>(kNgY), Get<float>(kNgZ)},
          Get<float>(kU),
          Get<float>(kV),
          Get<uint32_t>(kPrimitiveId),
          Get<uint32_t>(kGeometryId),
          Get<uint32_t>(kInstanceId)};
}

CallbackArguments ArgumentsFor(const SolveTask& task, Query query, uint32_t geometry,
                               uint32_t primitive_id) {
  CallbackPacket& packet = task.scratch.packet;
  return {query,
          task.frame->options.callback_width,
          packet.valid,
          packet.values,
          task.meshes[geometry].geometry_id,
          primitive_id,
          task.frame->instance_id,
          task.frame->options.call};
}

}  // namespace dacrt

#include "leaf/callback_packet.h"

#include "rays/record_layout.h"

namespace dacrt {

void CallbackPacket::SetRay(std::size_t lane, RayNumber number, float tfar) {
  using enum PacketComponent;
  const RayRecord& ray = task_.rays[number];
  const RayTag tag = task_.frame.Tag(task_.CallerOf(number));
  Set(kOrgX, lane, ray.org[0]);
  Set(kOrgY, lane, ray.org[1]);
  Set(kOrgZ, lane, ray.org[2]);
  Set(kTnear, lane, ray.tnear);
  Set(kDirX, lane, ray.dir[0]);
  Set(kDirY, lane, ray.dir[1]);
  Set(kDirZ, lane, ray.dir[2]);
  Set(kTime, lane, ray.time);
  Set(kTfar, lane, tfar);
  Set(kMask, lane, ray.mask);
  Set(kId, lane, tag.id);
  Set(kFlags, lane, tag.flags);
}

void CallbackPacket::SetHit(std::size_t lane, const FullHit& hit) {
  using enum PacketComponent;
  Set(kNgX, lane, hit.ng[0]);
  Set(kNgY, lane, hit.ng[1]);
  Set(kNgZ, lane, hit.ng[2]);
  Set(kU, lane, hit.u);
  Set(kV, lane, hit.v);
  Set(kPrimitiveId, lane, hit.primitive_id);
  Set(kGeometryId, lane, hit.geometry_id);
  Set(kInstanceId, lane, hit.instance_id);
}

FullHit CallbackPacket::GetHit(std::size_t lane) const {
  return RecordLayout::ReadHit(values_, width_, lane);
}

CallbackArguments CallbackPacket::Arguments(Query query, uint32_t geometry, uint32_t primitive_id) {
  return {query,
          static_cast<uint32_t>(width_),
          valid,
          values_,
          task_.scene.geometries[geometry].geometry_id,
          primitive_id,
          task_.instance_id,
          task_.frame.options.call};
}

}  // namespace dacrt

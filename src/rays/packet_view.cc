#include "rays/packet_view.h"

#include "dacrt/callback.h"

namespace dacrt {

RayView ViewOf(const RayPacket& packet) {
  using enum PacketComponent;
  RayView view;
  view.count = view.lanes = packet.lanes;
  view.lane_stride = sizeof(float);
  view.instance_value = packet.instance_value;
  const auto at = [&](PacketComponent component) {
    return reinterpret_cast<RayView::Component>(packet.values) +
           static_cast<std::size_t>(component) * packet.lanes * sizeof(float);
  };
  view.org_x = at(kOrgX);
  view.org_y = at(kOrgY);
  view.org_z = at(kOrgZ);
  view.tnear = at(kTnear);
  view.dir_x = at(kDirX);
  view.dir_y = at(kDirY);
  view.dir_z = at(kDirZ);
  view.time = at(kTime);
  view.tfar = at(kTfar);
  if (packet.has_masks) view.mask = at(kMask);
  view.id = at(kId);
  view.flags = at(kFlags);
  view.ng_x = at(kNgX);
  view.ng_y = at(kNgY);
  view.ng_z = at(kNgZ);
  view.u = at(kU);
  view.v = at(kV);
  view.primitive_id = at(kPrimitiveId);
  view.geometry_id = at(kGeometryId);
  view.instance_id = at(kInstanceId);
  return view;
}

}  // namespace dacrt

#include "rays/packet_view.h"

#include <cstddef>

#include "dacrt/callback.h"
#include "dacrt/ray.h"

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

// A record is a packet of one.
static_assert(sizeof(RayHit) == sizeof(float) * kPacketComponents);
static_assert(offsetof(RayHit, hit) ==
              sizeof(float) * static_cast<std::size_t>(PacketComponent::kNgX));

RayView ViewOf(std::span<RayHit> rays) {
  RayView view = ViewOf(RayPacket{rays.data()});
  view.count = rays.size();
  view.packet_stride = sizeof(RayHit);
  return view;
}

RayView ViewOf(std::span<Ray> rays) {
  RayView view = ViewOf(RayPacket{rays.data()});
  view.count = rays.size();
  view.packet_stride = sizeof(Ray);
  for (RayView::Component* const component :
       {&view.ng_x, &view.ng_y, &view.ng_z, &view.u, &view.v, &view.primitive_id, &view.geometry_id,
        &view.instance_id}) {
    *component = RayView::kAbsent;
  }
  return view;
}

}  // namespace dacrt

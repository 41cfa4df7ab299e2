#include "ray_streams.h"

#include "dacrt/ray.h"

namespace dacrt::compat {
namespace {

using Component = RayView::Component;

// A packet of N rays is twelve arrays of N values, for a hit eight more; a single record is a
// packet of one. These are the arrays' places in the packet.
enum RayField {
  kOrg = 0,
  kTnear = 3,
  kDir = 4,
  kTime = 7,
  kTfar = 8,
  kMask = 9,
  kId = 10,
  kFlags = 11,
  kRayFields = 12
};
enum HitField { kNg = 0, kU = 3, kV = 4, kPrimId = 5, kGeomId = 6, kInstId = 7 };
constexpr std::size_t kValueBytes = 4;

template <std::size_t kLanes>
constexpr std::size_t Place(std::size_t field) {
  return field * kLanes * kValueBytes;
}
static_assert(offsetof(RTCRay, tnear) == Place<1>(kTnear));
static_assert(offsetof(RTCRay, dir_x) == Place<1>(kDir));
static_assert(offsetof(RTCRay, tfar) == Place<1>(kTfar));
static_assert(offsetof(RTCRay, time) == Place<1>(kTime));
static_assert(offsetof(RTCRay, id) == Place<1>(kId));
static_assert(offsetof(RTCRay, flags) == Place<1>(kFlags));
static_assert(offsetof(RTCRay, mask) == Place<1>(kMask));
static_assert(offsetof(RTCHit, u) == Place<1>(kU));
static_assert(offsetof(RTCHit, primID) == Place<1>(kPrimId));
static_assert(offsetof(RTCHit, geomID) == Place<1>(kGeomId));
static_assert(offsetof(RTCHit, instID) == Place<1>(kInstId));
static_assert(offsetof(RTCRayHit, hit) == Place<1>(kRayFields));
static_assert(offsetof(RTCRayHit4, hit) == Place<4>(kRayFields));
static_assert(offsetof(RTCRayHit8, hit) == Place<8>(kRayFields));
static_assert(offsetof(RTCRayHit16, hit) == Place<16>(kRayFields));
static_assert(offsetof(RTCRay16, tfar) == Place<16>(kTfar));
static_assert(offsetof(RTCHit16, instID) == Place<16>(kInstId));

// A program that has both kinds of records may take the one for the other.
static_assert(sizeof(RTCRayHit) == sizeof(dacrt::RayHit));
static_assert(offsetof(RTCRayHit, ray.tfar) == offsetof(dacrt::RayHit, ray.tfar));
static_assert(offsetof(RTCRayHit, hit.instID) == offsetof(dacrt::RayHit, hit.instance_id));

/// Places the components of a packet of `lanes` rays that starts at `start`, which is an address
/// or, with a table of pointers, zero.
void PlaceComponents(RayView& view, Component start, std::size_t lanes, Record record) {
  const auto ray = [&](std::size_t field) { return start + field * lanes * kValueBytes; };
  view.org_x = ray(kOrg);
  view.org_y = ray(kOrg + 1);
  view.org_z = ray(kOrg + 2);
  view.tnear = ray(kTnear);
  view.dir_x = ray(kDir);
  view.dir_y = ray(kDir + 1);
  view.dir_z = ray(kDir + 2);
  view.tfar = ray(kTfar);
  view.mask = ray(kMask);
  view.time = ray(kTime);
  view.id = ray(kId);
  view.flags = ray(kFlags);
  if (record == Record::kRay) return;

  const auto hit = [&](std::size_t field) { return ray(kRayFields + field); };
  view.ng_x = hit(kNg);
  view.ng_y = hit(kNg + 1);
  view.ng_z = hit(kNg + 2);
  view.u = hit(kU);
  view.v = hit(kV);
  view.primitive_id = hit(kPrimId);
  view.geometry_id = hit(kGeomId);
  view.instance_id = hit(kInstId);
}

Component AddressOrAbsent(const void* values) {
  return values ? reinterpret_cast<Component>(values) : RayView::kAbsent;
}

}  // namespace

RayView PacketView(void* packets, std::size_t lanes, std::size_t packet_count,
                   std::size_t packet_stride, Record record) {
  RayView view;
  view.count = lanes * packet_count;
  view.lanes = lanes;
  view.lane_stride = kValueBytes;
  view.packet_stride = packet_stride;
  PlaceComponents(view, reinterpret_cast<Component>(packets), lanes, record);
  return view;
}

RayView PointerView(const void* const* records, std::size_t count, Record record) {
  RayView view;
  view.count = count;
  view.packets = records;
  PlaceComponents(view, 0, 1, record);
  return view;
}

RayView ComponentView(const RTCRayNp& rays, std::size_t count) {
  RayView view;
  view.count = count;
  view.packet_stride = kValueBytes;
  view.org_x = AddressOrAbsent(rays.org_x);
  view.org_y = AddressOrAbsent(rays.org_y);
  view.org_z = AddressOrAbsent(rays.org_z);
  view.tnear = AddressOrAbsent(rays.tnear);
  view.dir_x = AddressOrAbsent(rays.dir_x);
  view.dir_y = AddressOrAbsent(rays.dir_y);
  view.dir_z = AddressOrAbsent(rays.dir_z);
  view.tfar = AddressOrAbsent(rays.tfar);
  view.mask = AddressOrAbsent(rays.mask);
  view.time = AddressOrAbsent(rays.time);
  view.id = AddressOrAbsent(rays.id);
  view.flags = AddressOrAbsent(rays.flags);
  return view;
}

RayView ComponentView(const RTCRayHitNp& rays, std::size_t count) {
  RayView view = ComponentView(rays.ray, count);
  view.ng_x = AddressOrAbsent(rays.hit.Ng_x);
  view.ng_y = AddressOrAbsent(rays.hit.Ng_y);
  view.ng_z = AddressOrAbsent(rays.hit.Ng_z);
  view.u = AddressOrAbsent(rays.hit.u);
  view.v = AddressOrAbsent(rays.hit.v);
  view.primitive_id = AddressOrAbsent(rays.hit.primID);
  view.geometry_id = AddressOrAbsent(rays.hit.geomID);
  view.instance_id = AddressOrAbsent(rays.hit.instID[0]);
  return view;
}

}  // namespace dacrt::compat

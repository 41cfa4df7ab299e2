#include "ray_bundle.h"

#include <bit>
#include <cstring>

namespace dacrt::mpi {
namespace {

const RayRecord kDefaults{};

/// Calls copy(bytes of the ray, their number) for each part that travels, in order. One list for
/// both directions.
template <class Ray, class RayLuggage, class Copy>
void ForEachPart(Ray& ray, RayLuggage& luggage, const RayKind& kind, const Copy& copy) {
  copy(&ray.org, 28);  // to dir
  copy(&luggage.tfar, 4);
  copy(&luggage.home, 8);  // and index
  if (kind.has_mask) copy(&ray.mask, 4);
  if (kind.has_time) copy(&ray.time, 4);
  if (kind.for_callbacks) copy(&ray.id, 8);
  if (kind.has_hit) copy(&luggage.key, 40);
}
static_assert(offsetof(RayRecord, time) == offsetof(RayRecord, org) + 28);
static_assert(offsetof(RayRecord, flags) == offsetof(RayRecord, id) + 4);
static_assert(offsetof(Luggage, index) == offsetof(Luggage, home) + 4);
static_assert(offsetof(Luggage, hit) == offsetof(Luggage, key) + 4);

}  // namespace

RayView Bundle::View(Query query) {
  const auto at = [](auto& value) { return reinterpret_cast<RayView::Component>(&value); };
  RayRecord& ray = records_[0];
  RayView view;
  view.count = size_;
  view.packet_stride = sizeof(RayRecord);
  view.org_x = at(ray.org[0]), view.org_y = at(ray.org[1]), view.org_z = at(ray.org[2]);
  view.dir_x = at(ray.dir[0]), view.dir_y = at(ray.dir[1]), view.dir_z = at(ray.dir[2]);
  view.tnear = at(ray.tnear), view.tfar = at(ray.tfar);
  view.mask = at(ray.mask), view.time = at(ray.time);
  view.id = at(ray.id), view.flags = at(ray.flags);
  if (query == Query::kAny) return view;
  view.ng_x = at(ray.ng[0]), view.ng_y = at(ray.ng[1]), view.ng_z = at(ray.ng[2]);
  view.u = at(ray.u), view.v = at(ray.v);
  view.primitive_id = at(ray.primitive_id);
  view.geometry_id = at(ray.geometry_id);
  view.instance_id = at(ray.instance_id);
  return view;
}

RayKind KindOf(const RayRecord& ray, const Luggage& luggage, bool for_callbacks) {
  return {ray.mask != kDefaults.mask, std::bit_cast<uint32_t>(ray.time) != 0, for_callbacks,
          luggage.has_hit()};
}

void PutRay(const RayRecord& ray, const Luggage& luggage, const RayKind& kind, std::byte* to) {
  ForEachPart(ray, luggage, kind, [&](const void* part, std::size_t bytes) {
    std::memcpy(to, part, bytes);
    to += bytes;
  });
}

void GetRay(const std::byte* from, const RayKind& kind, RayRecord& ray, Luggage& luggage) {
  ray = kDefaults;
  luggage = {};
  ForEachPart(ray, luggage, kind, [&](void* part, std::size_t bytes) {
    std::memcpy(part, from, bytes);
    from += bytes;
  });
  ray.tfar = luggage.FindableTo();
}

void GetRay(const RayView& rays, std::size_t i, uint32_t home, RayRecord& ray, Luggage& luggage) {
  const std::uintptr_t start = rays.Address(0, i);
  const auto read = [&](RayView::Component component, uint32_t absent) {
    if (component == RayView::kAbsent) return absent;
    uint32_t bits;
    std::memcpy(&bits, reinterpret_cast<const void*>(start + component), sizeof(bits));
    return bits;
  };
  const auto real = [&](RayView::Component component) {
    return std::bit_cast<float>(read(component, 0));
  };
  ray = kDefaults;
  ray.org[0] = real(rays.org_x), ray.org[1] = real(rays.org_y), ray.org[2] = real(rays.org_z);
  ray.dir[0] = real(rays.dir_x), ray.dir[1] = real(rays.dir_y), ray.dir[2] = real(rays.dir_z);
  ray.tnear = real(rays.tnear);
  ray.tfar = real(rays.tfar);
  ray.mask = read(rays.mask, kDefaults.mask);
  ray.time = real(rays.time);
  ray.id = read(rays.id, kDefaults.id);
  ray.flags = read(rays.flags, kDefaults.flags);
  luggage = {};
  luggage.home = home;
  luggage.index = static_cast<uint32_t>(i);
  luggage.tfar = ray.tfar;
}

}  // namespace dacrt::mpi

#include "ray_bundle.h"

#include <bit>
#include <cstring>

namespace dacrt::mpi {
namespace {

/// Calls copy(bytes of the ray, their number) for each part that a record has, in order. One list
/// for both directions.
template <class Ray, class Copy>
void ForEachPart(Ray& ray, const RecordKind& kind, const Copy& copy) {
  copy(&ray.org, 28);  // to dir
  copy(&ray.tfar, 4);
  copy(&ray.home, 8);  // and index
  if (kind.has_mask) copy(&ray.mask, 4);
  if (kind.has_time) copy(&ray.time, 4);
  if (kind.for_callbacks) copy(&ray.id, 8);
  if (kind.has_hit) copy(&ray.key, 40);
}
static_assert(offsetof(TravellingRay, time) == offsetof(TravellingRay, org) + 28);
static_assert(offsetof(TravellingRay, index) == offsetof(TravellingRay, home) + 4);
static_assert(offsetof(TravellingRay, flags) == offsetof(TravellingRay, id) + 4);
static_assert(offsetof(TravellingRay, hit) == offsetof(TravellingRay, key) + 4);

}  // namespace

void PutRay(const TravellingRay& ray, const RecordKind& kind, std::byte* to) {
  ForEachPart(ray, kind, [&](const void* part, std::size_t bytes) {
    std::memcpy(to, part, bytes);
    to += bytes;
  });
}

TravellingRay GetRay(const std::byte* from, const RecordKind& kind) {
  TravellingRay ray;
  ForEachPart(ray, kind, [&](void* part, std::size_t bytes) {
    std::memcpy(part, from, bytes);
    from += bytes;
  });
  return ray;
}

TravellingRay FromView(const RayView& rays, std::size_t i, uint32_t home) {
  const auto read = [&](RayView::Component component, uint32_t absent) {
    return component == RayView::kAbsent ? absent : ReadBits(rays, component, i);
  };
  const auto real = [&](RayView::Component component) {
    return std::bit_cast<float>(read(component, 0));
  };
  TravellingRay ray;
  ray.home = home;
  ray.index = static_cast<uint32_t>(i);
  ray.org[0] = real(rays.org_x), ray.org[1] = real(rays.org_y), ray.org[2] = real(rays.org_z);
  ray.dir[0] = real(rays.dir_x), ray.dir[1] = real(rays.dir_y), ray.dir[2] = real(rays.dir_z);
  ray.tnear = real(rays.tnear);
  ray.tfar = real(rays.tfar);
  ray.mask = read(rays.mask, UINT32_MAX);
  ray.time = real(rays.time);
  ray.id = read(rays.id, UINT32_MAX);
  ray.flags = read(rays.flags, UINT32_MAX);
  return ray;
}

}  // namespace dacrt::mpi

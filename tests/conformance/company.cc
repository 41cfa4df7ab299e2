#include "company.h"

#include <algorithm>
#include <cmath>

namespace dacrt::tests {
namespace {

/// For coherent rays up to sixteen that follow each other.
std::span<const RTCRayHit> PacketAround(const Form& form, std::span<const RTCRayHit> rays,
                                        std::size_t i) {
  if (!form.coherent) return {};
  constexpr std::size_t kWidest = 16;
  const std::size_t first = i < kWidest ? 0 : i - kWidest + 1;
  return rays.subspan(first, std::min(rays.size(), i + kWidest) - first);
}

}  // namespace

Company CompanyOf(const Form& form, Query query, std::span<const RTCRayHit> rays, std::size_t i) {
  const std::span<const RTCRayHit> packet = PacketAround(form, rays, i);
  // Up to 32 occlusion rays of a stream follow the first of them, which may be any before.
  const bool follows = IsStream(form) && !form.coherent && query == Query::kAny;
  return {packet, follows ? rays.first(i) : packet};
}

Company CompanyOf(const Form& form, Query query, std::span<const RTCRayHit> rays,
                  std::span<const RTCRayHit> answers, std::size_t i) {
  Company company = CompanyOf(form, query, rays, i);
  for (const RTCRayHit& before : company.packet) {
    const RTCRayHit& after = answers[static_cast<std::size_t>(&before - rays.data())];
    if (std::isnan(after.ray.tfar) && IsTraced(before.ray)) company.loses_its_end = true;
  }
  return company;
}

bool PlanesMayBeSwapped(const RTCRay& ray, std::span<const RTCRayHit> guides) {
  return std::any_of(guides.begin(), guides.end(), [&](const RTCRayHit& other) {
    bool loses_sign = false;
    for (int axis = 0; axis < 3; ++axis) {
      const float own = (&ray.dir_x)[axis], first = (&other.ray.dir_x)[axis];
      if ((own < 0) != (first < 0)) return false;
      loses_sign = loses_sign || (first < 0 && -first < 1 / kLargestReciprocal);
    }
    return loses_sign;
  });
}

}  // namespace dacrt::tests

#include "hit_check.h"

#include <sstream>

#include "errors.h"

namespace dacrt::bench {

void HitCheck::Check(const std::string& method, const RayBuffer& rays) {
  if (fingerprints_.empty()) {
    first_method_ = method;
    fingerprints_.reserve(rays.rays().size());
    for (const RayRecord& ray : rays.rays()) fingerprints_.push_back(Fingerprint(query_, ray));
    return;
  }
  std::size_t differences = 0;
  std::size_t first = 0;
  for (std::size_t i = rays.rays().size(); i-- > 0;) {
    if (Fingerprint(query_, rays.rays()[i]) == fingerprints_[i]) continue;
    ++differences;
    first = i;
  }
  if (differences > 0) Fail(method, rays, differences, first);
}

void HitCheck::Fail(const std::string& method, const RayBuffer& rays, std::size_t differences,
                    std::size_t first) const {
  const RayRecord& ray = rays.rays()[first];
  std::ostringstream text;
  text.precision(9);
  text << method << " and " << first_method_ << " differ in " << differences << " of "
       << rays.rays().size() << " rays, first in ray " << first << " from " << ray.org[0] << ' '
       << ray.org[1] << ' ' << ray.org[2] << " along " << ray.dir[0] << ' ' << ray.dir[1] << ' '
       << ray.dir[2] << ", where " << method << " has tfar " << ray.tfar;
  if (query_ == Query::kClosest) text << " and primitive " << ray.primitive_id;
  throw Disagreement(text.str());
}

}  // namespace dacrt::bench

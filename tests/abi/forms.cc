#include "forms.h"

#include <cmath>

#include "session.h"

namespace dacrt::tests {
namespace {

EmbreeApi ToEmbreeApi(const Api& api) {
  EmbreeApi result;
#define X(name) result.name = api.name;
  DACRT_TESTS_EMBREE_FUNCTIONS(X)
#undef X
  result.path = api.name;
  return result;
}

bool Misses(int number) { return number % 10 == 7; }
bool IsInactive(int number) { return number == 13; }

RTCRayHit RayNumber(int number) {
  RTCRayHit record = RayAt((Misses(number) ? 5 : 0.3f) + 0.01f * static_cast<float>(number));
  record.ray.id = 100 + number;
  record.ray.flags = 200 + number;
  record.ray.mask = 0x10001u << number % 16;
  record.hit.u = 7;
  if (IsInactive(number)) {
    record.ray.tnear = 2;
    record.ray.tfar = 1;  // before the square, for the form without tnear
  }
  return record;
}

}  // namespace

bool MeetsSquare(int number) { return !Misses(number) && !IsInactive(number); }

int NumberOf(float org_x) {
  return static_cast<int>(std::lround((org_x - (org_x > 4 ? 5 : 0.3f)) * 100));
}

std::vector<RTCRayHit> RowOfRays(const Form& form) {
  std::vector<RTCRayHit> rays;
  for (int number = 0; number < kRays; ++number) rays.push_back(RayNumber(number));
  ReplaceAbsent(form, rays);
  return rays;
}

std::vector<Form> AllForms() {
  std::vector<Form> forms = PacketForms();
  for (const Form& form : StreamForms()) forms.push_back(form);
  return forms;
}

std::vector<RTCRayHit> Trace(const Api& api, RTCScene scene, RTCIntersectContext& context,
                             const Form& form, Query query, std::span<const RTCRayHit> rays) {
  return Trace(ToEmbreeApi(api), scene, context, form, query, rays);
}

}  // namespace dacrt::tests

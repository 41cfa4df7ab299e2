#include "forms.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "session.h"

namespace dacrt::tests {
namespace {

constexpr float kUlp = std::numeric_limits<float>::epsilon();  // of 1

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

void SetLane(RTCRayN* rays, unsigned int lanes, unsigned int lane, const RTCRay& ray) {
  float values[sizeof(RTCRay) / sizeof(float)];
  std::memcpy(values, &ray, sizeof ray);
  float* to = reinterpret_cast<float*>(rays) + lane;
  for (const float value : values) {
    std::memcpy(to, &value, sizeof value);  // which may be no float
    to += lanes;
  }
}

namespace {

template <unsigned int kLanes, class Packet, class Function>
std::size_t TraceThirds(Function function, RTCScene scene, RTCIntersectContext& context) {
  alignas(64) int valid[kLanes];
  alignas(64) Packet packet{};
  std::size_t valid_count = 0;
  for (unsigned int lane = 0; lane < kLanes; ++lane) {
    valid[lane] = lane % 3 == 1 ? -1 : 0;
    valid_count += lane % 3 == 1;
    RTCRay ray = RayNumber(0).ray;
    ray.id = lane;
    SetLane(reinterpret_cast<RTCRayN*>(&packet), kLanes, lane, ray);
  }
  function(valid, scene, &context, &packet);
  return valid_count;
}

}  // namespace

std::size_t TraceThirdsOfPackets(const Session& s, RTCScene scene, RTCIntersectContext& context) {
  const std::size_t valid_rays = TraceThirds<4, RTCRayHit4>(s.api.rtcIntersect4, scene, context) +
                                 TraceThirds<8, RTCRayHit8>(s.api.rtcIntersect8, scene, context) +
                                 TraceThirds<4, RTCRay4>(s.api.rtcOccluded4, scene, context) +
                                 TraceThirds<8, RTCRay8>(s.api.rtcOccluded8, scene, context);
  if (!HasPacketsOf16(s)) return valid_rays;
  return valid_rays + TraceThirds<16, RTCRayHit16>(s.api.rtcIntersect16, scene, context) +
         TraceThirds<16, RTCRay16>(s.api.rtcOccluded16, scene, context);
}

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

void ExpectSameHit(const RTCHit& ours, const RTCHit& real, float t) {
  EXPECT_EQ(ours.geomID, real.geomID);
  EXPECT_EQ(ours.primID, real.primID);
  EXPECT_EQ(ours.instID[0], real.instID[0]);
  EXPECT_NEAR(ours.u, real.u, 4 * kUlp);
  EXPECT_NEAR(ours.v, real.v, 4 * kUlp);
  EXPECT_NEAR(ours.Ng_x, real.Ng_x, 4 * kUlp);
  EXPECT_NEAR(ours.Ng_y, real.Ng_y, 4 * kUlp);
  EXPECT_NEAR(ours.Ng_z, real.Ng_z, 2 * kUlp * std::abs(t));
}

void ExpectSameRays(std::span<const RTCRayHit> ours, std::span<const RTCRayHit> real) {
  for (std::size_t i = 0; i < ours.size(); ++i) {
    SCOPED_TRACE("ray " + std::to_string(i));
    const float t = real[i].ray.tfar;
    if (std::isinf(t)) {
      EXPECT_EQ(ours[i].ray.tfar, t);
    } else {
      EXPECT_NEAR(ours[i].ray.tfar, t, 4 * kUlp * std::max(1.0f, std::abs(t)));
    }
    ExpectSameHit(ours[i].hit, real[i].hit, t);
  }
}

bool AreSame(const RTCRayHit& a, const RTCRayHit& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace dacrt::tests

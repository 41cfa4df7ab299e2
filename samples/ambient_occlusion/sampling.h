// Where rays start and go: numbers spread evenly, the same in every run, and rays made of them.
#pragma once

#include <Imath/ImathVec.h>
#include <embree3/rtcore.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace ao {

// A good hash of 32 bits (Mueller's finalizer, as improved by Ettinger's prospector: "lowbias32").
inline uint32_t Hash(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352d;
  x = (x ^ (x >> 15)) * 0x846ca68b;
  return x ^ (x >> 16);
}

// From 0 to just below 1.
inline float UnitInterval(uint32_t bits) { return float(bits >> 8) * 0x1p-24f; }

// The digits of i in the base, mirrored at the point.
inline float VanDerCorput(uint32_t i, uint32_t base) {
  double value = 0;
  for (double digit = 1.0 / base; i > 0; i /= base, digit /= base) value += (i % base) * digit;
  return float(value);
}

// The points of Hammersley's set, shifted as a whole by a hash of the pixel (Cranley and Patterson,
// "Randomization of Number Theoretic Methods for Multiple Integration", 1976): spread evenly within
// a pixel, and without a pattern from one pixel to the next.
class PixelSamples {
 public:
  PixelSamples(uint32_t pixel, uint32_t seed, uint32_t count) : count_(count) {
    const uint32_t hash = Hash(pixel ^ Hash(seed));
    shift_x_ = UnitInterval(hash);
    shift_y_ = UnitInterval(Hash(hash + 0x9e3779b9));
  }

  Imath::V2f operator()(uint32_t i) const {
    return {Wrap((i + 0.5f) / count_ + shift_x_), Wrap(VanDerCorput(i, 2) + shift_y_)};
  }

 private:
  static float Wrap(float x) { return x < 1 ? x : x - 1; }

  uint32_t count_;
  float shift_x_;
  float shift_y_;
};

// A direction round the unit normal, as likely as the cosine of the angle between the two. The
// basis is that of Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
inline Imath::V3f CosineDirection(const Imath::V3f& normal, const Imath::V2f& sample) {
  const float sign = std::copysign(1.0f, normal.z);
  const float a = -1 / (sign + normal.z);
  const float b = normal.x * normal.y * a;
  const Imath::V3f x(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
  const Imath::V3f y(b, sign + normal.y * normal.y * a, -normal.y);
  const float angle = 2 * std::numbers::pi_v<float> * sample.x;
  const float radius = std::sqrt(sample.y);
  return x * (radius * std::cos(angle)) + y * (radius * std::sin(angle)) +
         normal * std::sqrt(1 - sample.y);
}

inline RTCRay MakeRay(const Imath::V3f& origin, const Imath::V3f& direction,
                      float tfar = std::numeric_limits<float>::infinity()) {
  return {.org_x = origin.x,
          .org_y = origin.y,
          .org_z = origin.z,
          .tnear = 0,
          .dir_x = direction.x,
          .dir_y = direction.y,
          .dir_z = direction.z,
          .time = 0,
          .tfar = tfar,
          .mask = ~0u,
          .id = 0,
          .flags = 0};
}

inline RTCRayHit MakeRayHit(const Imath::V3f& origin, const Imath::V3f& direction) {
  RTCRayHit ray_hit{};
  ray_hit.ray = MakeRay(origin, direction);
  ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray_hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return ray_hit;
}

}  // namespace ao

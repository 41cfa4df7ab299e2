#include "automatic_view.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "random.h"
#include "ray_buffer.h"

namespace dacrt::bench {
namespace {

using Imath::Box3f;
using Imath::V3f;

constexpr int kPlaces = 512;
constexpr int kDirections = 128;

V3f Vector(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

// Directions spread evenly over the sphere: the spherical Fibonacci lattice.
V3f Direction(int i) {
  const float y = 1 - 2 * (i + 0.5f) / kDirections;
  const float angle = 2 * std::numbers::pi_v<float> * (i / std::numbers::phi_v<float>);
  const float radius = std::sqrt(1 - y * y);
  return {radius * std::cos(angle), y, radius * std::sin(angle)};
}

// How far one sees from places spread over the bounds.
class Survey {
 public:
  Survey(const BenchScene& scene, const Box3f& bounds) : rays_(kPlaces * kDirections) {
    tests::Random random(1);
    rays_.Begin(kInfinity);
    for (int place = 0; place < kPlaces; ++place) {
      V3f org;
      for (int axis = 0; axis < 3; ++axis) {
        org[axis] = random.Uniform(bounds.min[axis], bounds.max[axis]);
      }
      for (int i = 0; i < kDirections; ++i) {
        const V3f dir = Direction(i);
        rays_.Append({org.x, org.y, org.z}, {dir.x, dir.y, dir.z}, 0);
      }
    }
    const TriangleMesh mesh = scene.AsTriangleMesh();
    Scene(std::make_shared<Device>(), {&mesh, 1}).Trace(Query::kClosest, rays_.View());
  }

  V3f Place(int place) const { return Vector(Ray(place, 0).org); }

  // Infinite where nothing is seen.
  float Distance(int place, int direction) const { return Ray(place, direction).tfar; }

  // Whether something is seen in nearly every direction, never close by, and mostly the fronts of
  // triangles. (The inside of a solid body shows their backs.)
  bool IsInRoom(int place, float clearance) const {
    int hits = 0;
    int fronts = 0;
    for (int i = 0; i < kDirections; ++i) {
      if (Distance(place, i) < clearance) return false;
      if (!std::isfinite(Distance(place, i))) continue;
      ++hits;
      fronts += Vector(Ray(place, i).ng).dot(Direction(i)) < 0;
    }
    return hits >= kDirections * 9 / 10 && 2 * fronts > hits;
  }

  // The mean distance of what a camera in that direction sees.
  float Depth(int place, int forward) const {
    float depth = 0;
    int seen = 0;
    for (int i = 0; i < kDirections; ++i) {
      constexpr float kInView = 0.8f;  // cosine of the angle to the middle of the picture
      if (Direction(i).dot(Direction(forward)) < kInView) continue;
      ++seen;
      if (std::isfinite(Distance(place, i))) depth += Distance(place, i);
    }
    return depth / seen;
  }

 private:
  const RayRecord& Ray(int place, int direction) const {
    return rays_.rays()[place * kDirections + direction];
  }

  RayBuffer rays_;
};

struct ViewAndLamp {
  BenchView view;
  Lamp lamp;
};

std::optional<ViewAndLamp> InRoom(const BenchScene& scene, const Box3f& bounds) {
  const float diagonal = bounds.size().length();
  const Survey survey(scene, bounds);
  constexpr int kUp = 0;  // the first direction is the steepest
  int places_in_rooms = 0;
  float best_depth = 0;
  std::optional<ViewAndLamp> best;
  for (int place = 0; place < kPlaces; ++place) {
    constexpr float kClearance = 0.02f;  // of the diagonal
    if (!survey.IsInRoom(place, kClearance * diagonal)) continue;
    ++places_in_rooms;
    for (int forward = 0; forward < kDirections; ++forward) {
      constexpr float kSteepest = 0.2f;  // sine of the angle to the horizon
      if (std::abs(Direction(forward).y) > kSteepest) continue;
      const float depth = survey.Depth(place, forward);
      if (depth <= best_depth) continue;
      best_depth = depth;
      const V3f eye = survey.Place(place);
      // Half way to the ceiling; the clearance leaves room for a panel of this size.
      const float height = std::min(survey.Distance(place, kUp), diagonal) / 2;
      best = {{eye, eye + Direction(forward) * depth, 65},
              {eye + V3f(0, height, 0), kClearance * diagonal / 2}};
    }
  }
  constexpr int kLeastPlaces = kPlaces / 20;  // for a mesh to be an interior
  if (places_in_rooms < kLeastPlaces) return std::nullopt;
  return best;
}

ViewAndLamp FromAbove(const Box3f& bounds) {
  const float diagonal = bounds.size().length();
  const V3f towards_eye = V3f(0.5f, 0.45f, 1).normalized();
  return {{bounds.center() + towards_eye * diagonal, bounds.center(), 50},
          {bounds.center() + V3f(-0.3f, 1, 0.3f) * diagonal, 0.05f * diagonal}};
}

}  // namespace

void ChooseViewAndLamp(BenchScene& scene) {
  const Box3f bounds = Bounds(scene.mesh);
  const ViewAndLamp chosen = InRoom(scene, bounds).value_or(FromAbove(bounds));
  scene.view = chosen.view;
  scene.lamp = chosen.lamp;
}

}  // namespace dacrt::bench

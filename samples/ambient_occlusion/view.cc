#include "ambient_occlusion/view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/sampling.h"

namespace ao {
namespace {

using Imath::Box3f;
using Imath::V3f;

constexpr float kDefaultFov = 50;  // degrees

float Radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

// The mesh as seen from a number of places spread over its bounds, in directions spread evenly.
struct Survey {
  static constexpr uint32_t kPlaces = 512;
  static constexpr uint32_t kDirections = 128;

  std::vector<V3f> places;
  std::vector<V3f> directions;
  std::vector<float> distances;  // of place after place; infinite where nothing is hit
  float hit_share;

  const float* DistancesFrom(uint32_t place) const { return &distances[place * kDirections]; }
};

Survey MakeSurvey(const Scene& scene, const Box3f& bounds) {
  Survey survey;
  for (uint32_t i = 0; i < Survey::kPlaces; ++i) {
    const V3f within(VanDerCorput(i, 2), VanDerCorput(i, 3), VanDerCorput(i, 5));
    survey.places.push_back(bounds.min + bounds.size() * within);
  }
  for (uint32_t i = 0; i < Survey::kDirections; ++i) {
    const float z = 1 - 2 * (i + 0.5f) / Survey::kDirections;
    const float angle = 2 * std::numbers::pi_v<float> * VanDerCorput(i, 2);
    const float radius = std::sqrt(1 - z * z);
    survey.directions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }

  std::vector<RTCRayHit> rays;
  rays.reserve(size_t(Survey::kPlaces) * Survey::kDirections);
  for (const V3f& place : survey.places) {
    for (const V3f& direction : survey.directions) {
      rays.push_back(MakeRayHit(place, direction));
    }
  }
  scene.Intersect(rays.data(), unsigned(rays.size()), RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);

  size_t hits = 0;
  for (const RTCRayHit& ray : rays) {
    survey.distances.push_back(ray.ray.tfar);
    hits += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  survey.hit_share = float(hits) / float(rays.size());
  return survey;
}

// From a place that has some free space round it, along the direction in which the view is deepest:
// the mean free distance within the field of view.
View InteriorView(const Survey& survey, const Box3f& bounds, const V3f& up) {
  const float kFree = 0.02f * bounds.size().length();  // round the eye
  constexpr float kSteepest = 0.3f;                    // sine of the angle to the horizon
  const float kInView = std::cos(Radians(kDefaultFov / 2));
  View best{bounds.center(), bounds.center(), up, kDefaultFov};
  float best_depth = 0;
  for (uint32_t place = 0; place < Survey::kPlaces; ++place) {
    const float* distances = survey.DistancesFrom(place);
    if (*std::min_element(distances, distances + Survey::kDirections) < kFree) continue;
    for (const V3f& forward : survey.directions) {
      if (std::abs(forward.dot(up.normalized())) > kSteepest) continue;
      float depth = 0;
      int seen = 0;
      for (uint32_t i = 0; i < Survey::kDirections; ++i) {
        if (survey.directions[i].dot(forward) < kInView) continue;
        // What opens to the outside is no deeper than what ends at a wall.
        depth += std::isfinite(distances[i]) ? distances[i] : 0;
        ++seen;
      }
      if (depth / seen > best_depth) {
        best_depth = depth / seen;
        best.eye = survey.places[place];
        best.look_at = best.eye + forward * best_depth;
      }
    }
  }
  return best;
}

View ExteriorView(const Box3f& bounds, const V3f& up, float vertical_fov, float aspect) {
  // Seen from the front, somewhat from the right and from above.
  const V3f side =
      std::abs(up.normalized().z) < 0.9f ? V3f(0, 0, 1).cross(up).normalized() * -1 : V3f(1, 0, 0);
  const V3f front = side.cross(up).normalized();
  const V3f towards_eye = (front + side * 0.5f + up.normalized() * 0.45f).normalized();
  const float half_vertical = Radians(vertical_fov / 2);
  const float half_horizontal = std::atan(std::tan(half_vertical) * aspect);
  // The sphere round the bounds touches the edges of the picture.
  const float radius = bounds.size().length() / 2;
  const float distance = radius / std::sin(std::min(half_vertical, half_horizontal));
  return {bounds.center() + towards_eye * distance, bounds.center(), up, vertical_fov};
}

View AutomaticView(const Options& options, const Scene& scene) {
  const V3f up = options.up.value_or(V3f(0, 1, 0));
  const float fov = options.vertical_fov.value_or(kDefaultFov);
  const Box3f bounds = scene.Bounds();
  constexpr float kEnclosed = 0.8f;  // share of the rays that end inside of a room
  const Survey survey = MakeSurvey(scene, bounds);
  View view = survey.hit_share > kEnclosed
                  ? InteriorView(survey, bounds, up)
                  : ExteriorView(bounds, up, fov, float(options.width) / options.height);
  view.vertical_fov = fov;
  return view;
}

}  // namespace

View ChooseView(const Options& options, const Scene& scene) {
  View view;
  if (options.mesh.empty()) {
    const scenes::Camera camera = scenes::HallCamera();
    view = {V3f(camera.eye), V3f(camera.look_at), V3f(camera.up), camera.vertical_fov};
  } else if (options.eye && options.look_at) {
    view = {*options.eye, *options.look_at, V3f(0, 1, 0), kDefaultFov};
  } else {
    view = AutomaticView(options, scene);
    if (options.eye) view.look_at = scene.Bounds().center();
  }
  view.eye = options.eye.value_or(view.eye);
  view.look_at = options.look_at.value_or(view.look_at);
  view.up = options.up.value_or(view.up);
  view.vertical_fov = options.vertical_fov.value_or(view.vertical_fov);
  return view;
}

Camera::Camera(const View& view, uint32_t width, uint32_t height) : eye_(view.eye) {
  const V3f forward = (view.look_at - view.eye).normalized();
  const V3f right = forward.cross(view.up.normalized());
  constexpr float kParallel = 1e-6f;
  if (!(right.length() > kParallel)) {
    throw Error(ExitCode::kUsage,
                "the camera has no direction: --eye, --look-at and --up are in one line");
  }
  const V3f down = forward.cross(right.normalized()).normalized();
  const float pixel = 2 * std::tan(Radians(view.vertical_fov / 2)) / height;
  right_ = right.normalized() * pixel;
  down_ = down * pixel;
  corner_ = forward - right_ * (width / 2.0f) - down_ * (height / 2.0f);
}

V3f Camera::DirectionThrough(float x, float y) const {
  return (corner_ + right_ * x + down_ * y).normalized();
}

}  // namespace ao

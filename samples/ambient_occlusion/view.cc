#include "ambient_occlusion/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/sampling.h"

namespace ao {
namespace {

using Imath::Box3f;
using Imath::V3f;

constexpr float kDefaultFov = 50;  // degrees

float Radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

// What one sees from a number of places spread over the bounds, in directions spread evenly.
class Survey {
 public:
  static constexpr uint32_t kPlaces = 1024;
  static constexpr uint32_t kDirections = 256;

  Survey(const Scene& scene, const Box3f& bounds);

  const V3f& Place(uint32_t place) const { return places_[place]; }
  const V3f& Direction(uint32_t direction) const { return directions_[direction]; }

  // Whether the place is within a room: mostly enclosed, some way from anything, and surrounded by
  // the front faces of triangles. (The inside of a solid body shows their backs.)
  bool IsInRoom(uint32_t place, float clearance) const;

  // How good a view is: the room is wide, the view deep, and many different triangles are in sight.
  float Score(uint32_t place, uint32_t forward) const;

 private:
  const RTCRayHit& Ray(uint32_t place, uint32_t direction) const {
    return rays_[place * kDirections + direction];
  }

  std::vector<V3f> places_;
  std::vector<V3f> directions_;
  std::vector<RTCRayHit> rays_;
};

Survey::Survey(const Scene& scene, const Box3f& bounds) {
  for (uint32_t i = 0; i < kPlaces; ++i) {
    const V3f within(VanDerCorput(i, 2), VanDerCorput(i, 3), VanDerCorput(i, 5));
    places_.push_back(bounds.min + bounds.size() * within);
  }
  for (uint32_t i = 0; i < kDirections; ++i) {
    const float z = 1 - 2 * (i + 0.5f) / kDirections;
    const float angle = 2 * std::numbers::pi_v<float> * VanDerCorput(i, 2);
    const float radius = std::sqrt(1 - z * z);
    directions_.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  rays_.reserve(size_t(kPlaces) * kDirections);
  for (const V3f& place : places_) {
    for (const V3f& direction : directions_) rays_.push_back(MakeRayHit(place, direction));
  }
  scene.Intersect(rays_.data(), unsigned(rays_.size()), RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
}

bool Survey::IsInRoom(uint32_t place, float clearance) const {
  constexpr uint32_t kEnclosed = kDirections * 3 / 4;
  uint32_t hits = 0;
  uint32_t fronts = 0;
  for (uint32_t i = 0; i < kDirections; ++i) {
    const auto& [ray, hit] = Ray(place, i);
    if (hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    if (ray.tfar < clearance) return false;
    ++hits;
    fronts += V3f(hit.Ng_x, hit.Ng_y, hit.Ng_z).dot(directions_[i]) < 0;
  }
  return hits >= kEnclosed && 2 * fronts > hits;
}

float Survey::Score(uint32_t place, uint32_t forward) const {
  const float in_view = std::cos(Radians(40));
  float width = 0;
  float depth = 0;
  std::set<unsigned> triangles;
  for (uint32_t i = 0; i < kDirections; ++i) {
    // Where one sees out of the mesh, there is nothing to see.
    const float distance = Ray(place, i).ray.tfar;
    if (!std::isfinite(distance)) continue;
    width += distance;
    if (directions_[i].dot(directions_[forward]) < in_view) continue;
    depth += distance;
    triangles.insert(Ray(place, i).hit.primID);
  }
  return width * depth * float(triangles.size());
}

// The best view from a place in a room, if there are rooms.
std::optional<View> InteriorView(const Scene& scene, const Box3f& bounds, const V3f& up) {
  const float clearance = 0.02f * bounds.size().length();
  constexpr uint32_t kLeastPlaces = Survey::kPlaces / 20;  // in rooms, for a mesh to be an interior
  constexpr float kSteepest = 0.15f;                       // sine of the angle to the horizon
  const Survey survey(scene, bounds);
  uint32_t places_in_rooms = 0;
  float best_score = 0;
  std::optional<View> best;
  for (uint32_t place = 0; place < Survey::kPlaces; ++place) {
    if (!survey.IsInRoom(place, clearance)) continue;
    ++places_in_rooms;
    for (uint32_t forward = 0; forward < Survey::kDirections; ++forward) {
      const V3f& direction = survey.Direction(forward);
      if (std::abs(direction.dot(up.normalized())) > kSteepest) continue;
      if (const float score = survey.Score(place, forward); score > best_score) {
        best_score = score;
        best = View{survey.Place(place), survey.Place(place) + direction, up, kDefaultFov};
      }
    }
  }
  if (places_in_rooms < kLeastPlaces) return std::nullopt;
  return best;
}

// Obliquely from above, as near as the bounds fit into the picture.
View ExteriorView(const Box3f& bounds, const V3f& up, float vertical_fov, float aspect) {
  const V3f above = up.normalized();
  const V3f aside =
      above.cross(std::abs(above.z) < 0.9f ? V3f(0, 0, 1) : V3f(0, -1, 0)).normalized();
  const V3f towards_eye = (aside.cross(above) + aside * 0.5f + above * 0.45f).normalized();
  const V3f right = above.cross(towards_eye).normalized();
  const V3f top = towards_eye.cross(right);

  const float slope_y = std::tan(Radians(vertical_fov / 2));
  const float slope_x = slope_y * aspect;
  const V3f half = bounds.size() / 2;
  float distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const V3f c(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y,
                corner & 4 ? half.z : -half.z);
    distance = std::max({distance, c.dot(towards_eye) + std::abs(c.dot(right)) / slope_x,
                         c.dot(towards_eye) + std::abs(c.dot(top)) / slope_y});
  }
  constexpr float kMargin = 1.05f;
  return {bounds.center() + towards_eye * (kMargin * distance), bounds.center(), up, vertical_fov};
}

View AutomaticView(const Options& options, const Scene& scene) {
  const V3f up = options.up.value_or(V3f(0, 1, 0));
  const Box3f bounds = scene.Bounds();
  if (const auto view = InteriorView(scene, bounds, up)) return *view;
  return ExteriorView(bounds, up, options.vertical_fov.value_or(kDefaultFov),
                      float(options.width) / options.height);
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

#include "rays.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "random.h"

namespace dacrt::tests {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kPi = std::numbers::pi_v<float>;

Float3 Origin(const RTCRay& ray) { return {ray.org_x, ray.org_y, ray.org_z}; }
Float3 Direction(const RTCRay& ray) { return {ray.dir_x, ray.dir_y, ray.dir_z}; }

void SetOrigin(RTCRay& ray, const Float3& origin) {
  ray.org_x = origin.x;
  ray.org_y = origin.y;
  ray.org_z = origin.z;
}

void SetDirection(RTCRay& ray, const Float3& direction) {
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
}

bool IsHit(const RTCRayHit& record) { return record.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

Float3 HitPoint(const RTCRayHit& record) {
  return Origin(record.ray) + record.ray.tfar * Direction(record.ray);
}

Float3 RandomDirection(Random& random) {
  const float z = random.Uniform(-1, 1);
  const float phi = random.Uniform(0, 2 * kPi);
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Distributed by the cosine about the side of the surface that the ray came from.
Float3 CosineDirection(const RTCRayHit& record, Random& random) {
  Float3 normal = Normalized(Float3{record.hit.Ng_x, record.hit.Ng_y, record.hit.Ng_z});
  if (Dot(normal, Direction(record.ray)) > 0) normal = -1.0f * normal;
  return Normalized(normal + 0.999f * RandomDirection(random));
}

}  // namespace

std::vector<RayKind> AllRayKinds() {
  return {RayKind::kCamera,      RayKind::kAmbientOcclusion, RayKind::kDiffuse,
          RayKind::kRandomLines, RayKind::kAxisAligned,      RayKind::kZeroComponents,
          RayKind::kEdges,       RayKind::kSurface,          RayKind::kShort,
          RayKind::kTfarAtHit,   RayKind::kTnearAtHit,       RayKind::kNegativeTnear,
          RayKind::kMasks,       RayKind::kUnnormalised,     RayKind::kHostile};
}

const char* Name(RayKind kind) {
  switch (kind) {
    case RayKind::kCamera:
      return "camera";
    case RayKind::kAmbientOcclusion:
      return "ambient_occlusion";
    case RayKind::kDiffuse:
      return "diffuse";
    case RayKind::kRandomLines:
      return "random_lines";
    case RayKind::kAxisAligned:
      return "axis_aligned";
    case RayKind::kZeroComponents:
      return "zero_components";
    case RayKind::kEdges:
      return "edges";
    case RayKind::kSurface:
      return "surface";
    case RayKind::kShort:
      return "short";
    case RayKind::kTfarAtHit:
      return "tfar_at_hit";
    case RayKind::kTnearAtHit:
      return "tnear_at_hit";
    case RayKind::kNegativeTnear:
      return "negative_tnear";
    case RayKind::kMasks:
      return "masks";
    case RayKind::kUnnormalised:
      return "unnormalised";
    case RayKind::kHostile:
      return "hostile";
  }
  return "?";
}

/// The rays of one call of Make, and the ways of filling them.
class RayGenerator::Batch {
 public:
  Batch(const RayGenerator& generator, std::size_t count, uint64_t seed)
      : generator_(generator), random_(seed), rays_(count) {
    for (RTCRayHit& record : rays_) {
      RTCRay& ray = record.ray;
      ray.tnear = 0;
      ray.tfar = kInfinity;
      ray.time = random_.Uniform();
      ray.mask = UINT32_MAX;
      ray.id = random_.Bits();
      ray.flags = random_.Bits();
      record.hit = {std::bit_cast<float>(random_.Bits()),
                    std::bit_cast<float>(random_.Bits()),
                    std::bit_cast<float>(random_.Bits()),
                    std::bit_cast<float>(random_.Bits()),
                    std::bit_cast<float>(random_.Bits()),
                    random_.Bits(),
                    RTC_INVALID_GEOMETRY_ID,
                    {random_.Bits()}};
    }
  }

  std::vector<RTCRayHit> Take() && { return std::move(rays_); }

  void Fill(RayKind kind) {
    switch (kind) {
      case RayKind::kCamera:
        return Camera();
      case RayKind::kAmbientOcclusion:
        return AmbientOcclusion();
      case RayKind::kDiffuse:
        return Diffuse();
      case RayKind::kRandomLines:
        return ForEach([this](RTCRay& ray) { RandomLine(ray); });
      case RayKind::kAxisAligned:
        return ForEach([this](RTCRay& ray) { AxisAligned(ray, 1); });
      case RayKind::kZeroComponents:
        return ForEach([this](RTCRay& ray) { AxisAligned(ray, 2); });
      case RayKind::kEdges:
        return ForEach([this](RTCRay& ray) { AtEdge(ray); });
      case RayKind::kSurface:
        return Surface();
      case RayKind::kShort:
        return ForEach([this](RTCRay& ray) { Short(ray); });
      case RayKind::kTfarAtHit:
        return AtHit(&RTCRay::tfar);
      case RayKind::kTnearAtHit:
        return AtHit(&RTCRay::tnear);
      case RayKind::kNegativeTnear:
        return ForEach([this](RTCRay& ray) { NegativeTnear(ray); });
      case RayKind::kMasks:
        return ForEach([this](RTCRay& ray) { Masked(ray); });
      case RayKind::kUnnormalised:
        return ForEach([this](RTCRay& ray) { Unnormalised(ray); });
      case RayKind::kHostile:
        return ForEach([this](RTCRay& ray) { Hostile(ray); });
    }
  }

 private:
  template <typename FillRay>
  void ForEach(const FillRay& fill) {
    for (RTCRayHit& record : rays_) fill(record.ray);
  }

  const TestScene& scene() const { return generator_.scene_; }
  const TestScene::Corners& bounds() const { return generator_.bounds_; }
  float Diagonal() const { return Length(bounds().upper - bounds().lower); }

  /// In the bounds, enlarged about their centre.
  Float3 RandomPoint(float enlarged) {
    Float3 point;
    for (int axis = 0; axis < 3; ++axis) {
      const float center = 0.5f * (bounds().lower[axis] + bounds().upper[axis]);
      const float half = 0.5f * (bounds().upper[axis] - bounds().lower[axis]);
      point[axis] = center + enlarged * half * random_.Uniform(-1, 1);
    }
    return point;
  }

  /// The corners of any triangle of any mesh; a made-up one if there are none.
  std::array<Float3, 3> RandomTriangle() {
    if (scene().TriangleCount() == 0) return {Float3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (;;) {
      const auto mesh_count = static_cast<uint32_t>(scene().meshes.size());
      const TestMesh& mesh = scene().meshes[random_.Below(mesh_count)];
      if (mesh.triangles.empty()) continue;
      const auto triangle_count = static_cast<uint32_t>(mesh.triangles.size());
      const Triangle& triangle = mesh.triangles[random_.Below(triangle_count)];
      return {mesh.positions[triangle.vertex[0]], mesh.positions[triangle.vertex[1]],
              mesh.positions[triangle.vertex[2]]};
    }
  }

  tests::Camera RandomCamera() {
    const auto& cameras = scene().cameras;
    if (!cameras.empty()) return cameras[random_.Below(static_cast<uint32_t>(cameras.size()))];
    const Float3 center = 0.5f * (bounds().lower + bounds().upper);
    return {center + 1.2f * Diagonal() * RandomDirection(random_), center, 50};
  }

  void Camera() {
    const tests::Camera camera = RandomCamera();
    const Float3 forward = Normalized(camera.target - camera.eye);
    Float3 right = Normalized(Cross(forward, Float3{0, 1, 0}));
    if (Length(right) == 0) right = {1, 0, 0};
    const Float3 up = Cross(right, forward);
    const float scale = std::tan(0.5f * kPi / 180 * camera.vertical_fov_degrees);
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(rays_.size())));
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const auto pixel = [&](std::size_t p) {
        return scale * (2 * (static_cast<float>(p) + random_.Uniform()) / side - 1);
      };
      const float x = pixel(i % side);
      const float y = pixel(i / side);
      SetOrigin(rays_[i].ray, camera.eye);
      SetDirection(rays_[i].ray, Normalized(forward + x * right + (-y) * up));
    }
  }

  /// The rays with their hits; random bits in the rest of the records have survived.
  std::vector<RTCRayHit> Traced() const {
    std::vector<RTCRayHit> traced = rays_;
    generator_.trace_(traced);
    return traced;
  }

  void AmbientOcclusion() {
    Camera();
    const std::vector<RTCRayHit> traced = Traced();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (!IsHit(traced[i])) continue;
      RTCRay& ray = rays_[i].ray;
      SetOrigin(ray, HitPoint(traced[i]));
      SetDirection(ray, CosineDirection(traced[i], random_));
      ray.tnear = 1e-4f * Diagonal();
      ray.tfar = random_.Uniform(0.01f, 0.3f) * Diagonal();
    }
  }

  /// A third of the rays stays at each of the first three bounces. A path that left the scene
  /// starts again anywhere.
  void Diffuse() {
    Camera();
    for (std::size_t bounce = 0; bounce < 3; ++bounce) {
      const std::vector<RTCRayHit> traced = Traced();
      for (std::size_t i = 0; i < rays_.size(); ++i) {
        if (i % 3 < bounce) continue;
        RTCRay& ray = rays_[i].ray;
        if (IsHit(traced[i])) {
          SetOrigin(ray, HitPoint(traced[i]));
          SetDirection(ray, CosineDirection(traced[i], random_));
          ray.tnear = 1e-5f * Diagonal();
        } else {
          RandomLine(ray);
        }
      }
    }
  }

  void RandomLine(RTCRay& ray) {
    const Float3 from = RandomPoint(random_.Chance(0.5f) ? 0.9f : 2.5f);
    SetOrigin(ray, from);
    SetDirection(ray, RandomPoint(0.9f) - from);
  }

  /// Parallel to an axis (1) or to a plane of two (2); half of the rays keep a vertex's
  /// coordinates, so that they meet edges, vertices and the faces of bounding boxes exactly.
  void AxisAligned(RTCRay& ray, int axis_count) {
    const int first_axis = static_cast<int>(random_.Below(3));
    Float3 direction;
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_moving = (axis - first_axis + 3) % 3 < axis_count;
      const float sign = random_.Chance(0.5f) ? 1.0f : -1.0f;
      direction[axis] = sign * (!is_moving        ? 0.0f
                                : axis_count == 1 ? 1.0f
                                                  : random_.Uniform(0.01f, 1));
    }
    Float3 origin = RandomPoint(1);
    if (random_.Chance(0.5f)) {
      origin = RandomTriangle()[0];
      const float back = random_.Uniform(0, 2) * Diagonal();
      if (random_.Chance(0.8f)) origin = origin - back * direction;
    }
    SetOrigin(ray, origin);
    SetDirection(ray, direction);
  }

  void AtEdge(RTCRay& ray) {
    const auto [a, b, c] = RandomTriangle();
    const Float3 middle = 0.5f * (a + b);
    const Float3 outside = RandomPoint(1.5f);
    switch (random_.Below(5)) {
      case 0:  // at a vertex
        SetOrigin(ray, outside);
        SetDirection(ray, a - outside);
        return;
      case 1:  // at the middle of an edge
        SetOrigin(ray, outside);
        SetDirection(ray, middle - outside);
        return;
      case 2:  // along an edge, in the triangle's plane
        SetDirection(ray, b - a);
        SetOrigin(ray, a - 2.0f * Direction(ray));
        return;
      case 3:  // in the triangle's plane, through a vertex
        SetDirection(ray, c - middle);
        SetOrigin(ray, a - 3.0f * Direction(ray));
        return;
      default:  // past an edge, nearly in the plane
        SetDirection(ray, middle - a + 1e-3f * Length(b - a) * RandomDirection(random_));
        SetOrigin(ray, middle - 5.0f * Direction(ray));
    }
  }

  void Surface() {
    ForEach([this](RTCRay& ray) { RandomLine(ray); });
    const std::vector<RTCRayHit> traced = Traced();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (!IsHit(traced[i])) continue;
      SetOrigin(rays_[i].ray, HitPoint(traced[i]));
      SetDirection(rays_[i].ray,
                   random_.Chance(0.2f) ? Direction(traced[i].ray) : RandomDirection(random_));
    }
  }

  void Short(RTCRay& ray) {
    RandomLine(ray);
    switch (random_.Below(8)) {
      case 0:
        ray.tfar = 0;
        return;
      case 1:
        ray.tfar = -0.0f;
        return;
      case 2:
        ray.tfar = std::numeric_limits<float>::denorm_min();
        return;
      case 3:
        ray.tnear = ray.tfar = random_.Uniform();
        return;
      case 4:
        ray.tnear = random_.Uniform();
        ray.tfar = ray.tnear + random_.Uniform(0, 0.1f);
        return;
      default:
        ray.tfar = std::exp2(random_.Uniform(-10, 1));
    }
  }

  void AtHit(float RTCRay::*end) {
    ForEach([this](RTCRay& ray) { RandomLine(ray); });
    const std::vector<RTCRayHit> traced = Traced();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (!IsHit(traced[i])) continue;
      const float t = traced[i].ray.tfar;
      switch (random_.Below(3)) {
        case 0:
          rays_[i].ray.*end = std::nextafter(t, 0.0f);
          break;
        case 1:
          rays_[i].ray.*end = std::nextafter(t, kInfinity);
          break;
        default:
          rays_[i].ray.*end = t;
      }
    }
  }

  void NegativeTnear(RTCRay& ray) {
    SetOrigin(ray, RandomPoint(1));
    SetDirection(ray, RandomDirection(random_));
    switch (random_.Below(4)) {
      case 0:
        ray.tnear = -kInfinity;
        return;
      case 1:
        ray.tnear = -0.0f;
        return;
      case 2:
        ray.tnear = -random_.Uniform() * Diagonal();
        ray.tfar = -0.5f * ray.tnear;
        return;
      default:
        ray.tnear = -random_.Uniform() * Diagonal();
    }
  }

  void Masked(RTCRay& ray) {
    RandomLine(ray);
    switch (random_.Below(4)) {
      case 0:
        ray.mask = 0;
        return;
      case 1:
        ray.mask = 1u << random_.Below(32);
        return;
      case 2:
        ray.mask = random_.Bits();
        return;
      default:
        return;
    }
  }

  void Unnormalised(RTCRay& ray) {
    RandomLine(ray);
    const float scale = std::exp2(random_.Uniform(-30, 30));
    SetDirection(ray, scale * Direction(ray));
    if (random_.Chance(0.3f)) ray.tfar = random_.Uniform(0, 2) / scale;
  }

  /// Three of four rays are ordinary, to see that the others do not harm them.
  void Hostile(RTCRay& ray) {
    RandomLine(ray);
    if (!random_.Chance(0.25f)) return;
    constexpr float kBad[] = {kNan, -kNan, kInfinity, -kInfinity};
    const float bad = kBad[random_.Below(4)];
    switch (random_.Below(10)) {
      case 0:
        (&ray.org_x)[random_.Below(3)] = bad;
        return;
      case 1:
        (&ray.dir_x)[random_.Below(3)] = bad;
        return;
      case 2:
        ray.tnear = bad;
        return;
      case 3:
        ray.tfar = bad;
        return;
      case 4:
        SetDirection(ray, {0, 0, 0});
        return;
      case 5:
        SetDirection(ray, {-0.0f, 0, -0.0f});
        return;
      case 6:
        SetDirection(ray, {bad, bad, bad});
        return;
      case 7:
        ray.tnear = random_.Uniform(0, 2);
        ray.tfar = std::nextafter(ray.tnear, -1.0f);
        return;
      case 8:
        ray.tfar = -random_.Uniform();
        return;
      default:
        ray.tnear = kInfinity;
        return;
    }
  }

  const RayGenerator& generator_;
  Random random_;
  std::vector<RTCRayHit> rays_;
};

RayGenerator::RayGenerator(const TestScene& scene, TraceRays trace)
    : scene_(scene), trace_(std::move(trace)), bounds_(scene.Bounds()) {}

RayGenerator::RayGenerator(const TestScene& scene, const EmbreeScene& traced_scene)
    : RayGenerator(scene, [&traced_scene](std::span<RTCRayHit> rays) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        traced_scene.api().rtcIntersect1M(traced_scene.handle(), &context, rays.data(),
                                          static_cast<unsigned>(rays.size()), sizeof(RTCRayHit));
      }) {}

std::vector<RTCRayHit> RayGenerator::Make(RayKind kind, std::size_t count, uint64_t seed) const {
  Batch batch(*this, count, seed);
  batch.Fill(kind);
  return std::move(batch).Take();
}

}  // namespace dacrt::tests

#include "reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace dacrt::tests {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Largest relative error of one operation in single precision.
constexpr double kUnit = 0x1p-24;

/// Largest absolute error of one operation whose result is too small for a normal float, also
/// where such results are flushed to zero.
constexpr double kTiny = 0x1p-126;

/// Products up to here leave room for the sums of six of them.
constexpr double kLargestProduct = std::numeric_limits<float>::max() / 8;

/// Largest relative error of a term that went through n operations, one after the other (Higham,
/// "Accuracy and Stability of Numerical Algorithms", lemma 3.1). With fused multiply-add there are
/// fewer, never more.
constexpr double Gamma(int n) { return n * kUnit / (1 - n * kUnit); }

/// Embree's reciprocals are an estimate and a Newton step, good to two ulp, which is four units.
constexpr int kReciprocalOperations = 4;

/// |a|, |b| -> the cross product with all its terms added: bounds every sum of its terms.
Double3 AbsoluteCross(const Double3& a, const Double3& b) {
  return {a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x};
}

double Sum(const Double3& a) { return a.x + a.y + a.z; }

/// A condition of a hit, as a value that must not be negative.
struct Condition {
  Bounded margin;
  Doubt doubt;
  bool strict = false;  ///< zero does not hold

  bool Holds() const { return strict ? margin.value > 0 : margin.value >= 0; }
  bool IsCertain() const { return std::abs(margin.value) > margin.error; }
};

/// The polynomials of Moeller and Trumbore in Embree's formulation, without the sign of the
/// determinant folded in.
struct Polynomials {
  Bounded determinant;
  Bounded u, v, t;  ///< times the determinant
  Bounded normal[3];
  double largest_product;
};

/// Embree makes its triangles' edges where such numbers are flushed to zero, before a subtraction
/// and after it: what each component may be off by.
double FlushedFromEdges(const Corners& corners) {
  constexpr double kExact = 0x1p-102;  // differences of larger numbers are no smaller than kTiny
  for (const Float3* const corner : {&corners.v0, &corners.v1, &corners.v2}) {
    for (int axis = 0; axis < 3; ++axis) {
      const double value = std::abs((*corner)[axis]);
      if (value > 0 && value < kExact) return 2 * kTiny;
    }
  }
  return 0;
}

Polynomials Evaluate(const RTCRay& ray, const Corners& corners) {
  const auto& [v0, v1, v2] = corners;
  const Double3 direction{ray.dir_x, ray.dir_y, ray.dir_z};
  const Double3 c = Double3(v0) - Double3{ray.org_x, ray.org_y, ray.org_z};
  const Double3 e1 = Double3(v0) - Double3(v1);
  const Double3 e2 = Double3(v2) - Double3(v0);
  const Double3 normal = Cross(e2, e1);
  const Double3 r = Cross(c, direction);

  const Double3 d_abs = Abs(direction), c_abs = Abs(c), e1_abs = Abs(e1), e2_abs = Abs(e2);
  const Double3 r_abs = AbsoluteCross(c_abs, d_abs);
  const Double3 n_abs = AbsoluteCross(e2_abs, e1_abs);

  // Operations in sequence that a term has gone through:
  constexpr int kEdge = 1;                // subtraction of two vertices, or of vertex and origin
  constexpr int kR = kEdge + 2;           // product with an exact direction, difference
  constexpr int kNormal = 2 * kEdge + 2;  // product of two edges, difference
  constexpr int kDot = 3;                 // product, two sums
  Polynomials p;
  p.u = {Dot(r, e2), Gamma(kR + kEdge + kDot) * Dot(r_abs, e2_abs) + kTiny * (2 * Sum(e2_abs) + 3)};
  p.v = {Dot(r, e1), Gamma(kR + kEdge + kDot) * Dot(r_abs, e1_abs) + kTiny * (2 * Sum(e1_abs) + 3)};
  p.t = {Dot(normal, c),
         Gamma(kNormal + kEdge + kDot) * Dot(n_abs, c_abs) + kTiny * (2 * Sum(c_abs) + 3)};
  p.determinant = {Dot(normal, direction),
                   Gamma(kNormal + kDot) * Dot(n_abs, d_abs) + kTiny * (2 * Sum(d_abs) + 3)};
  for (int axis = 0; axis < 3; ++axis) {
    // A repeated vertex gives a normal of zero without any rounding.
    const double error = n_abs[axis] == 0 ? 0 : Gamma(kNormal) * n_abs[axis] + 2 * kTiny;
    p.normal[axis] = {normal[axis], error};
  }
  if (const double flushed = FlushedFromEdges(corners); flushed > 0) {
    const double of_normal = flushed * (Sum(e1_abs) + Sum(e2_abs));
    const double of_r = 2 * flushed * Sum(d_abs);
    for (Bounded& axis : p.normal) axis.error += of_normal;
    p.determinant.error += of_normal * Sum(d_abs);
    p.t.error += of_normal * Sum(c_abs) + flushed * Sum(n_abs);
    p.u.error += flushed * Sum(r_abs) + of_r * Sum(e2_abs);
    p.v.error += flushed * Sum(r_abs) + of_r * Sum(e1_abs);
  }
  if (Sum(n_abs) == 0) p.determinant.error = p.t.error = 0;
  p.largest_product = std::max({Dot(r_abs, e2_abs), Dot(r_abs, e1_abs), Dot(n_abs, c_abs),
                                Dot(n_abs, d_abs), Sum(r_abs), Sum(n_abs)});
  return p;
}

/// The conditions of a hit if the determinant has the given sign.
std::array<Condition, 5> Conditions(const RTCRay& ray, const Polynomials& p, double sign) {
  const double det = sign * p.determinant.value;
  const double u = sign * p.u.value, v = sign * p.v.value, t = sign * p.t.value;
  // Embree computes U + V <= |den| or |den| - U - V >= 0: two more operations at most.
  const double w_error = p.u.error + p.v.error + p.determinant.error +
                         Gamma(2) * (std::abs(det) + std::abs(u) + std::abs(v));
  // |den| * tnear < T and T <= |den| * tfar: one more operation.
  const auto scaled = [&](double end) {
    return Bounded{det * end, (p.determinant.error + kUnit * std::abs(det)) * std::abs(end)};
  };
  const Bounded near = std::isinf(ray.tnear) ? Bounded{ray.tnear, 0} : scaled(ray.tnear);
  const Bounded far = std::isinf(ray.tfar) ? Bounded{ray.tfar, 0} : scaled(ray.tfar);
  return {Condition{{u, p.u.error}, kDoubtEdge}, Condition{{v, p.v.error}, kDoubtEdge},
          Condition{{det - u - v, w_error}, kDoubtEdge},
          Condition{{t - near.value, p.t.error + near.error}, kDoubtInterval, true},
          Condition{{far.value - t, p.t.error + far.error}, kDoubtInterval}};
}

/// Adds what the conditions say to `answer`; false if one certainly fails.
bool Decide(const RTCRay& ray, const Polynomials& p, double sign, TriangleAnswer& answer) {
  uint32_t doubts = kNoDoubt;
  bool holds = true;
  for (const Condition& condition : Conditions(ray, p, sign)) {
    holds = holds && condition.Holds();
    if (condition.IsCertain()) {
      if (!condition.Holds()) return false;
    } else {
      doubts |= condition.doubt;
    }
  }
  answer.is_hit = answer.is_hit || (holds && sign * p.determinant.value > 0);
  answer.doubts |= doubts;
  return true;
}

/// A polynomial over the determinant.
Bounded Quotient(const Bounded& numerator, const Bounded& determinant, double sign) {
  const double magnitude = std::abs(determinant.value);
  if (magnitude <= determinant.error) return {0, kInfinity};
  const double value = sign * numerator.value / magnitude;
  return {value, (numerator.error + std::abs(value) * determinant.error) /
                         (magnitude - determinant.error) +
                     Gamma(kReciprocalOperations + 2) * std::abs(value) + kTiny};
}

/// One axis of a triangle's bounding box, as a ray sees it.
struct Slab {
  Slab(const RTCRay& ray, const Corners& corners, int axis)
      : origin((&ray.org_x)[axis]), reciprocal(EmbreeReciprocal((&ray.dir_x)[axis])) {
    const double lower = std::min({corners.v0[axis], corners.v1[axis], corners.v2[axis]});
    const double upper = std::max({corners.v0[axis], corners.v1[axis], corners.v2[axis]});
    near_plane = reciprocal < 0 ? upper : lower;
    far_plane = reciprocal < 0 ? lower : upper;
    near = (near_plane - origin) * reciprocal;
    far = (far_plane - origin) * reciprocal;
  }

  double origin;
  double reciprocal;  ///< of the direction
  double near_plane, far_plane;
  double near, far;  ///< distances to the planes
};

/// Where a point comes on a Morton curve through the bounds: near points at near places.
uint32_t PlaceOnCurve(const Float3& point, const TestScene::Corners& bounds) {
  constexpr uint32_t kBits = 10;
  uint32_t place = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = bounds.upper[axis] - bounds.lower[axis];
    const float share = extent > 0 ? (point[axis] - bounds.lower[axis]) / extent : 0;
    const auto cell = static_cast<uint32_t>(share * ((1u << kBits) - 1));
    for (uint32_t bit = 0; bit < kBits; ++bit) {
      place |= ((cell >> bit) & 1) << (3 * bit + static_cast<uint32_t>(axis));
    }
  }
  return place;
}

/// The coordinates beyond which Embree leaves a triangle out.
bool IsLegal(const Float3& vertex) {
  constexpr float kLargest = 1.844e18f;
  const Float3 magnitude = Abs(vertex);
  return magnitude.x < kLargest && magnitude.y < kLargest && magnitude.z < kLargest;
}

}  // namespace

double EmbreeReciprocal(double direction) {
  return std::copysign(std::min(1 / std::abs(direction), kLargestReciprocal), direction);
}

bool IsTraced(const RTCRay& ray) {
  const float sum = ray.org_x + ray.org_y + ray.org_z + ray.dir_x + ray.dir_y + ray.dir_z;
  return std::isfinite(sum) && ray.tnear >= 0 && ray.tnear <= ray.tfar;
}

TriangleAnswer TestTriangle(const RTCRay& ray, const Corners& corners) {
  const Polynomials p = Evaluate(ray, corners);
  TriangleAnswer answer;
  if (p.determinant.value == 0 && p.determinant.error == 0) return answer;

  const double sign = p.determinant.value < 0 ? -1 : 1;
  const bool is_parallel = std::abs(p.determinant.value) <= p.determinant.error;
  bool is_possible = Decide(ray, p, sign, answer);
  // Single precision may see the triangle from the other side.
  if (is_parallel) is_possible = Decide(ray, p, -sign, answer) || is_possible;
  if (p.largest_product > kLargestProduct) {
    answer.doubts |= kDoubtRange;
  } else if (!is_possible) {
    return {};
  } else if (is_parallel) {
    answer.doubts |= kDoubtParallel;
  }

  answer.t = Quotient(p.t, p.determinant, sign);
  answer.u = Quotient(p.u, p.determinant, sign);
  answer.v = Quotient(p.v, p.determinant, sign);
  std::copy_n(p.normal, 3, answer.normal);
  if (answer.doubts & kDoubtRange) {
    for (Bounded* value : {&answer.t, &answer.u, &answer.v}) value->error = kInfinity;
    for (Bounded& value : answer.normal) value.error = kInfinity;
  }
  return answer;
}

bool SlabTestMayMiss(const RTCRay& ray, float tfar, const Corners& corners,
                     std::span<const RTCRayHit> packet) {
  Bounded near[4] = {{std::max(0.0, static_cast<double>(ray.tnear)), 0}};
  Bounded far[4] = {{tfar, 0}};
  for (int axis = 0; axis < 3; ++axis) {
    const Slab slab(ray, corners, axis);
    // Its reciprocals lose this sign, by which it orders the planes.
    if ((&ray.dir_x)[axis] < 0 && slab.reciprocal == -kLargestReciprocal) return true;
    double origin = std::abs(slab.origin), reciprocal = std::abs(slab.reciprocal);
    for (const RTCRayHit& other : packet) {
      if (!IsTraced(other.ray)) continue;
      origin = std::max<double>(origin, std::abs((&other.ray.org_x)[axis]));
      reciprocal = std::max(reciprocal, std::abs(EmbreeReciprocal((&other.ray.dir_x)[axis])));
    }
    // (plane - origin) * reciprocal, or with fused multiply-add plane * reciprocal - origin *
    // reciprocal, where the second product is rounded on its own.
    const auto with_error = [&](double plane, double distance) {
      return Bounded{distance, (Gamma(kReciprocalOperations + 2) * std::abs(plane - slab.origin) +
                                Gamma(1) * origin) *
                                   reciprocal};
    };
    near[axis + 1] = with_error(slab.near_plane, slab.near);
    far[axis + 1] = with_error(slab.far_plane, slab.far);
  }
  for (int n = 0; n < 4; ++n) {
    for (int f = 0; f < 4; ++f) {
      // One axis does not lose a single ray on its own: its two planes' distances have the same
      // error in the same order.
      if (n == f && packet.empty()) continue;
      if (near[n].value + near[n].error > far[f].value - far[f].error) return true;
    }
  }
  return false;
}

Reference::Reference(const TestScene& scene) {
  const TestScene::Corners bounds = scene.Bounds();
  std::vector<std::pair<uint32_t, Item>> placed;
  for (const TestMesh& mesh : scene.meshes) {
    if (!mesh.enabled) continue;
    geometries_[mesh.geometry_id].assign(mesh.triangles.size(), kNoItem);
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& vertex = mesh.triangles[i].vertex;
      // As in Embree, a triangle whose vertices are not there can not be hit.
      if (std::ranges::any_of(vertex, [&](uint32_t v) { return v >= mesh.positions.size(); })) {
        continue;
      }
      const Corners corners{mesh.positions[vertex[0]], mesh.positions[vertex[1]],
                            mesh.positions[vertex[2]]};
      if (!IsLegal(corners.v0) || !IsLegal(corners.v1) || !IsLegal(corners.v2)) continue;
      placed.push_back(
          {PlaceOnCurve(corners.v0, bounds), {mesh.geometry_id, i, mesh.mask, corners}});
    }
  }
  std::stable_sort(placed.begin(), placed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });

  std::vector<Sphere> spheres;
  for (const auto& [place, item] : placed) {
    geometries_[item.geometry_id][item.primitive_id] = static_cast<uint32_t>(items_.size());
    items_.push_back(item);
    const Double3 v0(item.corners.v0), v1(item.corners.v1), v2(item.corners.v2);
    const Double3 center = (1.0 / 3) * (v0 + v1 + v2);
    spheres.push_back(
        {center, std::max({Length(v0 - center), Length(v1 - center), Length(v2 - center)})});
  }
  levels_.push_back(std::move(spheres));
  while (levels_.back().size() > 1) {
    const std::vector<Sphere>& below = levels_.back();
    std::vector<Sphere> level;
    for (std::size_t first = 0; first < below.size(); first += kGroup) {
      level.push_back(Around(below, first, std::min(first + kGroup, below.size())));
    }
    levels_.push_back(std::move(level));
  }
}

Reference::Sphere Reference::Around(const std::vector<Sphere>& below, std::size_t first,
                                    std::size_t end) {
  Sphere around{{}, 0};
  for (std::size_t i = first; i < end; ++i) {
    around.center = around.center + (1.0 / static_cast<double>(end - first)) * below[i].center;
  }
  for (std::size_t i = first; i < end; ++i) {
    around.radius =
        std::max(around.radius, Length(below[i].center - around.center) + below[i].radius);
  }
  return around;
}

const Corners* Reference::Find(uint32_t geometry_id, uint32_t primitive_id,
                               uint32_t ray_mask) const {
  const auto found = geometries_.find(geometry_id);
  if (found == geometries_.end() || primitive_id >= found->second.size()) return nullptr;
  const uint32_t item = found->second[primitive_id];
  if (item == kNoItem || (items_[item].mask & ray_mask) == 0) return nullptr;
  return &items_[item].corners;
}

Reference::Line::Line(const RTCRay& ray, double limit)
    : origin{ray.org_x, ray.org_y, ray.org_z}, direction{ray.dir_x, ray.dir_y, ray.dir_z} {
  const double length = Length(direction);
  direction = (1 / length) * direction;
  near = length * ray.tnear;
  far = length * std::min<double>(ray.tfar, limit);
}

bool Reference::IsNear(const Line& line, const Sphere& sphere, double scale) {
  // Double rounding is far below this share of the lengths involved.
  constexpr double kSlack = 1e-13;
  const Double3 to_center = sphere.center - line.origin;
  const Double3 offset = Cross(to_center, line.direction);
  const double radius = scale * sphere.radius;
  const double limit = radius * radius + kSlack * (Dot(to_center, to_center) + radius * radius);
  // What is no number, as where a ray has no direction, is near.
  if (Dot(offset, offset) > limit) return false;
  const double along = Dot(to_center, line.direction), reach = std::sqrt(limit);
  return !(along + reach < line.near) && !(along - reach > line.far);
}

template <typename Visit>
void Reference::ForEachNear(const RTCRay& ray, double limit, double scale,
                            const Visit& visit) const {
  if (items_.empty()) return;
  ForEachNearIn(levels_.size() - 1, 0, Line(ray, limit), scale, [&](const Item& item) {
    if ((item.mask & ray.mask) == 0) return;
    const TriangleAnswer answer = TestTriangle(ray, item.corners);
    if (!answer.MayHit()) return;
    visit(ReferenceHit{item.geometry_id, item.primitive_id, item.corners, answer});
  });
}

template <typename Visit>
void Reference::ForEachNearIn(std::size_t level, std::size_t index, const Line& line, double scale,
                              const Visit& visit) const {
  if (!IsNear(line, levels_[level][index], scale)) return;
  if (level == 0) return visit(items_[index]);
  const std::size_t end = std::min((index + 1) * kGroup, levels_[level - 1].size());
  for (std::size_t below = index * kGroup; below < end; ++below) {
    ForEachNearIn(level - 1, below, line, scale, visit);
  }
}

std::vector<ReferenceHit> Reference::MustHits(const RTCRay& ray, double limit) const {
  // What is hit for certain is hit by exact arithmetic, so the ray passes through its sphere.
  std::vector<ReferenceHit> hits;
  ForEachNear(ray, limit, 1, [&](const ReferenceHit& hit) {
    if (hit.answer.MustHit()) hits.push_back(hit);
  });
  return hits;
}

std::optional<ReferenceHit> Reference::MayHit(const RTCRay& ray) const {
  std::optional<ReferenceHit> found;
  // Most are near; long thin triangles may be hit far beside them.
  ForEachNear(ray, kInfinity, 2, [&](const ReferenceHit& hit) {
    if (!found || (hit.answer.is_hit && !found->answer.is_hit)) found = hit;
  });
  if (found) return found;
  const std::vector<ReferenceHit> hits = MayHits(ray);
  return hits.empty() ? std::nullopt : std::optional(hits.front());
}

std::vector<ReferenceHit> Reference::MayHits(const RTCRay& ray) const {
  std::vector<ReferenceHit> hits;
  for (const Item& item : items_) {
    if ((item.mask & ray.mask) == 0) continue;
    const TriangleAnswer answer = TestTriangle(ray, item.corners);
    if (answer.MayHit()) {
      hits.push_back({item.geometry_id, item.primitive_id, item.corners, answer});
    }
  }
  return hits;
}

}  // namespace dacrt::tests

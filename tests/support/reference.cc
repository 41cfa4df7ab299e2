#include "reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

Polynomials Evaluate(const RTCRay& ray, const Float3& v0, const Float3& v1, const Float3& v2) {
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
                     Gamma(kReciprocalOperations + 2) * std::abs(value)};
}

/// The coordinates beyond which Embree leaves a triangle out.
bool IsLegal(const Float3& vertex) {
  constexpr float kLargest = 1.844e18f;
  const Float3 magnitude = Abs(vertex);
  return magnitude.x < kLargest && magnitude.y < kLargest && magnitude.z < kLargest;
}

}  // namespace

TriangleAnswer TestTriangle(const RTCRay& ray, const Float3& v0, const Float3& v1,
                            const Float3& v2) {
  const Polynomials p = Evaluate(ray, v0, v1, v2);
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

bool SlabTestMayMiss(const RTCRay& ray, float tfar, const Float3& v0, const Float3& v1,
                     const Float3& v2) {
  // Embree's reciprocals of direction components stay below this, also those of zeros.
  constexpr double kLargestReciprocal = 1e18;
  const Double3 origin{ray.org_x, ray.org_y, ray.org_z};
  const Double3 direction{ray.dir_x, ray.dir_y, ray.dir_z};
  Bounded near[4] = {{std::max(0.0, static_cast<double>(ray.tnear)), 0}};
  Bounded far[4] = {{tfar, 0}};
  for (int axis = 0; axis < 3; ++axis) {
    const double lower = std::min({v0[axis], v1[axis], v2[axis]});
    const double upper = std::max({v0[axis], v1[axis], v2[axis]});
    const double reciprocal =
        std::copysign(std::min(1 / std::abs(direction[axis]), kLargestReciprocal), direction[axis]);
    // (plane - origin) * reciprocal, or with fused multiply-add plane * reciprocal - origin *
    // reciprocal, where the second product is rounded on its own.
    const auto distance = [&](double plane) {
      const double value = (plane - origin[axis]) * reciprocal;
      return Bounded{value, Gamma(kReciprocalOperations + 2) * std::abs(value) +
                                Gamma(1) * std::abs(origin[axis] * reciprocal)};
    };
    near[axis + 1] = distance(reciprocal < 0 ? upper : lower);
    far[axis + 1] = distance(reciprocal < 0 ? lower : upper);
  }
  for (int n = 0; n < 4; ++n) {
    for (int f = 0; f < 4; ++f) {
      // One axis does not lose the ray on its own: its two planes' distances have the same error
      // in the same order.
      if (n == f) continue;
      if (near[n].value + near[n].error > far[f].value - far[f].error) return true;
    }
  }
  return false;
}

Reference::Reference(const TestScene& scene) {
  for (const TestMesh& mesh : scene.meshes) {
    if (!mesh.enabled) continue;
    std::vector<uint32_t>& geometry = geometries_[mesh.geometry_id];
    geometry.assign(mesh.triangles.size(), kNoItem);
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& vertex = mesh.triangles[i].vertex;
      const Corners corners{mesh.positions[vertex[0]], mesh.positions[vertex[1]],
                            mesh.positions[vertex[2]]};
      if (!IsLegal(corners.v0) || !IsLegal(corners.v1) || !IsLegal(corners.v2)) continue;
      geometry[i] = static_cast<uint32_t>(items_.size());
      items_.push_back({mesh.geometry_id, i, mesh.mask, corners});
      const Double3 v0(corners.v0), v1(corners.v1), v2(corners.v2);
      const Double3 center = (1.0 / 3) * (v0 + v1 + v2);
      spheres_.push_back(
          {center, std::max({Length(v0 - center), Length(v1 - center), Length(v2 - center)})});
    }
  }
}

const Corners* Reference::Find(uint32_t geometry_id, uint32_t primitive_id,
                               uint32_t ray_mask) const {
  const auto found = geometries_.find(geometry_id);
  if (found == geometries_.end() || primitive_id >= found->second.size()) return nullptr;
  const uint32_t item = found->second[primitive_id];
  if (item == kNoItem || (items_[item].mask & ray_mask) == 0) return nullptr;
  return &items_[item].corners;
}

std::vector<ReferenceHit> Reference::MustHits(const RTCRay& ray) const {
  // What is hit for certain is hit by exact arithmetic, so the line passes through the sphere
  // about it. Double rounding is far below this share of the lengths involved.
  constexpr double kSlack = 1e-9;
  const Double3 origin{ray.org_x, ray.org_y, ray.org_z};
  const Double3 direction = Normalized(Double3{ray.dir_x, ray.dir_y, ray.dir_z});
  std::vector<ReferenceHit> hits;
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    const Double3 to_center = spheres_[i].center - origin;
    const Double3 offset = Cross(to_center, direction);
    const double distance_squared = Dot(to_center, to_center);
    const double radius = spheres_[i].radius;
    if (Dot(offset, offset) > radius * radius + kSlack * (distance_squared + radius * radius)) {
      continue;
    }
    const Item& item = items_[i];
    if ((item.mask & ray.mask) == 0) continue;
    const TriangleAnswer answer =
        TestTriangle(ray, item.corners.v0, item.corners.v1, item.corners.v2);
    if (answer.MustHit()) {
      hits.push_back({item.geometry_id, item.primitive_id, item.corners, answer});
    }
  }
  return hits;
}

std::vector<ReferenceHit> Reference::MayHits(const RTCRay& ray) const {
  std::vector<ReferenceHit> hits;
  for (const Item& item : items_) {
    if ((item.mask & ray.mask) == 0) continue;
    const TriangleAnswer answer =
        TestTriangle(ray, item.corners.v0, item.corners.v1, item.corners.v2);
    if (answer.MayHit()) {
      hits.push_back({item.geometry_id, item.primitive_id, item.corners, answer});
    }
  }
  return hits;
}

}  // namespace dacrt::tests

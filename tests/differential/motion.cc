#include "motion.h"

#include <cmath>

namespace dacrt::tests {
namespace {

/// Places of the members of RTCQuaternionDecomposition.
enum Part {
  kScale = 0,
  kSkewXy = 3,
  kSkewXz = 4,
  kSkewYz = 5,
  kShift = 6,
  kRotation = 9,
  kTranslation = 13
};

using Parts = std::array<Approximate, 16>;

/// Embree interpolates rotations with polynomials for sine, cosine and arc cosine. Of 200,000
/// random ones no number of a matrix was further off than this, and those are sums of products with
/// two.
constexpr double kSlerpError = 1.1e-5;

void Normalize(Approximate* q) {
  Approximate squares[4];
  for (int i = 0; i < 4; ++i) squares[i] = q[i] * q[i];
  const Approximate length = SquareRoot(squares[0] + squares[1] + squares[2] + squares[3]);
  for (int i = 0; i < 4; ++i) q[i] = q[i] / length;
}

Parts PartsOf(const Placement& placement) {
  Parts parts;
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = Exactly(placement.parts[i]);
  Normalize(&parts[kRotation]);
  return parts;
}

/// Along the shorter arc.
void InterpolateRotation(const Approximate* a, const Approximate* b, double fraction,
                         Approximate* out) {
  double cosine = 0;
  for (int i = 0; i < 4; ++i) cosine += a[i].value * b[i].value;
  const double sign = cosine < 0 ? -1 : 1;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0));
  double weight_a = 1 - fraction, weight_b = fraction;
  if (angle > 1e-6) {
    weight_a = std::sin((1 - fraction) * angle) / std::sin(angle);
    weight_b = std::sin(fraction * angle) / std::sin(angle);
  }
  for (int i = 0; i < 4; ++i) {
    out[i] = {weight_a * a[i].value + sign * weight_b * b[i].value, kSlerpError};
  }
}

ApproximateTransform Compose(const Parts& parts) {
  const Approximate *q = &parts[kRotation], two = Exactly(2);
  const Approximate r = q[0], i = q[1], j = q[2], k = q[3];
  const Approximate rr = r * r, ii = i * i, jj = j * j, kk = k * k;
  const Approximate3 rotation[3] = {
      {rr + ii - jj - kk, two * (i * j + r * k), two * (i * k - r * j)},
      {two * (i * j - r * k), rr - ii + jj - kk, two * (j * k + r * i)},
      {two * (i * k + r * j), two * (j * k - r * i), rr - ii - jj + kk}};
  const Approximate zero = Exactly(0);
  const Approximate3 shape[4] = {{parts[kScale], zero, zero},
                                 {parts[kSkewXy], parts[kScale + 1], zero},
                                 {parts[kSkewXz], parts[kSkewYz], parts[kScale + 2]},
                                 {parts[kShift], parts[kShift + 1], parts[kShift + 2]}};
  ApproximateTransform out;
  for (int column = 0; column < 4; ++column) {
    const Approximate3& s = shape[column];
    for (int row = 0; row < 3; ++row) {
      const Approximate factors[3] = {rotation[0][row], rotation[1][row], rotation[2][row]};
      out.column[column][row] = SumOfProducts(factors, s);
      if (column == 3) {
        out.column[3][row] = out.column[3][row] + parts[kTranslation + row];
      }
    }
  }
  return out;
}

}  // namespace

ApproximateRay Exactly(const RTCRay& ray) {
  return {{Exactly(ray.org_x), Exactly(ray.org_y), Exactly(ray.org_z)},
          {Exactly(ray.dir_x), Exactly(ray.dir_y), Exactly(ray.dir_z)},
          ray.tnear,
          ray.tfar};
}

Moment MomentAt(const WorldGeometry& geometry, float time) {
  Moment moment;
  const uint32_t steps = geometry.StepCount();
  if (steps <= 1) return moment;
  const double begin = geometry.time_begin, end = geometry.time_end, segments = steps - 1;
  const double share = (time - begin) / (end - begin);
  // A difference of times, divided by another: what is lost before the multiplication.
  const double share_error = RoundingOf(4) * (std::abs(share) + 1);
  moment.is_there = share >= 0 && share <= 1;
  moment.is_doubtful =
      share != 0 && share != 1 && std::min(std::abs(share), std::abs(1 - share)) <= share_error;
  const double place = std::clamp(share, 0.0, 1.0) * segments;
  const double floor = std::min(std::floor(place), segments - 1);
  moment.step = static_cast<uint32_t>(floor);
  moment.fraction = {place - floor, (share_error + RoundingOf(2)) * segments};
  // Steps that coincide with times are given exactly where the range is the whole of [0, 1].
  if (share == 0 || share == 1) moment.fraction.error = 0;
  return moment;
}

namespace {

/// What `value(step)` is at the moment. Near a step the neighbouring segment may be taken instead,
/// which can be steeper.
template <typename Value>
Approximate At(const WorldGeometry& geometry, const Moment& moment, const Value& value) {
  const uint32_t steps = geometry.StepCount();
  if (steps == 1) return Exactly(value(0));
  const double a = value(moment.step), b = value(moment.step + 1);
  Approximate result = Interpolate(Exactly(a), Exactly(b), moment.fraction);
  const auto add_slope = [&](uint32_t from) {
    result.error +=
        moment.fraction.error * std::abs(static_cast<double>(value(from + 1)) - value(from));
  };
  if (moment.fraction.value <= moment.fraction.error && moment.step > 0) add_slope(moment.step - 1);
  if (moment.fraction.value >= 1 - moment.fraction.error && moment.step + 2 < steps) {
    add_slope(moment.step + 1);
  }
  return result;
}

}  // namespace

ApproximateVertex VertexAt(const WorldGeometry& geometry, uint32_t vertex, const Moment& moment) {
  const auto at = [&](float Vertex::*member) {
    return At(geometry, moment,
              [&](uint32_t step) { return geometry.vertices[step][vertex].*member; });
  };
  return {{at(&Vertex::x), at(&Vertex::y), at(&Vertex::z)}, at(&Vertex::radius)};
}

Approximate3 NormalAt(const WorldGeometry& geometry, uint32_t vertex, const Moment& moment) {
  Approximate3 normal;
  for (int axis = 0; axis < 3; ++axis) {
    normal[axis] =
        At(geometry, moment, [&](uint32_t step) { return geometry.normals[step][vertex][axis]; });
  }
  return normal;
}

ApproximateTransform ToWorld(const WorldGeometry& instance, const Moment& moment) {
  const auto& placements = instance.placements;
  if (!instance.in_parts) {
    ApproximateTransform out;
    for (std::size_t i = 0; i < 12; ++i) {
      out.column[i / 3][i % 3] =
          At(instance, moment, [&](uint32_t step) { return placements[step].matrix[i]; });
    }
    return out;
  }
  if (placements.size() == 1) return Compose(PartsOf(placements[0]));
  Parts parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i] = At(instance, moment, [&](uint32_t step) { return placements[step].parts[i]; });
  }
  const Parts a = PartsOf(placements[moment.step]), b = PartsOf(placements[moment.step + 1]);
  InterpolateRotation(&a[kRotation], &b[kRotation], moment.fraction.value, &parts[kRotation]);
  return Compose(parts);
}

ApproximateRay ToInstance(const ApproximateRay& ray, const ApproximateTransform& to_world) {
  const auto& c = to_world.column;
  Approximate3 row[3] = {Cross(c[1], c[2]), Cross(c[2], c[0]), Cross(c[0], c[1])};
  const Approximate determinant = Dot(c[0], row[0]);
  ApproximateRay out = ray;
  for (int i = 0; i < 3; ++i) {
    for (Approximate& value : row[i]) value = value / determinant;
    const Approximate3& r = row[i];
    const Approximate shift = -Dot(r, c[3]);
    const Approximate factors[4] = {r[0], r[1], r[2], shift};
    const Approximate point[4] = {ray.org[0], ray.org[1], ray.org[2], Exactly(1)};
    out.org[i] = SumOfProducts(factors, point);
    out.dir[i] = Dot(r, ray.dir);
  }
  return out;
}

}  // namespace dacrt::tests

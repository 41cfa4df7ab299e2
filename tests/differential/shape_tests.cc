#include "shape_tests.h"

#include <cmath>
#include <initializer_list>
#include <limits>

namespace dacrt::tests {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A condition of a hit, as a value that must not be negative.
struct Condition {
  Approximate margin;
  Doubt doubt;
};

/// Adds what the conditions say to `answer`; false if one certainly fails.
bool Decide(std::initializer_list<Condition> conditions, ShapeAnswer& answer) {
  uint32_t doubts = kNoDoubt;
  bool holds = true;
  for (const Condition& condition : conditions) {
    const Approximate& margin = condition.margin;
    // Where nothing is known, nothing is certain.
    if (!(std::abs(margin.value) > margin.error)) {
      doubts |= condition.doubt;
    } else if (margin.value < 0) {
      return false;
    }
    holds = holds && margin.value >= 0;
  }
  answer.is_hit = answer.is_hit || holds;
  answer.doubts |= doubts;
  return true;
}

/// What is within the interval at `t` times `scale`: margins of both ends.
Approximate AfterNear(const ApproximateRay& ray, const Approximate& t, const Approximate& scale) {
  if (std::isinf(ray.tnear)) return {-ray.tnear, 0};
  return t - scale * Exactly(ray.tnear);
}

Approximate BeforeFar(const ApproximateRay& ray, const Approximate& t, const Approximate& scale) {
  if (std::isinf(ray.tfar)) return {ray.tfar, 0};
  return scale * Exactly(ray.tfar) - t;
}

void ForgetValues(ShapeAnswer& answer) {
  for (Bounded* value : {&answer.t, &answer.u, &answer.v}) value->error = kInfinity;
  for (Bounded& value : answer.normal) value.error = kInfinity;
}

bool AnyMayOverflow(std::initializer_list<Approximate> values) {
  for (const Approximate& value : values) {
    if (MayOverflow(value)) return true;
  }
  return false;
}

Approximate AbsoluteSum(const Approximate3& a) {
  Approximate sum;
  for (const Approximate& value : a) sum.value += Magnitude(value);
  return sum;
}

/// What bounds all terms of a product of sums, before any of them cancel.
Approximate LargestProduct(std::initializer_list<Approximate3> factors) {
  double product = 1;
  for (const Approximate3& factor : factors) product *= AbsoluteSum(factor).value;
  return Exactly(product);
}

/// The polynomials of a facet's test: hit where u, v and w have the sign of the determinant that
/// they belong to.
struct FacetTerms {
  Approximate u, v, w;   ///< not divided
  Approximate sum;       ///< what u and v are divided by
  Approximate t, depth;  ///< distance, not divided, and what it is divided by
  Approximate3 normal;
  double slack;         ///< u, v, w may be this much below zero
  Approximate largest;  ///< of the products on the way
};

/// A facet that may be seen from either side.
ShapeAnswer DecideFacet(const ApproximateRay& ray, const FacetTerms& terms) {
  ShapeAnswer answer;
  if (IsZero(terms.depth)) return answer;
  const auto decide = [&](double side, double sign) {
    const Approximate s = Exactly(side), d = Exactly(sign);
    const auto with_slack = [&](const Approximate& a) {
      return Approximate{a.value, a.error + terms.slack};
    };
    const Approximate depth = d * terms.depth, t = d * terms.t;
    return Decide({{with_slack(s * terms.u), kDoubtEdge},
                   {with_slack(s * terms.v), kDoubtEdge},
                   {with_slack(s * terms.w), kDoubtEdge},
                   {depth, kDoubtParallel},
                   {AfterNear(ray, t, depth), kDoubtInterval},
                   {BeforeFar(ray, t, depth), kDoubtInterval}},
                  answer);
  };
  bool is_possible = false;
  // Which side the edges show and which one the normal shows are the same, but for rounding.
  for (const double side : {-1.0, 1.0}) {
    for (const double sign : {-1.0, 1.0}) {
      const bool agree = (side * terms.sum.value >= 0) == (sign * terms.depth.value >= 0);
      const bool is_rounding = std::abs(terms.sum.value) <= terms.sum.error + terms.slack ||
                               std::abs(terms.depth.value) <= terms.depth.error;
      if (agree || is_rounding) is_possible = decide(side, sign) || is_possible;
    }
  }
  if (AnyMayOverflow({terms.u, terms.v, terms.w, terms.t, terms.depth, AbsoluteSum(terms.normal),
                      terms.largest})) {
    answer.doubts |= kDoubtRange;
  } else if (!is_possible) {
    return {};
  }
  answer.t = terms.t / terms.depth;
  answer.u = terms.u / terms.sum;
  answer.v = terms.v / terms.sum;
  std::copy_n(terms.normal.begin(), 3, answer.normal);
  if (answer.doubts & kDoubtRange) ForgetValues(answer);
  return answer;
}

}  // namespace

ShapeAnswer TestFacet(const ApproximateRay& ray, const Approximate3& v0, const Approximate3& v1,
                      const Approximate3& v2) {
  const Approximate3 c = v0 - ray.org, e1 = v0 - v1, e2 = v2 - v0;
  const Approximate3 normal = Cross(e2, e1), r = Cross(c, ray.dir);
  FacetTerms terms;
  terms.depth = Dot(normal, ray.dir);
  terms.u = Dot(r, e2);
  terms.v = Dot(r, e1);
  terms.w = terms.depth - terms.u - terms.v;
  terms.sum = terms.depth;
  terms.t = Dot(normal, c);
  terms.normal = normal;
  terms.slack = 0;
  const Approximate3 edges = {AbsoluteSum(e1), AbsoluteSum(e2), Exactly(0)};
  terms.largest.value =
      std::max({LargestProduct({c, ray.dir, edges}).value, LargestProduct({edges, edges, c}).value,
                LargestProduct({edges, edges, ray.dir}).value});
  return DecideFacet(ray, terms);
}

ShapeAnswer TestFacetRobustly(const ApproximateRay& ray, const Approximate3& v0,
                              const Approximate3& v1, const Approximate3& v2) {
  const Approximate3 a = v0 - ray.org, b = v1 - ray.org, c = v2 - ray.org;
  const Approximate3 ca = c - a, ab = a - b, bc = b - c;
  FacetTerms terms;
  terms.u = Dot(Cross(ca, c + a), ray.dir);
  terms.v = Dot(Cross(ab, a + b), ray.dir);
  terms.w = Dot(Cross(bc, b + c), ray.dir);
  terms.sum = terms.u + terms.v + terms.w;
  // The slack of one ulp, and the rounding of the sum that it is taken from.
  terms.slack = 0x1p-22 * Magnitude(terms.sum);
  // Any two edges will do for the normal.
  terms.normal = Cross(ca, ab);
  for (const Approximate3& other : {Cross(ab, bc), Cross(bc, ca)}) {
    for (int i = 0; i < 3; ++i) {
      terms.normal[i].error = std::max(terms.normal[i].error, other[i].error);
    }
  }
  terms.depth = Dot(terms.normal, ray.dir);
  terms.t = Dot(terms.normal, a);
  const Approximate3 corners = {AbsoluteSum(a), AbsoluteSum(b), AbsoluteSum(c)};
  terms.largest.value = std::max(LargestProduct({corners, corners, ray.dir}).value,
                                 LargestProduct({corners, corners, corners}).value);
  ShapeAnswer answer = DecideFacet(ray, terms);
  // Below this the real library divides by nothing, and has u = v = 0, of grids in any cell.
  constexpr double kLeastSum = 1e-18;
  if (std::abs(terms.sum.value) - terms.sum.error < kLeastSum) {
    answer.u.error = answer.v.error = kInfinity;
  }
  return answer;
}

std::vector<ShapeAnswer> TestSphere(const ApproximateRay& ray, const ApproximateVertex& sphere) {
  const Approximate length2 = Dot(ray.dir, ray.dir);
  if (IsZero(length2)) return {};
  const Approximate3 to_center = sphere.position - ray.org;
  const Approximate middle = Dot(to_center, ray.dir) / length2;
  const Approximate3 beside = to_center - middle * ray.dir;
  const Approximate distance2 = Dot(beside, beside), radius2 = sphere.radius * sphere.radius;
  const Approximate rest = radius2 - distance2;
  const Approximate half = SquareRoot(rest / length2);
  std::vector<ShapeAnswer> answers;
  for (const Approximate& along : {-half, half}) {
    const Approximate t = middle + along;
    ShapeAnswer answer;
    const bool is_possible = Decide({{rest, kDoubtEdge},
                                     {AfterNear(ray, t, Exactly(1)), kDoubtInterval},
                                     {BeforeFar(ray, t, Exactly(1)), kDoubtInterval}},
                                    answer);
    const bool is_out_of_range = AnyMayOverflow({length2, middle, distance2, radius2, t}) ||
                                 !(Magnitude(length2) > kUnderflow / kUnitRoundoff);
    if (!is_possible && !is_out_of_range) continue;
    answer.t = t;
    const Approximate3 normal = along * ray.dir - beside;
    std::copy_n(normal.begin(), 3, answer.normal);
    if (is_out_of_range) {
      answer.doubts |= kDoubtRange;
      ForgetValues(answer);
    }
    answers.push_back(answer);
  }
  return answers;
}

ShapeAnswer TestDisc(const ApproximateRay& ray, const ApproximateVertex& disc) {
  const Approximate length2 = Dot(ray.dir, ray.dir);
  ShapeAnswer answer;
  if (IsZero(length2)) return answer;
  const Approximate3 to_center = disc.position - ray.org;
  const Approximate t = Dot(to_center, ray.dir) / length2;
  const Approximate3 beside = to_center - t * ray.dir;
  const Approximate distance2 = Dot(beside, beside), radius2 = disc.radius * disc.radius;
  // A disc turns with the ray, so that one whose sphere holds the origin does not count.
  const bool is_possible = Decide({{radius2 - distance2, kDoubtEdge},
                                   {Dot(to_center, to_center) - radius2, kDoubtInterval},
                                   {AfterNear(ray, t, Exactly(1)), kDoubtInterval},
                                   {BeforeFar(ray, t, Exactly(1)), kDoubtInterval}},
                                  answer);
  const bool is_out_of_range = AnyMayOverflow({length2, t, distance2, radius2}) ||
                               !(Magnitude(length2) > kUnderflow / kUnitRoundoff);
  if (!is_possible && !is_out_of_range) return {};
  answer.t = t;
  for (int axis = 0; axis < 3; ++axis) answer.normal[axis] = -ray.dir[axis];
  if (is_out_of_range) {
    answer.doubts |= kDoubtRange;
    ForgetValues(answer);
  }
  return answer;
}

ShapeAnswer TestOrientedDisc(const ApproximateRay& ray, const ApproximateVertex& disc,
                             const Approximate3& normal) {
  const Approximate slope = Dot(ray.dir, normal);
  ShapeAnswer answer;
  if (IsZero(slope)) return answer;
  const Approximate t = Dot(disc.position - ray.org, normal) / slope;
  const Approximate3 off = ray.org + t * ray.dir - disc.position;
  const Approximate distance2 = Dot(off, off), radius2 = disc.radius * disc.radius;
  // Without a slope that is known, t is not known either, and every condition is in doubt.
  const Doubt edge = std::isinf(t.error) ? kDoubtParallel : kDoubtEdge;
  const bool is_possible = Decide({{radius2 - distance2, edge},
                                   {AfterNear(ray, t, Exactly(1)), kDoubtInterval},
                                   {BeforeFar(ray, t, Exactly(1)), kDoubtInterval}},
                                  answer);
  const bool is_out_of_range =
      !std::isinf(t.error) && AnyMayOverflow({slope, t, distance2, radius2});
  if (!is_possible && !is_out_of_range) return {};
  answer.t = t;
  std::copy_n(normal.begin(), 3, answer.normal);
  if (is_out_of_range) {
    answer.doubts |= kDoubtRange;
    ForgetValues(answer);
  }
  return answer;
}

}  // namespace dacrt::tests

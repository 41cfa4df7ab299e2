#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ray_box_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/box.h"
#include "geometry/ray_box-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Float3;
using unit::kInfinity;
using unit::Random;
using unit::Ray;

float FirstLane(V v) {
  HWY_ALIGN float lanes[kMaxLanes];
  hn::Store(v, kFloat, lanes);
  return lanes[0];
}

struct ScalarInterval {
  float entry;
  float exit;
};

struct RayLanes {
  V org[3];
  V reciprocal[3];
  V tnear;
  V tfar;

  explicit RayLanes(const Ray& ray)
      : tnear(hn::Set(kFloat, ray.tnear)), tfar(hn::Set(kFloat, ray.tfar)) {
    for (size_t axis = 0; axis < 3; ++axis) {
      org[axis] = hn::Set(kFloat, ray.org[axis]);
      reciprocal[axis] = SafeReciprocal(hn::Set(kFloat, ray.dir[axis]));
    }
  }
};

ScalarInterval IntervalOf(const Ray& ray, const Box& box) {
  const RayLanes lanes(ray);
  const Interval interval = IntersectBox(Widen(box.lower, box.upper), lanes.org, lanes.reciprocal);
  return {FirstLane(interval.entry), FirstLane(interval.exit)};
}

bool EntersBox(const Ray& ray, const Box& box) {
  const RayLanes lanes(ray);
  const Interval interval = IntersectBox(Widen(box.lower, box.upper), lanes.org, lanes.reciprocal);
  return Bits(Enters(interval, lanes.tnear, lanes.tfar)) & 1;
}

Box BoxOf(const Float3& a, const Float3& b, const Float3& c) {
  Box box = Box::Empty();
  box.Extend(a.data());
  box.Extend(b.data());
  box.Extend(c.data());
  return box;
}

// A ray aimed at a point of a triangle enters the triangle's box, from near and far, at scenes of
// every size; and the exact distance lies in the interval.
void IsConservative() {
  Random random(1);
  size_t rays = 0;
  for (int i = 0; i < 40000; ++i) {
    const float scale = std::abs(random.AnyMagnitude(1e-9f, 1e9f));
    const float size = scale * std::exp2(random.Uniform(-12, 0));
    const float distance = scale * std::exp2(random.Uniform(-10, 10));
    Float3 corner[3];
    corner[0] = random.InCube(-scale, scale);
    for (int k = 1; k < 3; ++k) {
      corner[k] = random.InCube(-size, size);
      for (size_t axis = 0; axis < 3; ++axis) corner[k][axis] += corner[0][axis];
    }
    if (i % 4 == 0) {  // flat in an axis: a box without volume
      const size_t axis = random.Below(3);
      corner[1][axis] = corner[2][axis] = corner[0][axis];
    }
    const float u = random.Uniform(0, 1), v = random.Uniform(0, 1 - u);
    Float3 target, dir = random.Direction();
    const float length = std::exp2(random.Uniform(-20, 20));
    Ray ray;
    for (size_t axis = 0; axis < 3; ++axis) {
      target[axis] = corner[0][axis] + u * (corner[1][axis] - corner[0][axis]) +
                     v * (corner[2][axis] - corner[0][axis]);
      ray.org[axis] = target[axis] - distance * dir[axis];
      ray.dir[axis] = dir[axis] * length;
    }
    const unit::ExactHit exact = unit::IntersectExactly(ray, corner[0], corner[1], corner[2]);
    if (!(exact.inside >= 0) || exact.t < 0) continue;
    ++rays;
    const Box box = BoxOf(corner[0], corner[1], corner[2]);
    ASSERT_TRUE(EntersBox(ray, box)) << "ray " << i;
    const ScalarInterval interval = IntervalOf(ray, box);
    ASSERT_LE(interval.entry, exact.t) << "ray " << i;
    ASSERT_GE(interval.exit, exact.t) << "ray " << i;
    // The same if the ray ends or begins just there.
    ray.tfar = std::nextafter(static_cast<float>(exact.t), kInfinity);
    ASSERT_TRUE(EntersBox(ray, box)) << "ray " << i << " ends at the triangle";
    ray.tfar = kInfinity;
    ray.tnear = std::nextafter(static_cast<float>(exact.t), 0.0f);
    ASSERT_TRUE(EntersBox(ray, box)) << "ray " << i << " begins at the triangle";
  }
  EXPECT_GT(rays, 20000u);
}

// The slack is no licence: a ray that passes well beside a box does not enter it.
void MissesWhatIsFarBeside() {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const Float3 center = random.InCube(-10, 10);
    Box box = Box::Empty();
    for (int k = 0; k < 2; ++k) {
      Float3 corner = random.InCube(-1, 1);
      for (size_t axis = 0; axis < 3; ++axis) corner[axis] += center[axis];
      box.Extend(corner.data());
    }
    // In a plane parallel to two axes, outside the box on the third by a thousandth.
    const size_t axis = random.Below(3);
    Ray ray = unit::MakeRay(random.InCube(-10, 10), random.Direction());
    ray.org[axis] = random.Next() & 1 ? box.upper[axis] + 1e-3f : box.lower[axis] - 1e-3f;
    ray.dir[axis] = random.Next() & 1 ? 0.0f : -0.0f;
    ASSERT_FALSE(EntersBox(ray, box)) << "ray " << i;
  }
}

// What the promise of equal bits rests on: if A lies in B, B is entered no later and left no
// earlier.
void IsMonotone() {
  Random random(3);
  for (int i = 0; i < 60000; ++i) {
    const bool tiny = i % 3 == 0;  // where the absolute widening governs
    const auto coordinate = [&] {
      if (random.Below(16) == 0) return random.Next() & 1 ? 0.0f : -0.0f;
      return tiny ? random.AnyMagnitude(1e-23f, 1e-17f) : random.AnyMagnitude(1e-6f, 1e6f);
    };
    Box inner, outer;
    Ray ray;
    for (size_t axis = 0; axis < 3; ++axis) {
      const float a = coordinate(), b = coordinate();
      inner.lower[axis] = outer.lower[axis] = std::min(a, b);
      inner.upper[axis] = outer.upper[axis] = std::max(a, b);
      // Outer faces: the same, the next number, or anything further out.
      for (uint32_t ulps = random.Below(4); ulps > 0; --ulps) {
        outer.lower[axis] = std::nextafter(outer.lower[axis], -kInfinity);
        outer.upper[axis] = std::nextafter(outer.upper[axis], kInfinity);
      }
      if (random.Below(4) == 0) outer.upper[axis] += std::abs(coordinate());
      ray.org[axis] = random.Below(4) == 0 ? inner.lower[axis] : coordinate();
      ray.dir[axis] = random.Below(8) == 0 ? (random.Next() & 1 ? 0.0f : -0.0f)
                                           : random.AnyMagnitude(1e-30f, 1e10f);
    }
    const ScalarInterval in = IntervalOf(ray, inner), out = IntervalOf(ray, outer);
    ASSERT_LE(out.entry, in.entry) << "pair " << i;
    ASSERT_GE(out.exit, in.exit) << "pair " << i;
  }
}

// The share of x and the constant must not be added up before they are taken off: the sum moves in
// steps of 2^-90, at multiples of 2^-68 for x, which for x below 1e-20 are larger than those of x.
void WideningIsMonotoneNearItsConstant() {
  for (int k = 0; k < 64; ++k) {
    for (const float sign : {1.0f, -1.0f}) {
      float x = sign * (static_cast<float>(k) + 0.5f) * 0x1p-68f;
      for (int i = 0; i < 16; ++i) x = std::nextafter(x, -kInfinity);
      for (int i = 0; i < 32; ++i) {
        const float y = std::nextafter(x, kInfinity);
        ASSERT_LE(FirstLane(WidenDown(hn::Set(kFloat, x))),
                  FirstLane(WidenDown(hn::Set(kFloat, y))))
            << x;
        ASSERT_LE(FirstLane(WidenUp(hn::Set(kFloat, x))), FirstLane(WidenUp(hn::Set(kFloat, y))))
            << x;
        x = y;
      }
    }
  }
}

void WideningContainsTheBox() {
  Random random(5);
  const float special[] = {0.0f, -0.0f, 1e-45f, -1e-45f, 1e-38f, 1.0f, -1.0f, 1.8e18f, -1.8e18f};
  for (int i = 0; i < 10000; ++i) {
    const float x = i < 9 ? special[i] : random.AnyMagnitude(1e-40f, 1.8e18f);
    ASSERT_LT(FirstLane(WidenDown(hn::Set(kFloat, x))), x);
    ASSERT_GT(FirstLane(WidenUp(hn::Set(kFloat, x))), x);
  }
}

void ReciprocalIsFiniteAndKeepsTheSign() {
  const float special[] = {0.0f, 1e-45f, 1e-38f, 1e-36f, 1e-20f, 1.0f, 3.0f, 1e30f, 3.4e38f};
  for (const float magnitude : special) {
    for (const float x : {magnitude, -magnitude}) {
      const float reciprocal = FirstLane(SafeReciprocal(hn::Set(kFloat, x)));
      EXPECT_TRUE(std::isfinite(reciprocal)) << x;
      EXPECT_NE(reciprocal, 0.0f) << x;
      EXPECT_EQ(std::signbit(reciprocal), std::signbit(x)) << x;
      if (magnitude >= 1e-36f) {
        EXPECT_EQ(reciprocal, 1.0f / x);
      }
    }
  }
}

// A ray that runs exactly in a face, along an edge or through a corner of the box is in the box,
// with either zero as the direction's component.
void RaysInAFaceAreInside() {
  const float faces[][2] = {{-1, 1}, {0, 1}, {-1, 0}, {0, 0}, {1e6f, 1e6f + 1}, {-3e-5f, 7e-5f}};
  for (const auto& x : faces) {
    for (const auto& y : faces) {
      const Box box{{x[0], y[0], -2, 0}, {x[1], y[1], 2, 0}};
      for (const float px : {x[0], (x[0] + x[1]) / 2, x[1]}) {
        for (const float py : {y[0], (y[0] + y[1]) / 2, y[1]}) {
          for (const float zero : {0.0f, -0.0f}) {
            for (const float way : {1.0f, -1.0f}) {
              const Ray ray = unit::MakeRay({px, py, -10 * way}, {zero, -zero, way});
              EXPECT_TRUE(EntersBox(ray, box)) << px << ' ' << py << ' ' << zero << ' ' << way;
            }
          }
        }
      }
    }
  }
}

void IntervalBoundsDecide() {
  const Box box{{1, -1, -1, 0}, {2, 1, 1, 0}};
  const auto enters = [&](float tnear, float tfar) HWY_ATTR {
    return EntersBox(unit::MakeRay({0, 0, 0}, {1, 0, 0}, tnear, tfar), box);
  };
  EXPECT_TRUE(enters(0, kInfinity));
  EXPECT_TRUE(enters(0, 1));
  EXPECT_TRUE(enters(2, kInfinity));
  EXPECT_TRUE(enters(1.5f, 1.5f));
  EXPECT_TRUE(enters(-kInfinity, kInfinity));
  EXPECT_FALSE(enters(0, 0.99f));
  EXPECT_FALSE(enters(2.01f, kInfinity));
  EXPECT_FALSE(enters(kInactiveTNear, kInactiveTFar));
  EXPECT_FALSE(enters(0, -kInfinity)) << "a blocked any-hit ray";
  // Behind the origin, also with a negative tnear: that counts as zero.
  EXPECT_FALSE(EntersBox(unit::MakeRay({0, 0, 0}, {-1, 0, 0}, -10), box));
  // From inside, and on the surface, leaving.
  EXPECT_TRUE(EntersBox(unit::MakeRay({1.5f, 0, 0}, {-1, 0, 0}), box));
  EXPECT_TRUE(EntersBox(unit::MakeRay({2, 0, 0}, {1, 0, 0}), box));
}

void BitsAreOneALane() {
  HWY_ALIGN float lanes[kMaxLanes] = {};
  for (uint32_t pattern = 0; pattern < (1u << std::min<size_t>(Lanes(), 10)); ++pattern) {
    for (size_t i = 0; i < Lanes(); ++i) lanes[i] = (pattern >> i) & 1 ? 1.0f : 0.0f;
    ASSERT_EQ(Bits(hn::Gt(hn::Load(kFloat, lanes), hn::Zero(kFloat))), pattern);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(RayBoxTest);
HWY_EXPORT_AND_TEST_P(RayBoxTest, IsConservative);
HWY_EXPORT_AND_TEST_P(RayBoxTest, MissesWhatIsFarBeside);
HWY_EXPORT_AND_TEST_P(RayBoxTest, IsMonotone);
HWY_EXPORT_AND_TEST_P(RayBoxTest, WideningIsMonotoneNearItsConstant);
HWY_EXPORT_AND_TEST_P(RayBoxTest, WideningContainsTheBox);
HWY_EXPORT_AND_TEST_P(RayBoxTest, ReciprocalIsFiniteAndKeepsTheSign);
HWY_EXPORT_AND_TEST_P(RayBoxTest, RaysInAFaceAreInside);
HWY_EXPORT_AND_TEST_P(RayBoxTest, IntervalBoundsDecide);
HWY_EXPORT_AND_TEST_P(RayBoxTest, BitsAreOneALane);

}  // namespace dacrt
#endif  // HWY_ONCE

#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "corner_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/corner-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

TriangleRef RandomRef(Random& random) {
  TriangleRef ref;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = random.Uniform(-5, 5), b = random.Uniform(-5, 5);
    ref.lower[axis] = std::min(a, b);
    ref.upper[axis] = std::max(a, b);
  }
  // As floats these are a NaN, a denormal, an infinity, a number.
  constexpr uint32_t kNames[] = {UINT32_MAX, 7, 0x7F800000u, 0x3F800000u};
  ref.primitive = kNames[random.Below(4)];
  ref.geometry = kNames[random.Below(4)];
  return ref;
}

void TwiceCenterIsTheSumOfTheCorners() {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const TriangleRef ref = RandomRef(random);
    HWY_ALIGN float center[4];
    TwiceCenter(Corner::Load(ref.lower), Corner::Load(ref.upper)).Store(center);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(center[axis], ref.lower[axis] + ref.upper[axis]);
    }
    ASSERT_EQ(center[3], 0.0f);
  }
}

// Against Box, which does the same one float at a time; the names behind the corners do no harm.
void BoundsAreThoseOfBox() {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    Box expected = Box::Empty(), extended = Box::Empty();
    CornerBounds bounds;
    for (uint32_t k = random.Below(20); k > 0; --k) {
      const TriangleRef ref = RandomRef(random);
      expected.Extend(ref.lower);
      expected.Extend(ref.upper);
      ExtendBox(extended, Corner::Load(ref.lower), Corner::Load(ref.upper));
      bounds.Extend(Corner::Load(ref.lower));
      bounds.Extend(Corner::Load(ref.upper));
    }
    const Box box = bounds.Get();
    EXPECT_EQ(box.IsEmpty(), expected.IsEmpty());
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(box.lower[axis], expected.lower[axis]);
      ASSERT_EQ(box.upper[axis], expected.upper[axis]);
      ASSERT_EQ(extended.lower[axis], expected.lower[axis]);
      ASSERT_EQ(extended.upper[axis], expected.upper[axis]);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(CornerTest);
HWY_EXPORT_AND_TEST_P(CornerTest, TwiceCenterIsTheSumOfTheCorners);
HWY_EXPORT_AND_TEST_P(CornerTest, BoundsAreThoseOfBox);

TEST(BoxTest, HalfAreaIsHalfOfTheSurface) {
  const Box box{{-1, 0, 2, 0}, {1, 3, 6, 0}};
  EXPECT_EQ(box.HalfArea(), 2 * 3 + 3 * 4 + 4 * 2);
  EXPECT_EQ(Box::Empty().HalfArea(), 0);
  const Box flat{{0, 0, 1, 0}, {2, 3, 1, 0}};
  EXPECT_EQ(flat.HalfArea(), 6);
  EXPECT_FALSE(flat.IsEmpty());
  EXPECT_TRUE(Box::Empty().IsEmpty());
}

}  // namespace dacrt
#endif  // HWY_ONCE

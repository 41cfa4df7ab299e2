#include "geometry/instance_bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "unit_test.h"

namespace dacrt {
namespace {

using unit::Random;

// What a ray meets in an instance is computed from the ray as it is there: it may lie outside of
// the box by the roundings of both ways.
TEST(InstanceBoundsTest, BoxesAreWiderThanWhatTheyHold) {
  constexpr double kRoundings = 0x1p-21;
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    TransformStep step;
    for (auto& column : step.matrix.column) {
      for (float& value : column) value = random.Uniform(-3, 3);
    }
    Box box = Box::Empty();
    for (int corner = 0; corner < 2; ++corner) box.Extend(random.InCube(-5, 5).data());
    Box bounds;
    BoundInstance({&step, 1}, box, &bounds);
    for (int corner = 0; corner < 8; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        double place = step.matrix.column[3][axis], size = std::abs(place);
        for (int k = 0; k < 3; ++k) {
          const double way =
              double{step.matrix.column[k][axis]} * (corner >> k & 1 ? box.upper[k] : box.lower[k]);
          place += way;
          size += std::abs(way);
        }
        ASSERT_LE(bounds.lower[axis], place - kRoundings * size);
        ASSERT_GE(bounds.upper[axis], place + kRoundings * size);
      }
    }
  }
}

TEST(InstanceBoundsTest, NothingIsBoundedThatIsTooFarAway) {
  TransformStep steps[3];
  steps[1].matrix.column[3][0] = 2e18f;
  const Box box{{-1, -1, -1}, {1, 1, 1}};
  Box bounds[3];
  BoundInstance(steps, box, bounds);
  EXPECT_FALSE(bounds[0].IsEmpty());
  EXPECT_TRUE(bounds[1].IsEmpty());
  EXPECT_FALSE(bounds[2].IsEmpty());
  BoundInstance(steps, Box::Empty(), bounds);
  EXPECT_TRUE(bounds[0].IsEmpty());
}

}  // namespace
}  // namespace dacrt

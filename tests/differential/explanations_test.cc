// What the real library may do, and no more: each explanation beside a case that it must not
// explain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "company.h"
#include "slab_test.h"
#include "world_compare.h"
#include "world_text.h"

namespace dacrt::tests {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

/// A small cube, and a large one around it, of a size.
struct Cubes {
  explicit Cubes(double size) {
    for (int axis = 0; axis < 3; ++axis) {
      own.lower[axis] = -0.125 * size;
      own.upper[axis] = 0.125 * size;
      all.lower[axis] = -2 * size;
      all.upper[axis] = 2 * size;
    }
  }

  SlabBox own, all;
};

ApproximateRay RayAlongY(double from, double x_direction) {
  return {{Exactly(0), Exactly(from), Exactly(0)},
          {Exactly(x_direction), Exactly(1), Exactly(1)},
          0,
          kInfinity};
}

// In a box that is 4e17 long a ray leaves an eighth of 1e17 after 1/32 of 1e18, which is 3.1e16.
TEST(OwnSpaceTest, LosesWhatIsFartherThanTheWayOut) {
  const Cubes cubes(1e17);
  const auto may_miss = [&](double from, double x_direction) {
    ApproximateRay ray = RayAlongY(from, x_direction);
    ray.dir[2] = Exactly(0);
    return OwnSpaceTestMayMiss(ray, cubes.own, cubes.all);
  };
  EXPECT_TRUE(may_miss(-5e16, 0));
  EXPECT_TRUE(may_miss(-5e16, 0.1));
  EXPECT_FALSE(may_miss(-4e16, 0)) << "enters after 2.75e16";
}

TEST(OwnSpaceTest, LosesNothingWhereDirectionsAreLargeEnough) {
  const Cubes cubes(1e17);
  ApproximateRay ray = RayAlongY(-1e18, 0.5);
  EXPECT_FALSE(OwnSpaceTestMayMiss(ray, cubes.own, cubes.all));
  ray.dir[0] = Exactly(0.3);
  EXPECT_TRUE(OwnSpaceTestMayMiss(ray, cubes.own, cubes.all));
}

TEST(OwnSpaceTest, LosesNothingInScenesOfUsualSizes) {
  const Cubes cubes(1e6);
  for (const double x : {0.0, -0.0, 1e-13, 0.1}) {
    EXPECT_FALSE(OwnSpaceTestMayMiss(RayAlongY(-1e9, x), cubes.own, cubes.all)) << x;
  }
}

TEST(CompanyOf, OnlyADistanceOfNoNumberInThePacketLosesItsEnd) {
  const RTCRayHit ray{{0, 0, 0, 0, 1, 1, 1, 0, kInfinity, 0, 0, 0}, {}};
  const std::vector<RTCRayHit> rays(100, ray);
  const auto loses_its_end = [&](bool coherent, std::size_t other, float t) {
    std::vector<RTCRayHit> answers = rays;
    answers[other].ray.tfar = t;
    const Form form{Form::Call::kRecords, coherent};
    return CompanyOf(form, Query::kClosest, rays, answers, 50).loses_its_end;
  };
  EXPECT_TRUE(loses_its_end(true, 40, kNoNumber));
  EXPECT_TRUE(loses_its_end(true, 60, kNoNumber));
  EXPECT_FALSE(loses_its_end(true, 90, kNoNumber));
  EXPECT_FALSE(loses_its_end(false, 40, kNoNumber));
  EXPECT_FALSE(loses_its_end(true, 40, 1e30f));
}

/// The world in which a filter function is shown a hit that is given up, and the ray of it.
class GivenUpHitTest : public testing::Test {
 protected:
  GivenUpHitTest() {
    std::ifstream file(std::string(DACRT_REGRESSIONS_DIR) +
                       "/offer_behind_a_hit_that_was_given_up.world");
    world_ = ReadWorld(file);
  }

  const Batch& batch() const { return world_.stages[0].batches[0]; }

  bool IsFault(Library library, const RTCHit& hit, float t, const std::vector<Offer>& offers) {
    const RTCRayHit& before = batch().rays[0];
    RTCRayHit after = before;
    after.hit = hit;
    after.ray.tfar = t;
    const WorldComparer comparer(world_.scenes);
    return comparer.FindOfferFault(batch(), library, before, after, offers, {}).has_value();
  }

  const RTCHit triangle_{
      -3.80104895e+31f, 5.21865761e+31f, 5.23230493e+31f, 0.0556785502f, 0.69348079f, 2, 1, {1}};
  const RTCHit sphere_{6.87639431e+14f, -9.38536878e+10f, -4.54001459e+09f, 0, 0, 0, 0, {3}};
  static constexpr float kNearSide = 3.83963617e+17f;

  World world_;
};

TEST_F(GivenUpHitTest, NothingBehindItNeedsToBeShown) {
  const Offer near{batch().rays[0].ray.id, sphere_, kNearSide, false};
  const Offer far{batch().rays[0].ray.id, triangle_, kInfinity, false};
  EXPECT_FALSE(IsFault(Library::kReal, triangle_, kInfinity, {near, far}));
}

TEST_F(GivenUpHitTest, ItMustHaveBeenShown) {
  const Offer far{batch().rays[0].ray.id, triangle_, kInfinity, false};
  EXPECT_TRUE(IsFault(Library::kReal, triangle_, kInfinity, {far}));
}

TEST_F(GivenUpHitTest, OnlyTheRealLibraryMay) {
  const Offer near{batch().rays[0].ray.id, sphere_, kNearSide, false};
  const Offer far{batch().rays[0].ray.id, triangle_, kInfinity, false};
  EXPECT_TRUE(IsFault(Library::kDropIn, triangle_, kInfinity, {near, far}));
}

}  // namespace
}  // namespace dacrt::tests

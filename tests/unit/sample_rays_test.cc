#include <gtest/gtest.h>

#include <memory>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sample_rays_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/box.h"
#include "paper/sample_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BatchMemory;
using unit::Random;
using unit::Ray;

/// Rays that can be told apart: org[0] is the ray's number.
std::vector<Ray> NumberedRays(Random& random, size_t count) {
  std::vector<Ray> rays = unit::MakeRays(random, count, 1);
  for (size_t i = 0; i < count; ++i) {
    rays[i].org[0] = static_cast<float>(i);
    rays[i].tnear = random.Uniform(0, 1);
    rays[i].tfar = random.Uniform(1, 2);
  }
  return rays;
}

// One from each of `count` equal stretches, so that they are spread evenly and none comes twice.
void TakesOneOfEachStretch() {
  Random random(1);
  const auto samples = std::make_unique<SampleRays>();
  for (const size_t ray_count : {1u, 2u, 15u, 16u, 17u, 100u, 101u, 1000u, 5000u}) {
    const auto rays = NumberedRays(random, ray_count);
    BatchMemory memory(8192, ray_count);
    memory.Push(NumberedRays(random, 1));  // so that the block does not begin at 0
    const RayBlock block = memory.Push(rays);
    for (const size_t count : {1u, 2u, 16u, 100u, 1024u}) {
      TakeSampleRays(memory.batch, block, count, *samples);
      ASSERT_EQ(samples->count, std::min(count, ray_count));
      for (size_t i = 0; i < samples->count; ++i) {
        const size_t number = static_cast<size_t>(samples->org[0][i]);
        ASSERT_GE(number, i * ray_count / samples->count);
        ASSERT_LT(number, (i + 1) * ray_count / samples->count);
        for (size_t axis = 0; axis < 3; ++axis) {
          ASSERT_EQ(samples->org[axis][i], rays[number].org[axis]);
          ASSERT_EQ(samples->reciprocal[axis][i], 1 / rays[number].dir[axis]);
        }
        ASSERT_EQ(samples->tnear[i], rays[number].tnear);
        ASSERT_EQ(samples->tfar[i], rays[number].tfar);
      }
    }
  }
}

// As many as asked for, and of very many rays more, up to the sample's capacity.
void ManyRaysAreSampledByMore() {
  EXPECT_EQ(SampleCount(1001, 100), 100u);
  EXPECT_EQ(SampleCount(100 * 512, 100), 100u);
  EXPECT_EQ(SampleCount(200 * 512, 100), 200u);
  EXPECT_EQ(SampleCount(size_t{1} << 30, 100), SampleRays::kCapacity);
  EXPECT_EQ(SampleCount(5000, SampleRays::kCapacity), SampleRays::kCapacity);
}

// A regular pattern of the caller (rows of pixels) must not meet a regular pattern of places.
void PlacesInTheStretchesVary() {
  Random random(2);
  const auto samples = std::make_unique<SampleRays>();
  BatchMemory memory(8192, 6400);
  const RayBlock block = memory.Push(NumberedRays(random, 6400));
  TakeSampleRays(memory.batch, block, 100, *samples);
  std::array<int, 8> places{};
  for (size_t i = 0; i < 100; ++i) {
    ++places[(static_cast<size_t>(samples->org[0][i]) - i * 64) / 8];
  }
  for (const int count : places) EXPECT_GT(count, 2);
}

void TheSameBlockGivesTheSameSample() {
  Random random(3);
  const auto a = std::make_unique<SampleRays>(), b = std::make_unique<SampleRays>();
  BatchMemory memory(2048, 1000);
  const RayBlock block = memory.Push(NumberedRays(random, 1000));
  TakeSampleRays(memory.batch, block, 100, *a);
  TakeSampleRays(memory.batch, block, 100, *b);
  for (size_t i = 0; i < 100; ++i) ASSERT_EQ(a->org[0][i], b->org[0][i]);
}

/// Where the line of a ray is in a box, in double precision; not the engine's arithmetic.
struct ExactInterval {
  double entry;
  double exit;
};

ExactInterval Exactly(const Ray& ray, const Box& box) {
  ExactInterval interval{0, double{ray.tfar}};
  for (size_t axis = 0; axis < 3; ++axis) {
    const double t0 = (double{box.lower[axis]} - ray.org[axis]) / ray.dir[axis];
    const double t1 = (double{box.upper[axis]} - ray.org[axis]) / ray.dir[axis];
    interval.entry = std::max(interval.entry, std::min(t0, t1));
    interval.exit = std::min(interval.exit, std::max(t0, t1));
  }
  return interval;
}

Box RandomBox(Random& random) {
  Box box = Box::Empty();
  for (int k = 0; k < 2; ++k) box.Extend(random.InCube(-4, 4).data());
  return box;
}

void CountsMatchDoublePrecision() {
  Random random(4);
  const auto samples = std::make_unique<SampleRays>();
  SampleCounts total;
  for (int round = 0; round < 3000; ++round) {
    const Box left = RandomBox(random), right = RandomBox(random);
    SampleCounts expected;
    std::vector<Ray> rays;
    const size_t count = 1 + random.Below(70);
    while (rays.size() < count) {
      Ray ray = unit::MakeRays(random, 1, 4)[0];
      if (random.Below(3) == 0) ray.tfar = random.Uniform(0, 4);
      const ExactInterval l = Exactly(ray, left), r = Exactly(ray, right);
      // Rays that rounding and slack could decide otherwise are left out.
      constexpr double kClear = 1e-3;
      if (std::abs(l.exit - l.entry) < kClear || std::abs(r.exit - r.entry) < kClear) continue;
      if (l.entry != r.entry && std::abs(l.entry - r.entry) < kClear) continue;
      rays.push_back(ray);
      const bool hits_left = l.entry < l.exit, hits_right = r.entry < r.exit;
      expected.left_hits += hits_left;
      expected.right_hits += hits_right;
      expected.left_closer += hits_left && hits_right && l.entry < r.entry;
      expected.right_closer += hits_left && hits_right && r.entry < l.entry;
    }
    BatchMemory memory(128, rays.size());
    const RayBlock block = memory.Push(rays);
    TakeSampleRays(memory.batch, block, SampleRays::kCapacity, *samples);
    const SampleCounts counts = CountSamples(*samples, left, right);
    ASSERT_EQ(counts.left_hits, expected.left_hits) << "round " << round;
    ASSERT_EQ(counts.right_hits, expected.right_hits) << "round " << round;
    ASSERT_EQ(counts.left_closer, expected.left_closer) << "round " << round;
    ASSERT_EQ(counts.right_closer, expected.right_closer) << "round " << round;
    total.left_hits += counts.left_hits;
    total.left_closer += counts.left_closer;
    total.right_closer += counts.right_closer;
  }
  EXPECT_GT(total.left_hits, 500u);
  EXPECT_GT(total.left_closer, 500u);
  EXPECT_GT(total.right_closer, 500u);
}

void RaysThatSayNothingAboutTheOrderCountForNeither() {
  const auto samples = std::make_unique<SampleRays>();
  const Box left{{0, 0, 0, 0}, {2, 2, 2, 0}}, right{{1, 0, 0, 0}, {3, 2, 2, 0}};
  BatchMemory memory(64, 4);
  const std::vector<Ray> rays = {
      unit::MakeRay({1.5f, 1, 1}, {1, 0, 0}),                        // begins in both
      unit::MakeRay({1.5f, 1, -5}, {0, 0, 1}),                       // enters both at once
      unit::MakeRay({9, 9, 9}, {1, 0, 0}),                           // misses both
      unit::MakeRay({1.5f, 1, 1}, {1, 0, 0}, 0, -unit::kInfinity)};  // blocked already
  const RayBlock block = memory.Push(rays);
  TakeSampleRays(memory.batch, block, 100, *samples);
  const SampleCounts counts = CountSamples(*samples, left, right);
  EXPECT_EQ(counts.left_hits, 2u);
  EXPECT_EQ(counts.right_hits, 2u);
  EXPECT_EQ(counts.left_closer, 0u);
  EXPECT_EQ(counts.right_closer, 0u);
}

// The slides: "number of sample rays with smaller entry distances". A ray that misses one side has
// nothing to compare.
void TheSideEnteredFirstIsCloser() {
  const auto samples = std::make_unique<SampleRays>();
  const Box left{{0, 0, 0, 0}, {1, 1, 1, 0}}, right{{2, 0, 0, 0}, {3, 1, 1, 0}};
  BatchMemory memory(64, 4);
  const std::vector<Ray> rays = {
      unit::MakeRay({-1, 0.5f, 0.5f}, {1, 0, 0}),            // left first, then right
      unit::MakeRay({5, 0.5f, 0.5f}, {-1, 0, 0}),            // right first, then left
      unit::MakeRay({2.5f, -1, 0.5f}, {0, 1, 0}),            // right alone
      unit::MakeRay({5, 0.5f, 0.5f}, {-1, 0, 0}, 0, 2.5f)};  // right, ends before left
  const RayBlock block = memory.Push(rays);
  TakeSampleRays(memory.batch, block, 100, *samples);
  const SampleCounts counts = CountSamples(*samples, left, right);
  EXPECT_EQ(counts.left_hits, 2u);
  EXPECT_EQ(counts.right_hits, 4u);
  EXPECT_EQ(counts.left_closer, 1u);
  EXPECT_EQ(counts.right_closer, 1u);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(SampleRaysTest);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, TakesOneOfEachStretch);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, ManyRaysAreSampledByMore);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, PlacesInTheStretchesVary);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, TheSameBlockGivesTheSameSample);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, CountsMatchDoublePrecision);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, RaysThatSayNothingAboutTheOrderCountForNeither);
HWY_EXPORT_AND_TEST_P(SampleRaysTest, TheSideEnteredFirstIsCloser);

}  // namespace dacrt
#endif  // HWY_ONCE

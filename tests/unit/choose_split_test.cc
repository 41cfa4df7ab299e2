#include <gtest/gtest.h>

#include <memory>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "choose_split_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/triangle_refs.h"
#include "paper/choose_split-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BatchMemory;
using unit::Random;
using unit::Ray;

std::optional<Split> Choose(const std::vector<TriangleRef>& refs, uint32_t bins, bool sampled,
                            Scratch& scratch) {
  StepClock clock;
  return ChooseSplit(refs.data(), unit::RangeOf(refs, 0, refs.size()), bins, sampled, scratch,
                     clock);
}

TriangleRef RefOf(float lower_x, float upper_x) {
  return {{lower_x, -1, -1}, 0, {upper_x, 1, 1}, 0};
}

/// Rays and triangles of the slides' worked example. Six triangles along x in five bins, two of
/// them in the last; three sample rays:
///   through all of them along x; along x too, but from the third on; across, through the fourth.
class SlidesExample {
 public:
  SlidesExample() : memory_(64, 3), scratch(std::make_unique<Scratch>()) {
    for (const int i : {0, 1, 2, 3, 4, 4}) {
      refs.push_back(RefOf(static_cast<float>(i) + 0.1f, static_cast<float>(i) + 0.9f));
    }
    const std::vector<Ray> rays = {unit::MakeRay({-1, 0, 0}, {1, 0, 0}),
                                   unit::MakeRay({2.5f, 0, 0}, {1, 0, 0}),
                                   unit::MakeRay({3.5f, 5, 0}, {0, -1, 0})};
    TakeSampleRays(memory_.batch, memory_.Push(rays), 100, scratch->samples);
  }

 private:
  BatchMemory memory_;

 public:
  std::vector<TriangleRef> refs;
  std::unique_ptr<Scratch> scratch;
};

void SlidesExampleCosts16And14And15And16Thirds() {
  SlidesExample example;
  const TriangleRange range = unit::RangeOf(example.refs, 0, example.refs.size());
  constexpr uint32_t kBins = 5;
  BinTriangles(example.refs.data(), range, BinMap(range.centers, kBins), kBins, *example.scratch);
  MakeCandidates(kBins, *example.scratch);
  constexpr double kCosts[] = {16 / 3.0, 14 / 3.0, 15 / 3.0, 16 / 3.0};
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_DOUBLE_EQ(SampledCost(example.scratch->candidates[0][k], example.scratch->samples),
                     kCosts[k]);
  }
}

void SlidesExampleChoosesTheSecond() {
  SlidesExample example;
  const auto split = Choose(example.refs, 5, true, *example.scratch);
  ASSERT_TRUE(split.has_value());
  EXPECT_EQ(split->axis, 0);
  EXPECT_EQ(split->last_left_bin, 1u);
  EXPECT_EQ(split->left_count, 2u);
  EXPECT_EQ(split->left_box.upper[0], 1.9f);
  EXPECT_EQ(split->right_box.lower[0], 2.1f);
}

// The surfaces alone, which know nothing of the rays, prefer another one: the middle.
void SurfacesChooseAnotherThere() {
  SlidesExample example;
  const auto split = Choose(example.refs, 5, false, *example.scratch);
  ASSERT_TRUE(split.has_value());
  EXPECT_EQ(split->last_left_bin, 2u);
}

void SurfaceCostIsThatOfWald() {
  const Box parent{{0, 0, 0, 0}, {4, 1, 1, 0}};
  const SplitCandidate candidate{{{0, 0, 0, 0}, {1, 1, 1, 0}}, {{2, 0, 0, 0}, {4, 1, 1, 0}}, 3, 7};
  EXPECT_DOUBLE_EQ(SurfaceCost(candidate, parent), 3 / 9.0 * 3 + 5 / 9.0 * 7);
}

// A parent without surface: all candidates cost the same, and none is not a number.
void SurfaceCostOfALineIsItsCount() {
  const Box line{{0, 0, 0, 0}, {4, 0, 0, 0}};
  const SplitCandidate candidate{line, line, 3, 7};
  EXPECT_EQ(SurfaceCost(candidate, line), 10);
}

/// Every candidate of every axis by sums over all triangles, cheapest first found.
void ChoosesTheLeastCost() {
  Random random(1);
  const auto scratch = std::make_unique<Scratch>();
  for (int round = 0; round < 200; ++round) {
    std::vector<TriangleRef> refs(2 + random.Below(200));
    for (TriangleRef& ref : refs) {
      for (int axis = 0; axis < 3; ++axis) {
        ref.lower[axis] = random.Uniform(-3, 3) * random.Uniform(0, 1);
        ref.upper[axis] = ref.lower[axis] + random.Uniform(0, 1);
      }
    }
    const uint32_t bins = 2 + random.Below(31);
    const bool sampled = round % 2 == 0;
    BatchMemory memory(512, 200);
    const auto rays = unit::MakeRays(random, 1 + random.Below(200), 4);
    TakeSampleRays(memory.batch, memory.Push(rays), 1 + random.Below(100), scratch->samples);
    const TriangleRange range = unit::RangeOf(refs, 0, refs.size());
    const auto split = Choose(refs, bins, sampled, *scratch);
    ASSERT_TRUE(split.has_value());

    const BinMap map(range.centers, bins);
    double least = 0, chosen = 0, least_surface = 0, chosen_surface = 0;
    bool first = true;
    for (int axis = 0; axis < 3; ++axis) {
      for (uint32_t k = 0; k + 1 < bins; ++k) {
        SplitCandidate candidate{Box::Empty(), Box::Empty(), 0, 0};
        for (const TriangleRef& ref : refs) {
          HWY_ALIGN int32_t bin[4];
          map.Map(TwiceCenter(Corner::Load(ref.lower), Corner::Load(ref.upper)), bin);
          const bool left = bin[axis] <= static_cast<int32_t>(k);
          Box& box = left ? candidate.left_box : candidate.right_box;
          box.Extend(ref.lower);
          box.Extend(ref.upper);
          ++(left ? candidate.left_count : candidate.right_count);
        }
        if (candidate.left_count == 0 || candidate.right_count == 0) continue;
        const double surface = SurfaceCost(candidate, range.bounds);
        const double cost = sampled ? SampledCost(candidate, scratch->samples) : surface;
        if (first || cost < least || (cost == least && surface < least_surface)) {
          least = cost;
          least_surface = surface;
          first = false;
        }
        if (axis == split->axis && k == split->last_left_bin) {
          chosen = cost;
          chosen_surface = surface;
          ASSERT_EQ(split->left_count, candidate.left_count);
          for (int a = 0; a < 3; ++a) {
            ASSERT_EQ(split->left_box.lower[a], candidate.left_box.lower[a]);
            ASSERT_EQ(split->right_box.upper[a], candidate.right_box.upper[a]);
          }
        }
      }
    }
    ASSERT_EQ(chosen, least) << "round " << round;
    ASSERT_EQ(chosen_surface, least_surface) << "round " << round;
  }
}

void CoincidentCentersHaveNoSplit() {
  const auto scratch = std::make_unique<Scratch>();
  std::vector<TriangleRef> refs;
  // Concentric boxes of different sizes.
  for (int i = 1; i < 20; ++i) {
    const float size = static_cast<float>(i);
    refs.push_back({{-size, -size, -size}, 0, {size, size, size}, 0});
  }
  EXPECT_FALSE(Choose(refs, 16, false, *scratch).has_value());
}

// Whatever the distribution, a split has triangles on both sides: the recursion ends.
void BothSidesHaveTriangles() {
  Random random(2);
  const auto scratch = std::make_unique<Scratch>();
  for (int round = 0; round < 500; ++round) {
    std::vector<TriangleRef> refs(2 + random.Below(10));
    for (TriangleRef& ref : refs) {
      for (int axis = 0; axis < 3; ++axis) {
        const float a = random.AnyMagnitude(1e-28f, 1.7e18f);
        const float b = random.AnyMagnitude(1e-28f, 1.7e18f);
        ref.lower[axis] = std::min(a, b);
        ref.upper[axis] = std::max(a, b);
      }
    }
    for (const uint32_t bins : {2u, 3u, 16u, 32u}) {
      const auto split = Choose(refs, bins, false, *scratch);
      ASSERT_TRUE(split.has_value());
      ASSERT_GT(split->left_count, 0u);
      ASSERT_LT(split->left_count, refs.size());
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(ChooseSplitTest);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, SlidesExampleCosts16And14And15And16Thirds);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, SlidesExampleChoosesTheSecond);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, SurfacesChooseAnotherThere);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, SurfaceCostIsThatOfWald);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, SurfaceCostOfALineIsItsCount);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, ChoosesTheLeastCost);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, CoincidentCentersHaveNoSplit);
HWY_EXPORT_AND_TEST_P(ChooseSplitTest, BothSidesHaveTriangles);

}  // namespace dacrt
#endif  // HWY_ONCE

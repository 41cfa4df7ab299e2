#include <gtest/gtest.h>

#include <memory>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "binning_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/triangle_refs.h"
#include "paper/binning-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

std::vector<TriangleRef> RandomRefs(Random& random, size_t count, float extent) {
  std::vector<TriangleRef> refs(count);
  for (size_t i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const float a = random.Uniform(-extent, extent), b = random.Uniform(-extent, extent);
      refs[i].lower[axis] = std::min(a, b);
      refs[i].upper[axis] = std::max(a, b);
    }
    refs[i].primitive = static_cast<uint32_t>(i);
    refs[i].geometry = UINT32_MAX;
  }
  return refs;
}

int32_t BinOf(const BinMap& map, const TriangleRef& ref, int axis) {
  HWY_ALIGN int32_t bin[4];
  map.Map(TwiceCenter(Corner::Load(ref.lower), Corner::Load(ref.upper)), bin);
  return bin[axis];
}

// Wald 2007: bin = bins (1 - epsilon) (centre - lower) / extent.
void BinsAreWalds() {
  Random random(1);
  for (const uint32_t bins : {2u, 3u, 16u, 32u}) {
    for (const float extent : {1e-15f, 1.0f, 1e17f}) {
      const auto refs = RandomRefs(random, 500, extent);
      const TriangleRange range = unit::RangeOf(refs, 0, refs.size());
      const BinMap map(range.centers, bins);
      for (const TriangleRef& ref : refs) {
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_TRUE(map.IsUseful(axis));
          const double center = double{ref.lower[axis]} + ref.upper[axis];
          const double lower = range.centers.lower[axis], upper = range.centers.upper[axis];
          const double place = bins * (center - lower) / (upper - lower);
          const int32_t bin = BinOf(map, ref, axis);
          ASSERT_GE(bin, 0);
          ASSERT_LT(bin, static_cast<int32_t>(bins));
          // Float arithmetic may decide otherwise at the borders of a bin only.
          ASSERT_NEAR(bin + 0.5, place, 0.5 + 1e-3) << bins << " bins";
        }
      }
    }
  }
}

// Else no candidate would have triangles on both sides, and every split would be by count.
void OuterCentersFallIntoOuterBins() {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const float offset = random.AnyMagnitude(1e-3f, 1e17f);
    auto refs = RandomRefs(random, 2, 1e-10f);
    for (TriangleRef& ref : refs) {
      for (int axis = 0; axis < 3; ++axis) {
        ref.lower[axis] += offset;
        ref.upper[axis] += offset;
      }
    }
    // As far apart as neighbouring numbers are, or further.
    const float further = std::nextafter(refs[0].upper[0], unit::kInfinity);
    refs[1].lower[0] = refs[1].upper[0] = random.Next() & 1 ? further : further * 1.5f;
    refs[0].lower[0] = refs[0].upper[0];
    const TriangleRange range = unit::RangeOf(refs, 0, refs.size());
    for (const uint32_t bins : {2u, 5u, 16u, 32u}) {
      const BinMap map(range.centers, bins);
      if (range.centers.upper[0] - range.centers.lower[0] < 1e-28f) continue;
      ASSERT_TRUE(map.IsUseful(0));
      const int32_t a = BinOf(map, refs[0], 0), b = BinOf(map, refs[1], 0);
      ASSERT_EQ(std::min(a, b), 0) << offset;
      ASSERT_EQ(std::max(a, b), static_cast<int32_t>(bins) - 1) << offset;
    }
  }
}

void AnAxisWithoutExtentIsNotUseful() {
  std::vector<TriangleRef> refs(3);
  for (TriangleRef& ref : refs) ref = {{1, 2, 3}, 0, {4, 5, 6}, 0};
  refs[1].upper[1] = 7;                   // centres differ in y
  refs[2].lower[2] = 3 * (1 - 0x1p-23f);  // and by one rounding in z
  Box tiny = Box::Empty();
  const float zero[3] = {0, 0, 0}, denormal[3] = {1e-45f, 1e-40f, 1e-30f};
  tiny.Extend(zero);
  tiny.Extend(denormal);
  const TriangleRange range = unit::RangeOf(refs, 0, refs.size());
  const BinMap map(range.centers, 16);
  EXPECT_FALSE(map.IsUseful(0));
  EXPECT_TRUE(map.IsUseful(1));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_FALSE(BinMap(tiny, 16).IsUseful(axis)) << "1 / extent overflows";
    for (const TriangleRef& ref : refs) EXPECT_GE(BinOf(BinMap(tiny, 16), ref, axis), 0);
  }
  for (const TriangleRef& ref : refs) EXPECT_EQ(BinOf(map, ref, 0), 0);
}

// Counts and bounds of the bins and of the candidates, against sums over all triangles; triangles
// outside the range do not count.
void BinsAndCandidatesMatchSums() {
  Random random(3);
  const auto scratch = std::make_unique<Scratch>();
  for (const uint32_t bins : {2u, 3u, 16u, 32u}) {
    for (const size_t count : {1u, 2u, 17u, 400u}) {
      const auto refs = RandomRefs(random, count + 7, 3);
      const TriangleRange range = unit::RangeOf(refs, 3, 3 + count);
      const BinMap map(range.centers, bins);
      BinTriangles(refs.data(), range, map, bins, *scratch);
      MakeCandidates(bins, *scratch);
      for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t k = 0; k < bins; ++k) {
          Box own = Box::Empty(), left = Box::Empty(), right = Box::Empty();
          size_t own_count = 0, left_count = 0, right_count = 0;
          for (size_t i = range.begin; i < range.end; ++i) {
            const int32_t bin = BinOf(map, refs[i], axis);
            const auto add = [&](Box& box, size_t& n) HWY_ATTR {
              box.Extend(refs[i].lower);
              box.Extend(refs[i].upper);
              ++n;
            };
            if (bin == static_cast<int32_t>(k)) add(own, own_count);
            if (bin <= static_cast<int32_t>(k)) {
              add(left, left_count);
            } else {
              add(right, right_count);
            }
          }
          const auto expect_box = [](const Box& actual, const Box& expected) HWY_ATTR {
            for (int a = 0; a < 3; ++a) {
              ASSERT_EQ(actual.lower[a], expected.lower[a]);
              ASSERT_EQ(actual.upper[a], expected.upper[a]);
            }
          };
          ASSERT_EQ(scratch->bins[axis][k].count, own_count);
          expect_box(scratch->bins[axis][k].bounds, own);
          if (k + 1 == bins) continue;
          const SplitCandidate& candidate = scratch->candidates[axis][k];
          ASSERT_EQ(candidate.left_count, left_count);
          ASSERT_EQ(candidate.right_count, right_count);
          expect_box(candidate.left_box, left);
          expect_box(candidate.right_box, right);
        }
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(BinningTest);
HWY_EXPORT_AND_TEST_P(BinningTest, BinsAreWalds);
HWY_EXPORT_AND_TEST_P(BinningTest, OuterCentersFallIntoOuterBins);
HWY_EXPORT_AND_TEST_P(BinningTest, AnAxisWithoutExtentIsNotUseful);
HWY_EXPORT_AND_TEST_P(BinningTest, BinsAndCandidatesMatchSums);

}  // namespace dacrt
#endif  // HWY_ONCE

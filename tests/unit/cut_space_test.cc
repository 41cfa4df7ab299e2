#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut_space_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "paper/cut_space-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

std::vector<TriangleRef> RandomRefs(Random& random, size_t count, float size) {
  std::vector<TriangleRef> refs(count);
  for (size_t i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      refs[i].lower[axis] = random.Uniform(-1, 1);
      refs[i].upper[axis] = refs[i].lower[axis] + random.Uniform(0, size);
    }
    refs[i].primitive = static_cast<uint32_t>(i);
    refs[i].geometry = 0;
  }
  return refs;
}

/// The triangles before the plane, on both sides and behind it, as the bins say.
enum class Side { kBefore, kBoth, kBehind };

Side SideOf(const TriangleRef& ref, const Cut& cut) {
  HWY_ALIGN int32_t first[4], last[4];
  cut.map.Map(Corner::Load(ref.lower), first);
  cut.map.Map(Corner::Load(ref.upper), last);
  if (last[cut.axis] <= cut.last_left_bin) return Side::kBefore;
  return first[cut.axis] > cut.last_left_bin ? Side::kBehind : Side::kBoth;
}

// The counts are those by which the recursion makes sure that the straddling triangles can be
// copied, so they must be what SortBySide then finds.
void SortsIntoThreeAndCountsThem() {
  Random random(1);
  const auto scratch = std::make_unique<Scratch>();
  size_t cuts = 0;
  for (int round = 0; round < 300; ++round) {
    const size_t count = 3 + random.Below(200), guards = 4;
    const auto before = RandomRefs(random, count + 2 * guards, random.Uniform(0.01f, 1));
    auto refs = before;
    const TriangleRange range = unit::RangeOf(refs, guards, guards + count);
    const auto cut = ChooseCut(refs.data(), range, 2 + random.Below(31), *scratch);
    if (!cut) continue;
    ++cuts;
    ASSERT_LT(cut->left_count, count);
    ASSERT_LT(cut->right_count, count);
    ASSERT_GE(cut->left_count + cut->right_count, count);
    const auto [left_end, right_begin] = SortBySide(refs.data(), range, *cut);
    ASSERT_EQ(right_begin - range.begin, cut->left_count);
    ASSERT_EQ(range.end - left_end, cut->right_count);
    std::vector<bool> seen(refs.size());
    for (size_t i = 0; i < refs.size(); ++i) {
      const uint32_t name = refs[i].primitive;
      ASSERT_FALSE(seen[name]);
      seen[name] = true;
      ASSERT_EQ(memcmp(&refs[i], &before[name], sizeof(TriangleRef)), 0);
      if (i < range.begin || i >= range.end) {
        ASSERT_EQ(name, i);
      } else {
        ASSERT_EQ(SideOf(refs[i], *cut), i < left_end      ? Side::kBefore
                                         : i < right_begin ? Side::kBoth
                                                           : Side::kBehind);
      }
    }
  }
  EXPECT_GT(cuts, 200u);
}

void ClipsToEitherSideAndLosesNothing() {
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    const auto before = RandomRefs(random, 50, 1);
    const int axis = static_cast<int>(random.Below(3));
    const float plane = random.Uniform(-1, 1);
    auto left = before, right = before;
    ClipTriangles(left, axis, plane, true);
    ClipTriangles(right, axis, plane, false);
    for (size_t i = 0; i < before.size(); ++i) {
      if (before[i].lower[axis] > plane || before[i].upper[axis] < plane) continue;
      for (int other = 0; other < 3; ++other) {
        ASSERT_EQ(left[i].lower[other], before[i].lower[other]);
        ASSERT_EQ(right[i].upper[other], before[i].upper[other]);
        ASSERT_EQ(left[i].upper[other], other == axis ? plane : before[i].upper[other]);
        ASSERT_EQ(right[i].lower[other], other == axis ? plane : before[i].lower[other]);
      }
    }
  }
}

// Rounding can put the plane beside a triangle that straddles it by the bins' word. Clipped naively
// its box is inside out: it would then end in an earlier bin than it begins, the counts of the next
// cut would be too small, and more references would be copied than there is room for.
void ABoxIsNeverClippedInsideOut() {
  Random random(3);
  for (int round = 0; round < 1000; ++round) {
    std::vector<TriangleRef> refs = RandomRefs(random, 1, random.Next() & 1 ? 0.0f : 1.0f);
    const TriangleRef before = refs[0];
    const float beside =
        random.Next() & 1 ? std::nextafter(before.lower[0], -9.0f) : before.upper[0] + 1e-6f;
    for (const bool left : {true, false}) {
      refs[0] = before;
      ClipTriangles(refs, 0, beside, left);
      ASSERT_LE(refs[0].lower[0], refs[0].upper[0]);
      ASSERT_GE(refs[0].lower[0], before.lower[0]);
      ASSERT_LE(refs[0].upper[0], before.upper[0]);
    }
  }
}

// Cut after cut, as the recursion does it, the counts stay those of SortBySide.
void CountsHoldForClippedTriangles() {
  Random random(4);
  const auto scratch = std::make_unique<Scratch>();
  for (int round = 0; round < 3000; ++round) {
    auto refs = RandomRefs(random, 40, 1);
    for (int depth = 0; depth < 8 && refs.size() > 2; ++depth) {
      const TriangleRange range = unit::RangeOf(refs, 0, refs.size());
      const auto cut = ChooseCut(refs.data(), range, 32, *scratch);
      if (!cut) break;
      const auto [left_end, right_begin] = SortBySide(refs.data(), range, *cut);
      ASSERT_EQ(right_begin, cut->left_count) << "round " << round << " depth " << depth;
      ASSERT_EQ(range.end - left_end, cut->right_count) << "round " << round << " depth " << depth;
      const bool left = random.Next() & 1;
      ClipTriangles({refs.data() + left_end, right_begin - left_end}, cut->axis, cut->plane, left);
      const auto begin = refs.begin();
      refs = left ? std::vector<TriangleRef>(begin, begin + static_cast<ptrdiff_t>(right_begin))
                  : std::vector<TriangleRef>(begin + static_cast<ptrdiff_t>(left_end), refs.end());
    }
  }
}

// A cut that leaves as much to test as there was is none: the recursion would not end.
void NoCutWhereNoneHelps() {
  const auto scratch = std::make_unique<Scratch>();
  std::vector<TriangleRef> same(20, {{-1, -1, -1}, 0, {1, 1, 1}, 0});
  EXPECT_FALSE(ChooseCut(same.data(), unit::RangeOf(same, 0, 20), 16, *scratch).has_value());
  std::vector<TriangleRef> points(20, {{1, 2, 3}, 0, {1, 2, 3}, 0});
  EXPECT_FALSE(ChooseCut(points.data(), unit::RangeOf(points, 0, 20), 16, *scratch).has_value());
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(CutSpaceTest);
HWY_EXPORT_AND_TEST_P(CutSpaceTest, SortsIntoThreeAndCountsThem);
HWY_EXPORT_AND_TEST_P(CutSpaceTest, ClipsToEitherSideAndLosesNothing);
HWY_EXPORT_AND_TEST_P(CutSpaceTest, ABoxIsNeverClippedInsideOut);
HWY_EXPORT_AND_TEST_P(CutSpaceTest, CountsHoldForClippedTriangles);
HWY_EXPORT_AND_TEST_P(CutSpaceTest, NoCutWhereNoneHelps);

}  // namespace dacrt
#endif  // HWY_ONCE

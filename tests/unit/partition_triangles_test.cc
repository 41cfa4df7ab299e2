#include <gtest/gtest.h>

#include <memory>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "partition_triangles_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/triangle_refs.h"
#include "paper/choose_split-inl.h"
#include "partition/partition_triangles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

constexpr size_t kGuards = 5;

std::vector<TriangleRef> RandomRefs(Random& random, size_t count) {
  std::vector<TriangleRef> refs(count);
  for (size_t i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      refs[i].lower[axis] = random.Uniform(-3, 3);
      refs[i].upper[axis] = refs[i].lower[axis] + random.Uniform(0, 1);
    }
    refs[i].primitive = static_cast<uint32_t>(i);
    refs[i].geometry = static_cast<uint32_t>(random.Below(3));
  }
  return refs;
}

bool SameRef(const TriangleRef& a, const TriangleRef& b) { return memcmp(&a, &b, sizeof(a)) == 0; }

void ExpectSameBox(const Box& actual, const Box& expected) {
  for (int axis = 0; axis < 3; ++axis) {
    ASSERT_EQ(actual.lower[axis], expected.lower[axis]);
    ASSERT_EQ(actual.upper[axis], expected.upper[axis]);
  }
}

void ExpectMeasured(const std::vector<TriangleRef>& refs, const TriangleRange& range) {
  const TriangleRange expected = unit::RangeOf(refs, range.begin, range.end);
  ExpectSameBox(range.bounds, expected.bounds);
  ExpectSameBox(range.centers, expected.centers);
}

void MovesEachToItsSideAndNothingElse() {
  Random random(1);
  const auto scratch = std::make_unique<Scratch>();
  for (int round = 0; round < 400; ++round) {
    const size_t count = 2 + random.Below(round < 200 ? 8 : 300);
    const auto before = RandomRefs(random, count + 2 * kGuards);
    auto refs = before;
    const TriangleRange range = unit::RangeOf(refs, kGuards, kGuards + count);
    const uint32_t bins = 2 + random.Below(31);
    StepClock clock;
    const auto split = ChooseSplit(refs.data(), range, bins, false, *scratch, clock);
    ASSERT_TRUE(split.has_value());
    const Children children = PartitionTriangles(refs.data(), range, *split);

    ASSERT_EQ(children.left.begin, range.begin);
    ASSERT_EQ(children.left.end, children.right.begin);
    ASSERT_EQ(children.right.end, range.end);
    ASSERT_EQ(children.left.count(), split->left_count);
    ExpectMeasured(refs, children.left);
    ExpectMeasured(refs, children.right);

    // A permutation: each name once, with the bounds that it had; those around untouched.
    std::vector<bool> seen(refs.size());
    for (size_t i = 0; i < refs.size(); ++i) {
      const uint32_t name = refs[i].primitive;
      ASSERT_LT(name, seen.size());
      ASSERT_FALSE(seen[name]);
      seen[name] = true;
      ASSERT_TRUE(SameRef(refs[i], before[name]));
      const bool inside = i >= range.begin && i < range.end;
      ASSERT_TRUE(inside || name == i);
    }
    // By bin, left before right.
    for (size_t i = range.begin; i < range.end; ++i) {
      HWY_ALIGN int32_t bin[4];
      split->map.Map(TwiceCenter(Corner::Load(refs[i].lower), Corner::Load(refs[i].upper)), bin);
      ASSERT_EQ(bin[split->axis] <= static_cast<int32_t>(split->last_left_bin),
                i < children.left.end);
    }
  }
}

void MeasuresBoundsOfBoxesAndCenters() {
  Random random(3);
  const auto refs = RandomRefs(random, 50);
  for (size_t begin = 0; begin < 5; ++begin) {
    for (size_t end = begin; end <= refs.size(); end += 9) {
      const TriangleRange range = MeasureTriangles(refs.data(), begin, end);
      ASSERT_EQ(range.begin, begin);
      ASSERT_EQ(range.end, end);
      ExpectMeasured(refs, range);
    }
  }
}

void HalvesByCountAndMovesNothing() {
  Random random(2);
  for (size_t count = 2; count < 40; ++count) {
    const auto before = RandomRefs(random, count + 2 * kGuards);
    auto refs = before;
    const TriangleRange range = unit::RangeOf(refs, kGuards, kGuards + count);
    const Children children = HalveTriangles(refs.data(), range);
    EXPECT_EQ(children.left.begin, range.begin);
    EXPECT_EQ(children.left.count(), count / 2);
    EXPECT_EQ(children.right.begin, children.left.end);
    EXPECT_EQ(children.right.end, range.end);
    ExpectMeasured(refs, children.left);
    ExpectMeasured(refs, children.right);
    for (size_t i = 0; i < refs.size(); ++i) ASSERT_TRUE(SameRef(refs[i], before[i]));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(PartitionTrianglesTest);
HWY_EXPORT_AND_TEST_P(PartitionTrianglesTest, MovesEachToItsSideAndNothingElse);
HWY_EXPORT_AND_TEST_P(PartitionTrianglesTest, MeasuresBoundsOfBoxesAndCenters);
HWY_EXPORT_AND_TEST_P(PartitionTrianglesTest, HalvesByCountAndMovesNothing);

}  // namespace dacrt
#endif  // HWY_ONCE

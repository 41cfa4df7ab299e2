#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pack_along_curve_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "partition/pack_along_curve-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

constexpr size_t kMost = WideNode::kWidth;

/// Boxes along a path, some of them large.
std::vector<TriangleRef> MakeRow(Random& random, size_t count) {
  std::vector<TriangleRef> row(count);
  float at[3] = {};
  for (TriangleRef& box : row) {
    const float size = random.Next() % 8 == 0 ? 2.0f : 0.2f;
    for (int axis = 0; axis < 3; ++axis) {
      at[axis] += random.Uniform(-0.3f, 0.3f);
      box.lower[axis] = at[axis];
      box.upper[axis] = at[axis] + random.Uniform(0, size);
    }
    box.primitive = box.geometry = 0;
  }
  return row;
}

double CostOf(std::span<const TriangleRef> group, double each) {
  double edge[3];
  for (int axis = 0; axis < 3; ++axis) {
    float lower = group[0].lower[axis], upper = group[0].upper[axis];
    for (const TriangleRef& box : group) {
      lower = std::min(lower, box.lower[axis]);
      upper = std::max(upper, box.upper[axis]);
    }
    edge[axis] = double{upper} - lower;
  }
  return edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0] + each;
}

/// What the best cut costs, of groups that are not too small or too heavy.
double LeastCost(std::span<const TriangleRef> row, std::span<const size_t> weights, size_t fewest,
                 double each) {
  std::vector<double> least(row.size() + 1, std::numeric_limits<double>::infinity());
  least[0] = 0;
  for (size_t end = 1; end <= row.size(); ++end) {
    size_t weight = 0;
    for (size_t size = 1; size <= std::min(kMost, end); ++size) {
      weight += weights[end - size];
      if (size < fewest || (size > 1 && weight > kMost)) continue;
      const double cost = CostOf(row.subspan(end - size, size), each);
      least[end] = std::min(least[end], least[end - size] + cost);
    }
  }
  return least[row.size()];
}

/// Cuts a row, and compares it with the best cut.
template <bool kHasWeights>
void ExpectBest(std::span<const TriangleRef> row, std::span<const size_t> weights, size_t fewest,
                float each) {
  RowCut<kHasWeights> cut(fewest, 1, each);
  std::vector<size_t> sizes;
  for (size_t i = 0; i < row.size(); ++i) sizes.push_back(cut.Add(row[i], weights[i]));
  double cost = 0;
  for (size_t end = row.size(); end > 0; end -= sizes[end - 1]) {
    const size_t size = sizes[end - 1];
    ASSERT_GE(size, fewest);
    ASSERT_LE(size, std::min(kMost, end));
    size_t weight = 0;
    for (size_t i = end - size; i < end; ++i) weight += weights[i];
    if (kHasWeights && size > 1) {
      ASSERT_LE(weight, kMost);
    }
    cost += CostOf(row.subspan(end - size, size), each);
  }
  const double least = LeastCost(row, weights, fewest, each);
  EXPECT_NEAR(cost, least, 1e-5 * least) << row.size() << " boxes";
}

void TheCutIsTheBest() {
  Random random(81);
  for (size_t count = 4; count < 60; ++count) {
    const std::vector<TriangleRef> row = MakeRow(random, count);
    const std::vector<size_t> ones(count, 1);
    for (const float each : {0.0f, 0.05f, 1.0f}) {
      ExpectBest<false>(row, ones, 1, each);
      ExpectBest<false>(row, ones, 4, each);
    }
  }
}

void NoGroupIsTooHeavy() {
  Random random(82);
  for (size_t count = 1; count < 60; ++count) {
    const std::vector<TriangleRef> row = MakeRow(random, count);
    std::vector<size_t> weights(count);
    for (size_t& weight : weights) weight = random.Next() % 16 == 0 ? 9 : 1 + random.Next() % 4;
    for (const float each : {0.0f, 0.05f, 1.0f}) ExpectBest<true>(row, weights, 1, each);
  }
}

/// Of equal cuts the one of fewest groups.
void BoxesWithoutSurfaceFillTheirGroups() {
  const std::vector<TriangleRef> row(21);
  RowCut<false> cut(1, 1, 0);
  std::vector<size_t> sizes;
  for (const TriangleRef& box : row) sizes.push_back(cut.Add(box, 1));
  for (size_t i = 0; i < row.size(); ++i) EXPECT_EQ(sizes[i], std::min(kMost, i + 1));
}

/// Also where the surfaces of a few are beyond all numbers together.
void SurfacesOfAnySizeAreCutAlike() {
  constexpr size_t kCount = 1000;
  const auto scratch = std::make_unique<SubsetScratch>();
  const auto ends_of = [&](float size) {
    Random random(84);
    const std::vector<TriangleRef> row = MakeRow(random, kCount);
    for (size_t i = 0; i < kCount; ++i) {
      TriangleRef& box = scratch->refs[i];
      box = row[i];
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] *= size;
        box.upper[axis] *= size;
      }
    }
    const TriangleRange range = MeasureTriangles(scratch->refs, 0, kCount);
    std::vector<uint32_t> ends(PackLeaves(Triangles(), range, *scratch));
    for (size_t i = 0; i < ends.size(); ++i) ends[i] = scratch->packed[i].end;
    return ends;
  };
  const std::vector<uint32_t> ends = ends_of(1);
  EXPECT_EQ(ends.back(), kCount);
  EXPECT_GT(ends.size(), kCount / kMost + 2) << "not all are full";
  EXPECT_EQ(ends_of(0x1p57f), ends);
  EXPECT_EQ(ends_of(0x1p-50f), ends);
  // Vertices may have been changed since they were looked at: then nothing is told apart.
  EXPECT_EQ(ends_of(0x1p100f).back(), kCount);
}

/// Leaves as they are found, in the order of the nodes.
struct FoundLeaves {
  ChildWord Child(uint32_t begin, uint32_t end) {
    ranges.push_back({begin, end});
    return ChildWord::Range(static_cast<uint32_t>(ranges.size() - 1));
  }
  struct Range {
    uint32_t begin, end;
  };
  std::vector<Range> ranges;
};

/// Leaves come in the order of their triangles.
void Walk(const ExactNode* nodes, size_t count, uint32_t number, const FoundLeaves& leaves,
          std::vector<bool>& seen, uint32_t& next) {
  ASSERT_LT(number, count);
  ASSERT_FALSE(seen[number]);
  seen[number] = true;
  const WideNode& node = nodes[number];
  ASSERT_GE(node.count, 1u);
  EXPECT_EQ(node.BareLeaves(UINT8_MAX) != 0, node.Child(0).IsLeaf()) << "rows do not mix";
  for (size_t k = 0; k < node.count; ++k) {
    const ChildWord child = node.Child(k);
    if (child.IsInner()) {
      const uint32_t inner = child.number() / WideNode::kExactSlots;
      ASSERT_GT(inner, number);
      Walk(nodes, count, inner, leaves, seen, next);
      continue;
    }
    const FoundLeaves::Range& leaf = leaves.ranges[child.range()];
    ASSERT_EQ(leaf.begin, next);
    ASSERT_LE(leaf.end - leaf.begin, kMost);
    next = leaf.end;
  }
}

void NodesHoldEachLeafOnce() {
  Random random(83);
  const auto scratch = std::make_unique<SubsetScratch>();
  for (const size_t count : {1u, 2u, 8u, 9u, 10u, 63u, 65u, 600u, 2047u, 2048u}) {
    for (const bool is_point : {false, true}) {
      const auto row = is_point ? std::vector<TriangleRef>(count) : MakeRow(random, count);
      std::copy(row.begin(), row.end(), scratch->refs);
      FoundLeaves leaves;
      const TriangleRange range = MeasureTriangles(scratch->refs, 0, count);
      const size_t leaf_count = PackLeaves(Triangles(), range, *scratch);
      const size_t nodes = PackNodes(range.bounds, leaf_count, leaves, *scratch);
      std::vector<bool> seen(nodes);
      uint32_t next = 0;
      Walk(scratch->nodes, nodes, 0, leaves, seen, next);
      EXPECT_EQ(next, count);
      EXPECT_EQ(std::count(seen.begin(), seen.end(), true), static_cast<ptrdiff_t>(nodes));
      if (is_point) {
        EXPECT_LE(leaves.ranges.size(), count / kMost + 2) << "two halves, each filled";
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

HWY_BEFORE_TEST(PackAlongCurveTest);
HWY_EXPORT_AND_TEST_P(PackAlongCurveTest, TheCutIsTheBest);
HWY_EXPORT_AND_TEST_P(PackAlongCurveTest, NoGroupIsTooHeavy);
HWY_EXPORT_AND_TEST_P(PackAlongCurveTest, BoxesWithoutSurfaceFillTheirGroups);
HWY_EXPORT_AND_TEST_P(PackAlongCurveTest, SurfacesOfAnySizeAreCutAlike);
HWY_EXPORT_AND_TEST_P(PackAlongCurveTest, NodesHoldEachLeafOnce);

}  // namespace dacrt
#endif  // HWY_ONCE

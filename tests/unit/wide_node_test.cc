#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "wide_node_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/wide_node-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Float3;
using unit::Random;

/// Boxes of up to eight children, and the box around them.
struct Family {
  std::vector<Box> boxes;
  Box bounds = Box::Empty();

  void Add(const Float3& a, const Float3& b) {
    Box box = Box::Empty();
    box.Extend(a.data());
    box.Extend(b.data());
    bounds.Extend(box.lower);
    bounds.Extend(box.upper);
    boxes.push_back(box);
  }

  WideNode Encode() const {
    const Box* children[WideNode::kWidth];
    for (size_t i = 0; i < boxes.size(); ++i) children[i] = &boxes[i];
    WideNode node{};
    EncodeChildren(bounds, children, boxes.size(), node);
    return node;
  }
};

/// The widening of a face, as that of a triangle's box.
float WideFace(float face, bool is_upper) {
  HWY_ALIGN float lanes[kMaxLanes];
  const V v = hn::Set(kFloat, face);
  hn::Store(is_upper ? WidenUp(v) : WidenDown(v), kFloat, lanes);
  return lanes[0];
}

/// Children hold their boxes, widened, and are not much larger.
void ExpectHeld(const Family& family, const std::string& what) {
  const WideNode node = family.Encode();
  ASSERT_EQ(node.count, family.boxes.size());
  ChildBoxes decoded;
  DecodeChildren(node, decoded);
  for (int axis = 0; axis < 3; ++axis) {
    const double from = family.bounds.lower[axis], to = family.bounds.upper[axis];
    // A step is a 255th of the extent, rounded up to eight bits of mantissa or moved on by a few of
    // those until it spans the extent. A face is off by one step, and by one more where the guess
    // was rounded. Far from the origin the rounding of a face counts, and what boxes are widened
    // by.
    const double largest = std::max(std::abs(from), std::abs(to));
    const double step = (to - from) / 255 * (1 + 3.0 / 128);
    const double slack = 2 * step + largest * 0x1p-20 + 1e-19;
    for (size_t i = 0; i < family.boxes.size(); ++i) {
      const Box& box = family.boxes[i];
      const float lower = decoded.lower[axis][i], upper = decoded.upper[axis][i];
      // No later and no earlier than the box that the direct solve looks at.
      ASSERT_LE(lower, WideFace(box.lower[axis], false)) << what << " child " << i;
      ASSERT_GE(upper, WideFace(box.upper[axis], true)) << what << " child " << i;
      ASSERT_GE(lower, box.lower[axis] - slack) << what << " child " << i << " of " << to - from;
      ASSERT_LE(upper, box.upper[axis] + slack) << what << " child " << i << " of " << to - from;
    }
  }
}

// Boxes of every size and place, also without extent on an axis or on all.
void HoldsItsChildrenTightly() {
  Random random(1);
  for (int round = 0; round < 30000; ++round) {
    const float size = std::abs(random.AnyMagnitude(1e-12f, 1e18f));
    const float place = random.Below(3) == 0 ? 0 : std::min(size * 1e5f, 0.8e18f);
    Family family;
    const Float3 center = random.InCube(-place, place);
    for (size_t count = 1 + random.Below(8); count > 0; --count) {
      Float3 a = random.InCube(-size, size);
      Float3 b = random.Below(2) == 0 ? random.InCube(-size, size) : a;
      for (size_t axis = 0; axis < 3; ++axis) {
        if (random.Below(2) == 0) b[axis] = a[axis] + size * random.Uniform(0, 0.01f);
        a[axis] = std::clamp(a[axis] + center[axis], -1.8e18f, 1.8e18f);
        b[axis] = std::clamp(b[axis] + center[axis], -1.8e18f, 1.8e18f);
      }
      if (random.Below(4) == 0) b = a;
      family.Add(a, b);
    }
    ExpectHeld(family, "round " + std::to_string(round));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Faces that are whole steps of every mantissa that a step can have, and next to them: where the
// guess of a step may be rounded to the wrong side.
void FacesOnSteps() {
  for (const float scale : {1.0f, 0x1p-60f, 0x1p52f, 0x1p-100f}) {
    for (int mantissa = 128; mantissa < 256; ++mantissa) {
      const float step = scale * static_cast<float>(mantissa);
      for (int begin = 1; begin < 255; begin += 3) {
        for (const float from : {0.0f, -100 * step}) {
          Family family;
          const float to = from + 255 * step, on = from + static_cast<float>(begin) * step;
          family.Add({from, from, from}, {from, from, from});
          family.Add({to, to, to}, {to, to, to});
          const float above = std::nextafter(on, to), below = std::nextafter(on, from);
          family.Add({on, above, below}, {on, above, below});
          ExpectHeld(family, std::to_string(begin) + " steps");
          if (testing::Test::HasFatalFailure()) return;
        }
      }
    }
  }
}

// The extent of the whole is rounded down to 255 steps that do not quite span it.
void StepsSpanTheWhole() {
  for (const float step : {1.0f, 0x1p-60f, 0x1p52f}) {
    for (int below = 100; below < 255; ++below) {
      const float from = -static_cast<float>(below) * step;
      const float to = std::nextafter(static_cast<float>(255 - below) * step, 1e30f);
      Family family;
      family.Add({from, from, from}, {from, from, from});
      family.Add({to, to, to}, {to, to, to});
      ExpectHeld(family, std::to_string(below) + " steps below 0");
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

void ScenesOfEveryShape() {
  const auto expect = [](const Family& family, const std::string& what) {
    ExpectHeld(family, what);
  };
  {
    Family family;
    family.Add({-1.8e18f, -1.8e18f, -1.8e18f}, {1.8e18f, 1.8e18f, 1.8e18f});
    family.Add({-1e-38f, -1e-38f, -1e-38f}, {1e-38f, 1e-38f, 1e-38f});
    family.Add({1.8e18f, -1.8e18f, 0}, {1.8e18f, -1.8e18f, 0});
    expect(family, "all");
  }
  for (const float x : {0.0f, -0.0f, 1.0f, -1.0f, 1.8e18f, -1.8e18f, 1e-40f, -3e-39f}) {
    Family point;
    for (int i = 0; i < 8; ++i) point.Add({x, x, x}, {x, x, x});
    expect(point, "a point");
    const float next = std::nextafter(x, 2e18f);
    Family near;
    for (int i = 0; i < 8; ++i) near.Add({x, x, next}, {i % 2 ? x : next, x, next});
    expect(near, "neighbours");
  }
  Family flat;
  for (int i = 0; i < 8; ++i) {
    const float s = static_cast<float>(i);
    flat.Add({s, 7, -s}, {s + 1, 7, -s - 1});
  }
  expect(flat, "flat");
}

// What no child stands for is entered by no ray.
void UnusedChildrenAreEmpty() {
  Random random(2);
  for (size_t count = 1; count < WideNode::kWidth; ++count) {
    Family family;
    for (size_t i = 0; i < count; ++i) family.Add(random.InCube(-1, 1), random.InCube(-1, 1));
    ChildBoxes decoded;
    DecodeChildren(family.Encode(), decoded);
    for (size_t i = count; i < WideNode::kWidth; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GT(decoded.lower[axis][i], decoded.upper[axis][i]);
      }
    }
  }
}

void UnionsHoldTheirChildren() {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    Family family;
    for (int i = 0; i < 8; ++i) family.Add(random.InCube(-1, 1), random.InCube(-1, 1));
    ChildBoxes decoded;
    DecodeChildren(family.Encode(), decoded);
    for (size_t begin = 0; begin < 8; ++begin) {
      for (size_t end = begin + 1; end <= 8; ++end) {
        const WideBox box = UnionOfChildren(decoded, begin, end);
        for (int axis = 0; axis < 3; ++axis) {
          const float* lower = decoded.lower[axis];
          const float* upper = decoded.upper[axis];
          ASSERT_EQ(hn::GetLane(box.lower[axis]), *std::min_element(lower + begin, lower + end));
          ASSERT_EQ(hn::GetLane(box.upper[axis]), *std::max_element(upper + begin, upper + end));
        }
      }
    }
  }
}

void UpperHalvesAreRoundedUp() {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const float value = std::abs(random.AnyMagnitude(1e-37f, 1e30f));
    const uint16_t half = UpperHalfNotBelow(value);
    ASSERT_GE(FromUpperHalf(half), value);
    ASSERT_LT(FromUpperHalf(static_cast<uint16_t>(half - 1)), value);
  }
  EXPECT_EQ(UpperHalfNotBelow(0.0f), 0);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(WideNodeTest);
HWY_EXPORT_AND_TEST_P(WideNodeTest, HoldsItsChildrenTightly);
HWY_EXPORT_AND_TEST_P(WideNodeTest, FacesOnSteps);
HWY_EXPORT_AND_TEST_P(WideNodeTest, StepsSpanTheWhole);
HWY_EXPORT_AND_TEST_P(WideNodeTest, ScenesOfEveryShape);
HWY_EXPORT_AND_TEST_P(WideNodeTest, UnusedChildrenAreEmpty);
HWY_EXPORT_AND_TEST_P(WideNodeTest, UnionsHoldTheirChildren);
HWY_EXPORT_AND_TEST_P(WideNodeTest, UpperHalvesAreRoundedUp);

// What stands in a child's place, and its number, come back as they were written.
TEST(WideNodeChildTest, KindsAndNumbersComeBack) {
  WideNode node{};
  node.first_node = 1000000;
  node.first_other = 4000000000u;
  for (std::size_t kind = 1; kind <= WideNode::kInner; ++kind) {
    for (const std::size_t offset : {0u, 1u, 7u, 2047u, 4095u}) {
      const std::size_t place = (kind + offset) % WideNode::kWidth;
      node.child[place] = WideNode::Child(kind, offset);
      EXPECT_EQ(node.Kind(place), kind);
      EXPECT_EQ(node.IsLeaf(place), kind <= WideNode::kMostLeafTriangles);
      EXPECT_EQ(node.IsSubset(place), kind == WideNode::kSubset);
      EXPECT_EQ(node.Number(place),
                (kind == WideNode::kInner ? node.first_node : node.first_other) + offset);
    }
  }
}

TEST(WideNodeChildTest, GapRanksComeBack) {
  WideNode node{};
  const uint32_t ranks[] = {6, 0, 3, 5, 1, 4, 2};
  for (std::size_t i = 0; i < 7; ++i) node.gaps |= ranks[i] << (3 * i);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(node.GapRank(i), ranks[i]);
}

}  // namespace dacrt
#endif  // HWY_ONCE

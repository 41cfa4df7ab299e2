#include <gtest/gtest.h>

#include <bit>
#include <string>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "wide_node_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/wide_node-inl.h"
#include "rays/load_records-inl.h"
#include "trace/enter_children-inl.h"

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

  /// A node that is exact or not, with room for both.
  ExactNode Encode(bool is_exact) const {
    const Box* children[WideNode::kWidth];
    for (size_t i = 0; i < boxes.size(); ++i) children[i] = &boxes[i];
    ExactNode node{};
    node.is_exact = is_exact;
    EncodeChildren(children, boxes.size(), node);
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

/// The volumes of all eight children.
struct Volumes {
  HWY_ALIGN float lower[3][WideNode::kWidth];
  HWY_ALIGN float upper[3][WideNode::kWidth];
};

/// As rays of an octant see them: near planes are lower ones where directions are positive.
Volumes Decode(const WideNode& node, uint32_t octant) {
  const ChildPlanes planes(node, PlaneOffsets(octant));
  Volumes volumes;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const bool is_negative = octant >> axis & 1;
    for (size_t part = 0; part < kParts; ++part) {
      const EightPart near = planes.near[part][axis], far = planes.far[part][axis];
      hn::Store(is_negative ? far : near, kEightTag, volumes.lower[axis] + part * kPartLanes);
      hn::Store(is_negative ? near : far, kEightTag, volumes.upper[axis] + part * kPartLanes);
    }
  }
  return volumes;
}

/// An exact node has the boxes themselves, widened, and becomes one that is not as if that had been
/// made of them.
void ExpectExact(const Family& family, const WideNode& other, const std::string& what) {
  const ExactNode node = family.Encode(true);
  ASSERT_EQ(node.slots(), 2u);
  ASSERT_EQ(node.count, family.boxes.size());
  for (uint32_t octant = 0; octant < 8; ++octant) {
    const Volumes decoded = Decode(node, octant);
    for (size_t i = 0; i < family.boxes.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        const Box& box = family.boxes[i];
        ASSERT_EQ(decoded.lower[axis][i], WideFace(box.lower[axis], false)) << what << " " << i;
        ASSERT_EQ(decoded.upper[axis][i], WideFace(box.upper[axis], true)) << what << " " << i;
      }
    }
  }
  WideNode compressed{};
  ChildFaces().Encode(node, compressed);
  ASSERT_EQ(memcmp(&compressed, &other, sizeof(compressed)), 0) << what;
}

/// Children hold their boxes, widened, and are not much larger, whatever the octant.
void ExpectHeld(const Family& family, const std::string& what) {
  const ExactNode node = family.Encode(false);
  ASSERT_EQ(node.slots(), 1u);
  ExpectExact(family, node, what);
  ASSERT_EQ(node.count, family.boxes.size());
  const Volumes decoded = Decode(node, 0);
  for (uint32_t octant = 1; octant < 8; ++octant) {
    const Volumes other = Decode(node, octant);
    ASSERT_EQ(memcmp(other.lower, decoded.lower, sizeof(other.lower)), 0) << what << " " << octant;
    ASSERT_EQ(memcmp(other.upper, decoded.upper, sizeof(other.upper)), 0) << what << " " << octant;
  }
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

// Wherever among its siblings an empty box stands, they are held as ever; alone it is a point.
void EmptyBoxesBecomePoints() {
  Random random(6);
  for (uint32_t round = 2; round < 512; ++round) {
    const uint32_t empty = round / 2;
    Family family;
    ChildBoxes boxes;
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      const bool is_empty = empty >> i & 1;
      if (!is_empty) family.Add(random.InCube(-1, 1), random.InCube(-1, 1));
      boxes.Set(i, is_empty ? Box::Empty() : family.boxes.back());
    }
    ExactNode node{};
    node.is_exact = round % 2 != 0;
    boxes.FillEmpty(WideNode::kWidth);
    boxes.Encode(WideNode::kWidth, node);
    const Volumes decoded = Decode(node, 0);
    size_t next = 0;
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      const bool is_empty = empty >> i & 1;
      const Box* const box = is_empty ? nullptr : &family.boxes[next++];
      for (int axis = 0; axis < 3; ++axis) {
        const float lower = decoded.lower[axis][i], upper = decoded.upper[axis][i];
        if (box) {
          ASSERT_LE(lower, WideFace(box->lower[axis], false)) << empty << " child " << i;
          ASSERT_GE(upper, WideFace(box->upper[axis], true)) << empty << " child " << i;
        }
        ASSERT_LE(upper - lower, 2.1f) << empty << " child " << i;
      }
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

/// The children that a ray enters, and where.
struct Entered {
  uint32_t children;
  HWY_ALIGN float entries[WideNode::kWidth];
};

template <class Enter>
Entered EnteredOf(const WideNode& node, const Enter& enter) {
  Entered entered;
  const auto store = [&](size_t part, EightPart entry) HWY_ATTR {
    hn::Store(entry, kEightTag, entered.entries + part * kPartLanes);
  };
  entered.children = enter(store) & node.UsedChildren();
  return entered;
}

/// Expects that a ray enters the children whose boxes, as the triangle test sees them, it meets,
/// and none of them later. Returns how many these are.
size_t ExpectEntered(const Family& family, const RayRecord& ray, const Entered& entered,
                     const std::string& what) {
  size_t count = 0;
  for (size_t i = 0; i < family.boxes.size(); ++i) {
    // The test of the box alone, which no volume around it may be stricter than.
    V origin[3], reciprocal[3];
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = hn::Set(kFloat, ray.org[axis]);
      reciprocal[axis] = hn::Set(kFloat, ray.reciprocal[axis]);
    }
    const Interval own =
        IntersectBox(Widen(family.boxes[i].lower, family.boxes[i].upper), origin, reciprocal);
    if (!(Bits(Enters(own, hn::Set(kFloat, ray.tnear), hn::Set(kFloat, ray.tfar))) & 1)) continue;
    ++count;
    EXPECT_TRUE(entered.children >> i & 1) << what << " child " << i;
    EXPECT_LE(entered.entries[i], std::max(hn::GetLane(own.entry), ray.start)) << what;
  }
  return count;
}

// A child is entered by rays that meet its box, in every octant, of every size and place; what no
// child stands for is not, once masked. By rays in lists and by those that go their own way.
void RaysEnterTheChildrenTheyMeet() {
  Random random(2);
  size_t entered_all = 0, not_entered = 0;
  for (int round = 0; round < 40000; ++round) {
    const size_t count = 1 + random.Below(8);
    const float size = std::abs(random.AnyMagnitude(1e-6f, 1e6f));
    const float place =
        random.Below(2) == 0 ? 0 : size * std::abs(random.AnyMagnitude(1e-2f, 1e5f));
    const float distance = size * std::abs(random.AnyMagnitude(1e-3f, 1e5f));
    const Float3 center = random.InCube(-place, place);
    Family family;
    for (size_t i = 0; i < count; ++i) {
      Float3 a = random.InCube(-size, size);
      Float3 b = random.InCube(-size, size);
      for (size_t axis = 0; axis < 3; ++axis) {
        if (random.Below(6) == 0) b[axis] = 0;
        a[axis] += center[axis];
        b[axis] += a[axis];
      }
      family.Add(a, b);
    }
    const ExactNode node = family.Encode(round % 2 != 0);
    ASSERT_EQ(node.UsedChildren(), (1u << count) - 1);
    RayRecord ray{};
    // At one of the children, more or less, often at a face of it, and from a face of another.
    const auto point_of = [&](const Box& box) {
      Float3 point;
      for (size_t axis = 0; axis < 3; ++axis) {
        const uint32_t face = random.Below(6);
        point[axis] = face == 0   ? box.lower[axis]
                      : face == 1 ? box.upper[axis]
                                  : random.Uniform(box.lower[axis], box.upper[axis]);
      }
      return point;
    };
    const Float3 aim = point_of(family.boxes[random.Below(static_cast<uint32_t>(count))]);
    Float3 org = point_of(family.boxes[random.Below(static_cast<uint32_t>(count))]);
    const Float3 off = random.InCube(-distance, distance);
    for (size_t axis = 0; axis < 3; ++axis) {
      if (random.Below(2) == 0) org[axis] += off[axis];
      ray.org[axis] = org[axis];
      ray.dir[axis] =
          random.Below(8) == 0 ? (random.Next() & 1 ? 0.0f : -0.0f) : aim[axis] - org[axis];
    }
    ray.tnear = random.Uniform(-1, 1);
    ray.tfar = random.Below(2) == 0 ? 1 : random.Uniform(1, 5);
    ray.mask = 1;
    if (!FinishRecord(ray)) continue;
    const PlaneOffsets offsets(ray.Octant());
    const SlabRay slab_ray(ray);
    const Entered in_list = EnteredOf(node, [&](const auto& store) HWY_ATTR {
      return EnterChildren(ChildPlanes(node, offsets), slab_ray, ray.tfar, store);
    });
    const Entered alone = EnteredOf(node, [&](const auto& store) HWY_ATTR {
      return LoneSlabRay(slab_ray).Enter(node, offsets, ray.tfar, store);
    });
    const std::string what = "round " + std::to_string(round);
    entered_all += ExpectEntered(family, ray, in_list, what + ", in a list");
    ExpectEntered(family, ray, alone, what + ", alone");
    ASSERT_FALSE(testing::Test::HasFailure());
    not_entered += static_cast<size_t>(std::popcount(node.UsedChildren() & ~alone.children));
  }
  EXPECT_GT(entered_all, 10000u);
  EXPECT_GT(not_entered, 20000u);
}

// Nearly always, so that few have to be masked; in a node without extent they are points.
void UnusedChildrenAreInsideOut() {
  Random random(3);
  for (size_t round = 2; round < 2 * WideNode::kWidth; ++round) {
    const size_t count = round / 2;
    Family family;
    for (size_t i = 0; i < count; ++i) family.Add(random.InCube(-1, 1), random.InCube(-1, 1));
    const Volumes decoded = Decode(family.Encode(round % 2 != 0), 0);
    for (size_t i = count; i < WideNode::kWidth; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GT(decoded.lower[axis][i], decoded.upper[axis][i]);
      }
    }
  }
}

void NumbersOfEightBitsAreRoundedUp() {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const float value = std::abs(random.AnyMagnitude(1e-37f, 1e30f));
    const float eight_bits = EightBitsNotBelow(value);
    ASSERT_EQ(std::bit_cast<uint32_t>(eight_bits) & 0xFFFFu, 0u);
    ASSERT_GE(eight_bits, value);
    const float before = std::bit_cast<float>(std::bit_cast<uint32_t>(eight_bits) - 0x10000u);
    ASSERT_LT(before, value);
    ASSERT_EQ(NextOfEightBits(before), eight_bits);
  }
  EXPECT_EQ(EightBitsNotBelow(0.0f), 0.0f);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(WideNodeTest);
HWY_EXPORT_AND_TEST_P(WideNodeTest, HoldsItsChildrenTightly);
HWY_EXPORT_AND_TEST_P(WideNodeTest, EmptyBoxesBecomePoints);
HWY_EXPORT_AND_TEST_P(WideNodeTest, FacesOnSteps);
HWY_EXPORT_AND_TEST_P(WideNodeTest, StepsSpanTheWhole);
HWY_EXPORT_AND_TEST_P(WideNodeTest, ScenesOfEveryShape);
HWY_EXPORT_AND_TEST_P(WideNodeTest, RaysEnterTheChildrenTheyMeet);
HWY_EXPORT_AND_TEST_P(WideNodeTest, UnusedChildrenAreInsideOut);
HWY_EXPORT_AND_TEST_P(WideNodeTest, NumbersOfEightBitsAreRoundedUp);

}  // namespace dacrt
#endif  // HWY_ONCE

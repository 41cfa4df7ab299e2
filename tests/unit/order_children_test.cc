#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "order_children_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "rays/load_records-inl.h"
#include "trace/order_children-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Float3;
using unit::Random;

RayRecord RecordOf(const Float3& org, const Float3& dir) {
  RayRecord ray{};
  std::copy(org.begin(), org.end(), ray.org);
  std::copy(dir.begin(), dir.end(), ray.dir);
  ray.tfar = unit::kInfinity;
  ray.mask = UINT32_MAX;
  EXPECT_TRUE(FinishRecord(ray));
  return ray;
}

ExactNode Encode(const std::vector<Box>& boxes) {
  const Box* children[WideNode::kWidth];
  for (size_t i = 0; i < boxes.size(); ++i) children[i] = &boxes[i];
  ExactNode node{};
  node.is_exact = true;
  EncodeChildren(children, boxes.size(), node);
  return node;
}

std::vector<uint8_t> Order(const WideNode& node, const std::vector<RayRecord>& rays,
                           const std::vector<RayNumber>& list) {
  std::vector<uint8_t> order(WideNode::kWidth, 0xFF);
  OrderChildren(ChildPlanes(node, PlaneOffsets(rays[list[0]].Octant())), rays.data(), list.data(),
                list.size(), order.data());
  return order;
}

void ExpectPermutation(const std::vector<uint8_t>& order) {
  std::vector<uint8_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
}

/// A box of size 1 around a place on the x axis.
Box At(float x) { return {{x - 0.5f, -0.5f, -0.5f, 0}, {x + 0.5f, 0.5f, 0.5f, 0}}; }

// Along a row of boxes, from either end.
void NearOnesComeFirst() {
  Random random(1);
  std::vector<float> places = {0, 2, 4, 6, 8, 10, 12, 14};
  for (int round = 0; round < 200; ++round) {
    for (size_t i = places.size(); i > 1; --i) {
      std::swap(places[i - 1], places[random.Below(static_cast<uint32_t>(i))]);
    }
    const size_t count = 1 + random.Below(8);
    std::vector<Box> boxes;
    for (size_t i = 0; i < count; ++i) boxes.push_back(At(places[i]));
    const ExactNode node = Encode(boxes);
    for (const bool forth : {true, false}) {
      const size_t ray_count = 1 + random.Below(20);
      std::vector<RayRecord> rays;
      std::vector<RayNumber> list(ray_count);
      std::iota(list.begin(), list.end(), RayNumber{0});
      for (size_t i = 0; i < ray_count; ++i) {
        const float y = random.Uniform(-0.3f, 0.3f);
        rays.push_back(forth ? RecordOf({-5, y, 0}, {1, 0, 0}) : RecordOf({30, y, 0}, {-1, 0, 0}));
      }
      const auto order = Order(node, rays, list);
      ExpectPermutation(order);
      std::vector<float> visited;
      for (const uint8_t child : order) {
        if (child < count) visited.push_back(forth ? places[child] : -places[child]);
      }
      ASSERT_TRUE(std::is_sorted(visited.begin(), visited.end()));
    }
  }
}

// Those that sample rays enter come before those that all of them miss.
void MissedOnesComeLast() {
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    std::vector<Box> boxes;
    std::vector<bool> is_hit;
    for (int i = 0; i < 8; ++i) {
      const bool hit = random.Below(2) == 0;
      Box box = At(3.0f * static_cast<float>(i));
      if (!hit) {
        box.lower[1] += 100;
        box.upper[1] += 100;
      }
      boxes.push_back(box);
      is_hit.push_back(hit);
    }
    const std::vector<RayRecord> rays(3, RecordOf({-5, 0, 0}, {1, 0, 0}));
    const auto order = Order(Encode(boxes), rays, {0, 1, 2});
    ExpectPermutation(order);
    bool missed = false;
    for (const uint8_t child : order) {
      if (is_hit[child]) {
        ASSERT_FALSE(missed);
      }
      missed |= !is_hit[child];
    }
  }
}

// Every sort of ray gives an order of all children: also ones in a face, behind, and far away.
void EveryRayGivesAnOrder() {
  Random random(3);
  for (int round = 0; round < 2000; ++round) {
    const float scale = std::abs(random.AnyMagnitude(1e-18f, 1e17f));
    std::vector<Box> boxes;
    for (uint32_t count = 1 + random.Below(8); count > 0; --count) {
      Box box = Box::Empty();
      box.Extend(random.InCube(-scale, scale).data());
      if (random.Below(3) > 0) box.Extend(random.InCube(-scale, scale).data());
      boxes.push_back(box);
    }
    const Float3 dir = random.Direction();
    std::vector<RayRecord> rays;
    std::vector<RayNumber> list;
    for (uint32_t count = 1 + random.Below(40); count > 0; --count) {
      Float3 own = dir;
      if (random.Below(3) == 0) {
        for (float& x : own) x *= random.Uniform(0.1f, 10);
      }
      if (random.Below(4) == 0) own[random.Below(3)] *= 1e-40f;
      list.push_back(static_cast<RayNumber>(rays.size()));
      rays.push_back(RecordOf(random.InCube(-2 * scale, 2 * scale), own));
      if (random.Below(5) == 0) rays.back().tfar = -unit::kInfinity;  // a blocked any-hit ray
    }
    ExpectPermutation(Order(Encode(boxes), rays, list));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// As where all rays begin in several children.
void OfEqualOnesTheLastComesFirst() {
  const std::vector<Box> boxes(8, At(3));
  const std::vector<RayRecord> rays(5, RecordOf({-5, 0, 0}, {1, 0, 0}));
  const auto order = Order(Encode(boxes), rays, {0, 1, 2, 3, 4});
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], order.size() - 1 - i);
}

// The sample is spread over the list, from its first ray to its last.
void TheSampleIsSpread() {
  // A few rays that come from the left stand at the ends of the list, between many from the right
  // that start so near that they would decide.
  static_assert(policy::SampleRays(100) >= 2);
  std::vector<RayRecord> rays;
  std::vector<RayNumber> list;
  for (RayNumber i = 0; i < 100; ++i) {
    const bool is_end = i == 0 || i == 99;
    // All in one octant; those in the middle enter the far box alone.
    rays.push_back(is_end ? RecordOf({-50, 0, 0}, {1, 0, 0}) : RecordOf({3, 0, 0}, {1, 0, 0}));
    list.push_back(i);
  }
  const auto order = Order(Encode({At(8), At(0)}), rays, list);
  std::vector<RayNumber> middle(list.begin() + 1, list.end() - 1);
  const auto of_middle = Order(Encode({At(8), At(0)}), rays, middle);
  EXPECT_LT(std::find(of_middle.begin(), of_middle.end(), 0),
            std::find(of_middle.begin(), of_middle.end(), 1));
  EXPECT_LT(std::find(order.begin(), order.end(), 1), std::find(order.begin(), order.end(), 0));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(OrderChildrenTest);
HWY_EXPORT_AND_TEST_P(OrderChildrenTest, NearOnesComeFirst);
HWY_EXPORT_AND_TEST_P(OrderChildrenTest, MissedOnesComeLast);
HWY_EXPORT_AND_TEST_P(OrderChildrenTest, EveryRayGivesAnOrder);
HWY_EXPORT_AND_TEST_P(OrderChildrenTest, OfEqualOnesTheLastComesFirst);
HWY_EXPORT_AND_TEST_P(OrderChildrenTest, TheSampleIsSpread);

}  // namespace dacrt
#endif  // HWY_ONCE

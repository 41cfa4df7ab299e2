#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "forms.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "group_lanes_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "rays/packet_view.h"
#include "trace/enter_children-inl.h"
#include "trace/group_interval-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::FormedRays;
using unit::FullRay;
using unit::kInfinity;
using unit::Random;
using unit::RaysOfEveryKind;

/// The lanes hold what the engine's records of the same rays hold.
template <size_t kMost>
void ExpectLanes(const GroupLanes<kMost>& group, LaneMask active, LaneMask valid,
                 const RayView& view, size_t first, const std::string& what) {
  const RecordLayout layout(view);
  uint32_t common = UINT32_MAX;
  for (uint32_t lane = 0; lane < kMost; ++lane) {
    if (!(valid >> lane & 1)) {
      ASSERT_FALSE(active >> lane & 1) << what;
      continue;
    }
    RayRecord expected{}, record{};
    const bool is_active = LoadRay(layout, first + lane, expected);
    ASSERT_EQ(active >> lane & 1, is_active) << what << " lane " << lane;
    if (!is_active) {
      ASSERT_LT(group.tfar[lane], 0) << what << " lane " << lane;
      continue;
    }
    common &= expected.mask;
    group.Store(lane, record);
    record.hit = expected.hit;  // which means nothing yet
    ASSERT_EQ(memcmp(&record, &expected, sizeof(record)), 0) << what << " lane " << lane;
  }
  ASSERT_EQ(group.CommonMask(active), common) << what;
}

// Also lanes that take no part, and packets of other sizes than the usual ones.
void PacketsAreLoadedAsTheirViewIs() {
  Random random(1);
  for (int round = 0; round < 50; ++round) {
    for (uint32_t lanes = 1; lanes <= kPacketRays; ++lanes) {
      const auto rays = RaysOfEveryKind(random, lanes);
      FormedRays formed(rays, {lanes, false, false});
      int32_t valid[kPacketRays];
      LaneMask valid_bits = 0;
      for (uint32_t lane = 0; lane < lanes; ++lane) {
        valid[lane] = random.Below(4) == 0 ? static_cast<int32_t>(random.Below(3)) : -1;
        valid_bits |= LaneMask{valid[lane] == -1} << lane;
      }
      RayPacket packet;
      packet.values = reinterpret_cast<void*>(formed.View().org_x);
      packet.lanes = lanes;
      packet.valid = round % 2 == 0 ? valid : nullptr;
      packet.has_masks = round % 3 != 0;
      if (!packet.valid) valid_bits = FirstLanes(lanes);
      GroupLanes<kPacketRays> group;
      const LaneMask active = group.LoadPacket(packet);
      ExpectLanes(group, active, valid_bits, ViewOf(packet), 0, std::to_string(lanes));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

template <size_t kMost>
void RaysOfViewsAreLoadedOf() {
  Random random(2);
  for (const unit::Form& form : unit::AllForms()) {
    const auto rays = RaysOfEveryKind(random, 2 * kMost);
    FormedRays formed(rays, form);
    RayView view = formed.View();
    for (size_t count = 1; count <= kMost; ++count) {
      // Then records are not in the usual order.
      std::swap(view.org_x, view.org_y);
      const size_t first = random.Below(static_cast<uint32_t>(rays.size() - count + 1));
      GroupLanes<kMost> group;
      const LaneMask active = group.LoadView(RecordLayout(view), first, count);
      ExpectLanes(group, active, FirstLanes(count), view, first, std::to_string(count));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// Every lane is in the set of one octant, and all of a set run there.
template <size_t kMost>
void LanesOfAnOctantOf() {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    const auto rays = RaysOfEveryKind(random, kMost);
    FormedRays formed(rays, {1, false, false});
    GroupLanes<kMost> group;
    const LaneMask active = group.LoadView(RecordLayout(formed.View()), 0, kMost);
    for (LaneMask rest = active; rest != 0;) {
      uint32_t octant = 8;
      const LaneMask lanes = group.LanesOfOctant(rest, octant);
      ASSERT_NE(lanes, 0u);
      ASSERT_EQ(lanes & ~rest, 0u);
      for (uint32_t lane = 0; lane < kMost; ++lane) {
        if (!(rest >> lane & 1)) continue;
        RayRecord record;
        group.Store(lane, record);
        ASSERT_EQ(record.Octant() == octant, (lanes >> lane & 1) != 0);
      }
      rest &= ~lanes;
    }
  }
}

// Of some lanes only, whatever stands in the others.
template <size_t kMost>
void BoundsAreThoseOfTheLanesOf() {
  Random random(4);
  for (int round = 0; round < 200; ++round) {
    GroupLanes<kMost> group;
    float* const rows[4] = {group.t, group.u, group.v, group.den};
    const bool all = round % 4 == 0;
    LaneMask lanes = 0;
    float least[4], largest[4];
    std::fill_n(least, 4, kInfinity);
    std::fill_n(largest, 4, -kInfinity);
    for (uint32_t lane = 0; lane < kMost; ++lane) {
      const bool takes_part = all || random.Below(3) != 0;
      lanes |= LaneMask{takes_part} << lane;
      for (size_t row = 0; row < 4; ++row) {
        if (!takes_part) {
          rows[row][lane] = random.Below(2) == 0 ? unit::kNaN : random.Uniform(-99, 99);
          continue;
        }
        rows[row][lane] = random.Uniform(-9, 9);
        least[row] = std::min(least[row], rows[row][lane]);
        largest[row] = std::max(largest[row], rows[row][lane]);
      }
    }
    if (lanes == 0) continue;
    const FourBounds bounds(group, lanes, {rows[0], rows[1], rows[2], rows[3]});
    for (size_t row = 0; row < 4; ++row) {
      ASSERT_EQ(bounds.low[row], least[row]);
      ASSERT_EQ(bounds.high[row], largest[row]);
    }
  }
}

// The interval of a group enters whatever one of its rays enters, and no later.
template <size_t kMost>
void IntervalsHoldTheirRaysOf() {
  Random random(5);
  size_t entered = 0, boxes_left_out = 0;
  for (int round = 0; round < 2000; ++round) {
    const unit::Float3 eye = random.InCube(-3, 3), aim = random.InCube(-1, 1);
    std::vector<FullRay> rays;
    for (size_t i = 0; i < kMost; ++i) {
      const unit::Float3 at = random.InCube(-0.3f, 0.3f);
      rays.push_back(unit::FullRayOf(unit::MakeRay(
          eye, {aim[0] + at[0] - eye[0], aim[1] + at[1] - eye[1], aim[2] + at[2] - eye[2]})));
    }
    FormedRays formed(rays, {1, false, false});
    GroupLanes<kMost> group;
    const LaneMask active = group.LoadView(RecordLayout(formed.View()), 0, kMost);
    uint32_t octant;
    const LaneMask lanes = group.LanesOfOctant(active, octant);
    const GroupInterval interval(group, lanes, octant);
    Box boxes[WideNode::kWidth];
    const Box* children[WideNode::kWidth];
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      boxes[i] = Box::Empty();
      boxes[i].Extend(random.InCube(-1, 1).data());
      boxes[i].Extend(random.InCube(-1, 1).data());
      children[i] = &boxes[i];
    }
    ExactNode node{};
    node.is_exact = random.Below(2) == 0;
    EncodeChildren(children, WideNode::kWidth, node);
    const ChildPlanes planes(node, PlaneOffsets(octant));
    HWY_ALIGN float entries[WideNode::kWidth];
    const uint32_t by_interval = interval.EnterChildren(planes, kInfinity, entries);
    // The same boxes as they are, in the lanes of vectors.
    uint32_t boxes_by_interval = 0;
    WideBoxOf<EightPart> lanes_of_boxes[kParts];
    for (size_t part = 0; part < kParts; ++part) {
      for (int axis = 0; axis < 3; ++axis) {
        HWY_ALIGN float lower[kPartLanes], upper[kPartLanes];
        for (size_t i = 0; i < kPartLanes; ++i) {
          lower[i] = boxes[part * kPartLanes + i].lower[axis];
          upper[i] = boxes[part * kPartLanes + i].upper[axis];
        }
        lanes_of_boxes[part].lower[axis] = WidenDown(hn::Load(kEightTag, lower));
        lanes_of_boxes[part].upper[axis] = WidenUp(hn::Load(kEightTag, upper));
      }
      boxes_by_interval |=
          interval.EnterBoxes(lanes_of_boxes[part], PlaneOffsets(octant), kInfinity)
          << (part * kPartLanes);
    }
    for (uint32_t lane = 0; lane < kMost; ++lane) {
      if (!(lanes >> lane & 1)) continue;
      RayRecord ray;
      group.Store(lane, ray);
      HWY_ALIGN float own[WideNode::kWidth];
      const uint32_t by_ray =
          EnterChildren(planes, SlabRay(ray), ray.tfar, [&](size_t part, EightPart entry) HWY_ATTR {
            hn::Store(entry, kEightTag, own + part * kPartLanes);
          });
      ASSERT_EQ(by_ray & ~by_interval, 0u);
      for (size_t part = 0; part < kParts; ++part) {
        EightPart org[3], reciprocal[3];
        for (int axis = 0; axis < 3; ++axis) {
          org[axis] = hn::Set(kEightTag, ray.org[axis]);
          reciprocal[axis] = hn::Set(kEightTag, ray.reciprocal[axis]);
        }
        const auto enters = Enters(IntersectBox(lanes_of_boxes[part], org, reciprocal),
                                   hn::Set(kEightTag, ray.tnear), hn::Set(kEightTag, ray.tfar));
        const uint64_t may_enter = boxes_by_interval >> (part * kPartLanes);
        ASSERT_EQ(Bits(kEightTag, enters) & ~may_enter, 0u);
        boxes_left_out += kPartLanes - hwy::PopCount(may_enter & ((1u << kPartLanes) - 1));
      }
      for (size_t i = 0; i < WideNode::kWidth; ++i) {
        if (!(by_ray >> i & 1)) continue;
        ++entered;
        ASSERT_LE(entries[i], own[i]);
      }
    }
  }
  EXPECT_GT(entered, 5000u);
  EXPECT_GT(boxes_left_out, 5000u);
}

/// The smallest groups and the largest ones.
void RaysOfViewsAreLoaded() {
  RaysOfViewsAreLoadedOf<kPacketRays>();
  RaysOfViewsAreLoadedOf<kMostGroupRays>();
}
void LanesOfAnOctant() {
  LanesOfAnOctantOf<kPacketRays>();
  LanesOfAnOctantOf<kMostGroupRays>();
}
void BoundsAreThoseOfTheLanes() {
  BoundsAreThoseOfTheLanesOf<kPacketRays>();
  BoundsAreThoseOfTheLanesOf<kMostGroupRays>();
}
void IntervalsHoldTheirRays() {
  IntervalsHoldTheirRaysOf<kPacketRays>();
  IntervalsHoldTheirRaysOf<kMostGroupRays>();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(GroupLanesTest);
HWY_EXPORT_AND_TEST_P(GroupLanesTest, PacketsAreLoadedAsTheirViewIs);
HWY_EXPORT_AND_TEST_P(GroupLanesTest, RaysOfViewsAreLoaded);
HWY_EXPORT_AND_TEST_P(GroupLanesTest, LanesOfAnOctant);
HWY_EXPORT_AND_TEST_P(GroupLanesTest, BoundsAreThoseOfTheLanes);
HWY_EXPORT_AND_TEST_P(GroupLanesTest, IntervalsHoldTheirRays);

}  // namespace dacrt
#endif  // HWY_ONCE

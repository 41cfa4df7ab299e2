#include <gtest/gtest.h>

#include <vector>

#include "forms.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "load_records_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "rays/load_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::FormedRays;
using unit::FullRay;
using unit::kInfinity;
using unit::Random;
using unit::Ray;
using unit::RaysOfEveryKind;
using enum PacketComponent;

constexpr unit::Form kRecordForm = {1, false, false};

/// The definition in RayView, and a mask of 0, which meets nothing.
bool IsActiveRay(const FullRay& ray) {
  for (const PacketComponent c : {kOrgX, kOrgY, kOrgZ, kDirX, kDirY, kDirZ}) {
    if (!std::isfinite(ray.Get(c))) return false;
  }
  return ray.Get(kTnear) <= ray.Get(kTfar) && ray.Get(kTfar) >= 0 && ray.Get<uint32_t>(kMask) != 0;
}

uint32_t OctantOf(const FullRay& ray) {
  return uint32_t{std::signbit(ray.Get(kDirX))} | uint32_t{std::signbit(ray.Get(kDirY))} << 1 |
         uint32_t{std::signbit(ray.Get(kDirZ))} << 2;
}

bool SameFloat(float a, float b) { return memcmp(&a, &b, sizeof(a)) == 0; }

void ExpectRecord(const RayRecord& record, const FullRay& ray) {
  constexpr PacketComponent kOrg[] = {kOrgX, kOrgY, kOrgZ}, kDir[] = {kDirX, kDirY, kDirZ};
  for (size_t axis = 0; axis < 3; ++axis) {
    ASSERT_TRUE(SameFloat(record.org[axis], ray.Get(kOrg[axis])));
    ASSERT_TRUE(SameFloat(record.dir[axis], ray.Get(kDir[axis])));
    const float d = ray.Get(kDir[axis]);
    const float expected = 1 / std::copysign(std::max(std::abs(d), kSmallestDirection), d);
    ASSERT_TRUE(SameFloat(record.reciprocal[axis], expected));
  }
  ASSERT_TRUE(SameFloat(record.tnear, ray.Get(kTnear)));
  ASSERT_TRUE(SameFloat(record.tfar, ray.Get(kTfar)));
  ASSERT_TRUE(SameFloat(record.time, ray.Get(kTime)));
  ASSERT_EQ(record.start, std::max(ray.Get(kTnear), 0.0f));
  ASSERT_EQ(record.mask, ray.Get<uint32_t>(kMask));
  ASSERT_EQ(record.state, RayRecord::kAtLimit);
  ASSERT_EQ(record.Octant(), OctantOf(ray));
}

/// Loads rays [first, first + count) and expects the active ones of each octant side by side, in
/// the order in which they came.
void ExpectLoaded(FormedRays& formed, const std::vector<FullRay>& rays, size_t first,
                  size_t count) {
  const unit::GuardedArray<RayRecord> records(count);
  const unit::GuardedArray<uint32_t> callers(count);
  const LoadedRays loaded =
      LoadRecords(formed.View(), first, count, records.data(), callers.data());
  uint32_t common_mask = UINT32_MAX;
  size_t active = 0, last_end = 0;
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    std::vector<uint32_t> expected;
    for (size_t i = 0; i < count; ++i) {
      const FullRay& ray = rays[first + i];
      if (OctantOf(ray) != octant || !IsActiveRay(ray)) continue;
      expected.push_back(static_cast<uint32_t>(i));
      common_mask &= ray.Get<uint32_t>(kMask);
    }
    ASSERT_GE(loaded.begin[octant], last_end) << "octants overlap";
    ASSERT_EQ(loaded.end[octant] - loaded.begin[octant], expected.size()) << "octant " << octant;
    for (size_t i = 0; i < expected.size(); ++i) {
      const size_t place = loaded.begin[octant] + i;
      ASSERT_EQ(callers[place], expected[i]);
      ExpectRecord(records[place], rays[first + expected[i]]);
      if (testing::Test::HasFatalFailure()) return;
    }
    last_end = loaded.end[octant];
    active += expected.size();
  }
  ASSERT_LE(last_end, count);
  ASSERT_EQ(loaded.count, active);
  ASSERT_EQ(loaded.common_mask, common_mask);
}

void EveryFormIsReadAlike() {
  Random random(1);
  for (const unit::Form& form : unit::AllForms()) {
    for (size_t count : {1u, 2u, 3u, 15u, 16u, 17u, 70u, 500u}) {
      SCOPED_TRACE(form.Text() + ", " + std::to_string(count));
      const auto rays = RaysOfEveryKind(random, count);
      FormedRays formed(rays, form);
      ExpectLoaded(formed, rays, 0, count);
      ExpectLoaded(formed, rays, count / 3, count - count / 3);
      ExpectLoaded(formed, rays, count / 2, 1);
      ASSERT_EQ(formed.Rays(), rays) << "only read";
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// Rays in the order of PacketComponent are read in another way than those in any other order, as
// are those without masks or a time.
void AbsentComponentsHaveTheirDefaults() {
  Random random(2);
  for (const unit::Form& form : unit::AllForms()) {
    auto rays = RaysOfEveryKind(random, 90);
    FormedRays formed(rays, form);
    for (int absent = 0; absent < 8; ++absent) {
      RayView view = formed.View();
      auto expected = rays;
      for (FullRay& ray : expected) {
        if (absent & 1) ray.Set(kMask, UINT32_MAX);
        if (absent & 2) ray.Set(kTime, 0.0f);
        if (absent & 4) ray.Set(kTnear, 0.0f);
      }
      if (absent & 1) view.mask = RayView::kAbsent;
      if (absent & 2) view.time = RayView::kAbsent;
      if (absent & 4) view.tnear = RayView::kAbsent;
      std::vector<RayRecord> records(90);
      std::vector<uint32_t> callers(90);
      const LoadedRays loaded = LoadRecords(view, 0, 90, records.data(), callers.data());
      size_t active = 0;
      for (const FullRay& ray : expected) active += IsActiveRay(ray);
      ASSERT_EQ(loaded.count, active) << form.Text();
      for (size_t octant = 0; octant < 8; ++octant) {
        for (size_t i = loaded.begin[octant]; i < loaded.end[octant]; ++i) {
          ExpectRecord(records[i], expected[callers[i]]);
          if (testing::Test::HasFatalFailure()) return;
        }
      }
    }
  }
}

// One component that stands elsewhere, all others in the order of PacketComponent.
void ComponentsMayStandAnywhere() {
  Random random(5);
  const auto rays = RaysOfEveryKind(random, 40);
  FormedRays formed(rays, kRecordForm), elsewhere(RaysOfEveryKind(random, 40), kRecordForm);
  const auto other = elsewhere.Rays();
  struct Place {
    RayView::Component RayView::*component;
    PacketComponent name;
  };
  const Place places[] = {{&RayView::org_x, kOrgX}, {&RayView::org_y, kOrgY},
                          {&RayView::org_z, kOrgZ}, {&RayView::tnear, kTnear},
                          {&RayView::dir_x, kDirX}, {&RayView::dir_y, kDirY},
                          {&RayView::dir_z, kDirZ}, {&RayView::time, kTime},
                          {&RayView::tfar, kTfar},  {&RayView::mask, kMask}};
  for (const Place& place : places) {
    RayView view = formed.View();
    view.*place.component = elsewhere.View().*place.component;
    std::vector<RayRecord> records(40);
    std::vector<uint32_t> callers(40);
    const LoadedRays loaded = LoadRecords(view, 0, 40, records.data(), callers.data());
    ASSERT_GT(loaded.count, 10u);
    for (size_t octant = 0; octant < 8; ++octant) {
      for (size_t i = loaded.begin[octant]; i < loaded.end[octant]; ++i) {
        FullRay expected = rays[callers[i]];
        expected.Set(place.name, other[callers[i]].Get<uint32_t>(place.name));
        ExpectRecord(records[i], expected);
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  }
  // Hits, too: those of a record are written in one go only where they stand side by side.
  for (const Place& place : {Place{&RayView::u, kU}, Place{&RayView::instance_id, kInstanceId},
                             Place{&RayView::ng_x, kNgX}, Place{&RayView::tfar, kTfar}}) {
    const auto before = formed.Rays(), before_elsewhere = elsewhere.Rays();
    RayView view = formed.View();
    view.*place.component = elsewhere.View().*place.component;
    RecordLayout(view).WriteHit(7, {{1, 2, 3}, 4, 5, 6, 7, 8, 9});
    const auto after = formed.Rays(), after_elsewhere = elsewhere.Rays();
    ASSERT_EQ(after[7].Get<uint32_t>(place.name), before[7].Get<uint32_t>(place.name));
    ASSERT_NE(after_elsewhere[7].Get<uint32_t>(place.name),
              before_elsewhere[7].Get<uint32_t>(place.name));
    formed = FormedRays(before, kRecordForm);
    elsewhere = FormedRays(before_elsewhere, kRecordForm);
  }
}

// Finite components whose sum overflows are finite, and infinities of opposite sign do not cancel.
void SumsThatOverflow() {
  const auto is_loaded = [](const Ray& ray) {
    std::vector<FullRay> rays = {unit::FullRayOf(ray)};
    FormedRays formed(rays, {1, false, false});
    RayRecord record;
    uint32_t caller;
    return LoadRecords(formed.View(), 0, 1, &record, &caller).count == 1;
  };
  EXPECT_TRUE(is_loaded(unit::MakeRay({3e38f, 3e38f, 3e38f}, {3e38f, -3e38f, -3e38f})));
  EXPECT_TRUE(is_loaded(unit::MakeRay({-3e38f, -3e38f, 0}, {3e38f, 3e38f, 3e38f})));
  EXPECT_TRUE(is_loaded(unit::MakeRay({0, 0, 0}, {0, 0, 0}))) << "a direction may be zero";
  EXPECT_FALSE(is_loaded(unit::MakeRay({kInfinity, -kInfinity, 0}, {1, 0, 0})));
  EXPECT_FALSE(is_loaded(unit::MakeRay({0, 0, kInfinity}, {-kInfinity, 0, 0})));
  EXPECT_TRUE(is_loaded(unit::MakeRay({0, 0, 0}, {1, 0, 0}, -kInfinity, kInfinity)));
  EXPECT_TRUE(is_loaded(unit::MakeRay({0, 0, 0}, {1, 0, 0}, -1, -0.0f)));
  EXPECT_TRUE(is_loaded(unit::MakeRay({0, 0, 0}, {1, 0, 0}, 1, 1)));
  EXPECT_FALSE(is_loaded(unit::MakeRay({0, 0, 0}, {1, 0, 0}, 1, std::nextafter(1.0f, 0.0f))));
}

// What is written is the hit, to the ray it is for, in every form, and nothing beside it.
void HitsGoToTheirRays() {
  Random random(4);
  for (const unit::Form& form : unit::AllForms()) {
    const auto rays = RaysOfEveryKind(random, 35);
    FormedRays formed(rays, form);
    auto expected = rays;
    const RayView view = formed.View();
    const RecordLayout layout(view);
    for (size_t i = 0; i < rays.size(); i += 1 + random.Below(3)) {
      if (random.Below(4) == 0) {
        layout.WriteBlocked(i);
        expected[i].Set(kTfar, -kInfinity);
        continue;
      }
      const float x = static_cast<float>(i);
      const uint32_t n = static_cast<uint32_t>(i);
      const FullHit hit{{x, x + 1, x + 2}, x + 3, x + 4, n + 5, n + 6, n + 7, x + 8};
      layout.WriteHit(i, hit);
      FullRay& ray = expected[i];
      ray.Set(kNgX, x);
      ray.Set(kNgY, x + 1);
      ray.Set(kNgZ, x + 2);
      ray.Set(kU, x + 3);
      ray.Set(kV, x + 4);
      ray.Set(kPrimitiveId, n + 5);
      ray.Set(kGeometryId, n + 6);
      ray.Set(kInstanceId, n + 7);
      ray.Set(kTfar, x + 8);
    }
    ASSERT_EQ(formed.Rays(), expected) << form.Text();
    ASSERT_TRUE(formed.GuardsHold()) << form.Text();
    // The same through a packet.
    if (form.apart || form.by_pointers) continue;
    RayPacket packet;
    packet.values = reinterpret_cast<void*>(view.org_x);
    packet.lanes = static_cast<uint32_t>(form.lanes);
    const uint32_t lane = packet.lanes - 1;
    const FullHit hit{{1, 2, 3}, 4, 5, 6, 7, 8, 9};
    RecordLayout::WriteLane(packet, lane, hit);
    const auto by_lane = formed.Rays();
    layout.WriteHit(lane, {{0, 0, 0}, 0, 0, 0, 0, 0, 0});
    layout.WriteHit(lane, hit);
    ASSERT_EQ(formed.Rays(), by_lane);
  }
}

void ARayThatBeginsAtMinusZeroBeginsAtZero() {
  // Origin and tnear, direction and time, tfar.
  const float record[12] = {1, 2, 3, -0.0f, 1, 1, 1, 0, kInfinity};
  RayRecord ray;
  ASSERT_TRUE(LoadRecord(record, false, ray));
  EXPECT_TRUE(SameFloat(ray.start, 0));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(LoadRecordsTest);
HWY_EXPORT_AND_TEST_P(LoadRecordsTest, EveryFormIsReadAlike);
HWY_EXPORT_AND_TEST_P(LoadRecordsTest, AbsentComponentsHaveTheirDefaults);
HWY_EXPORT_AND_TEST_P(LoadRecordsTest, ComponentsMayStandAnywhere);
HWY_EXPORT_AND_TEST_P(LoadRecordsTest, SumsThatOverflow);
HWY_EXPORT_AND_TEST_P(LoadRecordsTest, HitsGoToTheirRays);
HWY_EXPORT_AND_TEST_P(LoadRecordsTest, ARayThatBeginsAtMinusZeroBeginsAtZero);

}  // namespace dacrt
#endif  // HWY_ONCE

// The suite itself: the reference knows what is true, and no fault passes as explained.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "compare.h"
#include "contest.h"

namespace dacrt::tests {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

RTCRayHit RayFrom(const Float3& origin, const Float3& direction) {
  RTCRayHit record{};
  record.ray = {origin.x,    origin.y, origin.z,  0,          direction.x, direction.y,
                direction.z, 0,        kInfinity, UINT32_MAX, 0,           0};
  record.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return record;
}

constexpr Corners kUnitTriangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

TriangleAnswer TestUnitTriangle(const RTCRayHit& record) {
  return TestTriangle(record.ray, kUnitTriangle);
}

TEST(Reference, HitInTheMiddleIsCertain) {
  const TriangleAnswer answer = TestUnitTriangle(RayFrom({0.25f, 0.5f, 2}, {0, 0, -1}));
  EXPECT_TRUE(answer.MustHit());
  EXPECT_EQ(answer.t.value, 2);
  EXPECT_EQ(answer.u.value, 0.25);
  EXPECT_EQ(answer.v.value, 0.5);
  EXPECT_LT(answer.t.error, 1e-5);
}

TEST(Reference, MissBesideIsCertain) {
  EXPECT_FALSE(TestUnitTriangle(RayFrom({0.6f, 0.6f, 2}, {0, 0, -1})).MayHit());
  EXPECT_FALSE(TestUnitTriangle(RayFrom({-0.01f, 0.5f, 2}, {0, 0, -1})).MayHit());
  EXPECT_FALSE(TestUnitTriangle(RayFrom({0.25f, 0.5f, 2}, {0, 0, 1})).MayHit());
}

TEST(Reference, EdgeIsInDoubtWithinRoundingOnly) {
  const float after_one = std::nextafter(0.5f, 1.0f);
  const TriangleAnswer on = TestUnitTriangle(RayFrom({0.5f, 0.5f, 2}, {0, 0, -1}));
  const TriangleAnswer beside = TestUnitTriangle(RayFrom({0.5f, after_one, 2}, {0, 0, -1}));
  EXPECT_TRUE(on.is_hit);
  EXPECT_EQ(on.doubts, kDoubtEdge);
  EXPECT_FALSE(beside.is_hit);
  EXPECT_EQ(beside.doubts, kDoubtEdge);
  EXPECT_FALSE(TestUnitTriangle(RayFrom({0.5f, 0.50001f, 2}, {0, 0, -1})).MayHit());
}

TEST(Reference, EndsOfTheRayAreInDoubtWithinRoundingOnly) {
  RTCRayHit record = RayFrom({0.25f, 0.25f, 2}, {0, 0, -1});
  record.ray.tfar = 2;
  EXPECT_EQ(TestUnitTriangle(record).doubts, kDoubtInterval);
  record.ray.tfar = 1.9999f;
  EXPECT_FALSE(TestUnitTriangle(record).MayHit());
  record.ray.tfar = 2.0001f;
  EXPECT_TRUE(TestUnitTriangle(record).MustHit());
  record.ray.tnear = 2;
  EXPECT_EQ(TestUnitTriangle(record).doubts, kDoubtInterval);
  record.ray.tnear = 2.00005f;
  EXPECT_FALSE(TestUnitTriangle(record).MayHit());
}

TEST(Reference, RayInThePlaneIsParallel) {
  const TriangleAnswer answer = TestUnitTriangle(RayFrom({-1, 0.3f, 0}, {1, 0.1f, 0}));
  EXPECT_FALSE(answer.is_hit);
}

TEST(Reference, TriangleWithoutAreaIsNeverHit) {
  const RTCRayHit record = RayFrom({0, 0, 1}, {0, 0, -1});
  EXPECT_FALSE(TestTriangle(record.ray, {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}}).MayHit());
  EXPECT_FALSE(TestTriangle(record.ray, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}).MayHit());
}

TEST(Reference, SlabTestMayMissOnlyAtTheBox) {
  const RTCRayHit inside = RayFrom({0.3f, 0.3f, 2}, {0.01f, 0.02f, -1});
  EXPECT_FALSE(SlabTestMayMiss(inside.ray, kInfinity, kUnitTriangle, {}));
  const RTCRayHit at_face = RayFrom({1, 0.3f, 2}, {0, 0.02f, -1});
  EXPECT_TRUE(SlabTestMayMiss(at_face.ray, kInfinity, kUnitTriangle, {}));
}

TEST(Reference, SlabTestOfPacketMayMissByTheErrorOfItsOtherRays) {
  const RTCRayHit inside = RayFrom({1e5f + 0.3f, 0.3f, 2}, {0.01f, 0.02f, -1});
  const RTCRayHit steep = RayFrom({1e5f, 0.3f, 2}, {1e-6f, 0.02f, -1});
  const Corners far{{1e5f, 0, 0}, {1e5f + 1, 0, 0}, {1e5f, 1, 0}};
  EXPECT_FALSE(SlabTestMayMiss(inside.ray, kInfinity, far, {}));
  const RTCRayHit packet[] = {inside, steep};
  EXPECT_TRUE(SlabTestMayMiss(inside.ray, kInfinity, far, packet));
}

/// Single precision, in the library's own kernels, must agree with the bounds in double.
TEST(Reference, FindsNoFaultInTheRealLibrary) {
  const EmbreeDevice device(RealEmbree(), "isa=avx2");
  for (const char* const name : {"soup", "slivers", "coplanar", "boxes", "tiny", "far"}) {
    const TestScene scene = MakeScene(name);
    const EmbreeScene real(device, scene);
    const RayGenerator generator(scene, real);
    const Comparer comparer(scene);
    for (const RayKind kind : {RayKind::kCamera, RayKind::kDiffuse, RayKind::kSurface}) {
      const std::vector<RTCRayHit> rays = generator.Make(kind, 500, 3);
      const std::vector<RTCRayHit> traced =
          Trace(real, {Form::Call::kRecords}, Query::kClosest, rays);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto fault = comparer.FindFault(Query::kClosest, rays[i], traced[i]);
        EXPECT_FALSE(fault) << name << ": " << *fault << '\n'
                            << comparer.Describe(Query::kClosest, rays[i], &traced[i], traced[i]);
      }
    }
  }
}

/// Right answers of the real library, with one fault put into each.
class FaultTest : public testing::Test {
 protected:
  FaultTest() {
    const EmbreeScene real(device_, scene_);
    const RayGenerator generator(scene_, real);
    for (const RTCRayHit& ray : generator.Make(RayKind::kRandomLines, 2'500, 5)) {
      const RTCRayHit traced =
          Trace(real, {Form::Call::kRecords}, Query::kClosest, {&ray, 1}).front();
      (traced.hit.geomID == RTC_INVALID_GEOMETRY_ID ? misses_ : hits_).push_back({ray, traced});
    }
  }

  struct Pair {
    RTCRayHit before, after;
  };

  /// How many of `pairs` are explained although `fault` changed the drop-in's record.
  template <typename Fault>
  std::size_t CountExplained(const std::vector<Pair>& pairs, const Fault& fault) const {
    EXPECT_GT(pairs.size(), 50u);
    std::size_t explained = 0;
    for (const Pair& pair : pairs) {
      RTCRayHit faulty = pair.after;
      fault(pair, faulty);
      const Comparison comparison =
          comparer_.Compare(Query::kClosest, pair.before, pair.after, faulty);
      if (comparison.relation != Relation::kUnexplained) ++explained;
    }
    return explained;
  }

  const EmbreeDevice device_{RealEmbree(), "isa=avx2"};
  const TestScene scene_ = MakeScene("soup");
  const Comparer comparer_{scene_};
  std::vector<Pair> hits_, misses_;
};

TEST_F(FaultTest, RightAnswersAreIdentical) {
  for (const Pair& pair : hits_) {
    EXPECT_EQ(comparer_.Compare(Query::kClosest, pair.before, pair.after, pair.after).relation,
              Relation::kIdentical);
  }
}

TEST_F(FaultTest, LostHit) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair& pair, RTCRayHit& r) { r = pair.before; }), 0u);
}

TEST_F(FaultTest, WrongPrimitive) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.hit.primID ^= 1; }), 0u);
}

TEST_F(FaultTest, WrongGeometry) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.hit.geomID += 1; }), 0u);
}

TEST_F(FaultTest, WrongInstance) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.hit.instID[0] = 0; }), 0u);
}

TEST_F(FaultTest, WrongDistance) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.ray.tfar *= 1.5f; }), 0u);
  // One in a thousand rays grazes a triangle so small that a percent is within rounding.
  EXPECT_LE(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.ray.tfar *= 1.01f; }),
            hits_.size() / 1'000);
}

TEST_F(FaultTest, WrongBarycentrics) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.hit.u += 0.01f; }), 0u);
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.hit.v -= 0.01f; }), 0u);
}

TEST_F(FaultTest, WrongNormal) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.hit.Ng_x *= -1; }), 0u);
}

TEST_F(FaultTest, ChangedInput) {
  EXPECT_EQ(CountExplained(hits_, [](const Pair&, RTCRayHit& r) { r.ray.id ^= 1; }), 0u);
  EXPECT_EQ(CountExplained(misses_, [](const Pair&, RTCRayHit& r) { r.ray.flags ^= 1; }), 0u);
  EXPECT_EQ(CountExplained(misses_, [](const Pair&, RTCRayHit& r) { r.hit.u = 0.125f; }), 0u);
}

TEST_F(FaultTest, MadeUpHit) {
  const RTCHit hit = hits_.front().after.hit;
  EXPECT_EQ(CountExplained(misses_,
                           [&](const Pair&, RTCRayHit& r) {
                             r.hit = hit;
                             r.ray.tfar = 1;
                           }),
            0u);
}

TEST_F(FaultTest, LostAndMadeUpOcclusion) {
  for (const Pair& pair : hits_) {
    RTCRayHit occluded = pair.before;
    occluded.ray.tfar = -kInfinity;
    EXPECT_EQ(comparer_.Compare(Query::kAny, pair.before, occluded, pair.before).relation,
              Relation::kUnexplained);
  }
  for (const Pair& pair : misses_) {
    RTCRayHit occluded = pair.before;
    occluded.ray.tfar = -kInfinity;
    EXPECT_EQ(comparer_.Compare(Query::kAny, pair.before, pair.before, occluded).relation,
              Relation::kUnexplained);
  }
}

TEST_F(FaultTest, InactiveRayThatHits) {
  for (const Pair& pair : hits_) {
    RTCRayHit inactive = pair.before;
    inactive.ray.tnear = 1;
    inactive.ray.tfar = 0.5f;
    RTCRayHit after = pair.after;
    EXPECT_EQ(comparer_.Compare(Query::kClosest, inactive, inactive, after).relation,
              Relation::kUnexplained);
  }
}

}  // namespace
}  // namespace dacrt::tests

#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "conic_packets_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/box.h"
#include "paper/conic_packets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BatchMemory;
using unit::Float3;
using unit::Random;
using unit::Ray;

/// A batch with its packets.
class Packets {
 public:
  explicit Packets(const std::vector<Ray>& rays)
      : memory_(hwy::RoundUpTo(rays.size(), kMaxLanes) + 4 * kMaxLanes, rays.size()),
        arrays_(6, std::vector<float>(hwy::DivCeil(rays.size(), ConicPackets::kRays))),
        lists_(2 * arrays_[0].size()) {
    RayBatch& batch = memory_.batch;
    for (size_t axis = 0; axis < 3; ++axis) batch.cones.axis[axis] = arrays_[axis].data();
    batch.cones.tangent = arrays_[3].data();
    batch.cones.longest = arrays_[4].data();
    batch.cones.reach = arrays_[5].data();
    batch.packets = lists_;
    block_ = memory_.Push(rays);
    packets_ = MakeConicPackets(batch, block_);
  }

  /// The packets whose cones meet `box`.
  std::vector<RayBlock> Filter(const Box& box) {
    RayBlock* const out = lists_.data() + packets_.size();
    const size_t count = FilterPackets(memory_.batch.cones, packets_, box, out);
    return {out, out + count};
  }

  /// Packets with a ray that enters `box`, by the test for single rays.
  std::vector<RayBlock> Entering(const Box& box) const {
    const RayBatch& batch = memory_.batch;
    std::vector<RayBlock> entering;
    const WideBox wide = Widen(box.lower, box.upper);
    for (const RayBlock& packet : packets_) {
      bool enters = false;
      for (size_t slot = packet.begin; slot < packet.begin + packet.count; ++slot) {
        V org[3], reciprocal[3];
        for (int axis = 0; axis < 3; ++axis) {
          org[axis] = hn::Set(kFloat, batch.org[axis][slot]);
          reciprocal[axis] = SafeReciprocal(hn::Set(kFloat, batch.dir[axis][slot]));
        }
        enters |=
            Bits(Enters(IntersectBox(wide, org, reciprocal), hn::Set(kFloat, batch.tnear[slot]),
                        hn::Set(kFloat, batch.tfar[slot]))) &
            1;
      }
      if (enters) entering.push_back(packet);
    }
    return entering;
  }

  RayBatch& batch() { return memory_.batch; }
  std::span<const RayBlock> packets() const { return packets_; }
  const RayBlock& block() const { return block_; }

 private:
  BatchMemory memory_;
  std::vector<std::vector<float>> arrays_;
  std::vector<RayBlock> lists_;
  RayBlock block_{};
  std::span<const RayBlock> packets_;
};

Box RandomBox(Random& random, float extent, float size) {
  Float3 center = random.InCube(-extent, extent);
  Box box = Box::Empty();
  for (int k = 0; k < 2; ++k) {
    Float3 corner = random.InCube(-size, size);
    for (size_t axis = 0; axis < 3; ++axis) corner[axis] += center[axis];
    box.Extend(corner.data());
  }
  return box;
}

/// Rays from one point in cones of about `width`; 0 is a line, 2 all around.
std::vector<Ray> RaysFromAPoint(Random& random, size_t count, float width) {
  const Float3 apex = random.InCube(-2, 2);
  std::vector<Ray> rays;
  Float3 axis = random.Direction();
  for (size_t i = 0; i < count; ++i) {
    if (i % ConicPackets::kRays == 0) axis = random.Direction();
    Float3 dir = random.InCube(-width, width);
    const float length = std::exp2(random.Uniform(-4, 4));
    for (size_t k = 0; k < 3; ++k) dir[k] = (dir[k] + axis[k]) * length;
    rays.push_back(unit::MakeRay(apex, dir));
    if (random.Below(3) == 0) rays.back().tfar = random.Uniform(0, 2);
  }
  return rays;
}

void PacketsAreConsecutiveRays() {
  Random random(1);
  for (const size_t count : {1u, 63u, 64u, 65u, 200u}) {
    Packets packets(RaysFromAPoint(random, count, 0.1f));
    size_t next = 0;
    for (const RayBlock& packet : packets.packets()) {
      ASSERT_EQ(packet.begin, next);
      ASSERT_LE(packet.count, ConicPackets::kRays);
      next += packet.count;
    }
    ASSERT_EQ(next, count);
  }
}

// What decides: a packet of which any ray enters the box is kept. At every scale and cone width.
void NeverLeavesOutARayThatEnters() {
  Random random(2);
  size_t entering = 0, kept = 0, all = 0;
  for (int round = 0; round < 400; ++round) {
    const float scale = round % 4 == 0 ? std::exp2(random.Uniform(-30, 30)) : 1;
    auto rays = RaysFromAPoint(random, 1 + random.Below(400),
                               round % 7 == 0 ? 0 : std::exp2(random.Uniform(-12, 1.5f)));
    for (Ray& ray : rays) {
      for (float& x : ray.org) x *= scale;
      for (float& x : ray.dir) x *= scale;
    }
    Packets packets(rays);
    for (int k = 0; k < 20; ++k) {
      Box box = RandomBox(random, 3, std::exp2(random.Uniform(-10, 1)));
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] *= scale;
        box.upper[axis] *= scale;
      }
      const auto filtered = packets.Filter(box);
      const auto must = packets.Entering(box);
      size_t i = 0;
      for (const RayBlock& packet : must) {
        while (i < filtered.size() && filtered[i].begin < packet.begin) ++i;
        ASSERT_LT(i, filtered.size()) << "round " << round;
        ASSERT_EQ(filtered[i].begin, packet.begin) << "round " << round;
        ASSERT_EQ(filtered[i].count, packet.count);
      }
      entering += must.size();
      kept += filtered.size();
      all += packets.packets().size();
    }
  }
  EXPECT_GT(entering, 200u);
  // And it leaves out most of the others.
  EXPECT_LT(kept - entering, (all - entering) / 2);
}

// A point on a ray that lies in the cone's side, or at the ray's end: rounding must not leave it out.
void PointsOnTheOutermostRaysAreKept() {
  Random random(6);
  for (int round = 0; round < 300; ++round) {
    auto rays = RaysFromAPoint(random, 3, std::exp2(random.Uniform(-12, 0)));
    for (Ray& ray : rays) ray.tfar = random.Uniform(1, 2);
    Packets packets(rays);
    for (const Ray& ray : rays) {
      Box box = Box::Empty();
      float point[3];
      for (size_t axis = 0; axis < 3; ++axis) point[axis] = ray.org[axis] + ray.tfar * ray.dir[axis];
      box.Extend(point);
      ASSERT_EQ(packets.Filter(box).size(), 1u) << "round " << round;
    }
  }
}

void PacketsWhoseRaysAreDoneAreLeftOut() {
  Random random(3);
  Packets packets(RaysFromAPoint(random, 200, 0.2f));
  const Box everything{{-9, -9, -9, 0}, {9, 9, 9, 0}};
  EXPECT_EQ(packets.Filter(everything).size(), packets.packets().size());
  // The second one: blocked any-hit rays.
  for (size_t slot = 64; slot < 128; ++slot) packets.batch().tfar[slot] = -unit::kInfinity;
  for (const RayBlock& packet : packets.packets()) {
    UpdateReach(packets.batch(), packet, packets.batch().cones);
  }
  const auto filtered = packets.Filter(everything);
  ASSERT_EQ(filtered.size(), packets.packets().size() - 1);
  EXPECT_EQ(filtered[1].begin, 128u);
}

void RaysWithoutDirectionAndConesOfAllDirectionsAreKept() {
  Random random(4);
  const Box box{{1, 1, 1, 0}, {2, 2, 2, 0}};
  auto rays = RaysFromAPoint(random, 64, 0.1f);
  for (Ray& ray : rays) ray.org = {1.5f, 1.5f, 1.5f};
  rays[7].dir = {0, 0, 0};
  EXPECT_EQ(Packets(rays).Filter(box).size(), 1u);
  for (size_t i = 0; i < rays.size(); ++i) {
    rays[i].dir = {i % 2 ? 1.0f : -1.0f, 0, 0};  // they cancel: no axis
  }
  EXPECT_EQ(Packets(rays).Filter(box).size(), 1u);
}

void CommonOriginIsExact() {
  Random random(5);
  auto rays = RaysFromAPoint(random, 100, 0.3f);
  {
    Packets packets(rays);
    EXPECT_TRUE(HaveCommonOrigin(packets.batch(), packets.block()));
  }
  rays[99].org[1] = std::nextafter(rays[99].org[1], 9.0f);
  Packets packets(rays);
  EXPECT_FALSE(HaveCommonOrigin(packets.batch(), packets.block()));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(ConicPacketsTest);
HWY_EXPORT_AND_TEST_P(ConicPacketsTest, PacketsAreConsecutiveRays);
HWY_EXPORT_AND_TEST_P(ConicPacketsTest, NeverLeavesOutARayThatEnters);
HWY_EXPORT_AND_TEST_P(ConicPacketsTest, PointsOnTheOutermostRaysAreKept);
HWY_EXPORT_AND_TEST_P(ConicPacketsTest, PacketsWhoseRaysAreDoneAreLeftOut);
HWY_EXPORT_AND_TEST_P(ConicPacketsTest, RaysWithoutDirectionAndConesOfAllDirectionsAreKept);
HWY_EXPORT_AND_TEST_P(ConicPacketsTest, CommonOriginIsExact);

}  // namespace dacrt
#endif  // HWY_ONCE

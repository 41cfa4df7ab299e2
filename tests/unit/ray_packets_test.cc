#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ray_packets_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "paper/box_test-inl.h"
#include "rays/ray_packets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BatchMemory;
using unit::Float3;
using unit::GuardedArray;
using unit::Random;
using unit::Ray;

/// A PacketBatch over guarded memory, which holds no packet yet.
class PacketMemory {
 public:
  explicit PacketMemory(size_t capacity)
      : floats_(14 * capacity, 64), indices_(capacity, 64), bits_(capacity / 8) {
    std::fill(floats_.begin(), floats_.end(), unit::kNaN);
    float* next = floats_.data();
    const auto cut = [&] {
      float* field = next;
      next += capacity;
      return field;
    };
    for (auto* fields : {packets.org_lower, packets.org_upper, packets.reciprocal_lower,
                         packets.reciprocal_upper}) {
      for (int axis = 0; axis < 3; ++axis) fields[axis] = cut();
    }
    packets.tnear = cut();
    packets.tfar = cut();
    packets.index = indices_.data();
    packets.capacity = capacity;
    packets.lane_bits = bits_.data();
    packets.bits_capacity = capacity / 8;
  }

  PacketBatch packets{};

 private:
  GuardedArray<float> floats_;
  GuardedArray<uint32_t> indices_;
  GuardedArray<uint8_t> bits_;
};

/// Rays and their packets.
struct Packed {
  explicit Packed(const std::vector<Ray>& rays)
      : memory(hwy::RoundUpTo(rays.size(), kMaxLanes) + kMaxLanes, rays.size()),
        packet_memory(hwy::RoundUpTo(hwy::DivCeil(rays.size(), kMaxLanes), kMaxLanes) + kMaxLanes),
        block(memory.Push(rays)),
        packet_block(MakeRayPackets(memory.batch, block, packet_memory.packets)) {}

  const RayBatch& batch() const { return memory.batch; }
  PacketBatch& packets() { return packet_memory.packets; }

  /// Whether the ray of one slot enters a box, tested alone.
  bool RayEnters(size_t slot, const WideBox& box) const {
    const size_t begin = slot / Lanes() * Lanes();
    const auto fields = LoadFields(Fields(memory.batch), begin);
    return Bits(Enters(IntersectFields(box, fields), fields[6], fields[7])) >> (slot - begin) & 1;
  }

  /// A bit for each packet of the vector that begins at `slot`.
  uint64_t PacketsEnter(size_t slot, const WideBox& box) const {
    const auto fields = LoadFields(Fields(packet_memory.packets), slot);
    return Bits(Enters(IntersectFields(box, fields), fields[12], fields[13]));
  }

  BatchMemory memory;
  PacketMemory packet_memory;
  RayBlock block;
  PacketBlock packet_block;
};

Box RandomBox(Random& random, const Float3& center) {
  Box box = Box::Empty();
  const float size = std::exp2(random.Uniform(-8, 1));
  for (int k = 0; k < 2; ++k) {
    Float3 corner = random.InCube(-size, size);
    for (size_t axis = 0; axis < 3; ++axis) corner[axis] += center[axis];
    if (k == 1 && random.Below(4) == 0) {
      const size_t flat = random.Below(3);
      corner[flat] = box.lower[flat];
    }
    box.Extend(corner.data());
  }
  return box;
}

/// Somewhere on one of the rays.
Float3 PointOn(Random& random, const std::vector<Ray>& rays) {
  const Ray& ray = rays[random.Below(static_cast<uint32_t>(rays.size()))];
  const float t = random.Uniform(0, 4);
  Float3 point;
  for (size_t axis = 0; axis < 3; ++axis) point[axis] = ray.org[axis] + t * ray.dir[axis];
  return point;
}

/// A beam: rays from about one point in about one direction.
std::vector<Ray> MakeBeam(Random& random, size_t count, float origins, float directions) {
  const Float3 from = random.InCube(-3, 3), along = random.Direction();
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    const Float3 org = random.InCube(-origins, origins);
    const Float3 dir = random.InCube(-directions, directions);
    const float length = std::exp2(random.Uniform(-3, 3));
    for (size_t axis = 0; axis < 3; ++axis) {
      ray.org[axis] = from[axis] + org[axis];
      ray.dir[axis] = (along[axis] + dir[axis]) * length;
    }
  }
  return rays;
}

/// Rays of one kind each; some with a limited interval, some inactive.
std::vector<Ray> MakeBatch(Random& random, int kind, size_t count) {
  std::vector<Ray> rays;
  switch (kind) {
    case 0:
      rays = MakeBeam(random, count, 0, 0.01f);
      break;
    case 1:
      rays = MakeBeam(random, count, 0.1f, 0.1f);
      break;
    case 2:  // about an axis, so that signs differ
      rays = MakeBeam(random, count, 0.01f, 0);
      for (Ray& ray : rays) {
        ray.dir = {random.Uniform(-0.01f, 0.01f), random.Uniform(-0.01f, 0.01f), 1};
      }
      break;
    case 3:  // along an axis, with zeros of both signs
      rays = MakeBeam(random, count, 0.3f, 0);
      for (Ray& ray : rays) {
        for (float& x : ray.dir) x = random.Below(2) == 0 ? 0.0f : -0.0f;
        ray.dir[1] = 1;
      }
      break;
    default:
      rays = unit::MakeRays(random, count, 2);
  }
  for (Ray& ray : rays) {
    if (random.Below(8) == 0) ray.tnear = random.Uniform(-1, 2);
    if (random.Below(8) == 0) ray.tfar = random.Uniform(0, 4);
    if (random.Below(32) == 0) ray.tfar = -unit::kInfinity;  // a blocked any-hit ray
  }
  return rays;
}

constexpr int kKinds = 5;

// The promise that lets packets stand for their rays; the last packet may hold any number of them.
void NeverMissesWhatARayEnters() {
  Random random(1);
  size_t entered = 0, missed = 0;
  for (int round = 0; round < 400; ++round) {
    const size_t count = 1 + random.Below(100);
    const auto rays = MakeBatch(random, round % kKinds, count);
    Packed packed(rays);
    ASSERT_EQ(packed.packet_block.begin, 0u);
    ASSERT_EQ(packed.packet_block.count, hwy::DivCeil(count, kMaxLanes));
    for (int k = 0; k < 50; ++k) {
      const Box box = RandomBox(random, k % 2 == 0 ? PointOn(random, rays) : random.InCube(-3, 3));
      const WideBox wide = Widen(box.lower, box.upper);
      for (size_t slot = 0; slot < count; ++slot) {
        if (!packed.RayEnters(slot, wide)) continue;
        ++entered;
        const size_t packet = slot / kMaxLanes, begin = packet / Lanes() * Lanes();
        ASSERT_TRUE(packed.PacketsEnter(begin, wide) >> (packet - begin) & 1)
            << "ray " << slot << " of " << count << " in round " << round;
      }
      for (size_t i = 0; i < packed.packet_block.count; i += Lanes()) {
        missed += packed.PacketsEnter(i, wide) == 0;
      }
    }
  }
  EXPECT_GT(entered, 10000u);
  EXPECT_GT(missed, 3000u) << "packets that enter everything would be of no use";
}

// Far from the origin and near, in units of every size: rounding goes the same way as for a ray.
void NeverMissesAtAnyScale() {
  Random random(2);
  size_t entered = 0;
  for (int round = 0; round < 400; ++round) {
    const float size = std::abs(random.AnyMagnitude(1e-15f, 1e15f));
    const Float3 place = random.InCube(-size * 1000, size * 1000);
    auto rays = MakeBeam(random, 32, 0.05f, 0.05f);
    Box box = RandomBox(random, random.InCube(-2, 2));
    // Aimed at the box, most of them at its faces and corners.
    const auto move = [&](float* x) {
      for (size_t axis = 0; axis < 3; ++axis) x[axis] = x[axis] * size + place[axis];
    };
    move(box.lower);
    move(box.upper);
    for (Ray& ray : rays) {
      move(ray.org.data());
      for (size_t axis = 0; axis < 3; ++axis) {
        const float target = random.Below(2) == 0 ? box.lower[axis] : box.upper[axis];
        ray.dir[axis] = target - ray.org[axis];
      }
      if (random.Below(2) == 0) ray.tfar = 1;
      if (random.Below(4) == 0) ray.tnear = 1;
    }
    Packed packed(rays);
    const WideBox wide = Widen(box.lower, box.upper);
    const uint64_t enter = packed.PacketsEnter(0, wide);
    const uint64_t second = Lanes() > 1 ? enter >> 1 : packed.PacketsEnter(1, wide);
    for (size_t slot = 0; slot < 32; ++slot) {
      if (!packed.RayEnters(slot, wide)) continue;
      ++entered;
      ASSERT_TRUE((slot < kMaxLanes ? enter : second) & 1) << "round " << round;
    }
  }
  EXPECT_GT(entered, 4000u);
}

// What stands behind the last ray and the last packet has no part in anything.
void LanesWithoutRaysDoNotCount() {
  Random random(3);
  for (size_t count = 1; count <= 70; ++count) {
    const auto rays = MakeBeam(random, count, 0.1f, 0.1f);
    BatchMemory memory(hwy::RoundUpTo(count, kMaxLanes) + kMaxLanes, count);
    const RayBlock block = memory.Push(rays);
    for (size_t slot = count; slot < hwy::RoundUpTo(count, kMaxLanes); ++slot) {
      for (int axis = 0; axis < 3; ++axis) {
        memory.batch.org[axis][slot] = slot % 2 ? unit::kNaN : 1e30f;
        memory.batch.dir[axis][slot] = slot % 2 ? -unit::kInfinity : 0;
      }
    }
    PacketMemory packets(kMaxLanes * 2);
    MakeRayPackets(memory.batch, block, packets.packets);
    for (size_t packet = 0; packet * kMaxLanes < count; ++packet) {
      for (size_t axis = 0; axis < 3; ++axis) {
        float org[2] = {unit::kInfinity, -unit::kInfinity}, dir[2] = {org[0], org[1]};
        for (size_t i = packet * kMaxLanes; i < std::min(count, (packet + 1) * kMaxLanes); ++i) {
          const float reciprocal = 1 / rays[i].dir[axis];
          org[0] = std::min(org[0], rays[i].org[axis]);
          org[1] = std::max(org[1], rays[i].org[axis]);
          dir[0] = std::min(dir[0], reciprocal);
          dir[1] = std::max(dir[1], reciprocal);
        }
        ASSERT_EQ(packets.packets.org_lower[axis][packet], org[0]) << count;
        ASSERT_EQ(packets.packets.org_upper[axis][packet], org[1]);
        ASSERT_EQ(packets.packets.reciprocal_lower[axis][packet], dir[0]);
        ASSERT_EQ(packets.packets.reciprocal_upper[axis][packet], dir[1]);
      }
      ASSERT_EQ(packets.packets.tnear[packet], 0);
      ASSERT_EQ(packets.packets.tfar[packet], unit::kInfinity);
      ASSERT_EQ(packets.packets.index[packet], packet);
    }
    // The packets behind the last one are inactive; and all of them are taken.
    const size_t end = hwy::DivCeil(count, kMaxLanes);
    ASSERT_EQ(packets.packets.top, hwy::RoundUpTo(end, kMaxLanes));
    for (size_t packet = end; packet < packets.packets.top; ++packet) {
      ASSERT_LT(packets.packets.tfar[packet], packets.packets.tnear[packet]);
    }
  }
}

// A packet looks as far as the farthest of its rays still does, and not further.
void ReachFollowsTheRays() {
  Random random(4);
  for (const size_t count : {5u, 16u, 40u}) {
    Packed packed(MakeBeam(random, count, 0.1f, 0.1f));
    for (size_t packet = 0; packet < packed.packet_block.count; ++packet) {
      const RayBlock rays = RaysOf(packed.packets(), packet);
      ASSERT_EQ(rays.begin, packet * kMaxLanes);
      float farthest = -unit::kInfinity;
      for (size_t slot = rays.begin; slot < std::min(count, rays.begin + kMaxLanes); ++slot) {
        packed.memory.batch.tfar[slot] = random.Uniform(0, 10);
        farthest = std::max(farthest, packed.memory.batch.tfar[slot]);
      }
      UpdateReach(packed.batch(), packed.packets(), packet);
      ASSERT_EQ(packed.packets().tfar[packet], farthest);
      for (size_t slot = rays.begin; slot < std::min(count, rays.begin + kMaxLanes); ++slot) {
        packed.memory.batch.tfar[slot] = -unit::kInfinity;
      }
      UpdateReach(packed.batch(), packed.packets(), packet);
      ASSERT_LT(packed.packets().tfar[packet], 0) << "all blocked";
    }
  }
}

bool AreCoherentRays(const std::vector<Ray>& rays) {
  Packed packed(rays);
  const Box scene{{-2, -2, -2, 0}, {2, 2, 2, 0}};
  return AreCoherent(packed.packets(), packed.packet_block, scene);
}

// Rays as a camera makes them, line by line or in tiles; those to a light; and those that a matt
// wall sends out.
void ACameraIsCoherentAndDiffuseRaysAreNot() {
  Random random(5);
  constexpr size_t kCount = 4096;
  std::vector<Ray> lines(kCount), tiles(kCount), along(kCount), mixed(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    const auto aim = [](size_t x, size_t y) {
      return Float3{(static_cast<float>(x) - 31.5f) / 512, (static_cast<float>(y) - 31.5f) / 512,
                    1};
    };
    lines[i] = unit::MakeRay({0, 0, -4}, aim(i % 64, i / 64));
    tiles[i] = unit::MakeRay({0, 0, -4}, aim(i / 16 % 16 * 4 + i % 4, i / 256 * 4 + i / 4 % 4));
    along[i] = unit::MakeRay({static_cast<float>(i) * 1e-4f, 0, -4}, {0, 0, 1});
    mixed[i] = i % 16 < 15 ? tiles[i] : unit::MakeRays(random, 1, 2)[0];
  }
  EXPECT_TRUE(AreCoherentRays(lines));
  EXPECT_TRUE(AreCoherentRays(tiles));
  EXPECT_TRUE(AreCoherentRays(along)) << "signs of zeros must not count as width";
  EXPECT_FALSE(AreCoherentRays(mixed));
  EXPECT_FALSE(AreCoherentRays(unit::MakeRays(random, kCount, 2)));
  auto from_a_point = unit::MakeRays(random, kCount, 2);
  for (Ray& ray : from_a_point) ray.org = {0, 0, 0};
  EXPECT_FALSE(AreCoherentRays(from_a_point));
  // Parallel, but from all over the scene.
  auto parallel = unit::MakeRays(random, kCount, 2);
  for (Ray& ray : parallel) ray.dir = {0.5f, 0.25f, 1};
  EXPECT_FALSE(AreCoherentRays(parallel));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(RayPacketsTest);
HWY_EXPORT_AND_TEST_P(RayPacketsTest, NeverMissesWhatARayEnters);
HWY_EXPORT_AND_TEST_P(RayPacketsTest, NeverMissesAtAnyScale);
HWY_EXPORT_AND_TEST_P(RayPacketsTest, LanesWithoutRaysDoNotCount);
HWY_EXPORT_AND_TEST_P(RayPacketsTest, ReachFollowsTheRays);
HWY_EXPORT_AND_TEST_P(RayPacketsTest, ACameraIsCoherentAndDiffuseRaysAreNot);

}  // namespace dacrt
#endif  // HWY_ONCE

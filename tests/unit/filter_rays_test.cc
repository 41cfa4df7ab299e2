#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filter_rays_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/box.h"
#include "paper/filter_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

std::optional<FilteredRays> FilterByBox(RayBatch& batch, std::span<const RayBlock> parents,
                                        const Box& box) {
  return FilterRays(batch, parents, Widen(box.lower, box.upper));
}
namespace {

using unit::BatchMemory;
using unit::Random;
using unit::Ray;

Box RandomBox(Random& random, float size) {
  Box box = Box::Empty();
  for (int k = 0; k < 2; ++k) box.Extend(random.InCube(-size, size).data());
  return box;
}

/// Rays of which some share enters a box of about the size of the cube from which they come.
std::vector<Ray> RandomRays(Random& random, size_t count) {
  std::vector<Ray> rays = unit::MakeRays(random, count, 2);
  for (Ray& ray : rays) {
    if (random.Below(3) == 0) ray.tnear = random.Uniform(-1, 1);
    if (random.Below(3) == 0) ray.tfar = random.Uniform(1, 3);
    if (random.Below(16) == 0) ray.dir[random.Below(3)] = random.Next() & 1 ? 0.0f : -0.0f;
    if (random.Below(16) == 0) ray.tfar = -unit::kInfinity;  // a blocked any-hit ray
  }
  return rays;
}

/// The ray of one slot, tested alone (ray_box_test.cc compares that test with double precision).
bool EntersAlone(const RayBatch& batch, size_t slot, const Box& box) {
  V org[3], reciprocal[3];
  for (int axis = 0; axis < 3; ++axis) {
    org[axis] = hn::Set(kFloat, batch.org[axis][slot]);
    reciprocal[axis] = SafeReciprocal(hn::Set(kFloat, batch.dir[axis][slot]));
  }
  const Interval interval = IntersectBox(Widen(box.lower, box.upper), org, reciprocal);
  return Bits(Enters(interval, hn::Set(kFloat, batch.tnear[slot]),
                     hn::Set(kFloat, batch.tfar[slot]))) &
         1;
}

std::span<const RayBlock> One(const RayBlock& block) { return {&block, 1}; }

bool SameFloat(float a, float b) { return memcmp(&a, &b, sizeof(a)) == 0; }

void ExpectSameRay(const RayBatch& batch, size_t a, size_t b) {
  for (int axis = 0; axis < 3; ++axis) {
    ASSERT_TRUE(SameFloat(batch.org[axis][a], batch.org[axis][b]));
    ASSERT_TRUE(SameFloat(batch.dir[axis][a], batch.dir[axis][b]));
  }
  ASSERT_TRUE(SameFloat(batch.tnear[a], batch.tnear[b]));
  ASSERT_TRUE(SameFloat(batch.tfar[a], batch.tfar[b]));
  ASSERT_EQ(batch.index[a], batch.index[b]);
}

/// Slots of `parent` whose rays enter `box`, in order.
std::vector<size_t> Survivors(const RayBatch& batch, const RayBlock& parent, const Box& box) {
  std::vector<size_t> survivors;
  for (size_t slot = parent.begin; slot < parent.begin + parent.count; ++slot) {
    if (EntersAlone(batch, slot, box)) survivors.push_back(slot);
  }
  return survivors;
}

void ExpectFiltered(const RayBatch& batch, const FilteredRays& filtered,
                    const std::vector<size_t>& survivors) {
  ASSERT_EQ(filtered.block.begin % kMaxLanes, 0u);
  ASSERT_EQ(filtered.block.count, survivors.size());
  for (size_t i = 0; i < survivors.size(); ++i) {
    ExpectSameRay(batch, filtered.block.begin + i, survivors[i]);
  }
  // A full vector may be read from the last ray's on: what is behind it must be inactive.
  const size_t end = filtered.block.begin + filtered.block.count;
  for (size_t slot = end; slot < hwy::RoundUpTo(end, kMaxLanes); ++slot) {
    ASSERT_GT(batch.tnear[slot], batch.tfar[slot]);
  }
  ASSERT_GE(batch.top, end);
  ASSERT_LE(batch.top, batch.capacity);
}

void KeepsSurvivorsInOrder() {
  Random random(1);
  size_t kept = 0, removed = 0;
  for (size_t count = 0; count <= 70; ++count) {
    for (int round = 0; round < 10; ++round) {
      const Box box = RandomBox(random, 2);
      BatchMemory memory(512, count);
      RayBatch& batch = memory.batch;
      memory.Push(RandomRays(random, 0));
      const RayBlock parent = memory.Push(RandomRays(random, count));
      const auto survivors = Survivors(batch, parent, box);
      const auto filtered = FilterByBox(batch, One(parent), box);
      ASSERT_TRUE(filtered.has_value());
      ExpectFiltered(batch, *filtered, survivors);
      kept += survivors.size();
      removed += count - survivors.size();
    }
  }
  EXPECT_GT(kept, 2000u);
  EXPECT_GT(removed, 3000u);
}

void AllOrNoneSurvive() {
  Random random(2);
  const Box all{{-9, -9, -9, 0}, {9, 9, 9, 0}}, none{{50, 50, 50, 0}, {51, 51, 51, 0}};
  for (size_t count = 0; count <= 70; ++count) {
    BatchMemory memory(512, count);
    auto rays = unit::MakeRays(random, count, 2);
    for (Ray& ray : rays) ray.tfar = 20;
    const RayBlock parent = memory.Push(rays);
    for (const Box& box : {all, none}) {
      const auto filtered = FilterByBox(memory.batch, One(parent), box);
      ASSERT_TRUE(filtered.has_value());
      ASSERT_EQ(filtered->block.count, box.lower[0] < 0 ? count : 0);
      ExpectFiltered(memory.batch, *filtered, Survivors(memory.batch, parent, box));
      ReturnDistances(memory.batch, One(parent), *filtered);
    }
  }
}

// What the child found goes to the rays that it had, and the others keep theirs.
void DistancesComeBackThroughTheBits() {
  Random random(3);
  for (size_t count = 0; count <= 70; ++count) {
    const Box box = RandomBox(random, 2);
    BatchMemory memory(512, count);
    RayBatch& batch = memory.batch;
    const RayBlock parent = memory.Push(RandomRays(random, count));
    const size_t top = batch.top, bits_top = batch.bits_top;
    std::vector<float> expected(batch.tfar + parent.begin, batch.tfar + parent.begin + count);
    const auto filtered = FilterByBox(batch, One(parent), box);
    ASSERT_TRUE(filtered.has_value());
    for (size_t i = 0; i < filtered->block.count; ++i) {
      const size_t slot = filtered->block.begin + i;
      if (random.Below(3) == 0) continue;
      batch.tfar[slot] = random.Below(4) == 0 ? -unit::kInfinity : random.Uniform(0, 1);
      expected[batch.index[slot]] = batch.tfar[slot];
    }
    ReturnDistances(batch, One(parent), *filtered);
    for (size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(SameFloat(batch.tfar[parent.begin + i], expected[i])) << i << " of " << count;
    }
    ASSERT_EQ(batch.top, top);
    ASSERT_EQ(batch.bits_top, bits_top);
  }
}

/// As the recursion does: filters `parent` by ever smaller boxes, at each level shortens some rays,
/// and gives everything back. Writes what each ray must have in the end to `expected`.
void FilterDeeper(Random& random, RayBatch& batch, const RayBlock& parent, int depth,
                  std::vector<float>& expected) {
  if (depth == 0 || parent.count == 0) return;
  const size_t top = batch.top, bits_top = batch.bits_top;
  for (int child = 0; child < 2; ++child) {
    const Box box = RandomBox(random, 2);
    const auto survivors = Survivors(batch, parent, box);
    const auto filtered = FilterByBox(batch, One(parent), box);
    ASSERT_TRUE(filtered.has_value());
    ExpectFiltered(batch, *filtered, survivors);
    FilterDeeper(random, batch, filtered->block, depth - 1, expected);
    for (size_t i = 0; i < filtered->block.count; ++i) {
      const size_t slot = filtered->block.begin + i;
      if (random.Below(4) != 0) continue;
      batch.tfar[slot] *= 0.75f;
      expected[batch.index[slot]] = batch.tfar[slot];
    }
    ReturnDistances(batch, One(parent), *filtered);
    ASSERT_EQ(batch.top, top);
    ASSERT_EQ(batch.bits_top, bits_top);
    for (size_t i = 0; i < parent.count; ++i) {
      ASSERT_TRUE(SameFloat(batch.tfar[parent.begin + i], expected[batch.index[parent.begin + i]]));
    }
  }
}

void NestsAsTheRecursionDoes() {
  Random random(4);
  for (const size_t count : {1u, 7u, 16u, 33u, 250u}) {
    BatchMemory memory(4096, count);
    const auto rays = RandomRays(random, count);
    std::vector<float> expected;
    for (const Ray& ray : rays) expected.push_back(ray.tfar);
    FilterDeeper(random, memory.batch, memory.Push(rays), 4, expected);
  }
}

// With any capacity it either does all or leaves the stack as it was, and it never writes outside
// the arrays, which end at a guard page.
void WhatDoesNotFitLeavesTheStackAsItWas() {
  Random random(5);
  size_t done = 0, refused = 0;
  for (const size_t count : {1u, 15u, 16u, 17u, 40u, 64u, 70u}) {
    const size_t parent_slots = hwy::RoundUpTo(count, kMaxLanes);
    for (size_t capacity = parent_slots + kMaxLanes; capacity < parent_slots + 128;
         capacity += kMaxLanes) {
      for (int round = 0; round < 20; ++round) {
        const Box box = RandomBox(random, round % 4 == 0 ? 20.0f : 2.0f);
        BatchMemory memory(capacity, count);
        RayBatch& batch = memory.batch;
        const RayBlock parent = memory.Push(RandomRays(random, count));
        std::vector<float> tfar(batch.tfar, batch.tfar + count);
        const auto survivors = Survivors(batch, parent, box);
        const size_t top = batch.top, bits_top = batch.bits_top;
        const auto filtered = FilterByBox(batch, One(parent), box);
        if (filtered) {
          ++done;
          ExpectFiltered(batch, *filtered, survivors);
          ReturnDistances(batch, One(parent), *filtered);
        } else {
          ++refused;
        }
        ASSERT_EQ(batch.top, top);
        ASSERT_EQ(batch.bits_top, bits_top);
        ASSERT_EQ(Survivors(batch, parent, box), survivors);
        for (size_t i = 0; i < count; ++i) ASSERT_TRUE(SameFloat(batch.tfar[i], tfar[i]));
      }
    }
  }
  EXPECT_GT(done, 100u);
  EXPECT_GT(refused, 100u);
}

// The rays of several blocks become one, in order, and each block gets its distances back.
void SeveralParentsBecomeOneBlock() {
  Random random(8);
  for (int round = 0; round < 100; ++round) {
    const Box box = RandomBox(random, 2);
    BatchMemory memory(1024, 70);
    RayBatch& batch = memory.batch;
    std::vector<RayBlock> parents;
    std::vector<size_t> survivors;
    for (uint32_t k = random.Below(5); k > 0; --k) {
      parents.push_back(memory.Push(RandomRays(random, 1 + random.Below(70))));
      for (const size_t slot : Survivors(batch, parents.back(), box)) survivors.push_back(slot);
    }
    const std::vector<float> before(batch.tfar, batch.tfar + batch.top);
    const auto filtered = FilterByBox(batch, parents, box);
    ASSERT_TRUE(filtered.has_value());
    ExpectFiltered(batch, *filtered, survivors);
    for (size_t i = 0; i < survivors.size(); ++i) {
      batch.tfar[filtered->block.begin + i] = static_cast<float>(i);
    }
    ReturnDistances(batch, parents, *filtered);
    size_t next = 0;
    for (size_t slot = 0; slot < before.size(); ++slot) {
      const bool survived = next < survivors.size() && survivors[next] == slot;
      ASSERT_TRUE(SameFloat(batch.tfar[slot], survived ? static_cast<float>(next) : before[slot]));
      next += survived;
    }
    ASSERT_EQ(next, survivors.size());
  }
}

void WithoutRoomForTheBitsTheStackStays() {
  Random random(6);
  const Box box{{-9, -9, -9, 0}, {9, 9, 9, 0}};
  BatchMemory memory(512, 70);
  RayBatch& batch = memory.batch;
  const RayBlock parent = memory.Push(unit::MakeRays(random, 70, 2));
  const size_t top = batch.top;
  batch.bits_capacity = 2 * ((70 + kMaxLanes - 1) / kMaxLanes * kMaxLanes / 8);
  batch.bits_top = 0;
  ASSERT_TRUE(FilterByBox(batch, One(parent), box).has_value());
  const size_t first_top = batch.top;
  batch.bits_top = batch.bits_capacity - 1;
  EXPECT_FALSE(FilterByBox(batch, One(parent), box).has_value());
  EXPECT_EQ(batch.top, first_top);
  EXPECT_GT(first_top, top);
  EXPECT_EQ(batch.bits_top, batch.bits_capacity - 1);
}

// Lanes behind the last ray hold whatever the arena held, NaNs and infinities included.
void InactiveLanesNeverSurvive() {
  Random random(7);
  const Box everything{{-1e18f, -1e18f, -1e18f, 0}, {1e18f, 1e18f, 1e18f, 0}};
  const float junk[] = {unit::kNaN, unit::kInfinity, -unit::kInfinity, 0.0f, 3.4e38f};
  for (size_t count = 1; count <= 33; ++count) {
    BatchMemory memory(256, count);
    const RayBlock parent = memory.Push(unit::MakeRays(random, count, 2));
    for (size_t slot = count; slot < 64; ++slot) {
      for (int axis = 0; axis < 3; ++axis) {
        memory.batch.org[axis][slot] = junk[random.Below(5)];
        memory.batch.dir[axis][slot] = junk[random.Below(5)];
      }
    }
    const auto filtered = FilterByBox(memory.batch, One(parent), everything);
    ASSERT_TRUE(filtered.has_value());
    ASSERT_EQ(filtered->block.count, count);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(FilterRaysTest);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, KeepsSurvivorsInOrder);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, AllOrNoneSurvive);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, DistancesComeBackThroughTheBits);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, NestsAsTheRecursionDoes);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, WhatDoesNotFitLeavesTheStackAsItWas);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, SeveralParentsBecomeOneBlock);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, WithoutRoomForTheBitsTheStackStays);
HWY_EXPORT_AND_TEST_P(FilterRaysTest, InactiveLanesNeverSurvive);

}  // namespace dacrt
#endif  // HWY_ONCE

// The way from the caller's records into a batch. The way back is in store_hits_test.cc.

#include <gtest/gtest.h>

#include "unit_test.h"

namespace dacrt {
namespace {

using unit::BatchMemory;
using unit::GuardedArray;
using unit::kInfinity;
using unit::kNaN;
using unit::Mesh;
using unit::Random;
using unit::Ray;

constexpr std::size_t kCapacity = 256;

GeometryTable TableWithMask(uint32_t mask) {
  TriangleMesh mesh;
  mesh.mask = mask;
  return GeometryTable({&mesh, 1});
}

RayBlock Load(const RayView& view, BatchMemory& memory, std::size_t first, std::size_t count,
              uint32_t mesh_mask = UINT32_MAX) {
  return LoadRays(view, first, count, Query::kClosest, TableWithMask(mesh_mask), memory.batch);
}

void ExpectRay(const RayBatch& batch, std::size_t slot, const Ray& ray) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(batch.org[axis][slot], ray.org[axis]);
    EXPECT_EQ(batch.dir[axis][slot], ray.dir[axis]);
  }
  EXPECT_EQ(batch.tnear[slot], ray.tnear);
  EXPECT_EQ(batch.tfar[slot], ray.tfar);
}

TEST(LoadRaysTest, CopiesActiveRaysInOrder) {
  Random random(1);
  for (std::size_t count = 1; count <= 70; ++count) {
    auto rays = unit::MakeRays(random, count, 2);
    std::vector<uint32_t> active;
    for (std::size_t i = 0; i < count; ++i) {
      if (random.Below(3) == 0) {
        rays[i].tfar = -1;
      } else {
        active.push_back(static_cast<uint32_t>(i));
      }
    }
    const auto before = rays;
    BatchMemory memory(kCapacity, count);
    const RayBlock block = Load(ViewOf(rays), memory, 0, count);
    ASSERT_EQ(block.begin, 0u);
    ASSERT_EQ(block.count, active.size());
    for (std::size_t slot = 0; slot < block.count; ++slot) {
      ASSERT_EQ(memory.batch.index[slot], active[slot]);
      ExpectRay(memory.batch, slot, rays[active[slot]]);
      EXPECT_EQ(memory.batch.hits[active[slot]].geometry, PaperHit::kNone);
    }
    for (std::size_t slot = block.count; slot < block.count + kMaxLanes; ++slot) {
      EXPECT_GT(memory.batch.tnear[slot], memory.batch.tfar[slot]);
    }
    EXPECT_EQ(memory.batch.top % kMaxLanes, 0u);
    EXPECT_GE(memory.batch.top, block.count);
    for (std::size_t i = 0; i < count; ++i) EXPECT_TRUE(SameBits(rays[i], before[i]));
  }
}

TEST(LoadRaysTest, PiecesCountFromTheirFirstRay) {
  Random random(2);
  auto rays = unit::MakeRays(random, 100, 2);
  BatchMemory memory(kCapacity, 30);
  const RayBlock block = Load(ViewOf(rays), memory, 60, 30);
  ASSERT_EQ(block.count, 30u);
  for (std::size_t slot = 0; slot < 30; ++slot) {
    EXPECT_EQ(memory.batch.index[slot], slot);
    ExpectRay(memory.batch, slot, rays[60 + slot]);
  }
}

bool IsLoaded(const Ray& ray) {
  std::vector<Ray> rays = {ray};
  BatchMemory memory(kCapacity, 1);
  return Load(ViewOf(rays), memory, 0, 1).count == 1;
}

TEST(LoadRaysTest, InactiveIsWhatRayViewSays) {
  const Ray good = unit::MakeRay({0, 0, 0}, {1, 0, 0});
  EXPECT_TRUE(IsLoaded(good));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float bad : {kNaN, kInfinity, -kInfinity}) {
      Ray ray = good;
      ray.org[axis] = bad;
      EXPECT_FALSE(IsLoaded(ray));
      ray = good;
      ray.dir[axis] = bad;
      EXPECT_FALSE(IsLoaded(ray));
      // Two infinities of opposite sign must not cancel.
      ray.org[(axis + 1) % 3] = -bad;
      EXPECT_FALSE(IsLoaded(ray));
    }
  }
  // Finite components whose sum overflows are finite.
  EXPECT_TRUE(IsLoaded(unit::MakeRay({3e38f, 3e38f, 3e38f}, {3e38f, -3e38f, -3e38f})));
  EXPECT_TRUE(IsLoaded(unit::MakeRay({0, 0, 0}, {0, 0, 0}))) << "a direction may be zero";

  const auto with = [&](float tnear, float tfar) {
    Ray ray = good;
    ray.tnear = tnear;
    ray.tfar = tfar;
    return IsLoaded(ray);
  };
  EXPECT_TRUE(with(1, 1));
  EXPECT_TRUE(with(-1, 0));
  EXPECT_TRUE(with(-kInfinity, kInfinity));
  EXPECT_TRUE(with(-1, -0.0f));
  EXPECT_TRUE(with(kInfinity, kInfinity));
  EXPECT_FALSE(with(1, std::nextafter(1.0f, 0.0f)));
  EXPECT_FALSE(with(-2, -1)) << "tfar is negative";
  EXPECT_FALSE(with(0, -kInfinity));
  EXPECT_FALSE(with(kNaN, 1));
  EXPECT_FALSE(with(0, kNaN));
}

TEST(LoadRaysTest, MasksAreKeptOnlyWhereTheyDecideSomething) {
  Random random(3);
  auto rays = unit::MakeRays(random, 3, 2);
  rays[0].mask = 0b0110;
  rays[1].mask = 0;
  rays[2].mask = 0b0111;
  const auto decides = [&](uint32_t mesh_mask) {
    BatchMemory memory(kCapacity, 3);
    EXPECT_EQ(Load(ViewOf(rays), memory, 0, 3, mesh_mask).count, 2u) << "a mask of 0 meets nothing";
    if (!memory.batch.ray_masks) return false;
    EXPECT_EQ(memory.batch.ray_masks[0], 0b0110u);
    EXPECT_EQ(memory.batch.ray_masks[2], 0b0111u);
    return true;
  };
  EXPECT_FALSE(decides(UINT32_MAX));
  EXPECT_FALSE(decides(0b0010)) << "both rays meet the mesh";
  EXPECT_TRUE(decides(0b0001));
  EXPECT_TRUE(decides(0b1000));
  EXPECT_TRUE(decides(0));
}

TEST(LoadRaysTest, AbsentComponentsHaveTheirDefaults) {
  Random random(4);
  auto rays = unit::MakeRays(random, 5, 2);
  for (Ray& ray : rays) {
    ray.tnear = 5;
    ray.mask = 0;
  }
  RayView view = ViewOf(rays);
  view.tnear = view.mask = RayView::kAbsent;
  BatchMemory memory(kCapacity, 5);
  ASSERT_EQ(Load(view, memory, 0, 5, 1).count, 5u);
  for (std::size_t slot = 0; slot < 5; ++slot) EXPECT_EQ(memory.batch.tnear[slot], 0);
  EXPECT_EQ(memory.batch.ray_masks, nullptr);
}

TEST(LoadRaysTest, NoRays) {
  std::vector<Ray> rays(1);
  rays[0].tfar = -1;
  BatchMemory memory(kCapacity, 1);
  EXPECT_EQ(Load(ViewOf(rays), memory, 0, 1).count, 0u);
  EXPECT_EQ(Load(ViewOf(rays), memory, 0, 0).count, 0u);
}

/// The same rays in another layout, with memory that ends at a guard page.
struct Layout {
  std::size_t lanes;
  bool by_pointers;
};

class LoadRaysLayoutTest : public testing::TestWithParam<Layout> {};

// Packets of SoA lanes, consecutive or through a table of pointers; the last one may be partly
// used.
TEST_P(LoadRaysLayoutTest, ReadsTheRightLanes) {
  constexpr std::size_t kComponents = 9;
  const auto [lanes, by_pointers] = GetParam();
  Random random(5);
  for (const std::size_t count : {1u, 5u, 16u, 37u}) {
    const auto rays = unit::MakeRays(random, count, 2);
    const std::size_t packets = (count + lanes - 1) / lanes;
    const std::size_t packet_floats = kComponents * lanes;
    GuardedArray<float> memory(packets * packet_floats);
    std::fill(memory.begin(), memory.end(), kNaN);
    std::vector<const void*> table(packets);
    for (std::size_t p = 0; p < packets; ++p) {
      // In the table packets stand in reverse order, so that addresses do not rise.
      table[p] = memory.data() + (by_pointers ? packets - 1 - p : p) * packet_floats;
    }
    for (std::size_t i = 0; i < count; ++i) {
      float* lane = static_cast<float*>(const_cast<void*>(table[i / lanes])) + i % lanes;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lane[axis * lanes] = rays[i].org[axis];
        lane[(3 + axis) * lanes] = rays[i].dir[axis];
      }
      lane[6 * lanes] = rays[i].tnear;
      lane[7 * lanes] = rays[i].tfar;
      std::memcpy(lane + 8 * lanes, &rays[i].mask, sizeof(float));
    }
    RayView view;
    view.count = count;
    view.lanes = lanes;
    view.lane_stride = sizeof(float);
    view.packet_stride = packet_floats * sizeof(float);
    if (by_pointers) view.packets = table.data();
    const RayView::Component start =
        by_pointers ? 0 : reinterpret_cast<RayView::Component>(memory.data());
    RayView::Component* const components[kComponents] = {&view.org_x, &view.org_y, &view.org_z,
                                                         &view.dir_x, &view.dir_y, &view.dir_z,
                                                         &view.tnear, &view.tfar,  &view.mask};
    for (std::size_t c = 0; c < kComponents; ++c) {
      *components[c] = start + c * lanes * sizeof(float);
    }
    BatchMemory batch(kCapacity, count);
    ASSERT_EQ(Load(view, batch, 0, count).count, count);
    for (std::size_t i = 0; i < count; ++i) ExpectRay(batch.batch, i, rays[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Layouts, LoadRaysLayoutTest,
                         testing::Values(Layout{1, false}, Layout{1, true}, Layout{4, false},
                                         Layout{5, true}, Layout{16, false}, Layout{16, true},
                                         Layout{37, false}),
                         [](const auto& info) {
                           return std::to_string(info.param.lanes) +
                                  (info.param.by_pointers ? "LanesByPointer" : "Lanes");
                         });

}  // namespace
}  // namespace dacrt

#include <vector>

#include "leaf/make_leaf.h"
#include "partition/kept_partition.h"
#include "step_bench.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cross_facets_bench.cc"
#include <hwy/foreach_target.h>

#include "leaf/cross_facets-inl.h"
#include "rays/load_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

constexpr size_t kRays = 1024;

/// A leaf of eight triangles in a row, neighbours of which share two vertices, and rays that come
/// from above to somewhere about them.
struct LeafAndRays {
  LeafAndRays() : blocks(kMostLeafBytes, 64) {
    unit::Random random(1);
    unit::Mesh mesh;
    for (uint32_t i = 0; i < 10; ++i) {
      mesh.vertices.push_back({0.25f * i - 1, i % 2 ? 0.5f : -0.5f, random.Uniform(-0.1f, 0.1f)});
    }
    for (uint32_t i = 0; i < 8; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
    const GeometryTable table(std::vector{mesh.View()});
    std::vector<uint32_t> order;
    for (uint32_t i = 0; i < 8; ++i) order.push_back(table.Number(0, i));
    order.back() |= KeptOrder::kLastOfLeaf;
    const LeafItems items = FindItems(table, order.data(), 0, kLeafLanes);
    MakeLeaf(table, items, 0, SharedVertices::kFind, blocks.data());
    for (size_t i = 0; i < kRays; ++i) {
      const unit::Float3 org = random.InCube(-1, 1), to = random.InCube(-1, 1);
      RayRecord ray{};
      for (size_t axis = 0; axis < 3; ++axis) {
        ray.org[axis] = axis == 2 ? 3 : org[axis];
        ray.dir[axis] = (axis == 2 ? 0 : to[axis]) - ray.org[axis];
      }
      ray.tfar = unit::kInfinity;
      ray.mask = UINT32_MAX;
      FinishRecord(ray);
      rays.push_back(ray);
    }
  }

  const LeafBlock& block() const { return *reinterpret_cast<const LeafBlock*>(blocks.data()); }

  unit::GuardedArray<std::byte> blocks;
  std::vector<RayRecord> rays;
};

/// Rays that come one by one: each reads the leaf anew.
void CrossOne(benchmark::State& state) {
  const LeafAndRays leaf;
  for (auto _ : state) {
    uint64_t lanes = 0;
    for (const RayRecord& ray : leaf.rays) {
      for (size_t part = 0; part < kParts; ++part) {
        const LeafCorners<CornerLayout::kFew> corners{leaf.block(), part};
        lanes += CrossFacets<false>(SpreadRay{ray}, corners.Triangles(), corners.Again()).lanes;
      }
    }
    benchmark::DoNotOptimize(lanes);
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * kRays));
}

/// A list of rays, for which it is read once.
void CrossList(benchmark::State& state) {
  const LeafAndRays leaf;
  for (auto _ : state) {
    uint64_t lanes = 0;
    for (size_t part = 0; part < kParts; ++part) {
      const CornerLanes corners = DecodeCorners(leaf.block(), part);
      const auto triangles = corners.Triangles();
      for (const RayRecord& ray : leaf.rays) {
        lanes += CrossFacets<false>(SpreadRay{ray}, triangles, corners).lanes;
      }
    }
    benchmark::DoNotOptimize(lanes);
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * kRays));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
DACRT_STEP_BENCHMARK("CrossFacets", CrossOne);
DACRT_STEP_BENCHMARK("CrossFacetsOfList", CrossList);
}  // namespace
}  // namespace dacrt
#endif

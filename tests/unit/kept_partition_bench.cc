#include <memory>
#include <numeric>
#include <vector>

#include "step_bench.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kept_partition_bench.cc"
#include <hwy/foreach_target.h>

#include "leaf/leaf_block.h"
#include "partition/split_subset-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

/// As many triangles as are split in one go.
void Split(benchmark::State& state, SplitRule rule) {
  constexpr size_t kCount = SubsetScratch::kTriangles;
  unit::Random random(1);
  const unit::Mesh mesh = unit::MakeSoup(random, kCount, 1, 0.1f);
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});
  const auto scratch = std::make_unique<SubsetScratch>();
  std::vector<uint32_t> order(kCount);
  for (auto _ : state) {
    std::iota(order.begin(), order.end(), 0u);
    benchmark::DoNotOptimize(SplitTriangles(table, kLeafLanes, 0, order, rule, *scratch));
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * kCount));
}
void SplitToRent(benchmark::State& state) { Split(state, SplitRule::kRent); }
void SplitToBuy(benchmark::State& state) { Split(state, SplitRule::kBuy); }
void SplitWithCare(benchmark::State& state) { Split(state, SplitRule::kCare); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
DACRT_STEP_BENCHMARK("SplitTriangles/rent", SplitToRent);
DACRT_STEP_BENCHMARK("SplitTriangles/buy", SplitToBuy);
DACRT_STEP_BENCHMARK("SplitTriangles/care", SplitWithCare);
}  // namespace
}  // namespace dacrt
#endif

#include <vector>

#include "step_bench.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ray_lists_bench.cc"
#include <hwy/foreach_target.h>

#include "trace/ray_lists-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

/// Lists in the middle of the recursion, of which a third enters a child.
void FilterLists(benchmark::State& state) {
  constexpr size_t kRays = 1024;
  unit::Random random(1);
  std::vector<RayNumber> list(kRays + kListSlack), out(kRays + kListSlack);
  std::vector<uint8_t> masks(kRays + kListSlack);
  for (size_t i = 0; i < kRays; ++i) {
    list[i] = static_cast<RayNumber>(i);
    for (size_t child = 0; child < 8; ++child) masks[i] |= (random.Below(3) == 0) << child;
  }
  size_t child = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(FilterList(list.data(), masks.data(), kRays, child, out.data()));
    benchmark::ClobberMemory();
    child = (child + 1) % 8;
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
DACRT_STEP_BENCHMARK("FilterList", FilterLists);
}  // namespace
}  // namespace dacrt
#endif

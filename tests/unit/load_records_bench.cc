#include <vector>

#include "forms.h"
#include "step_bench.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "load_records_bench.cc"
#include <hwy/foreach_target.h>

#include "rays/load_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

/// A piece of records in all directions.
void LoadPiece(benchmark::State& state) {
  constexpr size_t kRays = 16384;
  unit::Random random(1);
  std::vector<unit::FullRay> rays;
  for (size_t i = 0; i < kRays; ++i) {
    rays.push_back(unit::FullRayOf(unit::MakeRay(random.InCube(-1, 1), random.Direction())));
  }
  unit::FormedRays formed(rays, {1, false, false});
  const RayView view = formed.View();
  std::vector<RayRecord> records(kRays);
  std::vector<uint32_t> callers(kRays);
  for (auto _ : state) {
    benchmark::DoNotOptimize(LoadRecords(view, 0, kRays, records.data(), callers.data()));
    benchmark::ClobberMemory();
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
DACRT_STEP_BENCHMARK("LoadRecords", LoadPiece);
}  // namespace
}  // namespace dacrt
#endif

// Benchmarks of steps, beside their tests and under their names. Those of a step that is written
// for SIMD run on every instruction set that the machine has, as FilterList/AVX2, FilterList/SCALAR
// ...
#pragma once

#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <cstdint>
#include <string>

namespace dacrt::unit {

/// Registers `run(state)`, which is to call what HWY_DYNAMIC_DISPATCH chooses, for each target.
template <class Run>
int RegisterForEachTarget(const std::string& name, Run run) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    benchmark::RegisterBenchmark((name + "/" + hwy::TargetName(target)).c_str(),
                                 [target, run](benchmark::State& state) {
                                   hwy::SetSupportedTargetsForTest(target);
                                   run(state);
                                   hwy::SetSupportedTargetsForTest(0);
                                 });
  }
  return 0;
}

}  // namespace dacrt::unit

/// Registers the exported `function` of a file that is compiled for each target.
#define DACRT_STEP_BENCHMARK(name, function)                                            \
  HWY_EXPORT(function);                                                                 \
  [[maybe_unused]] const int registered##function = dacrt::unit::RegisterForEachTarget( \
      name, [](benchmark::State& state) { HWY_DYNAMIC_DISPATCH(function)                \
                                          (state); })

#include "step_bench.h"

BENCHMARK_MAIN();

// The entry points of one instruction set.
#pragma once

#include "dacrt/settings.h"
#include "paper/paper.h"
#include "partition/partition.h"
#include "query/point_kernels.h"
#include "trace/trace.h"

namespace dacrt {

struct Kernels {
  const PaperKernels& paper;
  const PartitionKernels& partition;
  const TraceKernels& trace;
  QueryPointFunction query_point;
};

/// The kernels of the best instruction set that is compiled in, that the processor has, and that is
/// not above `limit`; sets `chosen` to it.
Kernels ChooseKernels(InstructionSet limit, InstructionSet& chosen);

}  // namespace dacrt

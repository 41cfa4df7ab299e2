// Splitting, for each instruction set.
#pragma once

#include <cstddef>

#include "partition/kept_partition.h"
#include "partition/refit.h"
#include "runtime/scratch.h"

namespace dacrt {

struct PartitionKernels {
  FirstLook first_look;
  /// Splits the whole of a scene, if that is not done yet and there is memory, with the threads of
  /// `tasks`.
  void (*split_all)(KeptPartition& kept, SubsetScratch& scratch, TaskPool& tasks);
  CanRefitFunction can_refit;
  RefitFunction refit;
};

/// The kernels of a target, by its index in Highway's tables.
const PartitionKernels& PartitionKernelsFor(std::size_t target);

}  // namespace dacrt

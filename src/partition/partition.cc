#include "partition/partition.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "partition/partition.cc"
#include <hwy/foreach_target.h>

#include "partition/list_triangles-inl.h"
#include "partition/refit-inl.h"
#include "partition/split_by_grid-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

void SplitAll(KeptPartition& kept, SubsetScratch& scratch, TaskPool& tasks) {
  if (kept.subset(0).root.load(std::memory_order_acquire) <= Subset::kNoRoom) return;
  // On a thread of the pool: others there may come to this scene as an instance and wait for who
  // splits it, who must not wait for their places then.
  tasks.Enter([&] { RootOf(kept, 0, 0, &scratch, &tasks, [] {}); });
}

}  // namespace

const PartitionKernels* GetPartitionKernels() {
  static constexpr PartitionKernels kKernels{kFirstLook, SplitAll, CanRefit, Refit};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
HWY_EXPORT(GetPartitionKernels);
}  // namespace

const PartitionKernels& PartitionKernelsFor(std::size_t target) {
  return *HWY_DISPATCH_TABLE(GetPartitionKernels)[target]();
}

}  // namespace dacrt
#endif  // HWY_ONCE

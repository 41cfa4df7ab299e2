#include "engine/kernels.h"

#include <hwy/highway.h>

namespace dacrt {
namespace {

struct Target {
  InstructionSet instruction_set;
  int64_t bits;  ///< Highway's targets that make it up
};

// Worst first. Highway's portable code is one of two, by compiler; both are called scalar here.
constexpr Target kTargets[] = {
    {InstructionSet::kScalar, HWY_SCALAR | HWY_EMU128},
    {InstructionSet::kNeon, HWY_NEON},
    {InstructionSet::kSse4, HWY_SSE4},
    {InstructionSet::kAvx2, HWY_AVX2},
    {InstructionSet::kAvx512, HWY_AVX3 | HWY_AVX3_DL},
};

/// What this build can run on this processor; its portable code always.
int64_t TargetsHere() { return (hwy::SupportedTargets() & HWY_TARGETS) | HWY_STATIC_TARGET; }

}  // namespace

std::vector<InstructionSet> AvailableInstructionSets() {
  std::vector<InstructionSet> available;
  for (const Target& target : kTargets) {
    if (target.bits & TargetsHere()) {
      available.push_back(target.instruction_set);
    }
  }
  return available;
}

bool ProcessorHas(InstructionSet instruction_set) {
  for (const Target& target : kTargets) {
    if (target.instruction_set != instruction_set) continue;
    return instruction_set == InstructionSet::kScalar || (target.bits & hwy::SupportedTargets());
  }
  return true;
}

Kernels ChooseKernels(InstructionSet limit, InstructionSet& chosen) {
  int64_t allowed = 0;
  for (const Target& target : kTargets) {
    if (!(target.bits & TargetsHere())) continue;
    // The worst one is taken even if the limit is below it: the code has no worse one.
    if (allowed != 0 && target.instruction_set > limit) continue;
    allowed |= target.bits & TargetsHere();
    chosen = target.instruction_set;
  }
  hwy::ChosenTarget target;
  target.Update(allowed);
  // Where Highway compiles for one instruction set only its tables have one entry.
  constexpr bool kHasOneTarget = (HWY_TARGETS & (HWY_TARGETS - 1)) == 0;
  const std::size_t index = kHasOneTarget ? 0 : target.GetIndex();
  return {PaperKernelsFor(index), PartitionKernelsFor(index), TraceKernelsFor(index),
          QueryPointFor(index)};
}

}  // namespace dacrt

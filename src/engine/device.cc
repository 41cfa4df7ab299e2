#include "engine/device.h"

#include <algorithm>
#include <utility>

#include "engine/call_plan.h"
#include "partition/grid.h"
#include "partition/kept_partition.h"

namespace dacrt {

Device::Implementation::Implementation(const Settings& settings, MemoryMonitor monitor)
    : settings(settings),
      kernels(ChooseKernels(settings.instruction_set, instruction_set)),
      memory(std::move(monitor)),
      workspaces(memory),
      tasks(settings.threads) {}

bool Device::Implementation::Keeps(std::size_t triangles, Keep keep) const {
  return keep == Keep::kByBudget && settings.algorithm == Algorithm::kNabata2013 &&
         BudgetBytes(triangles) >= KeptPartition::LeastBytes(triangles);
}

std::size_t Device::Implementation::BudgetBytes(std::size_t triangles) const {
  // What a partition takes without limit: measured at 7 to 9 bytes a triangle, and a sixth of a
  // scene's nodes can be nearly empty.
  constexpr std::size_t kDefault = 8, kUnlimited = 16;
  // So few triangles are no burden, whatever the share of each.
  constexpr std::size_t kLeast = 64 * 1024;
  if (settings.budget == kDefaultBudget) return kDefault * triangles + kLeast;
  if (settings.budget == kUnlimitedBudget) return kUnlimited * triangles + kLeast;
  return std::min<std::size_t>(settings.budget, kUnlimited * triangles + kLeast);
}

std::size_t Device::Implementation::CallBytes(std::size_t triangles, std::size_t rays,
                                              bool keeps) const {
  const CallPlan plan(rays, tasks.threads(), keeps, settings);
  const WorkspaceShape shape(triangles, plan.piece_rays, keeps, settings);
  if (!keeps) return plan.workers * shape.Bytes();
  const WorkspaceShape floor(triangles, CallPlan::Least(keeps, settings).piece_rays, keeps,
                             settings);
  return std::max(plan.workers * shape.Bytes(), floor.Bytes()) + GridBytes(triangles);
}

std::size_t Device::Implementation::GridBytes(std::size_t triangles) const {
  return Grid::Bytes(triangles, Grid::PartsFor(triangles, tasks.threads()));
}

Device::Device(const Settings& settings, MemoryMonitor monitor) {
  Validate(settings);
  implementation_ = std::make_unique<Implementation>(settings, std::move(monitor));
}

Device::~Device() = default;

const Settings& Device::settings() const { return implementation_->settings; }

InstructionSet Device::instruction_set() const { return implementation_->instruction_set; }

std::size_t Device::WorkspaceBytes(std::size_t triangle_count, std::size_t ray_count) const {
  return implementation_->CallBytes(triangle_count, ray_count,
                                    implementation_->Keeps(triangle_count, Keep::kByBudget));
}

std::size_t Device::WorkspaceBytesHeld() const { return implementation_->workspaces.BytesHeld(); }

void Device::ReleaseIdleWorkspaces() { implementation_->workspaces.ReleaseIdle(); }

}  // namespace dacrt

#include "engine/device.h"

#include <algorithm>
#include <utility>

#include "partition/grid.h"
#include "partition/kept_partition.h"
#include "trace/policy.h"

namespace dacrt {

Device::Implementation::Implementation(const Settings& settings, MemoryMonitor monitor)
    : settings(settings),
      kernels(ChooseKernels(settings.instruction_set, instruction_set)),
      memory(std::move(monitor)),
      workspaces(memory),
      tasks(settings.threads) {}

bool Device::Implementation::Keeps() const {
  return settings.algorithm == Algorithm::kNabata2013 && settings.budget > 0;
}

std::size_t Device::Implementation::BudgetBytes(const GeometryTable& geometries, Keep keep,
                                                bool prepares) const {
  // What a partition takes without limit: triangles that share no vertices take 41 bytes in leaves,
  // prepared ones 113 and more where leaves are not full, and a sixth of a scene's nodes can be
  // nearly empty.
  constexpr std::size_t kDefault = 32, kLittle = 8, kUnlimited = 64, kPrepared = 192;
  // So few triangles are no burden, whatever the share of each.
  constexpr std::size_t kLeast = 64 * 1024, kModest = 8'000'000;
  // What describes the scene, for which the least share leaves room.
  constexpr std::size_t kDescription = 8 * 1024;
  // Memory comes in pages: a partition has no more of them than its share pays for.
  constexpr std::size_t kPage = 4096;
  const std::size_t triangles = geometries.shares();
  const bool is_small = triangles <= policy::kPreparedScene;
  const bool is_prepared = is_small && prepares;
  // What the few may have more stays where a scene grows beyond them.
  const std::size_t few = std::min(triangles, policy::kRepeatingScene);
  std::size_t bytes = kLeast;
  if (is_prepared) {
    bytes = std::min(kLeast, 16 * 1024 + 64 * triangles) + kPrepared * triangles;
  } else if (is_small) {
    // There may be thousands of these: one of no more than a few triangles takes a page.
    bytes = 7 * kPage / 8 + (8 + kUnlimited) * triangles;
  } else {
    bytes += kUnlimited * triangles + (policy::kRepeatingBytes - kUnlimited) * few;
  }
  if (settings.budget == kDefaultBudget) {
    const std::size_t share = kDefault * triangles / kPage * kPage;
    if (!is_small) bytes = std::max(share, std::min(bytes, kModest));
  } else if (settings.budget != kUnlimitedBudget) {
    bytes = std::min<std::size_t>(settings.budget, bytes);
  }
  return keep == Keep::kLittle
             ? std::min(bytes, std::max(kLittle * triangles, kLeast + kDescription) - kDescription)
             : bytes;
}

WorkspaceShape Device::Implementation::Shape(const CallPlan& plan, std::size_t triangles,
                                             const SceneTraits& scene) const {
  return Keeps() ? WorkspaceShape::ForKept(plan.piece_rays, scene)
                 : WorkspaceShape::ForPaper(triangles, plan.piece_rays, scene.is_plain, settings);
}

std::size_t Device::Implementation::PlanBytes(const CallPlan& plan, std::size_t triangles,
                                              const SceneTraits& scene) const {
  const std::size_t bytes = Shape(plan, triangles, scene).Bytes();
  if (!Keeps()) return plan.workers * bytes;
  const std::size_t floor = Shape(CallPlan::Least(true, settings), 0, scene).Bytes();
  return std::max(bytes, floor) + (plan.workers - 1) * bytes;
}

std::size_t Device::Implementation::CallBytes(std::size_t triangles, std::size_t rays) const {
  const CallPlan plan(rays, tasks.threads(), Keeps(), settings);
  return PlanBytes(plan, triangles, {}) + (Keeps() ? GridBytes(triangles) : 0);
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
  return implementation_->CallBytes(triangle_count, ray_count);
}

std::size_t Device::WorkspaceBytesHeld() const { return implementation_->workspaces.BytesHeld(); }

void Device::ReleaseIdleWorkspaces() { implementation_->workspaces.ReleaseIdle(); }

}  // namespace dacrt

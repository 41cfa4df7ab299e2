// A scene in the place of another one: what that one keeps is refitted where it fits.

#include <memory>
#include <new>
#include <utility>

#include "dacrt/dacrt.h"
#include "engine/device.h"
#include "geometry/geometry_table.h"
#include "partition/growth.h"
#include "partition/kept_partition.h"
#include "partition/partition.h"
#include "partition/refit.h"
#include "runtime/ordinary_arithmetic.h"
#include "scene/scene_implementation.h"

namespace dacrt {

bool Scene::takes_over() const { return implementation_->takes_over(); }

void Scene::TakeOver(Scene& previous) noexcept {
  implementation_->TakeOver(*previous.implementation_);
}

void Scene::TakeCopy(const Scene& previous) {
  implementation_->TakeCopy(*previous.implementation_);
}

bool Scene::Implementation::PlanRefit(const Implementation& previous, const SceneOptions& options) {
  const KeptPartition* const kept = previous.parts.kept.get();
  const GeometryTable& geometries = parts.geometries;
  if (!kept || previous.device != device ||
      !BeginsWithSameItems(previous.parts.geometries, geometries)) {
    return false;
  }
  const std::size_t budget =
      Engine().BudgetBytes(geometries, options.keep, previous.parts.prepares_leaves);
  const std::size_t bytes = KeptPartition::BytesFor(geometries.triangle_count(), budget);
  const bool grows = geometries.size() > previous.parts.geometries.size();
  if (grows ? !kept->CanGrow(geometries, bytes) : kept->BytesReserved() != bytes) return false;
  RefitPlan plan{ChangedGeometries(previous.parts.geometries, geometries), options.always_refit};
  const PartitionKernels& kernels = Engine().kernels.partition;
  if (!kernels.can_refit(*kept, geometries, plan, Engine().tasks)) return false;
  try {
    if (grows) growth_.emplace(*kept, geometries, bytes, kernels.first_look.list, Engine().tasks);
  } catch (const std::bad_alloc&) {
    return false;  // there may be memory for one that is made anew: it has no addresses to spare
  }
  refit_plan_ = std::move(plan);
  return true;
}

void Scene::Implementation::TakeOver(Implementation& previous) noexcept {
  if (!refit_plan_) return;
  parts.kept = std::move(previous.parts.kept);
  if (auto copy = growth_ ? growth_->TakeCopy() : nullptr) parts.kept = std::move(copy);
  previous.parts.triangle_count = 0;
  CarryOutPlan();
}

void Scene::Implementation::TakeCopy(const Implementation& previous) {
  if (!refit_plan_) return;
  if (growth_) parts.kept = growth_->TakeCopy();
  if (!parts.kept) parts.kept = std::make_unique<KeptPartition>(*previous.parts.kept);
  CarryOutPlan();
}

void Scene::Implementation::CarryOutPlan() noexcept {
  const OrdinaryArithmetic ordinary;
  if (growth_) growth_->CarryOut(*parts.kept, parts.geometries);
  Engine().kernels.partition.refit(*parts.kept, parts.geometries, *refit_plan_, Engine().tasks);
  parts.bounds = parts.kept->bounds();
  growth_.reset();
  refit_plan_.reset();
}

}  // namespace dacrt

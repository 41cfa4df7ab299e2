// A few geometries of a scene become others, in their places: exchanged first, and back again if
// the partition cannot follow.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "engine/device.h"
#include "geometry/geometry_table.h"
#include "partition/kept_partition.h"
#include "partition/refit.h"
#include "scene/scene_implementation.h"

namespace dacrt {

bool Scene::Update(std::vector<Geometry> changed, bool always_refit) {
  return implementation_->Update(std::move(changed), {}, always_refit);
}

bool Scene::Update(std::vector<Geometry> changed, std::span<const Placement> placed,
                   bool always_refit) {
  return implementation_->Update(std::move(changed), placed, always_refit);
}

bool Scene::Implementation::Update(std::vector<Geometry> changed, std::span<const Placement> placed,
                                   bool always_refit) {
  struct Change {
    uint32_t geometry;
    Shapes::Successor successor;
  };
  GeometryTable& geometries = parts.geometries;
  if (!parts.kept) return false;
  std::vector<Change> changes;
  changes.reserve(changed.size());
  RefitPlan plan{std::vector<bool>(geometries.size()), always_refit};
  bool is_small = parts.is_small;
  for (Geometry& description : changed) {
    const auto geometry = geometries.Find(description.geometry_id);
    if (!geometry) return false;
    if (description.hidden) {
      changes.push_back({*geometry, geometries.shapes().Hidden(*geometry)});
    } else {
      const SceneParts* const scene = PartsFor(description, device.get());
      // For calls with functions of the program's a scene reserves more when it is made.
      if (scene && scene->has_callbacks && !parts.has_callbacks) return false;
      if (scene) is_small &= scene->is_small;
      changes.push_back({*geometry, Shapes::Successor(std::move(description), scene)});
    }
    const Shapes::Successor& successor = changes.back().successor;
    if (!geometries.shapes().CanExchange(*geometry, successor)) return false;
    if (IsChanged(geometries.shapes()[*geometry], successor.geometry()) &&
        !geometries.shapes().StandAsBefore(*geometry, successor)) {
      plan.changed[*geometry] = true;
    }
  }
  Shapes::Places places(placed.size());
  for (const Placement& placement : placed) {
    const auto geometry = geometries.Find(placement.geometry_id);
    // One that is there twice could not go back.
    if (!geometry || plan.changed[*geometry]) return false;
    if (!geometries.shapes().AddPlace(*geometry, placement.transforms, places)) return false;
    plan.changed[*geometry] = true;
  }
  for (Change& change : changes) geometries.Exchange(change.geometry, change.successor);
  geometries.Exchange(places);
  const auto go_back = [&] {
    geometries.Exchange(places);
    for (auto change = changes.rbegin(); change != changes.rend(); ++change) {
      geometries.Exchange(change->geometry, change->successor);
    }
  };
  try {
    if (!Engine().kernels.partition.can_refit(*parts.kept, geometries, plan, Engine().tasks)) {
      go_back();
      return false;
    }
  } catch (...) {
    go_back();
    throw;
  }
  Engine().kernels.partition.refit(*parts.kept, geometries, plan, Engine().tasks);
  parts.bounds = parts.kept->bounds();
  parts.is_small = is_small;
  return true;
}

}  // namespace dacrt

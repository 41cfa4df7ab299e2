#include "shrink.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

namespace dacrt::tests {
namespace {

/// Whether a program could play the world: nothing is attached twice, or detached when it is not
/// attached.
bool IsPlayable(const World& world) {
  std::vector<WorldScene> scenes = world.scenes;
  for (const Stage& stage : world.stages) {
    for (const Change& change : stage.changes) {
      const bool is_attached = scenes[change.scene].geometries[change.geometry].attached;
      if (change.kind == Change::Kind::kAttach && is_attached) return false;
      if (change.kind == Change::Kind::kDetach && !is_attached) return false;
      Apply(change, scenes);
    }
  }
  return true;
}

void EraseGeometry(World& world, uint32_t scene, uint32_t geometry) {
  auto& geometries = world.scenes[scene].geometries;
  geometries.erase(geometries.begin() + geometry);
  for (Stage& stage : world.stages) {
    std::erase_if(stage.changes, [&](const Change& change) {
      return change.scene == scene && change.geometry == geometry;
    });
    for (Change& change : stage.changes) {
      if (change.scene == scene && change.geometry > geometry) --change.geometry;
    }
  }
}

/// A scene that nothing shows.
void EraseScene(World& world, uint32_t scene) {
  world.scenes.erase(world.scenes.begin() + scene);
  for (WorldScene& other : world.scenes) {
    for (WorldGeometry& geometry : other.geometries) {
      if (geometry.instanced_scene > scene) --geometry.instanced_scene;
    }
  }
  for (Stage& stage : world.stages) {
    std::erase_if(stage.changes, [&](const Change& change) { return change.scene == scene; });
    for (Change& change : stage.changes) {
      if (change.scene > scene) --change.scene;
    }
  }
}

bool IsShown(const World& world, uint32_t scene) {
  if (scene + 1 == world.scenes.size()) return true;
  for (const WorldScene& other : world.scenes) {
    for (const WorldGeometry& geometry : other.geometries) {
      const bool shows = geometry.shape == Shape::kInstance || geometry.traces_again;
      if (shows && geometry.instanced_scene == scene) return true;
    }
  }
  return false;
}

/// Vertices that no primitive has are left out, and the others numbered anew. False if there are
/// none.
bool EraseUnusedVertices(WorldGeometry& geometry) {
  if (geometry.shape != Shape::kTriangles && geometry.shape != Shape::kQuads) return false;
  const std::size_t corners = geometry.shape == Shape::kTriangles ? 3 : 4;
  std::map<uint32_t, uint32_t> places;
  const auto count = static_cast<uint32_t>(geometry.vertices[0].size());
  for (const auto& p : geometry.primitives) {
    for (std::size_t i = 0; i < corners; ++i) {
      if (p[i] < count) places.emplace(p[i], 0);
    }
  }
  if (places.size() == count) return false;
  uint32_t next = 0;
  for (auto& [old_place, place] : places) place = next++;
  for (auto& p : geometry.primitives) {
    for (std::size_t i = 0; i < corners; ++i) {
      if (p[i] < count) p[i] = places[p[i]];
    }
  }
  for (auto& step : geometry.vertices) {
    std::vector<Vertex> used;
    for (const auto& [old_place, place] : places) used.push_back(step[old_place]);
    step = std::move(used);
  }
  return true;
}

class Shrinker {
 public:
  Shrinker(World world, const std::function<bool(const World&)>& fails, int most_trials)
      : world_(std::move(world)), fails_(fails), trials_left_(most_trials) {}

  World Run() {
    do {
      progress_ = false;
      ShrinkRays();
      ShrinkStages();
      ShrinkScenes();
      ForEachGeometry([this](auto geometry) { ShrinkPrimitives(geometry); });
      ForEachGeometry([this](auto geometry) { ShrinkSteps(geometry); });
      ResetToDefaults();
    } while (progress_ && trials_left_ > 0);
    return std::move(world_);
  }

 private:
  /// Keeps what `change(world)` makes of the world if that still fails.
  template <typename Change>
  bool Try(const Change& change) {
    if (trials_left_ <= 0) return false;
    World candidate = world_;
    change(candidate);
    if (!IsPlayable(candidate)) return false;
    --trials_left_;
    if (!fails_(candidate)) return false;
    world_ = std::move(candidate);
    progress_ = true;
    return true;
  }

  /// Leaves out runs of items, longest first: half of them, a quarter, down to single ones.
  /// `erase(world, first, count)` does it.
  template <typename Erase>
  void EraseRuns(std::size_t size, const Erase& erase) {
    for (std::size_t run = (size + 1) / 2; run > 0 && size > 1; run /= 2) {
      for (std::size_t first = 0; first < size && size > 1;) {
        const std::size_t count = std::min({run, size - first, size - 1});
        if (Try([&](World& world) { erase(world, first, count); })) {
          size -= count;
        } else {
          first += count;
        }
      }
    }
  }

  static Batch& BatchOf(World& world) { return world.stages.back().batches.back(); }

  void ShrinkRays() {
    EraseRuns(BatchOf(world_).rays.size(), [](World& world, std::size_t first, std::size_t count) {
      auto& rays = BatchOf(world).rays;
      rays.erase(rays.begin() + first, rays.begin() + first + count);
    });
  }

  void ShrinkStages() {
    for (std::size_t i = 0; i + 1 < world_.stages.size();) {
      if (!Try([&](World& world) { world.stages.erase(world.stages.begin() + i); })) ++i;
    }
    for (std::size_t i = 0; i < world_.stages.size(); ++i) {
      for (std::size_t k = 0; k < world_.stages[i].changes.size();) {
        if (!Try([&](World& world) {
              auto& changes = world.stages[i].changes;
              changes.erase(changes.begin() + k);
            })) {
          ++k;
        }
      }
    }
  }

  void ShrinkScenes() {
    for (uint32_t scene = 0; scene < world_.scenes.size(); ++scene) {
      for (uint32_t i = 0; i < world_.scenes[scene].geometries.size();) {
        if (!Try([&](World& world) { EraseGeometry(world, scene, i); })) ++i;
      }
    }
    for (uint32_t scene = 0; scene < world_.scenes.size();) {
      if (IsShown(world_, scene) || !Try([&](World& world) { EraseScene(world, scene); })) ++scene;
    }
  }

  template <typename Shrink>
  void ForEachGeometry(const Shrink& shrink) {
    for (std::size_t scene = 0; scene < world_.scenes.size(); ++scene) {
      for (std::size_t i = 0; i < world_.scenes[scene].geometries.size(); ++i) {
        shrink([scene, i](World& world) -> WorldGeometry& {
          return world.scenes[scene].geometries[i];
        });
      }
    }
  }

  template <typename Geometry>
  void ShrinkPrimitives(const Geometry& of) {
    const WorldGeometry& geometry = of(world_);
    if (geometry.shape == Shape::kInstance) return;
    EraseRuns(geometry.PrimitiveCount(), [&](World& world, std::size_t first, std::size_t count) {
      const auto erase = [&](auto& items) {
        items.erase(items.begin() + first, items.begin() + first + count);
      };
      WorldGeometry& smaller = of(world);
      if (HasFacets(smaller.shape)) {
        erase(smaller.primitives);
      } else {
        for (auto& step : smaller.vertices) erase(step);
        for (auto& step : smaller.normals) erase(step);
      }
    });
    World smaller = world_;
    if (EraseUnusedVertices(of(smaller))) Try([&](World& world) { world = smaller; });
  }

  template <typename Geometry>
  void ShrinkSteps(const Geometry& of) {
    for (const uint32_t steps : {1u, 2u, of(world_).StepCount() / 2, of(world_).StepCount() - 1}) {
      if (steps == 0 || steps >= of(world_).StepCount()) continue;
      Try([&](World& world) {
        WorldGeometry& geometry = of(world);
        if (geometry.shape == Shape::kInstance) geometry.placements.resize(steps);
        if (geometry.shape != Shape::kInstance) geometry.vertices.resize(steps);
        if (!geometry.normals.empty()) geometry.normals.resize(steps);
      });
    }
  }

  /// Sets a value to its default, where it is not that already.
  template <typename Get, typename Value>
  void Reset(const Get& get, const Value& value) {
    if (get(world_) == value) return;
    Try([&](World& world) { get(world) = value; });
  }

  void ResetToDefaults() {
    ForEachGeometry([this](auto of) {
      const auto reset = [&](auto WorldGeometry::*member) {
        Reset(
            [&](World & world) -> auto& { return of(world).*member; }, WorldGeometry{}.*member);
      };
      reset(&WorldGeometry::mask);
      reset(&WorldGeometry::enabled);
      reset(&WorldGeometry::attached);
      reset(&WorldGeometry::quality);
      reset(&WorldGeometry::closest_filter);
      reset(&WorldGeometry::any_filter);
      reset(&WorldGeometry::traces_again);
      reset(&WorldGeometry::time_begin);
      reset(&WorldGeometry::time_end);
      reset(&WorldGeometry::transform_format);
      const auto reset_layout = [&](auto ArrayLayout::*member) {
        Reset(
            [&](World & world) -> auto& { return of(world).layout.*member; },
            ArrayLayout{}.*member);
      };
      reset_layout(&ArrayLayout::memory);
      reset_layout(&ArrayLayout::offset);
      reset_layout(&ArrayLayout::gap);
    });
    for (std::size_t i = 0; i < world_.scenes.size(); ++i) {
      Reset(
          [&](World & world) -> auto& { return world.scenes[i].flags; }, RTC_SCENE_FLAG_NONE);
      Reset(
          [&](World & world) -> auto& { return world.scenes[i].quality; },
          RTC_BUILD_QUALITY_MEDIUM);
    }
    Reset(
        [](World & world) -> auto& { return world.drop_in_config; }, std::string());
    Reset(
        [](World & world) -> auto& { return BatchOf(world).context_filter; }, FilterKind::kNone);
    Reset(
        [](World & world) -> auto& { return BatchOf(world).rays_per_call; }, UINT32_MAX);
    Reset(
        [](World & world) -> auto& { return BatchOf(world).form.coherent; }, false);
    Reset(
        [](World & world) -> auto& { return BatchOf(world).form.gap; }, 0u);
    Reset(
        [](World & world) -> auto& { return BatchOf(world).query; }, Query::kClosest);
    if (BatchOf(world_).form.call != Form::Call::kRecords) {
      Try([](World& world) {
        BatchOf(world).form = {Form::Call::kRecords, BatchOf(world).form.coherent};
      });
    }
  }

  World world_;
  const std::function<bool(const World&)>& fails_;
  int trials_left_;
  bool progress_ = false;
};

}  // namespace

World Shrink(World world, const std::function<bool(const World&)>& fails, int most_trials) {
  return Shrinker(std::move(world), fails, most_trials).Run();
}

}  // namespace dacrt::tests

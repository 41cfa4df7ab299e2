// A scene of geometries of every shape: still, moving, masked, with callbacks, and shown by
// instances.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "dacrt/dacrt.h"
#include "forms.h"
#include "unit_test.h"

namespace dacrt::unit {

class World;

/// A scene and what it is made of.
class WorldScene {
 public:
  struct Options {
    bool has_callbacks = true;
    bool has_instances = true;
    bool robust = false;
    Keep keep = Keep::kByBudget;
    bool is_small = false;  ///< not above policy::kSmallScene
  };

  WorldScene(const Settings& settings, const Options& options);
  ~WorldScene();

 private:
  std::unique_ptr<World> world_, inner_world_;

 public:
  std::unique_ptr<Scene> scene;
};

/// Rays in and around it, with all components.
std::vector<FullRay> MakeFullRays(Random& random, std::size_t count);

}  // namespace dacrt::unit

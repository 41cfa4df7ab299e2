// Bounds of user geometries that are asked for before the engine does. It changes a scene in its
// place under a lock, under which no function of the program is called: that may call the API.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "dacrt/geometry.h"

namespace dacrt::compat {

class AskedBounds {
 public:
  /// Calls the bounds function of a user geometry for all of its primitives; does nothing for other
  /// geometries.
  void Ask(const dacrt::Geometry& geometry);

  /// Makes the engine read what the bounds function said, as long as this is there, if it was asked
  /// for as many primitives and time steps.
  void Answer(dacrt::Geometry& geometry);

 private:
  struct Answers {
    uint32_t time_steps;
    std::vector<Bounds> bounds;  ///< those of a primitive in a row
  };
  static void Read(void* answers, uint32_t primitive, uint32_t time_step, Bounds& bounds);

  std::map<const void*, Answers> answers_;  ///< by BoundsCallback::data
};

}  // namespace dacrt::compat

// The scene of the benchmarks' own tests.
#pragma once

#include "bench_scene.h"

namespace dacrt::bench {

/// A room of four by four by four metres, with its lamp below the ceiling.
inline BenchScene Room() {
  BenchScene scene{.name = "room",
                   .mesh = {},
                   .view = {{0, 1, 1.5f}, {0, 1, 0}, 60},
                   .lamp = {{0.2f, 1.8f, 0.1f}, 0.2f}};
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      scene.mesh.positions.push_back(corner >> axis & 1 ? 2.0f : -2.0f);
    }
  }
  scene.mesh.indices = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                        2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};
  return scene;
}

}  // namespace dacrt::bench

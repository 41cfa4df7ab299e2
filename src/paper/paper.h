// The engine's way into the published methods, for each instruction set.
#pragma once

#include <cstddef>

#include "paper/paper_task.h"

namespace dacrt {

struct PaperKernels {
  /// Solves the rays of `rays` against `triangles`.
  void (*solve)(Query query, const PaperTask& task, const TriangleRange& triangles,
                const RayBlock& rays);
  /// Writes the hits to the caller's records; returns their number.
  std::size_t (*store)(Query query, const RayView& view, std::size_t first, const PaperTask& task,
                       const RayBlock& rays);
};

/// The kernels of a target, by its index in Highway's tables.
const PaperKernels& PaperKernelsFor(std::size_t target);

}  // namespace dacrt

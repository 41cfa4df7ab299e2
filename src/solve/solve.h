// The engine's way into the code that is compiled for each instruction set.
#pragma once

#include <cstddef>

#include "query/point_task.h"
#include "scene/scene_parts.h"
#include "solve/solve_task.h"

namespace dacrt {

/// The entry points of one instruction set.
struct Kernels {
  /// Solves the rays of `rays` against `triangles`.
  void (*solve)(Query query, const SolveTask& task, const TriangleRange& triangles,
                const RayBlock& rays);
  /// Lists the triangles of a scene.
  ListFunction list;
  /// Splits the whole of a scene, if that is not done yet, with the threads of `tasks`.
  void (*split_all)(KeptPartition& kept, SubsetScratch& scratch, TaskPool& tasks);
  /// Writes the hits to the caller's records; returns their number.
  std::size_t (*store)(Query query, const RayView& view, std::size_t first, const SolveTask& task,
                       const RayBlock& rays);
  /// Calls the point callbacks of `scene`.
  void (*query_point)(PointTask& task, const SceneParts& scene);
};

/// The kernels of the best instruction set that is compiled in, that the processor has, and that is
/// not above `limit`; sets `chosen` to it.
const Kernels& ChooseKernels(InstructionSet limit, InstructionSet& chosen);

}  // namespace dacrt

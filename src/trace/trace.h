// The engine's way into the recursion over the kept partition, for each instruction set.
#pragma once

#include <cstddef>

#include "dacrt/dacrt.h"
#include "runtime/workspace.h"
#include "scene/scene_parts.h"

namespace dacrt {

struct TraceKernels {
  /// Rays `first` to `first + count` of the view, at most kMostPieceRays, in a workspace that has
  /// room for them.
  void (*piece)(Query query, const SceneParts& scene, const RayView& rays, std::size_t first,
                std::size_t count, const CallOptions& options, Workspace& workspace,
                Statistics& statistics);
  /// Whether rays of the view, some of which are looked at, run close together.
  bool (*run_together)(const SceneParts& scene, const RayView& rays);
  /// As a piece, at most policy::kShortCall rays on the stack. `pool` is asked for memory where a
  /// subset has to be split.
  void (*short_call)(Query query, const SceneParts& scene, const RayView& rays,
                     const CallOptions& options, WorkspacePool& pool);
  /// A single ray, and the lanes of a packet, by query. As many functions as there are ways: a
  /// single ray would notice one more on its way.
  using Packet = void (*)(const SceneParts& scene, const RayPacket& packet,
                          const CallOptions& options, WorkspacePool& pool);
  Packet single[2];
  Packet lanes[2];
};

/// The kernels of a target, by its index in Highway's tables.
const TraceKernels& TraceKernelsFor(std::size_t target);

}  // namespace dacrt

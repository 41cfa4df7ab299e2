// Measuring memory in a child process: in this one the other library, and all that has been
// measured before, would be in the way.
#pragma once

#include <string>
#include <vector>

#include "memory_use.h"

namespace dacrt::bench {

/// MeasureMemory in a process of its own, of a kind of geometry by its name in GeometryKinds.
/// `child` is the beginning of a command that calls AnswerMemory with what follows: library,
/// config, geometry. Rearms the rays. Throws std::runtime_error if that fails.
MemoryUse MeasureMemoryInChild(const std::string& path, const std::string& config,
                               const BenchScene& scene, const std::string& geometry,
                               RayBuffer& rays,
                               std::vector<std::string> child = {DACRT_MEMORY_CHILD});

/// The child: reads mesh and rays from the standard input, because to make them would leave traces
/// in its memory, and answers on the standard output. Throws std::runtime_error.
void AnswerMemory(const std::string& path, const std::string& config, const std::string& geometry);

}  // namespace dacrt::bench

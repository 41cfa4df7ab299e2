// Running what may crash in a process of its own.
#pragma once

#include <functional>

#include "scenes/hall.h"

namespace ao {

// Returns the mesh that `load` returns in a child process, or throws the Error or std::bad_alloc
// that it throws. Throws Error with kMesh if the child does not live to tell.
// Call it before there are threads: a child process has only the one that made it.
scenes::Mesh LoadIsolated(const std::function<scenes::Mesh()>& load);

}  // namespace ao

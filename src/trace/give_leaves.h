// Leaves get their geometry when rays come to them.
#pragma once

#include "geometry/wide_node.h"
#include "trace/trace_task.h"

namespace dacrt {

/// Copies the geometry of a node's leaves into the memory of the kept partition, as long as the
/// budget lasts. Any number of threads may do so at once.
void GiveLeavesGeometry(const TraceTask& task, WideNode& node);

}  // namespace dacrt

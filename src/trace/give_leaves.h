// Leaves get their geometry when rays come to them.
#pragma once

#include "geometry/wide_node.h"
#include "trace/trace_task.h"

namespace dacrt {

struct LeafBlock;
struct PreparedFacets;

/// PrepareFacets of leaf/cross_facets-inl.h.
using PrepareFunction = void (*)(const LeafBlock& block, PreparedFacets& facets);

/// For a node of which a ray, or a list of rays, enters `entered`: its leaves are given a copy of
/// their geometry in the memory of the kept partition, as long as the budget lasts, and copies that
/// are stale are renewed. Only those that are entered, and in nodes that are rented
/// (partition/rent_or_buy.h) only the second time. In small scenes they are prepared as well. Any
/// number of threads may do so at once.
void GiveLeavesGeometry(const TraceTask& task, WideNode& node, uint32_t entered,
                        PrepareFunction prepare);

}  // namespace dacrt

// A point query, for those who walk the scenes that it goes through.
#pragma once

#include "dacrt/point_query.h"
#include "dacrt/settings.h"
#include "runtime/workspace.h"

namespace dacrt {

struct PointTask {
  const PointQuery& query;
  float radius;  ///< as it is now; it only shrinks
  WorkspacePool& workspaces;
};

}  // namespace dacrt

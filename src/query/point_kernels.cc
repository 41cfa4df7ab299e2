#include "query/point_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/point_kernels.cc"
#include <hwy/foreach_target.h>

#include "query/query_point-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

void QueryPointIn(PointTask& task, const SceneParts& scene) {
  PointWalk(task, scene, task.query.to_scene, nullptr).Walk();
}

}  // namespace

QueryPointFunction GetQueryPoint() { return QueryPointIn; }

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
HWY_EXPORT(GetQueryPoint);
}  // namespace

QueryPointFunction QueryPointFor(std::size_t target) {
  return HWY_DISPATCH_TABLE(GetQueryPoint)[target]();
}

}  // namespace dacrt
#endif  // HWY_ONCE

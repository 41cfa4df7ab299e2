#include "solve/solve_instance.h"

#include <algorithm>
#include <cmath>

#include "scene/scene_parts.h"
#include "solve/solve.h"

namespace dacrt {
namespace {

void Transform(const AffineTransform& transform, const float* vector, bool is_point, float* out) {
  for (int axis = 0; axis < 3; ++axis) {
    float value = is_point ? transform.column[3][axis] : 0.0f;
    for (int i = 2; i >= 0; --i) value = std::fma(vector[i], transform.column[i][axis], value);
    out[axis] = value;
  }
}

}  // namespace

InstanceRays::InstanceRays(const SolveTask& task, uint32_t geometry)
    : task_(task),
      geometry_(geometry),
      scene_(*task.meshes.shapes().InstancedScene(geometry)),
      memory_(*task.frame->for_instance),
      batch_(memory_.batch()),
      most_(memory_.outer_slots().size()) {
  // What is kept by a ray's number serves both spaces.
  batch_.hits = task.batch.hits;
  batch_.full_hits = task.batch.full_hits;
  batch_.ray_masks = task.batch.ray_masks;
}

void InstanceRays::Add(std::size_t slot) {
  const RayBatch& outer = task_.batch;
  const std::size_t to = count_++;
  const float time = task_.frame->TimeOf(outer.index[slot]);
  const AffineTransform transform = task_.meshes.shapes().ToInstance(geometry_, time);
  const float org[3] = {outer.org[0][slot], outer.org[1][slot], outer.org[2][slot]};
  const float dir[3] = {outer.dir[0][slot], outer.dir[1][slot], outer.dir[2][slot]};
  float new_org[3], new_dir[3];
  Transform(transform, org, true, new_org);
  Transform(transform, dir, false, new_dir);
  for (int axis = 0; axis < 3; ++axis) {
    batch_.org[axis][to] = new_org[axis];
    batch_.dir[axis][to] = new_dir[axis];
  }
  batch_.tnear[to] = outer.tnear[slot];
  batch_.tfar[to] = outer.tfar[slot];
  batch_.index[to] = outer.index[slot];
  memory_.outer_slots()[to] = static_cast<uint32_t>(slot);
}

void InstanceRays::Solve(Query query) {
  if (count_ == 0) return;
  PadWithInactive(batch_, count_);
  batch_.top = (count_ + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
  PacketBatch packets = memory_.packets();
  CallFrame frame = *task_.frame;
  frame.instance_id = task_.meshes[geometry_].geometry_id;
  frame.for_instance = nullptr;
  const SolveTask task{
      scene_.meshes,    task_.settings, memory_.refs(),    batch_, packets, memory_.scratch(),
      task_.statistics, task_.clock,    scene_.kept.get(), &frame};
  TriangleRange triangles{};
  if (!scene_.kept) triangles = MakeTriangleRefs(scene_.meshes, memory_.refs());
  frame.kernels.solve(query, task, triangles, {0, count_});
  for (std::size_t i = 0; i < count_; ++i) {
    float& tfar = task_.batch.tfar[memory_.outer_slots()[i]];
    tfar = std::min(tfar, batch_.tfar[i]);
  }
  count_ = 0;
}

}  // namespace dacrt

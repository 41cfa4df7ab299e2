// The flow of one batch through the engine.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <deque>
#include <mutex>
#include <new>
#include <string>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/device.h"
#include "geometry/geometry_table.h"
#include "partition/grid.h"
#include "partition/kept_partition.h"
#include "runtime/split_memory.h"
#include "scene/progress_report.h"
#include "scene/scene_implementation.h"
#include "trace/policy.h"

namespace dacrt {
namespace {

void CheckRays(const RayView& rays) {
  const auto check = [](RayView::Component component, const char* name) {
    if (component == RayView::kAbsent) {
      throw Error(Error::Kind::kArgument, "Trace", std::string("rays.") + name, "kAbsent",
                  "every ray has one");
    }
  };
  check(rays.org_x, "org_x");
  check(rays.org_y, "org_y");
  check(rays.org_z, "org_z");
  check(rays.dir_x, "dir_x");
  check(rays.dir_y, "dir_y");
  check(rays.dir_z, "dir_z");
  check(rays.tfar, "tfar");
  if (rays.lanes == 0) {
    throw Error(Error::Kind::kArgument, "Trace", "rays.lanes", "0", "at least 1");
  }
}

[[noreturn, gnu::cold]] void RefuseLanes(const char* name, uint32_t lanes) {
  throw Error(Error::Kind::kArgument, "Trace", name, std::to_string(lanes),
              "it takes 1 to " + std::to_string(kMostPacketLanes));
}

inline void CheckLanes(const char* name, uint32_t lanes) {
  if (lanes - 1 >= kMostPacketLanes) [[unlikely]]
    RefuseLanes(name, lanes);
}

}  // namespace

Statistics Scene::Trace(Query query, const RayView& rays, const CallOptions& options) const {
  CheckRays(rays);
  CheckLanes("options.callback_width", options.callback_width);
  if (rays.count == 0 || triangle_count() == 0) return {};
  return implementation_->Trace(query, rays, options);
}

void Scene::Trace(Query query, const RayPacket& packet, const CallOptions& options) const {
  CheckLanes("packet.lanes", packet.lanes);
  CheckLanes("options.callback_width", options.callback_width);
  implementation_->Trace(query, packet, options);
}

Statistics Scene::Implementation::Trace(Query query, const RayView& rays,
                                        const CallOptions& options) const {
  if (parts.kept && rays.count <= policy::kShortCall) {
    if (IsUnsplit()) SplitForShortCall();
    Engine().kernels.trace.short_call(query, parts, rays, options, Engine().workspaces);
    return {};
  }
  const Device::Implementation::RunningCall call(Engine());
  CallPlan plan = PlanFor(rays.count, call.threads());
  if (plan.workers > 1 && rays.count >= policy::kEvenCall &&
      Engine().kernels.trace.run_together(parts, rays)) {
    plan.MakeEven(query == Query::kAny ? policy::kMostByLists : policy::kFewestByLists);
  }
  std::deque<WorkspacePool::Loan> workspaces;
  ReserveWorkspaces(plan, workspaces);
  Statistics statistics;
  // With all threads, because nobody could do anything else before it is done.
  if (parts.kept && !parts.has_callbacks) Split(workspaces[0]->scratch().subset);
  std::mutex mutex;
  std::atomic<std::size_t> next_ray{0};
  ProgressReport progress(options.progress, rays.count);
  Engine().tasks.ForEach(plan.workers, [&](std::size_t worker) {
    const Statistics own =
        parts.kept
            ? TracePieces(query, rays, options, plan, next_ray, *workspaces[worker], progress)
            : TraceUnkept(query, rays, options, plan, *workspaces[worker], progress);
    const std::lock_guard lock(mutex);
    statistics += own;
  });
  return statistics;
}

void Scene::Implementation::Trace(Query query, const RayPacket& packet,
                                  const CallOptions& options) const {
  if (parts.triangle_count == 0) return;
  if (!parts.kept) [[unlikely]]
    return TraceUnkept(query, packet, options);
  Device::Implementation& engine = Engine();
  const TraceKernels& kernels = engine.kernels.trace;
  const auto& trace = packet.lanes == 1 ? kernels.single : kernels.lanes;
  trace[static_cast<std::size_t>(query)](parts, packet, options, engine.workspaces);
}

/// A callback is called by the thread that calls.
CallPlan Scene::Implementation::PlanFor(std::size_t ray_count, std::size_t threads) const {
  return CallPlan(ray_count, parts.has_callbacks ? 1 : threads, parts.kept != nullptr,
                  Engine().settings);
}

SceneTraits Scene::Implementation::Traits() const {
  return {parts.geometries.is_plain(), parts.has_instances, parts.has_callbacks};
}

WorkspaceShape Scene::Implementation::Shape(const CallPlan& plan) const {
  return Engine().Shape(plan, parts.triangle_count, Traits());
}

std::size_t Scene::Implementation::CallBytes(std::size_t ray_count) const {
  const CallPlan plan = PlanFor(ray_count, Engine().tasks.threads());
  const std::size_t bytes = Engine().PlanBytes(plan, parts.triangle_count, Traits());
  if (!parts.kept) return bytes;
  std::size_t largest = parts.triangle_count;
  const Shapes& shapes = parts.geometries.shapes();
  for (uint32_t i = 0; i < shapes.size(); ++i) {
    const SceneParts* const scene = shapes.InstancedScene(i);
    if (scene) largest = std::max(largest, scene->triangle_count);
  }
  return bytes + Engine().GridBytes(largest);
}

void Scene::Implementation::ReserveWorkspaces(CallPlan& plan,
                                              std::deque<WorkspacePool::Loan>& workspaces) const {
  WorkspacePool& pool = Engine().workspaces;
  for (;;) {
    try {
      for (std::size_t worker = 0; worker < plan.workers; ++worker) {
        workspaces.emplace_back(pool).Reserve(Shape(plan));
      }
      return;
    } catch (const std::bad_alloc&) {
      workspaces.clear();
      pool.ReleaseSpare();
      Engine().spare_pages.Clear();
      if (!plan.Shrink()) throw;
    }
  }
}

Statistics Scene::Implementation::TracePieces(Query query, const RayView& rays,
                                              const CallOptions& options, const CallPlan& plan,
                                              std::atomic<std::size_t>& next_ray,
                                              Workspace& workspace,
                                              ProgressReport& progress) const {
  Statistics statistics;
  for (std::size_t first = next_ray; first < rays.count && progress.goes_on();) {
    const std::size_t count = plan.NextPiece(rays.count - first);
    if (!next_ray.compare_exchange_weak(first, first + count)) continue;
    Engine().kernels.trace.piece(query, parts, rays, first, count, options, workspace, statistics);
    progress.Add(count);
    first = next_ray;
  }
  return statistics;
}

void Scene::Implementation::Split(SubsetScratch& scratch) const {
  Engine().kernels.partition.split_all(*parts.kept, scratch, Engine().tasks);
}

void Scene::Implementation::SplitForShortCall() const {
  if (parts.has_callbacks || Engine().tasks.threads() == 1) return;
  // To wake threads costs more than a subset.
  if (parts.triangle_count <= SubsetScratch::kTriangles) return;
  SplitMemory memory(Engine().workspaces);
  const SplitMemory::Use scratch(memory);
  if (scratch.get()) Split(*scratch.get());
}

}  // namespace dacrt

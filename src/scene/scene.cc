// A committed scene, and the flow of one batch through the engine.

#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/device.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "partition/grid.h"
#include "partition/kept_partition.h"
#include "scene/scene_parts.h"
#include "solve/solve.h"

namespace dacrt {
namespace {

void CheckRays(const RayView& rays) {
  const auto check = [](RayView::Component component, const char* name) {
    if (component == RayView::kAbsent) {
      throw std::invalid_argument(std::string("Trace: rays.") + name + " is absent");
    }
  };
  check(rays.org_x, "org_x");
  check(rays.org_y, "org_y");
  check(rays.org_z, "org_z");
  check(rays.dir_x, "dir_x");
  check(rays.dir_y, "dir_y");
  check(rays.dir_z, "dir_z");
  check(rays.tfar, "tfar");
  if (rays.lanes == 0) throw std::invalid_argument("Trace: rays.lanes is 0");
}

void TakeSeconds(const StepClock& clock, Statistics& statistics) {
  const auto seconds = clock.Seconds();
  const auto of = [&](Step step) { return seconds[static_cast<std::size_t>(step)]; };
  statistics.seconds_loading = of(Step::kLoading);
  statistics.seconds_sampling = of(Step::kSampling);
  statistics.seconds_binning = of(Step::kBinning);
  statistics.seconds_partition = of(Step::kPartition);
  statistics.seconds_filtering = of(Step::kFiltering);
  statistics.seconds_direct = of(Step::kDirect);
  statistics.seconds_few_rays = of(Step::kFewRays);
  statistics.seconds_storing = of(Step::kStoring);
}

void CheckOptions(const CallOptions& options) {
  if (options.callback_width < 1 || options.callback_width > CallbackPacket::kMostLanes) {
    throw std::invalid_argument("Trace: options.callback_width is " +
                                std::to_string(options.callback_width) + ", not 1 to " +
                                std::to_string(CallbackPacket::kMostLanes));
  }
}

}  // namespace

class Scene::Implementation {
 public:
  Implementation(std::shared_ptr<Device> shared_device, MeshTable meshes, Keep keep,
                 std::vector<std::shared_ptr<const Scene>> scenes)
      : device(std::move(shared_device)), instanced(std::move(scenes)), parts{std::move(meshes)} {
    const std::size_t most = parts.meshes.triangle_count();
    if (most > 0 && Engine().Keeps(most, keep)) {
      parts.kept = std::make_unique<KeptPartition>(parts.meshes, Engine().BudgetBytes(most),
                                                   Engine().kernels.list, Engine().tasks);
      parts.bounds = parts.kept->bounds();
      parts.triangle_count = parts.kept->triangle_count();
    } else {
      CountTriangles();
    }
    has_callbacks = parts.meshes.shapes().has_callbacks();
    for (const auto& scene : instanced) has_callbacks |= scene->implementation_->has_callbacks;
    // A scene that keeps nothing needs as much as its call for each triangle: that is not reserved.
    if (parts.kept) {
      Engine().workspaces.KeepFloor(Shape(CallPlan::Least(true, Engine().settings)));
    }
  }

  static MeshTable MakeTable(const Device* device, std::span<const Geometry> geometries,
                             bool robust) {
    if (!device) throw std::invalid_argument("Scene: device is null");
    std::vector<const SceneParts*> scenes;
    for (const Geometry& geometry : geometries) scenes.push_back(PartsFor(geometry, device));
    return MeshTable(geometries, scenes, robust);
  }

  static std::vector<std::shared_ptr<const Scene>> ScenesOf(std::span<const Geometry> geometries) {
    std::vector<std::shared_ptr<const Scene>> scenes;
    for (const Geometry& geometry : geometries) {
      if (geometry.shape == Shape::kInstance) scenes.push_back(geometry.instanced_scene);
    }
    return scenes;
  }

  Device::Implementation& Engine() const { return *device->implementation_; }

  Statistics Trace(Query query, const RayView& rays, const CallOptions& options) const {
    const Device::Implementation::RunningCall call(Engine());
    CallPlan plan = PlanFor(rays.count, call.threads());
    std::deque<WorkerMemory> workspaces;
    ReserveWorkspaces(plan, workspaces);
    Statistics statistics;
    // With all threads, because nobody could do anything else before it is done.
    if (parts.kept && !has_callbacks) {
      Engine().kernels.split_all(*parts.kept, workspaces[0].own->scratch().subset, Engine().tasks);
    }
    std::mutex mutex;
    std::atomic<std::size_t> next_ray{0};
    Engine().tasks.ForEach(plan.workers, [&](std::size_t worker) {
      const Statistics own = TracePieces(query, rays, options, plan, next_ray, workspaces[worker]);
      const std::lock_guard lock(mutex);
      statistics += own;
    });
    return statistics;
  }

  void QueryPoint(const PointQuery& query) const {
    if (!(query.radius >= 0)) return;
    PointTask task{query, query.radius, Engine().workspaces, Engine().settings};
    Engine().kernels.query_point(task, parts);
  }

  /// See Device::WorkspaceBytes.
  std::size_t CallBytes(std::size_t ray_count) const {
    const CallPlan plan = PlanFor(ray_count, Engine().tasks.threads());
    std::size_t bytes = Shape(plan).Bytes();
    if (!instanced.empty()) bytes += InstanceShape(plan).Bytes();
    bytes = std::max(bytes * plan.workers, FloorBytes());
    std::size_t largest = parts.kept ? parts.triangle_count : 0;
    for (const auto& scene : instanced) {
      const SceneParts& inner = scene->implementation_->parts;
      if (inner.kept) largest = std::max(largest, inner.triangle_count);
    }
    return bytes + (largest > 0 ? Engine().GridBytes(largest) : 0);
  }

  std::shared_ptr<Device> device;
  std::vector<std::shared_ptr<const Scene>> instanced;
  SceneParts parts;
  bool has_callbacks = false;  ///< the scene itself, or one that it has an instance of

 private:
  /// What a worker needs. An idle second one where there are no instances.
  struct WorkerMemory {
    explicit WorkerMemory(WorkspacePool& pool) : own(pool) {}
    WorkspacePool::Loan own;
    std::optional<WorkspacePool::Loan> for_instance;
  };

  static const SceneParts* PartsFor(const Geometry& geometry, const Device* device) {
    if (geometry.shape != dacrt::Shape::kInstance) return nullptr;
    const std::string where =
        "Scene: geometry " + std::to_string(geometry.geometry_id) + ": instanced_scene ";
    if (!geometry.instanced_scene) throw std::invalid_argument(where + "is null");
    const Implementation& inner = *geometry.instanced_scene->implementation_;
    if (inner.device.get() != device) {
      throw std::invalid_argument(where + "belongs to another device");
    }
    return &inner.parts;
  }

  /// A callback is called by the thread that calls.
  CallPlan PlanFor(std::size_t ray_count, std::size_t threads) const {
    return CallPlan(ray_count, has_callbacks ? 1 : threads, parts.kept != nullptr,
                    Engine().settings);
  }

  /// What is reserved when the scene is made.
  std::size_t FloorBytes() const {
    return parts.kept ? Shape(CallPlan::Least(true, Engine().settings)).Bytes() : 0;
  }

  WorkspaceShape Shape(const CallPlan& plan) const {
    WorkspaceShape shape(parts.triangle_count, plan.piece_rays, parts.kept != nullptr,
                         Engine().settings);
    if (!parts.meshes.is_plain()) shape.full_hits = shape.rays;
    return shape;
  }

  /// For rays in the space of any of the instances.
  WorkspaceShape InstanceShape(const CallPlan& plan) const {
    // Gathered at once; more would save little, as the partition is there for all.
    constexpr std::size_t kMostRays = 8192;
    std::size_t triangles = 0;
    bool keeps = true;
    for (const auto& scene : instanced) {
      const SceneParts& inner = scene->implementation_->parts;
      if (inner.kept) continue;
      keeps = false;
      triangles = std::max(triangles, inner.triangle_count);
    }
    const std::size_t rays = std::min(plan.piece_rays, kMostRays);
    WorkspaceShape shape(triangles, rays, /*keeps=*/true, Engine().settings);
    const WorkspaceShape unkept(triangles, rays, /*keeps=*/false, Engine().settings);
    if (!keeps) {
      shape.refs = unkept.refs;
      shape.slots = std::max(shape.slots, unkept.slots);
    }
    shape.outer_slots = rays;
    return shape;
  }

  void CountTriangles() {
    const MeshTable& meshes = parts.meshes;
    Box& bounds = parts.bounds;
    const auto all = meshes.meshes();
    for (uint32_t mesh = 0; mesh < all.size(); ++mesh) {
      for (uint32_t primitive = 0; primitive < all[mesh].triangle_count; ++primitive) {
        TriangleRef ref;
        if (!BoundTriangle(meshes, mesh, primitive, ref)) continue;
        bounds.Extend(ref.lower);
        bounds.Extend(ref.upper);
        ++parts.triangle_count;
      }
    }
  }

  /// One for each worker; with a smaller plan if the memory for this one cannot be had.
  void ReserveWorkspaces(CallPlan& plan, std::deque<WorkerMemory>& workspaces) const {
    WorkspacePool& pool = Engine().workspaces;
    for (;;) {
      try {
        for (std::size_t worker = 0; worker < plan.workers; ++worker) {
          WorkerMemory& memory = workspaces.emplace_back(pool);
          memory.own.Reserve(Shape(plan));
          if (!instanced.empty()) memory.for_instance.emplace(pool).Reserve(InstanceShape(plan));
        }
        return;
      } catch (const std::bad_alloc&) {
        workspaces.clear();
        pool.ReleaseSpare();
        if (!plan.Shrink()) throw;
      }
    }
  }

  /// Works on pieces until none is left.
  Statistics TracePieces(Query query, const RayView& rays, const CallOptions& options,
                         const CallPlan& plan, std::atomic<std::size_t>& next_ray,
                         WorkerMemory& memory) const {
    const Device::Implementation& engine = Engine();
    const MeshTable& meshes = parts.meshes;
    KeptPartition* const kept = parts.kept.get();
    const WorkspacePool::Loan& workspace = memory.own;
    Statistics statistics;
    StepClock clock;
    std::optional<TriangleRange> triangles;
    for (std::size_t first = next_ray; first < rays.count;) {
      const std::size_t count = plan.NextPiece(rays.count - first);
      if (!next_ray.compare_exchange_weak(first, first + count)) continue;
      RayBatch batch = workspace->batch();
      PacketBatch packets = workspace->packets();
      const CallFrame frame{rays,
                            first,
                            options,
                            engine.kernels,
                            rays.instance_value,
                            memory.for_instance ? &**memory.for_instance : nullptr};
      const SolveTask task{meshes,
                           engine.settings,
                           workspace->refs(),
                           batch,
                           packets,
                           workspace->scratch(),
                           statistics,
                           clock,
                           kept,
                           meshes.is_plain() ? nullptr : &frame};
      const RayBlock active = [&] {
        const StepClock::Charge charge(clock, Step::kLoading);
        return LoadRays(rays, first, count, query, meshes, batch);
      }();
      // Object partition leaves the references to the next piece in another order; space partition
      // leaves them clipped.
      if (!triangles || engine.settings.algorithm == Algorithm::kMora2011) {
        const StepClock::Charge charge(clock, Step::kBinning);
        triangles = kept ? TriangleRange{} : MakeTriangleRefs(meshes, RefsOf(workspace));
      }
      if (active.count > 0) engine.kernels.solve(query, task, *triangles, active);
      const StepClock::Charge charge(clock, Step::kStoring);
      statistics.hits += engine.kernels.store(query, rays, first, task, active);
      statistics.rays += active.count;
      ++statistics.pieces;
      first = next_ray;
    }
    TakeSeconds(clock, statistics);
    return statistics;
  }

  std::span<TriangleRef> RefsOf(const WorkspacePool::Loan& workspace) const {
    return workspace->refs().first(parts.triangle_count);
  }
};

Scene::Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes, Keep keep) {
  if (!device) throw std::invalid_argument("Scene: device is null");
  implementation_ = std::make_unique<Implementation>(std::move(device), MeshTable(meshes), keep,
                                                     std::vector<std::shared_ptr<const Scene>>());
}

Scene::Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
             const SceneOptions& options) {
  MeshTable meshes = Implementation::MakeTable(device.get(), geometries, options.robust);
  implementation_ = std::make_unique<Implementation>(
      std::move(device), std::move(meshes), options.keep, Implementation::ScenesOf(geometries));
}

Scene::~Scene() = default;

Bounds Scene::bounds() const { return ToBounds(implementation_->parts.bounds); }

LinearBounds Scene::linear_bounds() const {
  return implementation_->parts.meshes.shapes().BoundLinearly();
}

std::size_t Scene::triangle_count() const { return implementation_->parts.triangle_count; }

std::size_t Scene::KeptBytes() const {
  const auto& kept = implementation_->parts.kept;
  return kept ? kept->BytesReserved() : 0;
}

std::size_t Scene::KeptBytesUsed() const {
  const auto& kept = implementation_->parts.kept;
  return kept ? kept->BytesUsed() : 0;
}

std::size_t Scene::WorkspaceBytes(std::size_t ray_count) const {
  return implementation_->CallBytes(ray_count);
}

Statistics Scene::Trace(Query query, const RayView& rays, const CallOptions& options) const {
  CheckRays(rays);
  CheckOptions(options);
  if (rays.count == 0 || triangle_count() == 0) return {};
  return implementation_->Trace(query, rays, options);
}

void Scene::QueryPoint(const PointQuery& query) const { implementation_->QueryPoint(query); }

}  // namespace dacrt

// A committed scene, and the flow of one batch through the engine.

#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/device.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "partition/kept_partition.h"
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

std::vector<TriangleMesh> StillTriangles(std::span<const Geometry> geometries) {
  std::vector<TriangleMesh> meshes;
  for (const Geometry& geometry : geometries) {
    if (geometry.shape != Shape::kTriangles || geometry.vertices.size() != 1) {
      throw std::invalid_argument("Scene: only still triangle meshes are supported yet");
    }
    TriangleMesh mesh;
    mesh.vertices = geometry.vertices[0].data;
    mesh.vertex_stride = geometry.vertices[0].stride;
    mesh.vertex_count = geometry.vertex_count;
    mesh.triangles = geometry.primitives.data;
    mesh.triangle_stride = geometry.primitives.stride;
    mesh.triangle_count = geometry.primitive_count;
    mesh.geometry_id = geometry.geometry_id;
    mesh.mask = geometry.mask;
    meshes.push_back(mesh);
  }
  return meshes;
}

}  // namespace

class Scene::Implementation {
 public:
  Implementation(std::shared_ptr<Device> shared_device, std::span<const TriangleMesh> all,
                 Keep keep)
      : device(std::move(shared_device)), meshes(all) {
    if (!device) throw std::invalid_argument("Scene: device is null");
    const std::size_t most = meshes.triangle_count();
    if (most > 0 && Engine().Keeps(most, keep)) {
      kept = std::make_unique<KeptPartition>(meshes, Engine().BudgetBytes(most));
      bounds = kept->bounds();
      triangle_count = kept->triangle_count();
    } else {
      CountTriangles();
    }
  }

  Device::Implementation& Engine() const { return *device->implementation_; }

  Statistics Trace(Query query, const RayView& rays) const {
    CallPlan plan(rays.count, Engine().tasks.threads(), kept != nullptr, Engine().settings);
    std::deque<WorkspacePool::Loan> workspaces;
    ReserveWorkspaces(plan, workspaces);
    Statistics statistics;
    std::mutex mutex;
    std::atomic<std::size_t> next_piece{0};
    Engine().tasks.ForEach(plan.workers, [&](std::size_t worker) {
      const Statistics own = TracePieces(query, rays, plan, next_piece, workspaces[worker]);
      const std::lock_guard lock(mutex);
      statistics += own;
    });
    return statistics;
  }

  std::shared_ptr<Device> device;
  MeshTable meshes;
  Box bounds = Box::Empty();
  std::size_t triangle_count = 0;
  std::unique_ptr<KeptPartition> kept;  ///< null if nothing is kept

 private:
  void CountTriangles() {
    const auto all = meshes.meshes();
    for (uint32_t mesh = 0; mesh < all.size(); ++mesh) {
      for (uint32_t primitive = 0; primitive < all[mesh].triangle_count; ++primitive) {
        TriangleRef ref;
        if (!BoundTriangle(meshes, mesh, primitive, ref)) continue;
        bounds.Extend(ref.lower);
        bounds.Extend(ref.upper);
        ++triangle_count;
      }
    }
  }

  /// One for each worker; with a smaller plan if the memory for this one cannot be had.
  void ReserveWorkspaces(CallPlan& plan, std::deque<WorkspacePool::Loan>& workspaces) const {
    for (;;) {
      try {
        const WorkspaceShape shape(triangle_count, plan.piece_rays, kept != nullptr,
                                   Engine().settings);
        for (std::size_t worker = 0; worker < plan.workers; ++worker) {
          workspaces.emplace_back(Engine().workspaces).Reserve(shape);
        }
        return;
      } catch (const std::bad_alloc&) {
        workspaces.clear();
        Engine().workspaces.ReleaseIdle();
        if (!plan.Shrink()) throw;
      }
    }
  }

  /// Works on pieces until none is left.
  Statistics TracePieces(Query query, const RayView& rays, const CallPlan& plan,
                         std::atomic<std::size_t>& next_piece,
                         WorkspacePool::Loan& workspace) const {
    const Device::Implementation& engine = Engine();
    Statistics statistics;
    StepClock clock;
    std::optional<TriangleRange> triangles;
    for (std::size_t piece; (piece = next_piece++) < plan.PieceCount(rays.count);) {
      const std::size_t first = piece * plan.piece_rays;
      const std::size_t count = std::min(plan.piece_rays, rays.count - first);
      RayBatch batch = workspace->batch();
      PacketBatch packets = workspace->packets();
      const SolveTask task{meshes,     engine.settings, workspace->refs(),
                           batch,      packets,         workspace->scratch(),
                           statistics, clock,           kept.get()};
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
    }
    TakeSeconds(clock, statistics);
    return statistics;
  }

  std::span<TriangleRef> RefsOf(const WorkspacePool::Loan& workspace) const {
    return workspace->refs().first(triangle_count);
  }
};

Scene::Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes, Keep keep)
    : implementation_(std::make_unique<Implementation>(std::move(device), meshes, keep)) {}

Scene::Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
             const SceneOptions& options)
    : Scene(std::move(device), std::span<const TriangleMesh>(StillTriangles(geometries)),
            options.keep) {}

Scene::~Scene() = default;

Bounds Scene::bounds() const {
  const Box& box = implementation_->bounds;
  return {{box.lower[0], box.lower[1], box.lower[2]}, {box.upper[0], box.upper[1], box.upper[2]}};
}

std::size_t Scene::triangle_count() const { return implementation_->triangle_count; }

std::size_t Scene::KeptBytes() const {
  return implementation_->kept ? implementation_->kept->BytesReserved() : 0;
}

std::size_t Scene::KeptBytesUsed() const {
  return implementation_->kept ? implementation_->kept->BytesUsed() : 0;
}

std::size_t Scene::WorkspaceBytes(std::size_t ray_count) const {
  return implementation_->Engine().CallBytes(triangle_count(), ray_count,
                                             implementation_->kept != nullptr);
}

Statistics Scene::Trace(Query query, const RayView& rays, const CallOptions&) const {
  CheckRays(rays);
  if (rays.count == 0 || triangle_count() == 0) return {};
  return implementation_->Trace(query, rays);
}

}  // namespace dacrt

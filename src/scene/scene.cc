// A committed scene, and the flow of one batch through the engine.

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "dacrt/dacrt.h"
#include "engine/device.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
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
  statistics.seconds_storing = of(Step::kStoring);
}

}  // namespace

class Scene::Implementation {
 public:
  Implementation(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes)
      : device(std::move(device)), meshes(meshes) {
    if (!this->device) throw std::invalid_argument("Scene: device is null");
    const auto all = this->meshes.meshes();
    for (uint32_t mesh = 0; mesh < all.size(); ++mesh) {
      for (uint32_t primitive = 0; primitive < all[mesh].triangle_count; ++primitive) {
        TriangleRef ref;
        if (!BoundTriangle(this->meshes, mesh, primitive, ref)) continue;
        bounds.Extend(ref.lower);
        bounds.Extend(ref.upper);
        ++triangle_count;
      }
    }
  }

  std::shared_ptr<Device> device;
  MeshTable meshes;
  Box bounds = Box::Empty();
  std::size_t triangle_count = 0;
};

Scene::Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes)
    : implementation_(std::make_unique<Implementation>(std::move(device), meshes)) {}

Scene::~Scene() = default;

Bounds Scene::bounds() const {
  const Box& box = implementation_->bounds;
  return {{box.lower[0], box.lower[1], box.lower[2]}, {box.upper[0], box.upper[1], box.upper[2]}};
}

std::size_t Scene::triangle_count() const { return implementation_->triangle_count; }

std::size_t Scene::WorkspaceBytes(std::size_t ray_count) const {
  return implementation_->device->WorkspaceBytes(implementation_->triangle_count, ray_count);
}

Statistics Scene::Trace(Query query, const RayView& rays) const {
  CheckRays(rays);
  Statistics statistics;
  if (rays.count == 0 || triangle_count() == 0) return statistics;

  Device::Implementation& device = *implementation_->device->implementation_;
  const MeshTable& meshes = implementation_->meshes;
  const std::size_t piece_rays = std::min<std::size_t>(rays.count, device.settings.piece_rays);
  WorkspacePool::Loan workspace(device.workspaces);
  workspace.Reserve({triangle_count(), piece_rays, device.settings});
  StepClock clock;
  TriangleRange triangles;
  for (std::size_t first = 0; first < rays.count; first += piece_rays) {
    RayBatch batch = workspace->batch();
    const SolveTask task{
        meshes, device.settings, workspace->refs(), batch, workspace->scratch(), statistics, clock};
    const RayBlock active = [&] {
      const StepClock::Charge charge(clock, Step::kLoading);
      return LoadRays(rays, first, std::min(piece_rays, rays.count - first), query, meshes, batch);
    }();
    // Object partition leaves the references to the next piece in another order; space partition
    // leaves them clipped.
    if (first == 0 || device.settings.algorithm == Algorithm::kMora2011) {
      const StepClock::Charge charge(clock, Step::kBinning);
      triangles = MakeTriangleRefs(meshes, workspace->refs().first(triangle_count()));
    }
    if (active.count > 0) device.kernels.solve(query, task, triangles, active);
    const StepClock::Charge charge(clock, Step::kStoring);
    statistics.hits += device.kernels.store(query, rays, first, task, active);
    statistics.rays += active.count;
    ++statistics.pieces;
  }
  TakeSeconds(clock, statistics);
  return statistics;
}

}  // namespace dacrt

// What a scene is inside. Each of its steps is a file: commit, take_over, update, trace_call,
// trace_unkept.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/device.h"
#include "engine/prepared_scenes.h"
#include "geometry/geometry_table.h"
#include "partition/growth.h"
#include "partition/kept_partition.h"
#include "partition/refit.h"
#include "runtime/workspace.h"
#include "scene/progress_report.h"
#include "scene/scene_parts.h"

namespace dacrt {

inline constexpr uint32_t kMostPacketLanes = 16;

// Hidden, although the class that it is in is exported.
class __attribute__((visibility("hidden"))) Scene::Implementation {
 public:
  /// `previous` is null for a scene that does not come in another one's place.
  Implementation(std::shared_ptr<Device> shared_device, GeometryTable geometries,
                 const SceneOptions& options, const Implementation* previous = nullptr);

  static GeometryTable MakeTable(const Device* device, std::span<const Geometry> geometries,
                                 bool robust);

  Device::Implementation& Engine() const { return *device->implementation_; }

  /// See Scene, for these and the following ones.
  bool takes_over() const { return refit_plan_.has_value(); }
  void TakeOver(Implementation& previous) noexcept;
  void TakeCopy(const Implementation& previous);
  bool Update(std::vector<Geometry> changed, std::span<const Placement> placed, bool always_refit);

  Statistics Trace(Query query, const RayView& rays, const CallOptions& options) const;
  void Trace(Query query, const RayPacket& packet, const CallOptions& options) const;

  /// See Scene::WorkspaceBytes.
  std::size_t CallBytes(std::size_t ray_count) const;

  std::shared_ptr<Device> device;
  SceneParts parts;

 private:
  /// What an instance shows; null for other shapes.
  static const SceneParts* PartsFor(const Geometry& geometry, const Device* device);
  void CountTriangles();

  /// False if there is nothing to take over, or it would not do.
  bool PlanRefit(const Implementation& previous, const SceneOptions& options);
  void CarryOutPlan() noexcept;

  CallPlan PlanFor(std::size_t ray_count, std::size_t threads) const;
  SceneTraits Traits() const;
  WorkspaceShape Shape(const CallPlan& plan) const;

  /// One for each worker; with a smaller plan if the memory for this one cannot be had.
  void ReserveWorkspaces(CallPlan& plan, std::deque<WorkspacePool::Loan>& workspaces) const;

  /// Works on pieces until none is left.
  Statistics TracePieces(Query query, const RayView& rays, const CallOptions& options,
                         const CallPlan& plan, std::atomic<std::size_t>& next_ray,
                         Workspace& workspace, ProgressReport& progress) const;

  /// The same by the published methods.
  Statistics TraceUnkept(Query query, const RayView& rays, const CallOptions& options,
                         const CallPlan& plan, Workspace& workspace,
                         ProgressReport& progress) const;
  void TraceUnkept(Query query, const RayPacket& packet, const CallOptions& options) const;

  /// Splits the scene into its subsets.
  void Split(SubsetScratch& scratch) const;
  bool IsUnsplit() const { return parts.kept->subset(0).root == Subset::kUnsplit; }

  /// The first call after a commit needs all threads for that, however short it is.
  void SplitForShortCall() const;

  const PreparedScenes::Part prepared_;
  std::optional<RefitPlan> refit_plan_;  ///< until it is carried out
  std::optional<Growth> growth_;         ///< the same; none if there is nothing new
};

}  // namespace dacrt

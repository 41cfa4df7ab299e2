// A call on a scene that keeps nothing: the published methods, piece by piece.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dacrt/dacrt.h"
#include "engine/device.h"
#include "geometry/triangle_refs.h"
#include "rays/packet_view.h"
#include "scene/progress_report.h"
#include "scene/scene_implementation.h"

namespace dacrt {
namespace {

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

Statistics Scene::Implementation::TraceUnkept(Query query, const RayView& rays,
                                              const CallOptions& options, const CallPlan& plan,
                                              Workspace& workspace,
                                              ProgressReport& progress) const {
  const Device::Implementation& engine = Engine();
  const GeometryTable& geometries = parts.geometries;
  Statistics statistics;
  StepClock clock;
  std::optional<TriangleRange> triangles;
  for (std::size_t first = 0; first < rays.count && progress.goes_on();) {
    const std::size_t count = std::min(plan.piece_rays, rays.count - first);
    RayBatch batch = workspace.batch();
    const CallFrame frame{&rays, nullptr, first, options, rays.instance_value};
    const PaperTask task{
        parts, engine.settings, workspace.refs(), batch, workspace.scratch(), statistics, clock,
        frame};
    const RayBlock active = [&] {
      const StepClock::Charge charge(clock, Step::kLoading);
      return LoadRays(rays, first, count, query, geometries, batch);
    }();
    // Object partition leaves the references to the next piece in another order; space partition
    // leaves them clipped.
    if (!triangles || engine.settings.algorithm == Algorithm::kMora2011) {
      const StepClock::Charge charge(clock, Step::kBinning);
      triangles = MakeTriangleRefs(geometries, workspace.refs().first(parts.triangle_count));
    }
    if (active.count > 0) engine.kernels.paper.solve(query, task, *triangles, active);
    const StepClock::Charge charge(clock, Step::kStoring);
    statistics.hits += engine.kernels.paper.store(query, rays, first, task, active);
    statistics.rays += active.count;
    ++statistics.pieces;
    progress.Add(count);
    first += count;
  }
  TakeSeconds(clock, statistics);
  return statistics;
}

void Scene::Implementation::TraceUnkept(Query query, const RayPacket& packet,
                                        const CallOptions& options) const {
  // Lanes that take no part are inactive rays.
  RayView view = ViewOf(packet);
  const void* lanes[kMostPacketLanes];
  static constexpr auto kInactive = [] {
    std::array<float, kPacketComponents * kMostPacketLanes> values{};
    values.fill(-1);
    return values;
  }();
  const auto start = reinterpret_cast<std::uintptr_t>(packet.values);
  for (uint32_t lane = 0; lane < packet.lanes; ++lane) {
    const bool is_valid = !packet.valid || packet.valid[lane] == -1;
    lanes[lane] = is_valid ? static_cast<const float*>(packet.values) + lane : kInactive.data();
  }
  view.lanes = 1;
  view.packets = lanes;
  for (RayView::Component* component :
       {&view.org_x, &view.org_y, &view.org_z,        &view.dir_x,       &view.dir_y,
        &view.dir_z, &view.tnear, &view.tfar,         &view.mask,        &view.time,
        &view.id,    &view.flags, &view.ng_x,         &view.ng_y,        &view.ng_z,
        &view.u,     &view.v,     &view.primitive_id, &view.geometry_id, &view.instance_id}) {
    if (*component != RayView::kAbsent) *component -= start;
  }
  Trace(query, view, options);
}

}  // namespace dacrt

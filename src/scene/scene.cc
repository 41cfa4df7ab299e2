// A committed scene, and the flow of one batch through the engine.

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/device.h"
#include "geometry/geometry_table.h"
#include "geometry/triangle_refs.h"
#include "partition/grid.h"
#include "partition/kept_partition.h"
#include "partition/refit.h"
#include "rays/packet_view.h"
#include "runtime/ordinary_arithmetic.h"
#include "runtime/split_memory.h"
#include "scene/scene_parts.h"
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

constexpr uint32_t kMostPacketLanes = 16;

[[noreturn, gnu::cold]] void RefuseLanes(const char* name, uint32_t lanes) {
  throw Error(Error::Kind::kArgument, "Trace", name, std::to_string(lanes),
              "it takes 1 to " + std::to_string(kMostPacketLanes));
}

inline void CheckLanes(const char* name, uint32_t lanes) {
  if (lanes - 1 >= kMostPacketLanes) [[unlikely]]
    RefuseLanes(name, lanes);
}

[[noreturn]] void RefuseDevice() {
  throw Error(Error::Kind::kArgument, "Scene", "device", "null", "a scene belongs to a device");
}

/// Tells the program how far a call is, and hears whether it is to go on.
class ProgressReport {
 public:
  ProgressReport(const Progress& progress, std::size_t rays) : progress_(progress), rays_(rays) {}

  bool goes_on() const { return goes_on_; }

  /// After a piece of `rays`.
  void Add(std::size_t rays) {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    done_ += rays;
    if (goes_on_ && !progress_(done_, rays_)) goes_on_ = false;
  }

 private:
  const Progress progress_;
  const std::size_t rays_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::atomic<bool> goes_on_{true};
};

}  // namespace

class __attribute__((visibility("hidden"))) Scene::Implementation {
 public:
  /// `previous` is null for a scene that does not come in another one's place.
  Implementation(std::shared_ptr<Device> shared_device, GeometryTable geometries,
                 const SceneOptions& options, std::vector<std::shared_ptr<const Scene>> scenes,
                 const Implementation* previous = nullptr)
      : device(std::move(shared_device)),
        instanced(std::move(scenes)),
        parts{std::move(geometries)} {
    if (previous && PlanRefit(*previous, options)) {
      parts.triangle_count = previous->parts.triangle_count;
    } else if (Engine().Keeps()) {
      const Keep keep = options.keep;
      parts.kept = std::make_unique<KeptPartition>(
          parts.geometries, Engine().BudgetBytes(parts.geometries, keep),
          Engine().kernels.partition.list, Engine().tasks, &Engine().memory);
      if (previous && previous->WasTraced()) parts.kept->SetShortLived();
      parts.bounds = parts.kept->bounds();
      parts.triangle_count = parts.kept->triangle_count();
    } else {
      CountTriangles();
    }
    parts.has_instances = !instanced.empty();
    parts.has_callbacks = parts.geometries.shapes().has_callbacks();
    parts.is_small = parts.triangle_count <= policy::kSmallScene;
    for (const auto& scene : instanced) {
      parts.has_callbacks |= scene->implementation_->parts.has_callbacks;
      parts.is_small &= scene->implementation_->parts.is_small;
    }
    // A scene that keeps nothing needs as much as its call for each triangle: that is not reserved.
    if (Engine().Keeps())
      Engine().workspaces.KeepFloor(Shape(CallPlan::Least(true, Engine().settings)));
  }

  static GeometryTable MakeTable(const Device* device, std::span<const Geometry> geometries,
                                 bool robust) {
    if (!device) RefuseDevice();
    std::vector<const SceneParts*> scenes;
    for (const Geometry& geometry : geometries) scenes.push_back(PartsFor(geometry, device));
    return GeometryTable(geometries, scenes, robust);
  }

  static std::vector<std::shared_ptr<const Scene>> ScenesOf(std::span<const Geometry> geometries) {
    std::vector<std::shared_ptr<const Scene>> scenes;
    for (const Geometry& geometry : geometries) {
      if (geometry.shape == Shape::kInstance) scenes.push_back(geometry.instanced_scene);
    }
    return scenes;
  }

  Device::Implementation& Engine() const { return *device->implementation_; }

  bool takes_over() const { return refit_plan_.has_value(); }

  /// Whether rays came since it was committed: programs that make a scene step by step send none.
  bool WasTraced() const { return parts.kept && Subset::IsNode(parts.kept->subset(0).root); }

  void TakeOver(Implementation& previous) noexcept {
    if (!refit_plan_) return;
    parts.kept = std::move(previous.parts.kept);
    previous.parts.triangle_count = 0;
    CarryOutPlan();
  }

  void TakeCopy(const Implementation& previous) {
    if (!refit_plan_) return;
    parts.kept = std::make_unique<KeptPartition>(*previous.parts.kept);
    CarryOutPlan();
  }

  bool Update(std::vector<Geometry> changed, bool always_refit) {
    struct Change {
      uint32_t geometry;
      Shapes::Successor successor;
    };
    GeometryTable& geometries = parts.geometries;
    if (!parts.kept) return false;
    std::vector<Change> changes;
    changes.reserve(changed.size());
    RefitPlan plan{std::vector<bool>(geometries.size()), always_refit};
    for (Geometry& description : changed) {
      const auto geometry = geometries.Find(description.geometry_id);
      if (!geometry) return false;
      if (description.hidden) {
        auto hidden = geometries.shapes().Hidden(*geometry);
        if (!hidden) return false;
        changes.push_back({*geometry, *std::move(hidden)});
      } else {
        const SceneParts* const scene = PartsFor(description, device.get());
        changes.push_back({*geometry, Shapes::Successor(std::move(description), scene)});
      }
      const Shapes::Successor& successor = changes.back().successor;
      if (!geometries.shapes().CanExchange(*geometry, successor)) return false;
      if (IsChanged(geometries.shapes()[*geometry], successor.geometry())) {
        plan.changed[*geometry] = true;
      }
    }
    for (Change& change : changes) geometries.Exchange(change.geometry, change.successor);
    const auto go_back = [&] {
      for (auto change = changes.rbegin(); change != changes.rend(); ++change) {
        geometries.Exchange(change->geometry, change->successor);
      }
    };
    try {
      if (!Engine().kernels.partition.can_refit(*parts.kept, geometries, plan, Engine().tasks)) {
        go_back();
        return false;
      }
    } catch (...) {
      go_back();
      throw;
    }
    Engine().kernels.partition.refit(*parts.kept, geometries, plan, Engine().tasks);
    parts.bounds = parts.kept->bounds();
    return true;
  }

  Statistics Trace(Query query, const RayView& rays, const CallOptions& options) const {
    if (parts.kept && rays.count <= policy::kShortCall) {
      if (IsUnsplit()) SplitForShortCall();
      Engine().kernels.trace.short_call(query, parts, rays, options, Engine().workspaces);
      return {};
    }
    const Device::Implementation::RunningCall call(Engine());
    CallPlan plan = PlanFor(rays.count, call.threads());
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

  void Trace(Query query, const RayPacket& packet, const CallOptions& options) const {
    if (!parts.kept) [[unlikely]]
      return TraceUnkept(query, packet, options);
    Engine().kernels.trace.packet(query, parts, packet, options, Engine().workspaces);
  }

  [[gnu::noinline]] void TraceUnkept(Query query, const RayPacket& packet,
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

  void QueryPoint(const PointQuery& query) const {
    if (!(query.radius >= 0)) return;
    PointTask task{query, query.radius, Engine().workspaces};
    Engine().kernels.query_point(task, parts);
  }

  /// See Device::WorkspaceBytes.
  std::size_t CallBytes(std::size_t ray_count) const {
    const CallPlan plan = PlanFor(ray_count, Engine().tasks.threads());
    const std::size_t bytes = Shape(plan).Bytes() * plan.workers;
    if (!parts.kept) return bytes;
    std::size_t largest = parts.triangle_count;
    for (const auto& scene : instanced) {
      largest = std::max(largest, scene->implementation_->parts.triangle_count);
    }
    return std::max(bytes, Engine().FloorBytes(!instanced.empty())) + Engine().GridBytes(largest);
  }

  std::shared_ptr<Device> device;
  std::vector<std::shared_ptr<const Scene>> instanced;
  SceneParts parts;

 private:
  /// False if there is nothing to take over, or it would not do.
  bool PlanRefit(const Implementation& previous, const SceneOptions& options) {
    const KeptPartition* const kept = previous.parts.kept.get();
    const GeometryTable& geometries = parts.geometries;
    if (!kept || previous.device != device ||
        kept->BytesReserved() !=
            KeptPartition::BytesFor(geometries.triangle_count(),
                                    Engine().BudgetBytes(geometries, options.keep)) ||
        !HaveSameItems(previous.parts.geometries, geometries)) {
      return false;
    }
    RefitPlan plan{ChangedGeometries(previous.parts.geometries, geometries), options.always_refit};
    if (!Engine().kernels.partition.can_refit(*kept, geometries, plan, Engine().tasks))
      return false;
    refit_plan_ = std::move(plan);
    return true;
  }

  void CarryOutPlan() noexcept {
    const OrdinaryArithmetic ordinary;
    Engine().kernels.partition.refit(*parts.kept, parts.geometries, *refit_plan_, Engine().tasks);
    parts.bounds = parts.kept->bounds();
    refit_plan_.reset();
  }

  static const SceneParts* PartsFor(const Geometry& geometry, const Device* device) {
    if (geometry.shape != dacrt::Shape::kInstance) return nullptr;
    const auto refuse = [&](const char* value, const char* reason) {
      throw Error(Error::Kind::kArgument, "Scene",
                  "geometry " + std::to_string(geometry.geometry_id) + ": instanced_scene", value,
                  reason);
    };
    if (!geometry.instanced_scene) refuse("null", "an instance shows a scene");
    const Implementation& inner = *geometry.instanced_scene->implementation_;
    if (inner.device.get() != device) refuse("a scene of another device", "it must be of this one");
    return &inner.parts;
  }

  /// A callback is called by the thread that calls.
  CallPlan PlanFor(std::size_t ray_count, std::size_t threads) const {
    return CallPlan(ray_count, parts.has_callbacks ? 1 : threads, parts.kept != nullptr,
                    Engine().settings);
  }

  WorkspaceShape Shape(const CallPlan& plan) const {
    return Engine().Shape(plan, parts.triangle_count, parts.geometries.is_plain(),
                          !instanced.empty());
  }

  void CountTriangles() {
    const GeometryTable& geometries = parts.geometries;
    Box& bounds = parts.bounds;
    for (uint32_t geometry = 0; geometry < geometries.size(); ++geometry) {
      for (uint32_t primitive = 0; primitive < geometries[geometry].triangle_count; ++primitive) {
        TriangleRef ref;
        if (!BoundTriangle(geometries, geometry, primitive, ref)) continue;
        bounds.Extend(ref.lower);
        bounds.Extend(ref.upper);
        ++parts.triangle_count;
      }
    }
  }

  /// One for each worker; with a smaller plan if the memory for this one cannot be had.
  void ReserveWorkspaces(CallPlan& plan, std::deque<WorkspacePool::Loan>& workspaces) const {
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
        if (!plan.Shrink()) throw;
      }
    }
  }

  /// Works on pieces until none is left.
  Statistics TracePieces(Query query, const RayView& rays, const CallOptions& options,
                         const CallPlan& plan, std::atomic<std::size_t>& next_ray,
                         Workspace& workspace, ProgressReport& progress) const {
    Statistics statistics;
    for (std::size_t first = next_ray; first < rays.count && progress.goes_on();) {
      const std::size_t count = plan.NextPiece(rays.count - first);
      if (!next_ray.compare_exchange_weak(first, first + count)) continue;
      Engine().kernels.trace.piece(query, parts, rays, first, count, options, workspace,
                                   statistics);
      progress.Add(count);
      first = next_ray;
    }
    return statistics;
  }

  /// The same by the published methods.
  Statistics TraceUnkept(Query query, const RayView& rays, const CallOptions& options,
                         const CallPlan& plan, Workspace& workspace,
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

  bool IsUnsplit() const { return parts.kept->subset(0).root == Subset::kUnsplit; }

  /// Splits the scene into its subsets.
  void Split(SubsetScratch& scratch) const {
    Engine().kernels.partition.split_all(*parts.kept, scratch, Engine().tasks);
  }

  /// The first call after a commit needs all threads for that, however short it is.
  void SplitForShortCall() const {
    if (parts.has_callbacks || Engine().tasks.threads() == 1) return;
    // To wake threads costs more than a subset.
    if (parts.triangle_count <= SubsetScratch::kTriangles) return;
    SplitMemory memory(Engine().workspaces);
    const SplitMemory::Use scratch(memory);
    if (scratch.get()) Split(*scratch.get());
  }

  std::optional<RefitPlan> refit_plan_;  ///< until it is carried out
};

Scene::Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes, Keep keep) {
  if (!device) RefuseDevice();
  implementation_ = std::make_unique<Implementation>(std::move(device), GeometryTable(meshes),
                                                     SceneOptions{.keep = keep},
                                                     std::vector<std::shared_ptr<const Scene>>());
}

Scene::Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
             const SceneOptions& options) {
  GeometryTable table = Implementation::MakeTable(device.get(), geometries, options.robust);
  implementation_ = std::make_unique<Implementation>(std::move(device), std::move(table), options,
                                                     Implementation::ScenesOf(geometries));
}

Scene::Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
             const SceneOptions& options, const Scene& previous) {
  GeometryTable table = Implementation::MakeTable(device.get(), geometries, options.robust);
  implementation_ = std::make_unique<Implementation>(std::move(device), std::move(table), options,
                                                     Implementation::ScenesOf(geometries),
                                                     previous.implementation_.get());
}

bool Scene::takes_over() const { return implementation_->takes_over(); }

void Scene::TakeOver(Scene& previous) noexcept {
  implementation_->TakeOver(*previous.implementation_);
}

void Scene::TakeCopy(const Scene& previous) {
  implementation_->TakeCopy(*previous.implementation_);
}

bool Scene::Update(std::vector<Geometry> changed, bool always_refit) {
  return implementation_->Update(std::move(changed), always_refit);
}

Scene::~Scene() = default;

Bounds Scene::bounds() const { return ToBounds(implementation_->parts.bounds); }

LinearBounds Scene::linear_bounds() const {
  return implementation_->parts.geometries.shapes().BoundLinearly();
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
  CheckLanes("options.callback_width", options.callback_width);
  if (rays.count == 0 || triangle_count() == 0) return {};
  return implementation_->Trace(query, rays, options);
}

void Scene::Trace(Query query, const RayPacket& packet, const CallOptions& options) const {
  CheckLanes("packet.lanes", packet.lanes);
  CheckLanes("options.callback_width", options.callback_width);
  if (triangle_count() == 0) return;
  implementation_->Trace(query, packet, options);
}

void Scene::QueryPoint(const PointQuery& query) const { implementation_->QueryPoint(query); }

}  // namespace dacrt

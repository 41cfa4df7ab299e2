#include "scene.h"

#include <algorithm>
#include <set>
#include <utility>

#include "boundary.h"
#include "device.h"

namespace dacrt::compat {
namespace {

RTCBounds ToEmbree(const dacrt::Bounds& bounds) {
  return {bounds.lower[0], bounds.lower[1], bounds.lower[2], 0,
          bounds.upper[0], bounds.upper[1], bounds.upper[2], 0};
}

}  // namespace

Scene::Scene(std::shared_ptr<Device> device)
    : device_(std::move(device)), first_free_id_(device_->first_geometry_id()) {}

Scene::~Scene() { HandleTable<Scene>::Instance().Forget(this); }

unsigned int Scene::Attach(std::shared_ptr<Geometry> geometry) {
  CheckIsNoCycle(*geometry);
  const std::lock_guard lock(geometries_mutex_);
  while (geometries_.contains(first_free_id_)) ++first_free_id_;
  AttachLocked(std::move(geometry), first_free_id_);
  return first_free_id_++;
}

void Scene::AttachById(std::shared_ptr<Geometry> geometry, unsigned int id) {
  if (id == RTC_INVALID_GEOMETRY_ID) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "geomID = RTC_INVALID_GEOMETRY_ID");
  }
  CheckIsNoCycle(*geometry);
  const std::lock_guard lock(geometries_mutex_);
  if (geometries_.contains(id)) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "geomID = ", id, " is taken");
  }
  AttachLocked(std::move(geometry), id);
}

void Scene::AttachLocked(std::shared_ptr<Geometry> geometry, unsigned int id) {
  if (geometry->device() != device_) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "scene and geometry are from different devices");
  }
  MakeRoomById(id);
  instance_count_ += geometry->IsInstance();
  ++revision_;
  if (geometry->is_enabled()) visible_revision_ = revision_;
  Attached& attached = geometries_[id] = {};
  attached.geometry = std::move(geometry);
  if (id < by_id_.size()) by_id_[id] = attached.geometry.get();
  const auto gone = gone_.find(id);
  if (gone == gone_.end()) return;
  attached.trace = gone->second;
  gone_.erase(gone);
}

void Scene::MakeRoomById(unsigned int id) {
  // Most IDs are numbers in a row.
  if (id < by_id_.size() || id / 2 > geometries_.size() + 32) return;
  auto place = geometries_.lower_bound(static_cast<unsigned int>(by_id_.size()));
  by_id_.resize(id + std::size_t{1});
  for (; place != geometries_.end() && place->first < id; ++place) {
    by_id_[place->first] = place->second.geometry.get();
  }
}

void Scene::CheckIsNoCycle(const Geometry& geometry) const {
  const auto& instanced = geometry.instanced_scene();
  if (instanced && instanced->LeadsTo(this)) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "scene would be an instance in itself");
  }
}

bool Scene::LeadsTo(const void* object) const {
  if (object == this) return true;
  std::set<std::shared_ptr<Scene>> instanced;
  {
    const std::lock_guard lock(geometries_mutex_);
    if (instance_count_ == 0) return false;
    for (const auto& [id, attached] : geometries_) {
      if (object == attached.geometry.get()) return true;
      if (attached.geometry->instanced_scene())
        instanced.insert(attached.geometry->instanced_scene());
    }
  }
  return std::any_of(instanced.begin(), instanced.end(),
                     [&](const auto& scene) { return scene->LeadsTo(object); });
}

void Scene::Detach(unsigned int id) {
  Attached detached;  // Destroyed after the lock.
  if (id == RTC_INVALID_GEOMETRY_ID) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "geomID = RTC_INVALID_GEOMETRY_ID");
  }
  const std::lock_guard lock(geometries_mutex_);
  const auto place = geometries_.find(id);
  if (place == geometries_.end()) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "geomID = ", id, " is not attached");
  }
  Remember(id, place->second.trace, gone_);
  detached = std::move(place->second);
  instance_count_ -= detached.geometry->IsInstance();
  geometries_.erase(place);
  if (id < by_id_.size()) by_id_[id] = nullptr;
  if (id >= device_->first_geometry_id()) first_free_id_ = std::min(first_free_id_, id);
  visible_revision_ = ++revision_;
}

void Scene::Remember(unsigned int id, const Trace& trace, std::map<unsigned int, Trace>& gone) {
  if (trace.is_visible || trace.is_known()) gone[id] = trace;
}

Geometry* Scene::Find(unsigned int id) const {
  if (id < by_id_.size()) return by_id_[id];
  const auto place = geometries_.find(id);
  return place == geometries_.end() ? nullptr : place->second.geometry.get();
}

Geometry* Scene::FindThreadSafe(unsigned int id) const {
  const std::lock_guard lock(geometries_mutex_);
  return Find(id);
}

void Scene::Commit() {
  const std::lock_guard commit_lock(commit_mutex_);
  // What may be the last to keep something of the program's, destroyed after the lock.
  AskedBounds asked;
  Succession next;
  Selection selection;
  for (bool in_place = true;;) {
    std::unique_lock lock(geometries_mutex_);
    const Changes changes = FindChanges();
    if (!changes.need_commit) return;
    CheckComplete(changes);
    if (in_place && !changes.need_snapshot && Describe(changes, next)) {
      if (changes.need_bounds) {
        const uint64_t revision = revision_;
        lock.unlock();
        for (const dacrt::Geometry& geometry : next.descriptions) asked.Ask(geometry);
        lock.lock();
        in_place = revision_ == revision;  // Else geometries have come or gone meanwhile.
        if (!in_place) continue;
        for (dacrt::Geometry& geometry : next.descriptions) asked.Answer(geometry);
      }
      if (Update(changes, next)) return;
    }
    selection = Select(asked);
    break;
  }
  // Without the lock: the progress monitor may call the API. Embree does not call it for an empty
  // scene either.
  const bool is_empty = selection.geometries.empty();
  if (!is_empty) ReportProgress(0);
  // Only commits, of which there is one at a time, exchange the snapshot.
  auto snapshot = std::make_shared<Snapshot>(*device_, selection, snapshot_.get());
  if (!is_empty) ReportProgress(1);
  Install(selection, std::move(snapshot));
}

Scene::Snapshot::Snapshot(Device& device, const Selection& selection, const Snapshot* previous)
    : has_instances_(std::any_of(
          selection.geometries.begin(), selection.geometries.end(),
          [](const dacrt::Geometry& geometry) { return geometry.shape == Shape::kInstance; })),
      scene_(previous && !device.ranks()
                 ? dacrt::Scene(device.engine(), selection.geometries, OptionsFor(selection),
                                previous->scene_)
                 : dacrt::Scene(device.engine(), selection.geometries, OptionsFor(selection))) {
  if (const auto& ranks = device.ranks()) {
    shared_ = ranks->Commit(mpi::Local(*device.engine(), scene_), selection.geometries,
                            OptionsFor(selection));
    if (!shared_->is_shared()) device.NoteSceneStays();
  }
}

SceneOptions Scene::Snapshot::OptionsFor(const Selection& selection) {
  return {selection.flags & RTC_SCENE_FLAG_COMPACT ? Keep::kLittle : Keep::kByBudget,
          (selection.flags & RTC_SCENE_FLAG_ROBUST) != 0, selection.always_refit,
          selection.splits_with_care};
}

Scene::Changes Scene::FindChanges() {
  Changes changes;
  changes.need_commit =
      revision_ != committed_revision_ || flags_ != committed_flags_ || device_->is_divided();
  changes.need_snapshot =
      !snapshot_ || flags_ != committed_flags_ || device_->ranks() || progress_function_;
  for (Place& place : geometries_) {
    const Attached& attached = place.second;
    const Geometry& geometry = *attached.geometry;
    const bool is_enabled = geometry.is_enabled(), was_visible = attached.trace.is_visible;
    if (is_enabled && geometry.is_modified()) {
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "the geometry with geomID = ", place.first,
                     " was changed and not committed");
    }
    const Versions versions = Versions::Of(geometry);
    changes.need_commit |= versions.version != attached.committed.version;
    if (is_enabled) {
      changes.always_refit &= geometry.build_quality() == RTC_BUILD_QUALITY_REFIT;
      changes.need_snapshot |= !was_visible && !attached.trace.is_known();
    }
    // User geometries are asked for their bounds at every commit, as Embree does it.
    const bool is_asked = is_enabled && geometry.IsUser() && attached.trace.is_known();
    changes.need_bounds |= is_asked;
    if (is_asked || is_enabled != was_visible || versions != attached.committed) {
      (attached.HasMovedAtMost() ? changes.moved : changes.described_anew).push_back(&place);
    }
  }
  for (auto& gone : gone_) {
    if (gone.second.is_visible) changes.gone.push_back(&gone);
  }
  return changes;
}

/// Where Embree crashes.
void Scene::CheckComplete(const Changes& changes) {
  for (const Place* place : changes.described_anew) {
    const Geometry& geometry = *place->second.geometry;
    if (!geometry.is_enabled()) continue;
    if (const char* const lack = geometry.Lack()) {
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "the geometry with geomID = ", place->first,
                     " has no ", lack);
    }
    static_assert(RTC_MAX_INSTANCE_LEVEL_COUNT == 1);
    if (geometry.IsInstance() && geometry.instanced_scene()->HasInstances()) {
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "the geometry with geomID = ", place->first,
                     " is an instance of a scene that has instances");
    }
  }
}

bool Scene::Describe(const Changes& changes, Succession& next) const {
  const bool context_filter = (flags_ & RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) != 0;
  next.descriptions.reserve(changes.described_anew.size() + changes.gone.size());
  next.committed.reserve(changes.described_anew.size() + changes.moved.size());
  const auto hide = [&](unsigned int id, Trace& trace) {
    dacrt::Geometry& description = next.descriptions.emplace_back();
    description.geometry_id = id;
    description.hidden = true;
    next.used.resize(next.used.size() + trace.used_count);
    next.traces.emplace_back(&trace, false);
  };
  for (Place* place : changes.described_anew) {
    auto& [id, attached] = *place;
    next.committed.emplace_back(&attached, Versions::Of(*attached.geometry));
    if (!attached.geometry->is_enabled()) {
      if (attached.trace.is_visible) hide(id, attached.trace);
      continue;
    }
    const std::size_t used_before = next.used.size();
    next.descriptions.push_back(Describe(*place, context_filter, next.used));
    next.traces.emplace_back(&attached.trace, true);
    if (next.descriptions.back().primitive_count == 0) return false;
    if (next.used.size() - used_before != attached.trace.used_count) return false;
  }
  for (auto* gone : changes.gone) hide(gone->first, gone->second);
  for (Place* place : changes.moved) {
    next.committed.emplace_back(&place->second, Versions::Of(*place->second.geometry));
  }
  return true;
}

bool Scene::Update(const Changes& changes, Succession& next) {
  if (snapshot_.use_count() > 1) return false;  // Instances show it.
  std::vector<Placement> placements;
  placements.reserve(changes.moved.size());
  for (const Place* place : changes.moved) {
    placements.push_back({place->first, place->second.geometry->transforms()});
  }
  if (!snapshot_->Update(std::move(next.descriptions), placements, changes.always_refit)) {
    return false;
  }
  auto next_used = next.used.begin();
  for (const auto& [trace, is_visible] : next.traces) {
    next_used =
        std::swap_ranges(snapshot_->used().begin() + trace->used,
                         snapshot_->used().begin() + trace->used + trace->used_count, next_used);
    trace->is_visible = is_visible;
  }
  for (const auto& [attached, versions] : next.committed) attached->committed = versions;
  committed_revision_ = revision_;
  ++commit_count_;
  return true;
}

/// A geometry for the engine, and what that refers to: of an instance its scene, for to keep the
/// instance would keep the scene that it may get next.
dacrt::Geometry Scene::Describe(const Place& place, bool context_filter, Used& used) {
  const auto& [id, attached] = place;
  dacrt::Geometry description = attached.geometry->Describe(id, context_filter);
  if (description.primitive_count == 0) return description;
  if (attached.geometry->IsInstance()) {
    used.push_back(description.instanced_scene);
  } else {
    used.push_back(attached.geometry);  // Callbacks refer to it.
    attached.geometry->AddUsedBuffers(used);
  }
  return description;
}

Scene::Selection Scene::Select(AskedBounds& asked) const {
  Selection selection;
  selection.revision = revision_;
  selection.flags = flags_;
  selection.always_refit = true;
  // Unless the program says that there will not be many rays, or has thrown others away already.
  selection.splits_with_care = (flags_ & RTC_SCENE_FLAG_DYNAMIC) == 0 &&
                               build_quality_ != RTC_BUILD_QUALITY_LOW &&
                               (!snapshot_ || snapshot_->scene().triangle_count() == 0);
  selection.attached.reserve(geometries_.size());
  selection.geometries.reserve(geometries_.size());
  const bool context_filter = (flags_ & RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) != 0;
  for (const Place& place : geometries_) {
    Attached& attached = selection.attached.emplace_back(place).second;
    const Geometry& geometry = *attached.geometry;
    attached.committed = Versions::Of(geometry);
    attached.trace.is_visible = geometry.is_enabled();
    attached.trace.is_instance = geometry.IsInstance();
    attached.trace.used = selection.used.size();
    attached.trace.used_count = 0;
    if (!geometry.is_enabled()) continue;
    dacrt::Geometry description = Describe(place, context_filter, selection.used);
    attached.trace.used_count = selection.used.size() - attached.trace.used;
    if (description.primitive_count == 0) continue;
    asked.Answer(description);
    selection.always_refit &= geometry.build_quality() == RTC_BUILD_QUALITY_REFIT;
    selection.geometries.push_back(std::move(description));
  }
  return selection;
}

void Scene::Install(Selection& selection, std::shared_ptr<Snapshot> snapshot) {
  const std::lock_guard lock(geometries_mutex_);
  // Before anything changes: there may be no memory for it. Geometries may have come and gone since
  // the commit began.
  std::map<unsigned int, Trace> gone;
  for (const auto& [id, attached] : selection.attached) {
    if (!geometries_.contains(id)) Remember(id, attached.trace, gone);
  }
  if (snapshot->takes_over()) {
    // One that instances show stays as it is.
    if (snapshot_.use_count() > 1) {
      snapshot->TakeCopy(*snapshot_);
    } else {
      snapshot->TakeOver(*snapshot_);
    }
  }
  snapshot->Keep(std::move(selection.used));
  gone_.swap(gone);
  // Both are in the order of IDs.
  auto place = geometries_.begin();
  for (const auto& [id, attached] : selection.attached) {
    while (place != geometries_.end() && place->first < id) ++place;
    if (place == geometries_.end()) break;
    if (place->first != id) continue;
    if (place->second.geometry == attached.geometry) {
      place->second = attached;
    } else {
      place->second = {
          .geometry = place->second.geometry, .committed = {}, .trace = attached.trace};
    }
  }
  committed_revision_ = selection.revision;
  committed_flags_ = selection.flags;
  ++commit_count_;
  snapshot_.swap(snapshot);  // The old one goes with `snapshot`, after the lock.
}

void Scene::ReportProgress(double done) const {
  if (progress_function_ && !progress_function_(progress_user_pointer_, done)) {
    throw ApiError(RTC_ERROR_CANCELLED, "the progress monitor cancelled the commit");
  }
}

void Scene::SetProgressMonitor(RTCProgressMonitorFunction function, void* user_pointer) {
  progress_function_ = function;
  progress_user_pointer_ = user_pointer;
}

void Scene::SetBuildQuality(RTCBuildQuality quality) {
  if (quality < RTC_BUILD_QUALITY_LOW || quality > RTC_BUILD_QUALITY_HIGH) {
    throw ApiError(RTC_ERROR_UNKNOWN, "quality = ", static_cast<int>(quality),
                   " is no build quality of a scene");
  }
  build_quality_ = quality;
}

const dacrt::Scene& Scene::CommittedAsItStands() const {
  if (visible_revision_ > committed_revision_) {
    RefuseUncommitted();
  }
  return Committed();
}

RTCBounds Scene::Bounds() const {
  const std::lock_guard lock(geometries_mutex_);
  return ToEmbree(CommittedAsItStands().bounds());
}

RTCLinearBounds Scene::LinearBounds() const {
  const std::lock_guard lock(geometries_mutex_);
  const dacrt::LinearBounds bounds = CommittedAsItStands().linear_bounds();
  return {ToEmbree(bounds.begin), ToEmbree(bounds.end)};
}

std::shared_ptr<const dacrt::Scene> Scene::CommittedShared() const {
  const std::lock_guard lock(geometries_mutex_);
  return snapshot_ ? std::shared_ptr<const dacrt::Scene>(snapshot_, &snapshot_->scene()) : nullptr;
}

bool Scene::HasInstances() const {
  const std::lock_guard lock(geometries_mutex_);
  if (!snapshot_ || !snapshot_->has_instances()) return false;
  return std::ranges::any_of(geometries_,
                             [](const Place& place) { return place.second.trace.ShowsScene(); }) ||
         std::ranges::any_of(gone_, [](const auto& gone) { return gone.second.ShowsScene(); });
}

void Scene::RefuseUncommitted() {
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "the scene is not committed");
}

}  // namespace dacrt::compat

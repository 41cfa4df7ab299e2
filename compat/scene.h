// A scene: geometries by ID, and what the last commit made of them.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "asked_bounds.h"
#include "dacrt/dacrt.h"
#include "dacrt/mpi.h"
#include "geometry.h"

namespace dacrt::compat {

/// Threads: geometries may be attached, detached and fetched by any number at once, and any number
/// may commit, where one does the work and the others wait for it. Between a commit's start and end
/// and while the scene is modified the program does not trace it, which is the API's rule.
class Scene : public std::enable_shared_from_this<Scene> {
 public:
  explicit Scene(std::shared_ptr<Device> device);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const std::shared_ptr<Device>& device() const { return device_; }

  /// Attaches under the smallest free ID, which is returned. Throws RTC_ERROR_INVALID_OPERATION for
  /// an instance of this scene, or of one that leads to it.
  unsigned int Attach(std::shared_ptr<Geometry> geometry);
  void AttachById(std::shared_ptr<Geometry> geometry, unsigned int id);
  void Detach(unsigned int id);

  /// Null if no geometry has this ID. Unlike everything else here, not safe while another thread
  /// attaches or detaches, and free of locks for that.
  Geometry* Find(unsigned int id) const;
  Geometry* FindThreadSafe(unsigned int id) const;

  /// Makes the present state of the enabled geometries the one that is traced. If it throws, the
  /// scene stays as it was.
  void Commit();

  void SetProgressMonitor(RTCProgressMonitorFunction function, void* user_pointer);
  void SetBuildQuality(RTCBuildQuality quality);
  RTCSceneFlags flags() const { return flags_; }
  void set_flags(RTCSceneFlags flags) { flags_ = flags; }

  /// Throws RTC_ERROR_INVALID_OPERATION if geometries were attached, but for disabled ones, or
  /// detached since the last commit, or if there was none.
  RTCBounds Bounds() const;

  /// The bounds at the ends of the time range from 0 to 1; between them lie those of all times.
  RTCLinearBounds LinearBounds() const;

  /// What the last commit made. Throws RTC_ERROR_INVALID_OPERATION if there was none.
  const dacrt::Scene& Committed() const {
    if (!snapshot_) [[unlikely]]
      RefuseUncommitted();
    return snapshot_->scene();
  }

  /// The same as several ranks have it; null where the device works alone.
  mpi::GroupScene* CommittedTogether() const { return snapshot_ ? snapshot_->shared() : nullptr; }

  /// The same for scenes that have an instance of this one, with all that it refers to. Null if
  /// there was no commit.
  std::shared_ptr<const dacrt::Scene> CommittedShared() const;

  /// Whether `object`, a scene or a geometry, is this scene, is in it, or is in a scene that it has
  /// an instance of.
  bool LeadsTo(const void* object) const;

  /// Whether there were instances at the last commit.
  bool HasInstances() const;

  /// Grows with every commit that changed something.
  uint64_t commit_count() const { return commit_count_; }

 private:
  /// What the snapshot knows of an ID.
  struct Trace {
    bool is_visible = false;
    bool is_instance = false;
    std::size_t used = 0;  ///< where what it uses stands in what the snapshot keeps
    std::size_t used_count = 0;

    /// Whether the snapshot has it, be it hidden.
    bool is_known() const { return used_count > 0; }
    bool ShowsScene() const { return is_visible && is_instance && is_known(); }
  };

  /// Of a geometry: see its functions of these names.
  struct Versions {
    static Versions Of(const Geometry& geometry) {
      return {geometry.version(), geometry.description_version(), geometry.placement_version()};
    }
    bool operator==(const Versions&) const = default;

    uint64_t version = 0;
    uint64_t description = 0;
    uint64_t placement = 0;
  };

  struct Attached {
    std::shared_ptr<Geometry> geometry;
    Versions committed;  ///< those of the last commit
    Trace trace;

    /// Whether the snapshot shows this instance, and where it stands is all that may have changed.
    bool HasMovedAtMost() const {
      return trace.ShowsScene() && geometry->is_enabled() &&
             geometry->description_version() == committed.description;
    }
  };
  using Place = std::pair<const unsigned int, Attached>;

  /// What has changed since the last commit.
  struct Changes {
    bool need_commit = false;
    bool need_snapshot = false;  ///< more than the descriptions of some geometries
    bool need_bounds = false;    ///< of user geometries
    bool always_refit = true;    ///< all are of REFIT quality
    std::vector<Place*> described_anew;
    std::vector<Place*> moved;  ///< instances that are otherwise what they were
    std::vector<std::pair<const unsigned int, Trace>*> gone;
  };

  /// Memory and objects that descriptions refer to.
  using Used = std::vector<std::shared_ptr<const void>>;

  /// What the snapshot is to become in the places of what has changed.
  struct Succession {
    std::vector<dacrt::Geometry> descriptions;
    std::vector<std::pair<Trace*, bool>> traces;  ///< of these, and whether they will be visible
    Used used;  ///< by each as many as by its trace; afterwards what is not used any more
    std::vector<std::pair<Attached*, Versions>> committed;
  };

  /// What a commit is made of, as it was when the commit began.
  struct Selection {
    uint64_t revision = 0;
    RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
    std::vector<std::pair<unsigned int, Attached>> attached;  ///< all, by ID, as they will be
    std::vector<dacrt::Geometry> geometries;                  ///< the enabled ones
    bool always_refit = false;                                ///< all are of REFIT quality
    bool splits_with_care = false;                            ///< see dacrt::SceneOptions
    Used used;
  };

  /// The engine's scene with the memory that it reads, which goes after it.
  class Snapshot {
   public:
    /// In the place of `previous`, unless that is null.
    Snapshot(Device& device, const Selection& selection, const Snapshot* previous);
    Snapshot(const Snapshot&) = delete;
    Snapshot& operator=(const Snapshot&) = delete;

    const dacrt::Scene& scene() const { return scene_; }

    /// Whether the scene will take over what the previous one keeps, which is then done for.
    bool takes_over() const { return scene_.takes_over(); }
    void TakeOver(Snapshot& previous) noexcept { scene_.TakeOver(previous.scene_); }
    void TakeCopy(const Snapshot& previous) { scene_.TakeCopy(previous.scene_); }

    /// Whether the scene is now as `changed` says; else it is as before.
    bool Update(std::vector<dacrt::Geometry> changed, std::span<const Placement> placed,
                bool always_refit) {
      return scene_.Update(std::move(changed), placed, always_refit);
    }

    /// Keeps what the scene refers to as long as it is there.
    void Keep(Used used) { used_ = std::move(used); }
    Used& used() { return used_; }

    /// The same scene, as several ranks have it; null without.
    mpi::GroupScene* shared() const { return shared_.get(); }
    bool has_instances() const { return has_instances_; }  ///< hidden ones among them

   private:
    static SceneOptions OptionsFor(const Selection& selection);

    const bool has_instances_;
    Used used_;
    dacrt::Scene scene_;
    std::unique_ptr<mpi::GroupScene> shared_;
  };

  void AttachLocked(std::shared_ptr<Geometry> geometry, unsigned int id);
  /// Before a geometry gets that ID.
  void MakeRoomById(unsigned int id);
  void CheckIsNoCycle(const Geometry& geometry) const;
  /// Throws RTC_ERROR_INVALID_OPERATION if an enabled geometry was changed and not committed.
  Changes FindChanges();
  static void CheckComplete(const Changes& changes);
  /// Describes what has changed. False if another snapshot must be made.
  bool Describe(const Changes& changes, Succession& next) const;
  /// Brings the snapshot up to date in its place. False, and nothing is done, if another one must
  /// be made.
  bool Update(const Changes& changes, Succession& next);
  /// Keeps what the snapshot knows of a geometry that is not there any more.
  static void Remember(unsigned int id, const Trace& trace, std::map<unsigned int, Trace>& gone);
  static dacrt::Geometry Describe(const Place& place, bool context_filter, Used& used);
  [[noreturn]] static void RefuseUncommitted();
  /// Throws RTC_ERROR_INVALID_OPERATION as Bounds does.
  const dacrt::Scene& CommittedAsItStands() const;
  /// `asked` are bounds that need not be asked for again.
  Selection Select(AskedBounds& asked) const;
  void Install(Selection& selection, std::shared_ptr<Snapshot> snapshot);
  void ReportProgress(double done) const;

  const std::shared_ptr<Device> device_;

  mutable std::mutex geometries_mutex_;  ///< of the next ten
  std::map<unsigned int, Attached> geometries_;
  /// Those of IDs below its size, null where there is none: programs ask for them at each hit.
  std::vector<Geometry*> by_id_;
  std::map<unsigned int, Trace> gone_;  ///< detached ones that the snapshot knows
  std::size_t instance_count_ = 0;      ///< of these
  unsigned int first_free_id_;          ///< no smaller ID is free, from the device's first on
  uint64_t revision_ = 1;               ///< grows when geometries are attached or detached
  uint64_t visible_revision_ = 1;       ///< the last one but for attaching what is disabled
  uint64_t committed_revision_ = 0;     ///< the one that was committed last
  RTCSceneFlags committed_flags_ = RTC_SCENE_FLAG_NONE;
  std::shared_ptr<Snapshot> snapshot_;

  std::atomic<uint64_t> commit_count_{0};

  std::mutex commit_mutex_;  ///< one commit at a time; taken before the other
  RTCProgressMonitorFunction progress_function_ = nullptr;
  void* progress_user_pointer_ = nullptr;
  RTCSceneFlags flags_ = RTC_SCENE_FLAG_NONE;
  RTCBuildQuality build_quality_ = RTC_BUILD_QUALITY_MEDIUM;
};

inline Device& DeviceOf(Scene& scene) { return *scene.device(); }

}  // namespace dacrt::compat

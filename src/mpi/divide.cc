// Mode::kDivide: scenes of which every rank has a part.
#include <algorithm>
#include <mutex>

#include "divided_call.h"
#include "members.h"

namespace dacrt::mpi {
namespace {

class DividedGroup : public Group, public std::enable_shared_from_this<DividedGroup> {
 public:
  DividedGroup(MPI_Comm communicator, const Options& options)
      : members_(communicator, options), bundle_rays_(options.piece_rays) {}

  int rank() const override { return members_.link().rank(); }
  int size() const override { return members_.link().size(); }
  std::size_t least_rays() const override { return 0; }
  Ending End() override { return members_.is_broken() ? Ending::kAbort : Ending::kFinalise; }

  Traffic traffic() const override {
    const std::lock_guard lock(mutex_);
    Traffic traffic = traffic_;
    traffic.messages_sent = members_.link().messages_sent();
    traffic.messages_received = members_.link().messages_received();
    traffic.bytes_sent = members_.link().bytes_sent();
    traffic.bytes_received = members_.link().bytes_received();
    return traffic;
  }

  std::unique_ptr<GroupScene> Commit(const LocalScene& local, std::span<const Geometry> geometries,
                                     const SceneOptions& options) override;

  void Trace(const LocalScene& local, const DividedParts& parts, Query query, const RayView& rays,
             const CallOptions& options) {
    const std::lock_guard lock(mutex_);
    ++traffic_.calls;
    if (members_.link().size() == 1) {
      local.trace(query, rays, options);
      return;
    }
    ++traffic_.calls_shared;
    members_.Together([&] {
      DividedCall call(members_, local, parts, next_call_++, bundle_rays_, room_, query, rays,
                       options, traffic_);
      call.Run();
      call.Store();
    });
  }

 private:
  mutable std::mutex mutex_;
  Members members_;
  const std::size_t bundle_rays_;
  Bundle room_;
  uint64_t next_scene_ = 1, next_call_ = 0;
  Traffic traffic_;
};

class DividedScene : public GroupScene {
 public:
  DividedScene(std::shared_ptr<DividedGroup> group, LocalScene local, DividedParts parts)
      : group_(std::move(group)), local_(std::move(local)), parts_(std::move(parts)) {}

  void Trace(Query query, const RayView& rays, const CallOptions& options) override {
    group_->Trace(local_, parts_, query, rays, options);
  }
  bool is_shared() const override { return true; }

 private:
  const std::shared_ptr<DividedGroup> group_;
  const LocalScene local_;
  const DividedParts parts_;
};

bool HasCallbacks(const Geometry& geometry) {
  return geometry.shape == Shape::kUser || geometry.closest_filter || geometry.any_filter;
}

std::unique_ptr<GroupScene> DividedGroup::Commit(const LocalScene& local,
                                                 std::span<const Geometry> geometries,
                                                 const SceneOptions&) {
  const std::lock_guard lock(mutex_);
  // What an instance leads to is not known here, and may have callbacks.
  const bool has_callbacks =
      std::any_of(geometries.begin(), geometries.end(), [](const Geometry& geometry) {
        return HasCallbacks(geometry) || geometry.shape == Shape::kInstance;
      });
  std::vector<PartSummary> summaries;
  members_.Together([&] {
    summaries = members_.Gather(PartSummary{local.bounds, has_callbacks, local.instruction_set});
  });
  std::vector<Bounds> bounds;
  bool any_has_callbacks = false;
  for (const PartSummary& summary : summaries) {
    if (summary.instruction_set != local.instruction_set) {
      throw Error(Error::Kind::kArgument, "Commit", "instruction_set",
                  std::string(Name(summary.instruction_set)),
                  "ranks use different ones, and would find different hits: limit all to one, "
                  "with isa");
    }
    bounds.push_back(summary.bounds);
    any_has_callbacks |= summary.has_callbacks != 0;
  }
  return std::make_unique<DividedScene>(
      shared_from_this(), local,
      DividedParts{next_scene_++, RouteBoxes(bounds), any_has_callbacks, KeyBounds(geometries)});
}

}  // namespace

std::shared_ptr<Group> Divide(MPI_Comm communicator, const Options& options) {
  return std::make_shared<DividedGroup>(communicator, options);
}

}  // namespace dacrt::mpi

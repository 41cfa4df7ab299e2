// Mode::kReplicate, on the rank that has the program.
#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <set>

#include "crew.h"
#include "link_speed.h"
#include "pieces.h"
#include "scene_message.h"
#include "view_piece.h"
#include "wire.h"

namespace dacrt::mpi {
namespace {

/// Arrays travel in parts, which MPI and memory can take.
constexpr std::size_t kPartBytes = 8u << 20;

/// Pieces on their way to one worker or back: one that it traces, one that it finds next.
constexpr int kPiecesAhead = 2;

/// A worker that gets fewer rays does not trace at full speed.
constexpr std::size_t kLeastPiece = 4096;

class ReplicatedGroup : public Group, public std::enable_shared_from_this<ReplicatedGroup> {
 public:
  ReplicatedGroup(MPI_Comm communicator, const Options& options)
      : crew_(communicator, options), piece_rays_(options.piece_rays) {
    least_rays_ = options.least_rays;
    if (least_rays_ == Options::kMeasured) {
      least_rays_ = LeastRays(MeasureLink(crew_), static_cast<std::size_t>(crew_.size()));
    }
  }

  int rank() const override { return 0; }
  int size() const override { return crew_.size(); }
  std::size_t least_rays() const override { return least_rays_; }

  Ending End() override {
    const std::lock_guard lock(mutex_);
    crew_.Stop();
    if (crew_.faults().empty()) return Ending::kFinalise;
    return crew_.KillHung() ? Ending::kLeave : Ending::kAbort;
  }

  Traffic traffic() const override {
    const std::lock_guard lock(mutex_);
    Traffic traffic = traffic_;
    traffic.calls += calls_alone_;
    traffic.messages_sent = crew_.link().messages_sent();
    traffic.messages_received = crew_.link().messages_received();
    traffic.bytes_sent = crew_.link().bytes_sent();
    traffic.bytes_received = crew_.link().bytes_received();
    return traffic;
  }

  std::unique_ptr<GroupScene> Commit(const LocalScene& local, std::span<const Geometry> geometries,
                                     const SceneOptions& options) override;

  /// Tells the workers that a scene is not needed any more.
  void Forget(const Scene* scene, uint64_t number, const std::vector<ArrayName>& names);

  /// Answers `query`, together with the workers if none of them is busy with another call.
  void Trace(const LocalScene& local, uint64_t number, Query query, const RayView& rays,
             const CallOptions& options);

  /// Answers it alone.
  void TraceAlone(const LocalScene& local, Query query, const RayView& rays,
                  const CallOptions& options);

 private:
  class Call;

  void SendMissing(const PackedScene& packed);
  void ThrowIfLost();

  mutable std::mutex mutex_;  ///< of all that follows, but for what is atomic
  mutable Crew crew_;
  std::size_t least_rays_;
  const std::size_t piece_rays_;
  std::map<const Scene*, uint64_t> numbers_;  ///< of scenes that the workers have
  std::map<ArrayName, int> held_;             ///< how many of these scenes use an array
  uint64_t next_scene_ = 1;
  uint64_t next_piece_ = 1;
  Traffic traffic_;
  std::atomic<uint64_t> calls_alone_{0};
  std::atomic<bool> has_lost_{false};
};

class ReplicatedScene : public GroupScene {
 public:
  /// `number` 0 stands for a scene that the workers do not have.
  ReplicatedScene(std::shared_ptr<ReplicatedGroup> group, LocalScene local, uint64_t number,
                  std::vector<ArrayName> names)
      : group_(std::move(group)),
        local_(std::move(local)),
        number_(number),
        names_(std::move(names)) {}
  ~ReplicatedScene() override {
    if (number_ != 0) group_->Forget(local_.scene, number_, names_);
  }

  void Trace(Query query, const RayView& rays, const CallOptions& options) override {
    if (number_ == 0 || rays.count < group_->least_rays()) {
      group_->TraceAlone(local_, query, rays, options);
    } else {
      group_->Trace(local_, number_, query, rays, options);
    }
  }
  bool is_shared() const override { return number_ != 0; }

 private:
  const std::shared_ptr<ReplicatedGroup> group_;
  const LocalScene local_;
  const uint64_t number_;
  const std::vector<ArrayName> names_;
};

std::unique_ptr<GroupScene> ReplicatedGroup::Commit(const LocalScene& local,
                                                    std::span<const Geometry> geometries,
                                                    const SceneOptions& options) {
  const std::lock_guard lock(mutex_);
  const auto make_local = [&] {
    return std::make_unique<ReplicatedScene>(shared_from_this(), local, 0,
                                             std::vector<ArrayName>());
  };
  if (crew_.workers().empty()) return make_local();
  const uint64_t number = next_scene_++;
  const auto number_of = [&](const Scene* scene) -> std::optional<uint64_t> {
    const auto place = numbers_.find(scene);
    return place == numbers_.end() ? std::nullopt : std::optional(place->second);
  };
  auto packed = PackScene(number, local, geometries, options, number_of);
  if (!packed) return make_local();
  SendMissing(*packed);
  Message message;
  message.Put(Command::kScene);
  std::memcpy(message.Extend(packed->message.size()), packed->message.data(),
              packed->message.size());
  crew_.SendAll(std::move(message));
  for (const ArrayName& name : packed->names) ++held_[name];
  numbers_[local.scene] = number;
  has_lost_ = !crew_.faults().empty();
  return std::make_unique<ReplicatedScene>(shared_from_this(), local, number,
                                           std::move(packed->names));
}

void ReplicatedGroup::SendMissing(const PackedScene& packed) {
  std::set<ArrayName> sent;
  for (std::size_t i = 0; i < packed.arrays.size(); ++i) {
    const ArraySource& array = packed.arrays[i];
    const ArrayName& name = packed.names[i];
    if (name.bytes == 0 || held_.contains(name) || !sent.insert(name).second) continue;
    const std::size_t items_a_part = std::max<std::size_t>(1, kPartBytes / array.item_bytes);
    for (std::size_t first = 0; first < array.count; first += items_a_part) {
      const std::size_t count = std::min(items_a_part, array.count - first);
      Message part;
      part.Put(Command::kArray);
      part.Put(name);
      part.Put(static_cast<uint64_t>(first * array.item_bytes));
      CopyItems(array, first, count, part.Extend(count * array.item_bytes));
      crew_.SendAll(std::move(part));
      crew_.WaitForRoom();
    }
  }
}

void ReplicatedGroup::Forget(const Scene* scene, uint64_t number,
                             const std::vector<ArrayName>& names) {
  const std::lock_guard lock(mutex_);
  Message message;
  message.Put(Command::kForget);
  message.Put(number);
  crew_.SendAll(std::move(message));
  const auto place = numbers_.find(scene);
  if (place != numbers_.end() && place->second == number) numbers_.erase(place);
  for (const ArrayName& name : names) {
    const auto held = held_.find(name);
    if (--held->second == 0) held_.erase(held);
  }
}

void ReplicatedGroup::ThrowIfLost() {
  if (!has_lost_) return;
  const std::lock_guard lock(mutex_);
  throw Fault(crew_.faults() + "; its rays are traced by the ranks that are left");
}

void ReplicatedGroup::TraceAlone(const LocalScene& local, Query query, const RayView& rays,
                                 const CallOptions& options) {
  local.trace(query, rays, options);
  ++calls_alone_;
  ThrowIfLost();
}

/// One call that is shared. Whatever happens, no worker has a piece of it when it ends.
class ReplicatedGroup::Call {
 public:
  Call(ReplicatedGroup& group, const LocalScene& local, uint64_t scene, Query query,
       const RayView& rays, const CallOptions& options)
      : group_(group),
        crew_(group.crew_),
        local_(local),
        scene_(scene),
        query_(query),
        rays_(rays),
        options_(options) {}

  void Run() {
    try {
      while (Step()) {
      }
    } catch (...) {
      // The rays that are out come back, or their rank is lost; none is sent any more.
      next_ray_ = rays_.count;
      returned_.clear();
      while (!out_.empty()) {
        if (!TakeAnswer()) Wait();
        returned_.clear();
      }
      throw;
    }
  }

 private:
  struct Range {
    std::size_t first, count;
  };
  struct Out {
    int rank;
    Range range;
  };

  /// Does one thing: first what others wait for.
  bool Step() {
    const Clock::time_point start = Clock::now();
    const bool took = TakeAnswer();
    const bool sent = SendPieces();
    group_.traffic_.seconds_moving += SecondsSince(start);
    if (took || sent) {
      idle_.Reset();
      return true;
    }
    if (const auto range = NextRange()) {
      const Clock::time_point trace_start = Clock::now();
      local_.trace(query_, Piece(rays_, range->first, range->count), options_);
      group_.traffic_.rays_traced += range->count;
      group_.traffic_.seconds_tracing += SecondsSince(trace_start);
      return true;
    }
    if (out_.empty()) return false;
    const Clock::time_point wait_start = Clock::now();
    Wait();
    group_.traffic_.seconds_waiting += SecondsSince(wait_start);
    return true;
  }

  void Wait() {
    idle_.Pause();
    crew_.LoseSilent();
    TakeBack();
  }

  /// Rays that nobody has yet. Pieces grow smaller towards the end, so that all end together.
  std::optional<Range> NextRange() {
    if (!returned_.empty()) {
      const Range range = returned_.back();
      returned_.pop_back();
      return range;
    }
    if (next_ray_ == rays_.count) return std::nullopt;
    const std::size_t ranks = crew_.workers().size() + 1;
    const std::size_t share = (rays_.count - next_ray_) / (3 * ranks);
    const std::size_t wanted =
        std::min(std::max(share, std::min(kLeastPiece, group_.piece_rays_)), group_.piece_rays_);
    const Range range{next_ray_, PieceLength(rays_, next_ray_, wanted)};
    next_ray_ += range.count;
    return range;
  }

  bool SendPieces() {
    bool sent = false;
    for (int ahead = 1; ahead <= kPiecesAhead; ++ahead) {
      for (const int rank : std::vector<int>(crew_.workers())) {
        const auto has = std::count_if(out_.begin(), out_.end(),
                                       [&](const auto& out) { return out.second.rank == rank; });
        if (has >= ahead) continue;
        const auto range = NextRange();
        if (!range) return sent;
        const uint64_t piece = group_.next_piece_++;
        if (has == 0) crew_.SetOwing(rank, true);
        out_[piece] = {rank, *range};
        crew_.Send(rank,
                   PackPiece(scene_, piece, query_, Piece(rays_, range->first, range->count)));
        group_.traffic_.rays_out += range->count;
        sent = true;
      }
    }
    TakeBack();
    return sent;
  }

  /// What lost workers had goes to others.
  void TakeBack() {
    for (auto out = out_.begin(); out != out_.end();) {
      const bool is_lost = !crew_.IsThere(out->second.rank);
      if (is_lost) returned_.push_back(out->second.range);
      out = is_lost ? out_.erase(out) : std::next(out);
    }
  }

  bool TakeAnswer() {
    const auto arrival = crew_.Receive();
    if (!arrival) return false;
    try {
      Read(*arrival);
    } catch (const CutMessage&) {
      crew_.Lose(arrival->from, Loss::kHung, "has sent a message that was cut");
    }
    TakeBack();
    return true;
  }

  void Read(const Link::Arrival& arrival) {
    Reader reader(arrival.message);
    const auto answer = reader.Take<Answer>();
    if (answer == Answer::kFailure) {
      return crew_.Lose(arrival.from, Loss::kFailed, reader.TakeText());
    }
    if (answer != Answer::kHits) throw CutMessage();
    const auto out = out_.find(PieceOf(reader));
    if (out == out_.end() || out->second.rank != arrival.from) throw CutMessage();
    const Range range = out->second.range;
    UnpackHits(reader, query_, Piece(rays_, range.first, range.count));
    out_.erase(out);
    const bool owes_more = std::any_of(out_.begin(), out_.end(), [&](const auto& other) {
      return other.second.rank == arrival.from;
    });
    crew_.SetOwing(arrival.from, owes_more);
  }

  ReplicatedGroup& group_;
  Crew& crew_;
  const LocalScene& local_;
  const uint64_t scene_;
  const Query query_;
  const RayView& rays_;
  const CallOptions& options_;

  std::size_t next_ray_ = 0;
  std::vector<Range> returned_;  ///< that lost workers had
  std::map<uint64_t, Out> out_;  ///< by the number of the piece
  Idle idle_;
};

void ReplicatedGroup::Trace(const LocalScene& local, uint64_t number, Query query,
                            const RayView& rays, const CallOptions& options) {
  std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || crew_.workers().empty()) {
    if (lock) lock.unlock();
    return TraceAlone(local, query, rays, options);
  }
  ++traffic_.calls;
  ++traffic_.calls_shared;
  crew_.LoseSilent();
  Call(*this, local, number, query, rays, options).Run();
  has_lost_ = !crew_.faults().empty();
  lock.unlock();
  ThrowIfLost();
}

}  // namespace

std::shared_ptr<Group> Replicate(MPI_Comm communicator, const Options& options) {
  return std::make_shared<ReplicatedGroup>(communicator, options);
}

}  // namespace dacrt::mpi

// The same world in two libraries: traces batches in both and compares.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "isolation.h"
#include "player.h"
#include "report.h"
#include "world_compare.h"

namespace dacrt::tests {

/// The two libraries of a run; which one counts as the real one is only a matter of what is allowed
/// to it (see Library). Devices are kept.
class Arena {
 public:
  /// The real library and the drop-in. A world says how they are configured, but for the drop-in
  /// `config` goes first if it is not empty.
  explicit Arena(const std::string& config = "");

  /// The real library twice: as a world says, and with `config` in place of the drop-in. Shows
  /// whether the rules hold.
  static Arena OfRealAlone(const std::string& config);

  const EmbreeDevice& Real(const World& world);
  const EmbreeDevice& DropIn(const World& world);
  Library Judged() const { return judged_; }

  /// `progress` says from now on which library is at work. It must outlive the arena.
  void Show(Progress& progress) { progress_ = &progress; }
  Progress& progress() { return *progress_; }

 private:
  Arena(const EmbreeApi& drop_in, const std::string& config, Library judged)
      : drop_in_(drop_in), config_(config), judged_(judged) {}

  const EmbreeDevice& Device(const EmbreeApi& api, const std::string& config);

  const EmbreeApi& drop_in_;
  const std::string config_;
  const Library judged_;  ///< what the second library is judged as
  std::map<std::pair<const EmbreeApi*, std::string>, std::unique_ptr<EmbreeDevice>> devices_;
  std::unique_ptr<Progress> own_progress_ = std::make_unique<Progress>();
  Progress* progress_ = own_progress_.get();
};

/// A difference that is not explained.
struct Finding {
  std::string reason;
  std::string description;
  std::size_t ray = 0;  ///< of the batch
};

class Duel {
 public:
  /// Makes the world's scenes in both libraries. Throws std::runtime_error if one reports an error.
  Duel(Arena& arena, const World& world);
  ~Duel();

  /// Makes the changes of a stage in both, and commits.
  void Commit(std::span<const Change> changes);

  /// Fills in the rays of a batch.
  void MakeRays(Batch& batch, uint64_t seed) const;

  /// Traces the batch with both, and counts. Returns the first few findings.
  std::vector<Finding> Run(const Batch& batch, Tally& tally) const;

 private:
  struct Trial;
  void Describe();
  PlayedWorld& Real() const;
  PlayedWorld& DropIn() const;
  Company CompanyOf(const Batch& batch, const Trial& trial, std::size_t i) const;
  void CheckCall(const Batch& batch, const CallContext& call, Library library,
                 std::vector<Finding>& findings) const;
  void CompareOffers(const Batch& batch, const Trial& trial, std::vector<Finding>& findings) const;
  void Audit(const Batch& batch, const Trial& trial, Tally& tally,
             std::vector<Finding>& findings) const;

  Library judged_;
  Progress& progress_;
  std::vector<WorldScene> scenes_;  ///< as they are now
  std::unique_ptr<PlayedWorld> real_, drop_in_;
  std::unique_ptr<WorldComparer> comparer_;
};

}  // namespace dacrt::tests

// Where a call that comes to an unsplit subset gets the memory to split it in.
#pragma once

#include <optional>

#include "runtime/workspace.h"

namespace dacrt {

/// Calls that have a workspace split in it; the short way borrows one, which most calls never need.
/// Threads: one.
class SplitMemory {
 public:
  explicit SplitMemory(SubsetScratch& own) : scratch_(&own) {}
  explicit SplitMemory(WorkspacePool& pool) : pool_(&pool) {}

  /// The scratch, for as long as this lives. There is none if it is in use already, or if there
  /// is no memory.
  class Use {
   public:
    explicit Use(SplitMemory& memory) : memory_(memory), scratch_(memory.Take()) {}
    ~Use() {
      if (scratch_) memory_.scratch_ = scratch_;
    }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    SubsetScratch* get() const { return scratch_; }

   private:
    SplitMemory& memory_;
    SubsetScratch* const scratch_;
  };

 private:
  SubsetScratch* Take();

  SubsetScratch* scratch_ = nullptr;  ///< null while in use, or not borrowed yet
  WorkspacePool* const pool_ = nullptr;
  std::optional<WorkspacePool::Loan> loan_;
};

}  // namespace dacrt

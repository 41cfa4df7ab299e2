// The module that the drop-in loads when its configuration asks for MPI.
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <mutex>
#include <string>

#include "dacrt/mpi.h"
#include "patience.h"

namespace dacrt::mpi {
namespace {

/// The groups of the process: one of each mode, for all of its devices. Never destroyed, because
/// the program's static objects may trace after it ended.
class Job {
 public:
  static Job& Instance() {
    static Job* const job = new Job;
    static const AtExit at_exit;
    return *job;
  }

  std::shared_ptr<Group> Open(Mode mode, const Options& options) {
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[static_cast<std::size_t>(mode)];
    // A rank that refused, or did not come, does not come a second time.
    if (!slot.failure.empty()) throw Fault(slot.failure);
    if (slot.group) return slot.group;
    try {
      Initialise();
      slot.group = mode == Mode::kReplicate ? Replicate(MPI_COMM_WORLD, options)
                                            : Divide(OwnCommunicator(options), options);
    } catch (const std::exception& error) {
      slot.failure = error.what();
      throw;
    }
    return slot.group;
  }

 private:
  struct Slot {
    std::shared_ptr<Group> group;
    std::string failure;
  };
  struct AtExit {
    ~AtExit() { Instance().End(); }
  };

  void Initialise() {
    int is_initialised = 0, level = 0;
    MPI_Initialized(&is_initialised);
    if (is_initialised) {
      MPI_Query_thread(&level);
    } else {
      MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &level);
      is_ours_ = true;
    }
    if (level < MPI_THREAD_SERIALIZED) {
      throw Fault("MPI was initialised for a single thread: MPI_THREAD_SERIALIZED is needed");
    }
  }

  /// The program may use MPI_COMM_WORLD itself.
  static MPI_Comm OwnCommunicator(const Options& options) {
    MPI_Comm communicator;
    MPI_Request request;
    MPI_Comm_idup(MPI_COMM_WORLD, &communicator, &request);
    const Clock::time_point start = Clock::now();
    int is_done = 0;
    for (Idle idle; !is_done; idle.Pause()) {
      MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
      if (!is_done && SecondsSince(start) > options.timeout_seconds) {
        throw Fault("not all ranks made a device in time");
      }
    }
    return communicator;
  }

  void End() {
    const std::lock_guard lock(mutex_);
    Ending ending = Ending::kFinalise;
    for (Slot& slot : slots_) {
      if (slot.group) ending = std::max(ending, slot.group->End());
    }
    int is_finalised = 0;
    MPI_Finalized(&is_finalised);
    if (!is_ours_ || is_finalised || ending == Ending::kLeave) return;
    if (ending == Ending::kFinalise) {
      MPI_Finalize();
      return;
    }
    // What the program has written should not go with it.
    std::cout.flush();
    std::fflush(nullptr);
    MPI_Abort(MPI_COMM_WORLD, 1);
  }

  std::mutex mutex_;
  Slot slots_[2];
  bool is_ours_ = false;
};

}  // namespace

extern "C" __attribute__((visibility("default"))) void dacrt_mpi_open(std::shared_ptr<Group>& group,
                                                                      Mode mode,
                                                                      const Options& options) {
  group = Job::Instance().Open(mode, options);
}

}  // namespace dacrt::mpi

// The workers of rank 0: who is there, who is lost, and what is on its way to them.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "dacrt/mpi.h"
#include "greeting.h"
#include "link.h"
#include "patience.h"

namespace dacrt::mpi {

/// Why a rank is lost.
enum class Loss {
  kFailed,  ///< it says so itself
  kEnded,   ///< its process is gone
  kHung,    ///< nobody knows what it does
};

/// Threads: one at a time.
class Crew {
 public:
  /// Greets every other rank, and waits for its greeting. Throws Fault, and tells all, if one
  /// cannot work with this one or does not come.
  Crew(MPI_Comm communicator, const Options& options);

  ~Crew() { Stop(); }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  Link& link() { return link_; }
  int size() const { return link_.size(); }

  /// The ranks that are not lost.
  const std::vector<int>& workers() const { return workers_; }
  bool IsThere(int rank) const;

  /// Why ranks are lost, in one sentence; empty if none is.
  const std::string& faults() const { return faults_; }

  /// Ends ranks that are lost and may still be running, where this one can: on the same machine. An
  /// MPI job does not end before they do. False if there are others.
  bool KillHung();

  /// From now on nothing is sent to `rank` or taken from it.
  void Lose(int rank, Loss loss, const std::string& reason);

  /// Tells the workers to stop. There are none afterwards.
  void Stop();

  /// Notes that `rank` owes an answer from now on, or that it has given one.
  void SetOwing(int rank, bool owes);

  /// Loses workers that owe an answer for too long, and those that have ended.
  void LoseSilent();

  /// Sends a message to one worker, or to all. A worker that MPI does not reach is lost.
  void Send(int rank, Message message) { Send({&rank, 1}, std::move(message)); }
  void SendAll(Message message) { Send(std::vector<int>(workers_), std::move(message)); }

  /// Waits until little is on its way to the workers. Those that do not take it are lost.
  void WaitForRoom();

  /// The next answer of a worker that is not lost, and which.
  std::optional<Link::Arrival> Receive();

 private:
  struct Worker {
    Greeting greeting;
    bool owes = false;
    Clock::time_point since;
  };

  void Send(std::span<const int> ranks, Message message);
  void SendStop(int rank);

  const double timeout_seconds_;
  Link link_;
  const Greeting own_ = MakeGreeting(Role::kProgram);
  std::vector<Worker> all_;  ///< by rank
  std::vector<int> workers_;
  std::string faults_;
  std::vector<int> hung_;
  Clock::time_point looked_;  ///< for those that have ended
};

}  // namespace dacrt::mpi

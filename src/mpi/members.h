// The ranks of a divided scene: what they do together, and what they do when one is lost.
#pragma once

#include <cstdint>
#include <deque>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/mpi.h"
#include "greeting.h"
#include "link.h"
#include "patience.h"

namespace dacrt::mpi {

/// All operations are collective. The first that fails ends the group: it tells the other ranks,
/// and all later ones throw Fault at once.
///
/// Threads: one at a time.
class Members {
 public:
  /// Throws Fault on all ranks if two cannot work together.
  Members(MPI_Comm communicator, const Options& options);

  Link& link() { return link_; }
  const Link& link() const { return link_; }
  bool is_broken() const { return !fault_.empty(); }

  /// Runs `body`, a collective operation. What it throws ends the group, and is Fault here.
  template <class Body>
  void Together(Body&& body) {
    Begin();
    try {
      body();
    } catch (const std::exception& error) {
      Break(error.what());
    }
  }

  /// Within Together. Gives `own` to every rank; the values of all ranks, in their order.
  template <class T>
  std::vector<T> Gather(const T& own) {
    Message message;
    message.Put(own);
    std::vector<T> all;
    const std::vector<Message> messages = GatherMessages(std::move(message));
    for (const Message& other : messages) {
      Reader reader(other);
      all.push_back(reader.Take<T>());
      reader.ExpectEnd();
    }
    return all;
  }

  /// Within Together, after all of a call's messages: begins to wait for the others to say so, too.
  void StartBarrier(uint64_t call);

  /// Whether all have. Does not wait.
  bool IsBarrierDone();

  /// Within Together, often: shows the others that this rank is there. Throws Fault if one of them
  /// has ended, has not been heard from for too long, or has ended the group.
  void Watch();

  /// Notes that something came from `rank`.
  void Hear(int rank) { heard_[static_cast<std::size_t>(rank)] = Clock::now(); }

 private:
  std::vector<Message> GatherMessages(Message own);
  void Begin();
  [[noreturn]] void Break(const std::string& reason);

  const double timeout_seconds_;
  Link link_;
  const Greeting own_ = MakeGreeting(Role::kMember);
  std::vector<Greeting> greetings_;
  std::vector<Clock::time_point> heard_;
  Clock::time_point shown_, looked_;
  std::string fault_;
  std::vector<std::deque<Message>> gathered_;  ///< by rank: what has arrived, also too early
  uint64_t barrier_call_ = 0;
  int barrier_step_ = 0;  ///< ranks from here to the one that is told next; doubles each round
  std::set<std::pair<uint64_t, uint64_t>> barrier_news_;  ///< call and step
};

}  // namespace dacrt::mpi

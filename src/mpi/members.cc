#include "members.h"

#include <algorithm>
#include <cstdio>

#include "wire.h"

namespace dacrt::mpi {

Members::Members(MPI_Comm communicator, const Options& options)
    : timeout_seconds_(options.timeout_seconds),
      link_(communicator),
      heard_(static_cast<std::size_t>(link_.size())),
      gathered_(static_cast<std::size_t>(link_.size())) {
  Together([&] {
    greetings_ = Gather(own_);
    for (int rank = 0; rank < link_.size(); ++rank) {
      const std::string refusal =
          Refusal(own_, greetings_[static_cast<std::size_t>(rank)], Role::kMember, rank);
      if (!refusal.empty()) throw Fault(refusal);
    }
  });
}

void Members::Begin() {
  if (is_broken()) throw Fault(fault_);
  const auto now = Clock::now();
  shown_ = looked_ = now;
  for (auto& heard : heard_) heard = now;
}

void Members::Break(const std::string& reason) {
  fault_ = reason;
  Message text;
  text.PutText(reason);
  const auto shared = std::make_shared<const Message>(std::move(text));
  for (int rank = 0; rank < link_.size(); ++rank) {
    if (rank == link_.rank()) continue;
    try {
      link_.Send(rank, kTagEnd, shared);
    } catch (const Fault&) {
      // It is lost, or finds out by itself.
    }
  }
  throw Fault(fault_);
}

std::vector<Message> Members::GatherMessages(Message own) {
  const auto shared = std::make_shared<const Message>(own.Copy());
  for (int rank = 0; rank < link_.size(); ++rank) {
    if (rank != link_.rank()) link_.Send(rank, kTagGather, shared);
  }
  gathered_[static_cast<std::size_t>(link_.rank())].push_back(std::move(own));
  const auto is_here = [](const auto& messages) { return !messages.empty(); };
  for (Idle idle; !std::all_of(gathered_.begin(), gathered_.end(), is_here);) {
    Watch();
    if (auto arrival = link_.Receive(kTagGather)) {
      Hear(arrival->from);
      gathered_[static_cast<std::size_t>(arrival->from)].push_back(std::move(arrival->message));
      idle.Reset();
    } else {
      idle.Pause();
    }
  }
  std::vector<Message> all;
  for (auto& messages : gathered_) {
    all.push_back(std::move(messages.front()));
    messages.pop_front();
  }
  return all;
}

/// The dissemination barrier (Hensgen, Finkel, Manber, "Two algorithms for barrier
/// synchronization", 1988): in each round a rank tells the one `step` ranks on that it, and all
/// that told it, are here.
void Members::StartBarrier(uint64_t call) {
  barrier_call_ = call;
  barrier_step_ = 0;
}

bool Members::IsBarrierDone() {
  while (const auto arrival = link_.Receive(kTagBarrier)) {
    Hear(arrival->from);
    Reader reader(arrival->message);
    const auto call = reader.Take<uint64_t>();
    barrier_news_.emplace(call, reader.Take<uint64_t>());
  }
  while (barrier_step_ < link_.size()) {
    if (barrier_step_ > 0 &&
        barrier_news_.erase({barrier_call_, static_cast<uint64_t>(barrier_step_)}) == 0) {
      return false;
    }
    barrier_step_ = barrier_step_ == 0 ? 1 : 2 * barrier_step_;
    if (barrier_step_ >= link_.size()) return true;
    Message news;
    news.Put(barrier_call_);
    news.Put(static_cast<uint64_t>(barrier_step_));
    link_.Send((link_.rank() + barrier_step_) % link_.size(), kTagBarrier, std::move(news));
  }
  return true;
}

void Members::Watch() {
  link_.Progress();
  while (const auto arrival = link_.Receive(kTagAlive)) Hear(arrival->from);
  if (const auto end = link_.Receive(kTagEnd)) throw Fault(Reader(end->message).TakeText());
  if (SecondsSince(shown_) > timeout_seconds_ / 4) {
    shown_ = Clock::now();
    for (int rank = 0; rank < link_.size(); ++rank) {
      if (rank != link_.rank()) link_.Send(rank, kTagAlive, Message());
    }
  }
  if (SecondsSince(looked_) < kLookSeconds) return;
  looked_ = Clock::now();
  for (int rank = 0; rank < link_.size(); ++rank) {
    if (rank == link_.rank()) continue;
    const auto place = static_cast<std::size_t>(rank);
    const std::string name = "rank " + std::to_string(rank);
    if (!greetings_.empty() && HasEnded(own_, greetings_[place])) throw Fault(name + " has ended");
    if (SecondsSince(heard_[place]) < timeout_seconds_) continue;
    char text[64];
    std::snprintf(text, sizeof(text), " has not been heard of for %g s", timeout_seconds_);
    throw Fault(name + text);
  }
}

}  // namespace dacrt::mpi

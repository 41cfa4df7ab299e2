#include "crew.h"

#include <algorithm>
#include <utility>

#include "wire.h"

namespace dacrt::mpi {
namespace {

std::string Seconds(double seconds) {
  std::string text = std::to_string(seconds);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " s";
}

Greeting TakeGreeting(const Message& message) {
  Reader reader(message);
  return message.size() == sizeof(Greeting) ? reader.Take<Greeting>() : Greeting{};
}

}  // namespace

Crew::Crew(MPI_Comm communicator, const Options& options)
    : timeout_seconds_(options.timeout_seconds),
      link_(communicator),
      all_(static_cast<std::size_t>(link_.size())) {
  const Clock::time_point start = Clock::now();
  Idle idle;
  std::string refusal;
  for (int missing = link_.size() - 1; missing > 0;) {
    if (const auto arrival = link_.Receive(kTagGreeting)) {
      Worker& worker = all_[static_cast<std::size_t>(arrival->from)];
      worker.greeting = TakeGreeting(arrival->message);
      if (refusal.empty()) {
        refusal = Refusal(own_, worker.greeting, Role::kWorker, arrival->from);
      }
      workers_.push_back(arrival->from);
      --missing;
      idle.Reset();
    } else if (SecondsSince(start) > timeout_seconds_) {
      refusal = "only " + std::to_string(workers_.size()) + " of " +
                std::to_string(link_.size() - 1) + " other ranks came within " +
                Seconds(timeout_seconds_);
      break;
    } else {
      idle.Pause();
    }
  }
  std::sort(workers_.begin(), workers_.end());
  for (const int rank : workers_) {
    Message verdict;
    verdict.Put(own_);
    verdict.PutText(refusal);
    link_.Send(rank, kTagVerdict, std::move(verdict));
  }
  if (refusal.empty()) return;
  for (const auto wait = Clock::now(); SecondsSince(wait) < 1 && link_.Progress();) idle.Pause();
  throw Fault(refusal);
}

void Crew::Stop() {
  for (const int rank : std::exchange(workers_, {})) SendStop(rank);
}

bool Crew::KillHung() {
  std::erase_if(
      hung_, [&](int rank) { return Kill(own_, all_[static_cast<std::size_t>(rank)].greeting); });
  return hung_.empty();
}

/// A message so short is gone when MPI has taken it. It cannot matter if the rank is lost by now.
void Crew::SendStop(int rank) {
  try {
    Message stop;
    stop.Put(Command::kStop);
    stop.Put(faults_.empty() ? Ending::kFinalise : Ending::kLeave);
    link_.Send(rank, kTagCommand, std::move(stop));
    link_.Progress();
  } catch (const Fault&) {
  }
}

bool Crew::IsThere(int rank) const {
  return std::find(workers_.begin(), workers_.end(), rank) != workers_.end();
}

void Crew::Lose(int rank, Loss loss, const std::string& reason) {
  if (!IsThere(rank)) return;
  std::erase(workers_, rank);
  if (loss == Loss::kHung) hung_.push_back(rank);
  faults_ += (faults_.empty() ? "rank " : "; rank ") + std::to_string(rank) + " " + reason;
  if (loss == Loss::kFailed) SendStop(rank);
  link_.Abandon(rank);
}

void Crew::SetOwing(int rank, bool owes) {
  Worker& worker = all_[static_cast<std::size_t>(rank)];
  worker.owes = owes;
  worker.since = Clock::now();
}

void Crew::LoseSilent() {
  const bool look = SecondsSince(looked_) > kLookSeconds;
  if (look) looked_ = Clock::now();
  for (const int rank : std::vector<int>(workers_)) {
    const Worker& worker = all_[static_cast<std::size_t>(rank)];
    if (look && HasEnded(own_, worker.greeting)) {
      Lose(rank, Loss::kEnded, "has ended");
    } else if (worker.owes && SecondsSince(worker.since) > timeout_seconds_) {
      Lose(rank, Loss::kHung, "has not answered for " + Seconds(timeout_seconds_));
    }
  }
}

void Crew::Send(std::span<const int> ranks, Message message) {
  const auto shared = std::make_shared<const Message>(std::move(message));
  for (const int rank : ranks) {
    try {
      link_.Send(rank, kTagCommand, shared);
    } catch (const Fault& fault) {
      Lose(rank, Loss::kHung, std::string("cannot be reached: ") + fault.what());
    }
  }
}

void Crew::WaitForRoom() {
  constexpr std::size_t kMostBytes = 32u << 20;
  Idle idle;
  for (const int rank : std::vector<int>(workers_)) {
    if (link_.BytesWaiting(rank) <= kMostBytes) continue;
    SetOwing(rank, true);
    while (IsThere(rank) && link_.BytesWaiting(rank) > kMostBytes) {
      if (link_.Progress()) {
        SetOwing(rank, true);
        idle.Reset();
      } else {
        LoseSilent();
        idle.Pause();
      }
    }
    SetOwing(rank, false);
  }
}

std::optional<Link::Arrival> Crew::Receive() {
  link_.Progress();
  while (auto arrival = link_.Receive(kTagAnswer)) {
    if (IsThere(arrival->from)) return arrival;
  }
  return std::nullopt;
}

}  // namespace dacrt::mpi

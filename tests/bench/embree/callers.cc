#include "callers.h"

namespace dacrt::bench {

Callers::Callers(int count) {
  busy_ = count - 1;
  for (int i = 1; i < count; ++i) helpers_.emplace_back([this] { Help(); });
  while (busy_ > 0) std::this_thread::yield();  // until all of them wait for work
}

Callers::~Callers() {
  work_ = nullptr;
  ++round_;
}

void Callers::Run(std::size_t count, const std::function<void(std::size_t)>& work) {
  work_ = &work;
  count_ = count;
  next_ = 0;
  busy_ = helpers_.size();
  ++round_;
  TakeWork();
  while (busy_ > 0) std::this_thread::yield();
}

void Callers::Help() {
  for (unsigned seen = 0;; ++seen) {
    --busy_;
    while (round_ == seen) std::this_thread::yield();
    if (!work_) return;
    TakeWork();
  }
}

void Callers::TakeWork() {
  for (std::size_t i = next_++; i < count_; i = next_++) (*work_)(i);
}

}  // namespace dacrt::bench

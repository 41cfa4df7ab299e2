#include "trace/child_guesses.h"

#include <gtest/gtest.h>

#include <barrier>
#include <cstddef>
#include <cstdint>
#include <set>
#include <thread>
#include <vector>

namespace dacrt {
namespace {

// A guess decides nothing: right or wrong, what is taken is what comes out.
TEST(ChildGuessesTest, WhatIsTakenComesOut) {
  ChildGuesses& guesses = ChildGuesses::OfThisStack();
  // Also for nodes that share a guess.
  for (uint32_t i = 0; i < 5000; ++i) {
    const ChildWord taken = i % 3 == 0   ? ChildWord::Inner(i / 7)
                            : i % 3 == 1 ? ChildWord::Block(i / 7)
                                         : ChildWord::Subset(i / 7);
    EXPECT_EQ(guesses.Take(i * 37 % 1000, taken).bits(), taken.bits());
    EXPECT_EQ(guesses.Take(i * 37 % 1000, taken).bits(), taken.bits());
  }
}

TEST(ChildGuessesTest, AStackKeepsItsOwn) {
  EXPECT_EQ(&ChildGuesses::OfThisStack(), &ChildGuesses::OfThisStack());
}

// Threads that run at once hardly ever share some.
TEST(ChildGuessesTest, ThreadsHaveTheirOwn) {
  constexpr std::size_t kThreads = 16;
  std::vector<const ChildGuesses*> found(kThreads);
  std::barrier all_run(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] {
      found[i] = &ChildGuesses::OfThisStack();
      all_run.arrive_and_wait();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(std::set<const ChildGuesses*>(found.begin(), found.end()).size(), kThreads / 4);
}

}  // namespace
}  // namespace dacrt

#include "runtime/tasks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <chrono>
#include <ctime>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace dacrt {
namespace {

class TasksTest : public testing::TestWithParam<std::size_t> {};

INSTANTIATE_TEST_SUITE_P(Threads, TasksTest, testing::Values(1u, 2u, 3u, 8u),
                         [](const auto& info) { return std::to_string(info.param); });

std::vector<int> CallsOf(TaskPool& pool, std::size_t count) {
  std::vector<std::atomic<int>> calls(count);
  pool.ForEach(count, [&](std::size_t i) { ++calls.at(i); });
  return {calls.begin(), calls.end()};
}

TEST_P(TasksTest, EachIndexIsCalledOnce) {
  TaskPool pool(GetParam());
  EXPECT_EQ(pool.threads(), std::min(GetParam(), TaskPool(0).threads()));
  for (const std::size_t count : {0u, 1u, 2u, 3u, 8u, 9u, 1000u}) {
    EXPECT_EQ(CallsOf(pool, count), std::vector<int>(count, 1));
  }
}

// Callers on threads of their own share the pool and do not get each other's work.
TEST_P(TasksTest, SeveralCallersAtOnce) {
  TaskPool pool(GetParam());
  constexpr std::size_t kCallers = 6;
  std::vector<int> wrong(kCallers, 0);
  std::vector<std::thread> callers;
  for (std::size_t caller = 0; caller < kCallers; ++caller) {
    callers.emplace_back([&, caller] {
      for (std::size_t round = 0; round < 50; ++round) {
        const std::size_t count = (caller * 50 + round) % 17;
        wrong[caller] += CallsOf(pool, count) != std::vector<int>(count, 1);
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, std::vector<int>(kCallers, 0));
}

// No more bodies run at once than the pool has threads.
TEST_P(TasksTest, AtMostAsManyThreadsAsTheyAre) {
  TaskPool pool(GetParam());
  std::atomic<std::size_t> running{0}, most{0};
  pool.ForEach(64, [&](std::size_t) {
    const std::size_t now = ++running;
    std::size_t seen = most;
    while (seen < now && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    --running;
  });
  EXPECT_GE(most, 1u);
  EXPECT_LE(most, GetParam());
}

// What a body throws comes out of the call, and the pool is as good as before.
TEST_P(TasksTest, WhatABodyThrowsComesBack) {
  TaskPool pool(GetParam());
  for (const std::size_t count : {1u, 2u, 100u}) {
    try {
      pool.ForEach(count, [&](std::size_t i) {
        if (i == count / 2) throw std::runtime_error("body " + std::to_string(i));
      });
      ADD_FAILURE() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "body " + std::to_string(count / 2));
    }
    EXPECT_THROW(pool.ForEach(count, [](std::size_t) { throw std::bad_alloc(); }), std::bad_alloc);
    EXPECT_EQ(CallsOf(pool, 100), std::vector<int>(100, 1));
  }
}

// Bodies that wait for each other come to an end only on threads of their own.
TEST(TasksOfTheMachineTest, SeveralThreadsWork) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "there is one thread only";
  TaskPool pool(2);
  std::atomic<int> running{0};
  std::atomic<bool> met{false};
  // Seconds of the processor: a machine that is busy elsewhere takes its time.
  const std::clock_t end = std::clock() + 20 * CLOCKS_PER_SEC;
  pool.ForEach(2, [&](std::size_t) {
    if (++running == 2) met = true;
    while (!met && std::clock() < end) std::this_thread::yield();
    --running;
  });
  EXPECT_TRUE(met);
}

// Threads had the environment that they were started with, so that a hit could depend on the thread
// that found it.
TEST(TasksOfTheMachineTest, BodiesHaveTheCallersFloatingPointEnvironment) {
  TaskPool pool(0);
  for (const int rounding : {FE_UPWARD, FE_TOWARDZERO, FE_TONEAREST}) {
    std::fesetround(rounding);
    std::vector<int> of_bodies(64, -1);
    pool.ForEach(of_bodies.size(), [&](std::size_t i) {
      of_bodies[i] = std::fegetround();
      std::this_thread::sleep_for(std::chrono::microseconds(200));  // so that others come, too
      std::fesetround(FE_DOWNWARD);                                 // nobody else's business
    });
    EXPECT_EQ(of_bodies, std::vector<int>(64, rounding));
    int entered = -1;
    pool.Enter([&] { entered = std::fegetround(); });
    EXPECT_EQ(entered, rounding);
    std::fesetround(FE_TONEAREST);
  }
}

// Where all threads are busy and wait for what another call does, that call must not wait for them.
TEST(TasksOfTheMachineTest, WhoHasEnteredDoesNotWaitForAFreeThread) {
  TaskPool pool(0);
  std::atomic<bool> is_inside{false}, is_done{false};
  std::thread inside([&] {
    pool.Enter([&] {
      is_inside = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      pool.ForEach(8, [](std::size_t) {});
      is_done = true;
    });
  });
  while (!is_inside) std::this_thread::yield();
  pool.ForEach(2 * pool.threads(), [&](std::size_t) {
    while (!is_done) std::this_thread::yield();
  });
  inside.join();
}

TEST(TasksOfTheMachineTest, NoneMeansAsManyAsThereAre) {
  TaskPool pool(0);
  EXPECT_GE(pool.threads(), 1u);
  EXPECT_EQ(CallsOf(pool, 100), std::vector<int>(100, 1));
}

}  // namespace
}  // namespace dacrt

#include "runtime/workspace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <string>
#include <thread>

#include "address_space_limit.h"
#include "unit_test.h"

namespace dacrt {
namespace {

struct Array {
  const char* name;
  std::byte* begin;
  std::size_t bytes;
};

/// All arrays of a workspace that are not empty, as long as a call may use them.
std::vector<Array> ArraysOf(const Workspace& workspace, const WorkspaceShape& shape) {
  std::vector<Array> arrays;
  const auto add = [&]<class T>(const char* name, T* begin, std::size_t count) {
    if (count == 0) return;
    arrays.push_back({name, reinterpret_cast<std::byte*>(begin), count * sizeof(T)});
  };
  const RayBatch& batch = workspace.batch();
  add("scratch", &workspace.scratch(), 1);
  add("refs", workspace.refs().data(), workspace.refs().size());
  for (float* field : batch.org) add("org", field, batch.capacity);
  for (float* field : batch.dir) add("dir", field, batch.capacity);
  add("tnear", batch.tnear, batch.capacity);
  add("tfar", batch.tfar, batch.capacity);
  add("index", batch.index, batch.capacity);
  add("lane_bits", batch.lane_bits, batch.bits_capacity);
  add("hits", batch.hits, shape.rays);
  add("ray_masks", batch.ray_masks, shape.rays);
  for (float* axis : batch.cones.axis) add("cones.axis", axis, shape.cones);
  add("cones.tangent", batch.cones.tangent, shape.cones);
  add("cones.longest", batch.cones.longest, shape.cones);
  add("cones.reach", batch.cones.reach, shape.cones);
  add("packets", batch.packets.data(), batch.packets.size());
  add("full_hits", batch.full_hits, shape.full_hits);
  add("records", workspace.rays(), shape.records);
  add("record_hits", workspace.hits(), shape.records);
  add("callers", workspace.callers(), shape.records);
  add("tags", workspace.tags(), shape.tags);
  const ListMemory lists = workspace.lists();
  add("lists", lists.top, static_cast<std::size_t>(lists.end - lists.top));
  const InstanceMemory instances = workspace.instance_memory();
  add("instance_rays", instances.rays, instances.count);
  add("instance_hits", instances.hits, instances.count);
  add("instance_outer", instances.outer_rays, instances.count);
  return arrays;
}

std::vector<Settings> SettingsOfEveryAlgorithm() {
  std::vector<Settings> all(4);
  all[1].skip_filtering = false;
  all[2].algorithm = Algorithm::kAfra2012;
  all[3].algorithm = Algorithm::kMora2011;
  return all;
}

/// Every array can be written over its whole length without leaving the formula's bytes, and none
/// shares a byte with another one.
void ExpectArraysFit(const WorkspaceShape& shape, const std::string& what) {
  Workspace workspace;
  workspace.Reserve(shape);
  ASSERT_EQ(workspace.bytes(), shape.Bytes());
  std::vector<Array> arrays = ArraysOf(workspace, shape);
  std::byte* lowest = arrays[0].begin;
  for (const Array& array : arrays) {
    lowest = std::min(lowest, array.begin);
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(array.begin) % 64, 0u) << array.name;
    std::memset(array.begin, 0xFF, array.bytes);
  }
  std::sort(arrays.begin(), arrays.end(),
            [](const Array& a, const Array& b) { return a.begin < b.begin; });
  for (std::size_t i = 1; i < arrays.size(); ++i) {
    ASSERT_LE(arrays[i - 1].begin + arrays[i - 1].bytes, arrays[i].begin)
        << arrays[i - 1].name << " and " << arrays[i].name << " " << what;
  }
  ASSERT_LE(arrays.back().begin + arrays.back().bytes, lowest + workspace.bytes())
      << arrays.back().name << " " << what;
}

constexpr std::size_t kRayCounts[] = {1, 2, 15, 16, 17, 63, 64, 65, 1000, 4095, 30001, 65536};

TEST(WorkspaceTest, ArraysFitTheFormulaAndDoNotOverlap) {
  for (const Settings& settings : SettingsOfEveryAlgorithm()) {
    for (const std::size_t triangles : {1u, 2u, 3u, 7u, 1000u, 4097u}) {
      for (const std::size_t rays : kRayCounts) {
        ExpectArraysFit(
            WorkspaceShape::ForPaper(triangles, rays, triangles % 2 == 1, settings),
            std::to_string(triangles) + " triangles, " + std::to_string(rays) + " rays");
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(WorkspaceTest, ArraysForAKeptPartitionFitAndDoNotOverlap) {
  for (const SceneTraits& scene :
       {SceneTraits{}, SceneTraits{.has_instances = true}, SceneTraits{.has_callbacks = true}}) {
    for (const std::size_t rays : kRayCounts) {
      ExpectArraysFit(WorkspaceShape::ForKept(rays, scene), std::to_string(rays) + " rays");
      if (HasFatalFailure()) return;
    }
  }
}

// The lists of kListLevels levels fit if every ray were in each.
TEST(WorkspaceTest, HasRoomForTheListsOfAllLevels) {
  for (const std::size_t rays : kRayCounts) {
    Workspace workspace;
    workspace.Reserve(WorkspaceShape::ForKept(rays, {}));
    const ListMemory lists = workspace.lists();
    EXPECT_EQ(static_cast<std::size_t>(lists.end - lists.top),
              WorkspaceShape::kListLevels * ListBytes(rays));
    EXPECT_EQ(workspace.instance_memory().count, 0u);
    EXPECT_NE(workspace.rays(), nullptr);
    EXPECT_NE(workspace.hits(), nullptr);
  }
}

TEST(WorkspaceTest, HasRoomForThePieceAndItsSurvivors) {
  for (const Settings& settings : SettingsOfEveryAlgorithm()) {
    for (const std::size_t rays : {1u, 17u, 5000u}) {
      Workspace workspace;
      workspace.Reserve(WorkspaceShape::ForPaper(100, rays, false, settings));
      EXPECT_GE(workspace.batch().capacity, 2 * rays + kMaxLanes);
      EXPECT_EQ(workspace.batch().capacity % kMaxLanes, 0u);
      EXPECT_GE(8 * workspace.batch().bits_capacity, workspace.batch().capacity);
      EXPECT_EQ(workspace.batch().top, 0u);
      EXPECT_EQ(workspace.batch().bits_top, 0u);
      EXPECT_GE(workspace.refs().size(), 100u);
    }
  }
}

TEST(WorkspaceTest, GrowsAndDoesNotShrink) {
  const Settings settings;
  Workspace workspace;
  EXPECT_EQ(workspace.bytes(), 0u);
  workspace.Reserve(WorkspaceShape::ForPaper(10, 100, false, settings));
  const std::size_t small = workspace.bytes();
  workspace.Reserve(WorkspaceShape::ForPaper(1000, 100, false, settings));
  const std::size_t large = workspace.bytes();
  EXPECT_GT(large, small);
  workspace.Reserve(WorkspaceShape::ForPaper(10, 100, false, settings));
  EXPECT_EQ(workspace.bytes(), large);
  EXPECT_EQ(workspace.refs().size(), 10u);
}

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

TEST(WorkspaceTest, WithoutMemoryItThrowsAndCanBeUsedAgain) {
  const Settings settings;
  Workspace workspace;
  workspace.Reserve(WorkspaceShape::ForPaper(10, 100, false, settings));
  {
    const unit::AddressSpaceLimit limit(64 * kMegabyte);
    if (!limit.is_set()) GTEST_SKIP() << "the address space can not be limited here";
    EXPECT_THROW(workspace.Reserve(WorkspaceShape::ForPaper(10, 50000000, false, settings)),
                 std::bad_alloc);
    EXPECT_EQ(workspace.bytes(), 0u) << "empty, as promised";
  }
  workspace.Reserve(WorkspaceShape::ForPaper(10, 100, false, settings));
  std::memset(workspace.refs().data(), 0, workspace.refs().size_bytes());
}

TEST(WorkspacePoolTest, CountsWhatIsIdleAndOnLoan) {
  const Settings settings;
  const WorkspaceShape small = WorkspaceShape::ForPaper(10, 100, false, settings);
  const WorkspaceShape large = WorkspaceShape::ForPaper(5000, 100, false, settings);
  const MemoryAccount memory(nullptr);
  WorkspacePool pool(memory);
  EXPECT_EQ(pool.BytesHeld(), 0u);
  {
    WorkspacePool::Loan a(pool), b(pool);
    a.Reserve(small);
    EXPECT_EQ(pool.BytesHeld(), small.Bytes());
    b.Reserve(large);
    EXPECT_EQ(pool.BytesHeld(), small.Bytes() + large.Bytes());
    pool.ReleaseIdle();
    EXPECT_EQ(pool.BytesHeld(), small.Bytes() + large.Bytes()) << "none is idle";
    a.Reserve(large);
    EXPECT_EQ(pool.BytesHeld(), 2 * large.Bytes());
  }
  EXPECT_EQ(pool.BytesHeld(), 2 * large.Bytes()) << "kept between calls";
  {
    WorkspacePool::Loan again(pool);
    again.Reserve(small);
    EXPECT_EQ(pool.BytesHeld(), 2 * large.Bytes());
    pool.ReleaseIdle();
    EXPECT_EQ(pool.BytesHeld(), large.Bytes());
  }
  pool.ReleaseIdle();
  EXPECT_EQ(pool.BytesHeld(), 0u);
}

TEST(WorkspacePoolTest, LendsTheLargestFirst) {
  const Settings settings;
  const WorkspaceShape small = WorkspaceShape::ForPaper(10, 100, false, settings);
  const WorkspaceShape large = WorkspaceShape::ForPaper(5000, 100, false, settings);
  for (const bool large_is_first : {false, true}) {
    const MemoryAccount memory(nullptr);
    WorkspacePool pool(memory);
    {
      WorkspacePool::Loan a(pool), b(pool);
      a.Reserve(large_is_first ? large : small);
      b.Reserve(large_is_first ? small : large);
    }
    WorkspacePool::Loan next(pool);
    next.Reserve(large);
    EXPECT_EQ(pool.BytesHeld(), small.Bytes() + large.Bytes()) << "nothing had to grow";
  }
}

TEST(WorkspacePoolTest, CountsAFailedLoanAsNothing) {
  const Settings settings;
  std::ptrdiff_t told = 0;
  const MemoryAccount memory([&](std::ptrdiff_t bytes) {
    told += bytes;
    return true;
  });
  WorkspacePool pool(memory);
  {
    WorkspacePool::Loan loan(pool);
    loan.Reserve(WorkspaceShape::ForPaper(10, 100, false, settings));
    const unit::AddressSpaceLimit limit(64 * kMegabyte);
    if (!limit.is_set()) GTEST_SKIP() << "the address space can not be limited here";
    EXPECT_THROW(loan.Reserve(WorkspaceShape::ForPaper(10, 50000000, false, settings)),
                 std::bad_alloc);
    EXPECT_EQ(pool.BytesHeld(), 0u);
    EXPECT_EQ(told, 0) << "what it had had and what it did not get";
  }
  pool.ReleaseIdle();
  EXPECT_EQ(pool.BytesHeld(), 0u);
  EXPECT_EQ(told, 0);
}

TEST(WorkspacePoolTest, ManyThreadsShareIt) {
  const Settings settings;
  const WorkspaceShape shape = WorkspaceShape::ForPaper(100, 100, false, settings);
  const MemoryAccount memory(nullptr);
  WorkspacePool pool(memory);
  std::vector<std::thread> threads;
  for (unsigned char t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 200; ++i) {
        WorkspacePool::Loan loan(pool);
        loan.Reserve(shape);
        std::memset(loan->refs().data(), t, loan->refs().size_bytes());
        for (const std::byte byte : std::as_bytes(loan->refs())) {
          ASSERT_EQ(byte, std::byte{t}) << "another thread has the same workspace";
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(pool.BytesHeld(), 8 * shape.Bytes());
  EXPECT_EQ(pool.BytesHeld() % shape.Bytes(), 0u);
  pool.ReleaseIdle();
  EXPECT_EQ(pool.BytesHeld(), 0u);
}

}  // namespace
}  // namespace dacrt

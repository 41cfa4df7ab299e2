#include "runtime/workspace.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <thread>

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
  const PacketBatch& packets = workspace.packets();
  for (float* field : packets.org_lower) add("packets.org_lower", field, packets.capacity);
  for (float* field : packets.org_upper) add("packets.org_upper", field, packets.capacity);
  for (float* field : packets.reciprocal_lower) {
    add("packets.reciprocal_lower", field, packets.capacity);
  }
  for (float* field : packets.reciprocal_upper) {
    add("packets.reciprocal_upper", field, packets.capacity);
  }
  add("packets.tnear", packets.tnear, packets.capacity);
  add("packets.tfar", packets.tfar, packets.capacity);
  add("packets.index", packets.index, packets.capacity);
  add("packets.lane_bits", packets.lane_bits, packets.bits_capacity);
  add("packets", batch.packets.data(), batch.packets.size());
  return arrays;
}

std::vector<Settings> SettingsOfEveryAlgorithm() {
  std::vector<Settings> all(4);
  all[1].skip_filtering = false;
  all[2].algorithm = Algorithm::kAfra2012;
  all[3].algorithm = Algorithm::kMora2011;
  return all;
}

// Every array can be written over its whole length without leaving the formula's bytes, and none
// shares a byte with another one.
TEST(WorkspaceTest, ArraysFitTheFormulaAndDoNotOverlap) {
  for (const Settings& settings : SettingsOfEveryAlgorithm()) {
    for (const std::size_t triangles : {1u, 2u, 3u, 7u, 1000u, 4097u}) {
      for (const std::size_t rays : {1u, 2u, 15u, 16u, 17u, 63u, 64u, 65u, 1000u, 4095u, 30001u}) {
        Workspace workspace;
        const bool keeps = triangles % 2 == 1;
        const WorkspaceShape shape(triangles, rays, keeps, settings);
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
              << arrays[i - 1].name << " and " << arrays[i].name << " with " << rays << " rays";
        }
        ASSERT_LE(arrays.back().begin + arrays.back().bytes, lowest + workspace.bytes())
            << arrays.back().name << " with " << triangles << " triangles, " << rays << " rays";
      }
    }
  }
}

TEST(WorkspaceTest, HasRoomForThePieceAndItsSurvivors) {
  for (const Settings& settings : SettingsOfEveryAlgorithm()) {
    for (const std::size_t rays : {1u, 17u, 5000u}) {
      Workspace workspace;
      workspace.Reserve(WorkspaceShape(100, rays, false, settings));
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
  workspace.Reserve(WorkspaceShape(10, 100, false, settings));
  const std::size_t small = workspace.bytes();
  workspace.Reserve(WorkspaceShape(1000, 100, false, settings));
  const std::size_t large = workspace.bytes();
  EXPECT_GT(large, small);
  workspace.Reserve(WorkspaceShape(10, 100, false, settings));
  EXPECT_EQ(workspace.bytes(), large);
  EXPECT_EQ(workspace.refs().size(), 10u);
}

/// Lets the process map no more than `bytes` beyond what it has now.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(std::size_t bytes) {
    getrlimit(RLIMIT_AS, &before_);
    rlimit limit = before_;
    std::size_t pages = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
      if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
      std::fclose(file);
    }
    limit.rlim_cur = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + bytes;
    is_set_ = pages > 0 && setrlimit(RLIMIT_AS, &limit) == 0;
  }
  ~AddressSpaceLimit() {
    if (is_set_) setrlimit(RLIMIT_AS, &before_);
  }
  AddressSpaceLimit(const AddressSpaceLimit&) = delete;
  AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;
  bool is_set() const { return is_set_; }

 private:
  rlimit before_{};
  bool is_set_ = false;
};

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

TEST(WorkspaceTest, WithoutMemoryItThrowsAndCanBeUsedAgain) {
  const Settings settings;
  Workspace workspace;
  workspace.Reserve(WorkspaceShape(10, 100, false, settings));
  {
    const AddressSpaceLimit limit(64 * kMegabyte);
    if (!limit.is_set()) GTEST_SKIP() << "the address space can not be limited here";
    EXPECT_THROW(workspace.Reserve(WorkspaceShape(10, 50000000, false, settings)), std::bad_alloc);
    EXPECT_EQ(workspace.bytes(), 0u) << "empty, as promised";
  }
  workspace.Reserve(WorkspaceShape(10, 100, false, settings));
  std::memset(workspace.refs().data(), 0, workspace.refs().size_bytes());
}

TEST(WorkspacePoolTest, CountsWhatIsIdleAndOnLoan) {
  const Settings settings;
  const WorkspaceShape small(10, 100, false, settings), large(5000, 100, false, settings);
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

TEST(WorkspacePoolTest, CountsAFailedLoanAsNothing) {
  const Settings settings;
  const MemoryAccount memory(nullptr);
  WorkspacePool pool(memory);
  {
    WorkspacePool::Loan loan(pool);
    loan.Reserve(WorkspaceShape(10, 100, false, settings));
    const AddressSpaceLimit limit(64 * kMegabyte);
    if (!limit.is_set()) GTEST_SKIP() << "the address space can not be limited here";
    EXPECT_THROW(loan.Reserve(WorkspaceShape(10, 50000000, false, settings)), std::bad_alloc);
    EXPECT_EQ(pool.BytesHeld(), 0u);
  }
  pool.ReleaseIdle();
  EXPECT_EQ(pool.BytesHeld(), 0u);
}

TEST(WorkspacePoolTest, ManyThreadsShareIt) {
  const Settings settings;
  const WorkspaceShape shape(100, 100, false, settings);
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

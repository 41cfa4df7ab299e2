#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "split_by_grid_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "kept_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

// Threads that split a large subset together leave the triangles in the order in which one does;
// also where they have sorted them while they listed them.
void ThreadsTogetherSplitAsOneDoes() {
  Random random(9);
  const Mesh mesh = unit::MakeSoup(random, 100000, 1, 0.01f);
  TaskPool tasks(3);
  for (const bool is_sorted : {false, true}) {
    SCOPED_TRACE(is_sorted);
    Kept by_one({mesh}, kPlenty), by_all({mesh}, kPlenty, nullptr, 3);
    if (!is_sorted) {
      ASSERT_EQ(by_one.partition.TakeSorted()->parts, 1u);
      ASSERT_EQ(by_all.partition.TakeSorted()->parts, tasks.threads());
    }
    const uint32_t root = by_one.Root(0);
    ASSERT_EQ(RootOf(by_all.partition, 0, 0, by_all.scratch.get(), &tasks, [] {}), root);
    const auto one = by_one.partition.triangles(), all = by_all.partition.triangles();
    EXPECT_TRUE(std::equal(one.begin(), one.end(), all.begin(), all.end()));
    EXPECT_EQ(by_all.partition.BytesUsed(), by_one.partition.BytesUsed());
    const uint32_t slots = by_one.partition.subset(0).node_slots;
    for (uint32_t slot = root; slot < root + slots; ++slot) {
      const WideNode &a = by_one.partition.node(slot), &b = by_all.partition.node(slot);
      ASSERT_EQ(memcmp(&a, &b, sizeof(WideNode)), 0) << slot;
    }
    Walker(by_all).Walk(true);
  }
}

// The grid by which triangles are sorted while they are listed lies around some of them. Wherever
// the others are, the partition is whole.
void ASampleMayMissMost() {
  Random random(19);
  for (const float far : {0.0f, 3.0f, 1e6f, 1e15f}) {
    SCOPED_TRACE(far);
    Mesh mesh = unit::MakeSoup(random, 20000, 1, 0.01f);
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
      if (i / 3 % 7 != 0) mesh.vertices[i][0] += far;
    }
    const Box sample = SampleCenters(GeometryTable(std::vector{mesh.View()}));
    ASSERT_LT(sample.upper[0], 2.5f) << "this test knows which ones the sample is of";
    for (const size_t threads : {1u, 3u}) {
      Kept kept({mesh}, kPlenty, nullptr, threads);
      Walker walker(kept);
      walker.Walk(true);
      EXPECT_LT(walker.deepest, 20u);
    }
  }
}

// The same where many triangles stand in one cell of the first grid, and are sorted into another.
void ASampleOfACellMayMissMost() {
  Random random(21);
  for (const size_t count : {12000u, 40000u}) {
    for (const float far : {0.0f, 3.0f, 30.0f}) {
      SCOPED_TRACE(testing::Message() << count << " " << far);
      Mesh mesh = unit::MakeSoup(random, count, 1, 0.01f);
      for (size_t i = 0; i < mesh.vertices.size(); ++i) {
        if (i / 3 % 7 != 0) mesh.vertices[i][1] += far;
      }
      for (const float end : {-1e4f, 1e4f}) mesh.Add({end, end, end}, {end, 0, end}, {0, end, end});
      Kept kept({mesh}, kPlenty);
      Walker walker(kept);
      walker.Walk(true);
      EXPECT_LT(walker.deepest, 20u);
      EXPECT_GT(walker.subsets, count / SubsetScratch::kTriangles);
    }
  }
}

// A grid takes memory of its own only if it does not fit that in which small subsets are split.
void SmallGridsTakeNoMemory() {
  Random random(22);
  for (const auto& [triangles, takes_memory] : {std::pair{9000u, false}, {50000u, true}}) {
    SCOPED_TRACE(triangles);
    size_t requests = 0;
    const MemoryAccount account{[&](std::ptrdiff_t bytes) {
      requests += bytes > 0;
      return true;
    }};
    Kept kept({unit::MakeSoup(random, triangles, 1, 0.05f)}, kPlenty, &account);
    ASSERT_TRUE(kept.partition.TakeSorted());
    requests = 0;
    ASSERT_TRUE(Subset::IsNode(kept.Root(0)));
    EXPECT_EQ(requests > 0, takes_memory);
    Walker(kept).Walk(true);
  }
}

// A grid needs room beside the nodes over it, and triangles that can all be hit; a copy has none.
void OnlySomeAreSortedWhileListed() {
  Random random(20);
  Mesh mesh = unit::MakeSoup(random, 150000, 1, 0.01f);
  Kept kept({mesh}, 32 * mesh.triangles.size());
  KeptPartition copy(kept.partition);
  EXPECT_FALSE(copy.TakeSorted());
  EXPECT_TRUE(kept.partition.TakeSorted());
  EXPECT_FALSE(kept.partition.TakeSorted()) << "taken already";
  EXPECT_FALSE(Kept({mesh}, 8 * mesh.triangles.size()).partition.TakeSorted());
  EXPECT_FALSE(Kept({unit::MakeSoup(random, 2048, 1, 0.1f)}, kPlenty).partition.TakeSorted());
  mesh.vertices[777][1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(Kept({mesh}, kPlenty).partition.TakeSorted());
}

// While one thread splits a subset, another one that comes there splits those beside it.
void WhoWouldWaitSplitsANeighbour() {
  Random random(10);
  Kept kept({unit::MakeSoup(random, 20000, 1, 0.05f)}, kPlenty);
  KeptPartition& partition = kept.partition;
  EXPECT_FALSE(SplitNeighbour(partition, partition.subset(0), *kept.scratch)) << "it has none";
  ASSERT_TRUE(Subset::IsNode(kept.Root(0)));
  const WideNode& node = partition.node(partition.subset(1).parent / WideNode::kWidth);
  std::vector<uint32_t> subsets;
  for (size_t i = 0; i < node.count; ++i) {
    if (node.Child(i).IsSubset()) subsets.push_back(node.Child(i).number());
  }
  ASSERT_GT(subsets.size(), 1u);
  Subset& busy = partition.subset(subsets[0]);
  busy.root = Subset::kBeingSplit;
  for (size_t i = 1; i < subsets.size(); ++i) {
    ASSERT_EQ(partition.subset(subsets[i]).root, Subset::kUnsplit);
    EXPECT_TRUE(SplitNeighbour(partition, busy, *kept.scratch));
    EXPECT_TRUE(Subset::IsRented(partition.subset(subsets[i]).root)) << "no rays have come";
  }
  EXPECT_FALSE(SplitNeighbour(partition, busy, *kept.scratch)) << "all are split";
  EXPECT_EQ(busy.root, Subset::kBeingSplit);
  busy.root = Subset::kUnsplit;
  Walker(kept).Walk(true);
}

// Threads that come to the same subsets at once get the same roots, and a partition that is whole.
void ThreadsAgree() {
  Random random(8);
  for (const size_t budget : {kPlenty, KeptPartition::LeastBytes(9000) + 5000}) {
    for (int round = 0; round < 4; ++round) {
      Kept kept({unit::MakeSoup(random, 9000, 1, 0.05f)}, budget);
      constexpr size_t kThreads = 4;
      std::vector<std::vector<uint32_t>> roots(kThreads);
      std::vector<std::thread> threads;
      for (size_t t = 0; t < kThreads; ++t) {
        threads.emplace_back([&, t] {
          const auto scratch = std::make_unique<SubsetScratch>();
          // Breadth first: subsets as they are found.
          std::vector<uint32_t> subsets = {0};
          for (size_t i = 0; i < subsets.size(); ++i) {
            const uint32_t root =
                *RootOf(kept.partition, subsets[i], 0, scratch.get(), nullptr, [] {});
            roots[t].push_back(root);
            if (root == Subset::kNoRoom) continue;
            std::vector<uint32_t> open = {Subset::NodeOf(root)};
            while (!open.empty()) {
              const WideNode& node = kept.partition.node(open.back());
              open.pop_back();
              for (size_t k = 0; k < node.count; ++k) {
                const ChildWord child = node.Child(k);
                if (child.IsSubset()) subsets.push_back(child.number());
                // Others may have split a subset meanwhile.
                if (child.IsInner()) open.push_back(child.number());
              }
            }
          }
        });
      }
      for (std::thread& thread : threads) thread.join();
      for (size_t t = 1; t < kThreads; ++t) ASSERT_EQ(roots[t][0], roots[0][0]);
      Walker(kept).Walk(budget == kPlenty);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// Nothing is split before someone comes, and only that to which someone comes.
void SplitsWhereAsked() {
  Random random(9);
  Kept kept({unit::MakeSoup(random, 9000, 1, 0.05f)}, kPlenty);
  const size_t before = kept.partition.BytesUsed();
  EXPECT_EQ(kept.partition.subset(0).root.load(), Subset::kUnsplit);
  EXPECT_TRUE(kept.partition.root().IsSubset());
  const WideNode* node = &kept.partition.node(kept.Root(0));
  EXPECT_EQ(&kept.partition.node(kept.partition.root().number()), node);
  const size_t first = kept.partition.BytesUsed();
  EXPECT_GT(first, before);
  while (!node->Child(0).IsSubset()) {
    ASSERT_TRUE(node->Child(0).IsInner());
    node = &kept.partition.node(node->Child(0).number());
  }
  const uint32_t subset = node->Child(0).number();
  EXPECT_EQ(kept.partition.subset(subset).root.load(), Subset::kUnsplit);
  kept.Root(subset);
  const size_t second = kept.partition.BytesUsed();
  EXPECT_GT(second, first);
  kept.Root(subset);
  EXPECT_EQ(kept.partition.BytesUsed(), second);
}

// Where there is no memory to split in, the subset is nobody else's meanwhile, and stays unsplit.
void WithoutScratchTheSubsetStays() {
  Random random(35);
  Kept kept({unit::MakeSoup(random, 900, 1, 0.05f)}, kPlenty);
  bool called = false;
  const auto root = RootOf(kept.partition, 0, 0, nullptr, nullptr, [&] {
    called = true;
    EXPECT_EQ(kept.partition.subset(0).root.load(), Subset::kBeingSplit);
  });
  EXPECT_FALSE(root.has_value());
  EXPECT_TRUE(called);
  EXPECT_EQ(kept.partition.subset(0).root.load(), Subset::kUnsplit);
  EXPECT_THROW(RootOf(kept.partition, 0, 0, nullptr, nullptr, [] { throw std::bad_alloc(); }),
               std::bad_alloc);
  EXPECT_EQ(kept.partition.subset(0).root.load(), Subset::kUnsplit);
  Walker(kept).Walk(true);
}

/// What is allowed when a partition is made, and nothing afterwards.
class NoGrids {
 public:
  MemoryAccount account{[this](std::ptrdiff_t bytes) { return bytes < 0 || !is_made; }};
  bool is_made = false;
};

// They stayed as they were, and each ray was tested against every triangle.
void LargeSubsetsAreSplitWhereThereIsNoMemoryForAGrid() {
  Random random(36);
  Mesh same, around_one_point, line;
  for (int i = 1; i <= 20000; ++i) {
    const float s = static_cast<float>(i);
    same.Add({1, -1, -1}, {1, 1, -1}, {1, 0, 1});
    around_one_point.Add({-s, -s, -s}, {s, s, -s}, {0, 0, s});
    const float far = std::exp2(static_cast<float>(i % 100) - 50) * (1 + s * 1e-5f);
    line.Add({far, 0, 0}, {far, 1, 0}, {far, 0, 1});
  }
  for (const Mesh& mesh : {unit::MakeSoup(random, 2049, 1, 0.1f),
                           unit::MakeSoup(random, 50000, 1, 0.05f), same, around_one_point, line}) {
    SCOPED_TRACE(mesh.triangles.size());
    NoGrids no_grids;
    Kept kept({mesh}, kPlenty, &no_grids.account);
    no_grids.is_made = true;
    Walker walker(kept);
    walker.Walk(true);
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_GT(walker.subsets, mesh.triangles.size() / SubsetScratch::kTriangles);
    EXPECT_LT(walker.deepest, 60u);
  }
  // Without scratch, too, as far as that goes.
  Kept kept({unit::MakeSoup(random, 5000, 1, 0.05f)}, kPlenty);
  const auto root =
      RootOf(kept.partition, 0, 0, nullptr, nullptr, [] { FAIL() << "a large one needs none"; });
  ASSERT_TRUE(root.has_value());
  EXPECT_LT(*root, Subset::kNoRoom);
  Walker(kept).Walk(true);
}

// Triangles that were moved already stood in two places then, and others in none.
void IfOnePartCannotBeMovedNoneIs() {
  Random random(37);
  constexpr size_t kTriangles = 10000;
  std::vector<uint32_t> triangles(kTriangles);
  std::iota(triangles.begin(), triangles.end(), 0u);
  const auto before = triangles;
  Grid grid(kTriangles, 1, static_cast<const MemoryAccount*>(nullptr));
  for (size_t i = 0; i < kTriangles; ++i) {
    grid.triangles[i] = triangles[i];
    grid.cell_of[i] = static_cast<uint16_t>(i % 2);
  }
  const auto move = [&](bool fails) {
    grid.place[0] = kTriangles / 2;
    grid.place[1] = 0;
    MoveAll(triangles, grid, [&](const auto& body) {
      body(Grid::Part{0, 0, 3000});
      if (fails) throw std::bad_alloc();
      body(Grid::Part{0, 3000, kTriangles});
    });
  };
  EXPECT_THROW(move(true), std::bad_alloc);
  EXPECT_EQ(triangles, before);
  move(false);
  EXPECT_NE(triangles, before);
  std::sort(triangles.begin(), triangles.end());
  EXPECT_EQ(triangles, before);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(SplitByGridTest);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, ThreadsTogetherSplitAsOneDoes);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, ASampleMayMissMost);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, ASampleOfACellMayMissMost);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, SmallGridsTakeNoMemory);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, OnlySomeAreSortedWhileListed);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, WhoWouldWaitSplitsANeighbour);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, ThreadsAgree);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, SplitsWhereAsked);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, WithoutScratchTheSubsetStays);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, LargeSubsetsAreSplitWhereThereIsNoMemoryForAGrid);
HWY_EXPORT_AND_TEST_P(SplitByGridTest, IfOnePartCannotBeMovedNoneIs);

}  // namespace dacrt
#endif  // HWY_ONCE

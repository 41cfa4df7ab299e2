// The memory of a kept partition: who gets which bytes of it.
#include <gtest/gtest.h>

#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/kernels.h"
#include "geometry/geometry_table.h"
#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "runtime/tasks.h"
#include "unit_test.h"

namespace dacrt::unit {
namespace {

/// A partition with all that it needs.
struct Kept {
  Kept(Mesh triangles, std::size_t budget)
      : mesh(std::move(triangles)),
        table(std::vector{mesh.View()}),
        partition(table, budget, Look(), tasks) {}

  static const FirstLook& Look() {
    InstructionSet chosen;
    return ChooseKernels(Settings().instruction_set, chosen).partition.first_look;
  }

  const Mesh mesh;
  const GeometryTable table;
  TaskPool tasks{1};
  KeptPartition partition;
};

/// Bytes that have an owner, by their addresses.
class Owned {
 public:
  /// False if somebody has one of them already.
  bool Take(const void* begin, std::size_t bytes) {
    const auto from = reinterpret_cast<std::uintptr_t>(begin);
    const auto next = ranges_.lower_bound(from);
    if (next != ranges_.end() && next->first < from + bytes) return false;
    if (next != ranges_.begin() && std::prev(next)->second > from) return false;
    ranges_.emplace(from, from + bytes);
    return true;
  }

 private:
  std::map<std::uintptr_t, std::uintptr_t> ranges_;
};

/// What one thread got.
struct Room {
  std::vector<std::pair<uint32_t, std::size_t>> nodes;
  std::vector<std::pair<uint32_t, std::size_t>> leaves;
};

/// Asks for nodes and leaves in turn, in no order, until there is neither.
void AskForRoom(KeptPartition& kept, uint64_t seed, uint32_t largest_leaf, Room& room) {
  Random random(seed);
  for (int refused = 0; refused < 200;) {
    if (random.Below(3) == 0) {
      const std::size_t count = 1 + random.Below(20);
      uint32_t first, first_subset;
      if (kept.Allocate(count, 0, first, first_subset)) {
        room.nodes.emplace_back(first, count);
        continue;
      }
    } else if (kept.HasLeafRoom()) {
      const std::size_t bytes = 1 + random.Below(largest_leaf);
      uint32_t place;
      if (kept.AllocateLeaf(bytes, place)) {
        room.leaves.emplace_back(place, bytes);
        continue;
      }
    }
    ++refused;
  }
}

// Nodes grow up and leaves down, from any number of threads, until they meet: nobody gets a byte
// that somebody else has, or that is not of the budget.
TEST(KeptRoomTest, NodesAndLeavesNeverMeet) {
  Random random(31);
  const Mesh mesh = MakeSoup(random, 3000, 1, 0.05f);
  const std::size_t least = KeptPartition::LeastBytes(3000);
  for (const std::size_t threads : {1u, 4u}) {
    for (const std::size_t budget : {least, least + 1, least + 20000, 8 * mesh.triangles.size(),
                                     32 * mesh.triangles.size(), 100 * mesh.triangles.size()}) {
      for (const uint32_t largest_leaf : {16u, 300u, static_cast<uint32_t>(kMostLeafBytes)}) {
        SCOPED_TRACE(std::to_string(budget) + " bytes, " + std::to_string(threads) + " threads");
        Kept owner(mesh, budget);
        KeptPartition& kept = owner.partition;
        const bool had_leaf_room = kept.HasLeafRoom();
        std::vector<Room> rooms(threads);
        {
          std::vector<std::thread> running;
          for (std::size_t t = 0; t < threads; ++t) {
            running.emplace_back([&, t] { AskForRoom(kept, t, largest_leaf, rooms[t]); });
          }
          for (std::thread& thread : running) thread.join();
        }
        const std::byte* const begin = kept.view().leaves;
        const std::byte* const end = begin + kept.BytesReserved();
        Owned owned;
        ASSERT_TRUE(owned.Take(kept.triangles().data(), kept.triangles().size_bytes()));
        ASSERT_TRUE(owned.Take(&kept.subset(0), sizeof(Subset)));
        std::size_t node_bytes = 0, leaf_bytes = 0;
        for (const Room& room : rooms) {
          for (const auto& [first, count] : room.nodes) {
            const std::byte* const node = reinterpret_cast<const std::byte*>(&kept.node(first));
            ASSERT_EQ(reinterpret_cast<std::uintptr_t>(node) % 64, 0u);
            ASSERT_GE(node, begin);
            ASSERT_LE(node + count * sizeof(WideNode), end);
            ASSERT_TRUE(owned.Take(node, count * sizeof(WideNode)));
            node_bytes += count * sizeof(WideNode);
          }
          for (const auto& [place, bytes] : room.leaves) {
            ASSERT_LE(place, ChildWord::kMostBlock);
            const std::byte* const leaf = kept.leaf(place);
            ASSERT_GE(leaf, begin);
            // Whole vectors may be read from the last byte on.
            ASSERT_LE(leaf + bytes + KeptPartition::kReadBehind, end);
            ASSERT_TRUE(owned.Take(leaf, bytes));
            leaf_bytes += bytes;
          }
        }
        EXPECT_GT(node_bytes, 0u);
        EXPECT_EQ(leaf_bytes > 0, had_leaf_room);
        EXPECT_FALSE(kept.HasLeafRoom()) << "it has ended";
        uint32_t place;
        EXPECT_FALSE(kept.AllocateLeaf(kMostLeafBytes, place));
        EXPECT_LE(kept.BytesUsed(), kept.BytesReserved());
        // Nearly all of it was had.
        EXPECT_GT(kept.BytesUsed() + 20 * sizeof(WideNode) + kMostLeafBytes +
                      KeptPartition::kReadBehind + (64 + 3000 / 128) * sizeof(Subset) + 128,
                  kept.BytesReserved());
      }
    }
  }
}

// So many nodes may be exact that leaves find room beside them: none in a small budget, all in a
// large one. What is given back may be had again.
TEST(KeptRoomTest, LeavesHaveRoomBesideExactNodes) {
  constexpr std::size_t kCount = 12000, kNodes = kCount / 24;
  Random random(34);
  const Mesh mesh = MakeSoup(random, kCount, 1, 0.05f);
  std::size_t before = 0;
  for (const std::size_t bytes : {0u, 8u, 24u, 32u, 34u, 40u, 64u}) {
    SCOPED_TRACE(std::to_string(bytes) + " bytes a triangle");
    Kept owner(mesh, bytes * kCount);
    KeptPartition& kept = owner.partition;
    std::size_t count = 0;
    while (count < 4 * kNodes && kept.TakeExactRoom(1)) ++count;
    EXPECT_GE(count, before);
    if (bytes <= 24) {
      EXPECT_EQ(count, 0u);
    } else if (bytes == 32) {
      EXPECT_GT(count, kNodes / 4);
      EXPECT_LT(count, kNodes);
    } else if (bytes >= 40) {
      EXPECT_GT(count, kNodes);
    }
    before = count;
    uint32_t place;
    std::size_t leaf_bytes = 0;
    while (kept.AllocateLeaf(256, place)) leaf_bytes += 256;
    if (bytes == 24 || bytes == 32) {
      EXPECT_GT(leaf_bytes, (bytes - 16) * kCount - 128 * count) << "beside all nodes";
    }
    kept.ReturnExactRoom(count);
    EXPECT_EQ(kept.TakeExactRoom(count), true);
    EXPECT_EQ(kept.AllocateLeaf(256, place), false) << "what was taken is taken";
  }
}

TEST(KeptRoomTest, SubsetsEndWhereNodesBegin) {
  Random random(32);
  Kept owner(MakeSoup(random, 3000, 1, 0.05f), 100 * 3000);
  KeptPartition& kept = owner.partition;
  uint32_t node, last = 0;
  for (uint32_t subset; kept.Allocate(0, 1, node, subset);) last = subset;
  EXPECT_GT(last, 0u);
  EXPECT_LE(reinterpret_cast<std::uintptr_t>(&kept.subset(last) + 1),
            reinterpret_cast<std::uintptr_t>(kept.view().nodes));
}

// Without room for a leaf the order still says what is in it.
// A refit would take a subset that is counted and stands nowhere for the first node's first child.
TEST(KeptRoomTest, WhatIsRefusedTakesNoSubsets) {
  Random random(8);
  Kept owner(MakeSoup(random, 3000, 1, 0.05f), 32 * 3000);
  KeptPartition& kept = owner.partition;
  uint32_t node, subset;
  EXPECT_FALSE(kept.Allocate(1 << 20, 3, node, subset)) << "too many nodes";
  EXPECT_EQ(kept.subset_count(), 1u);
  EXPECT_FALSE(kept.Allocate(2, 1000, node, subset)) << "too many subsets";
  EXPECT_EQ(kept.subset_count(), 1u);
  ASSERT_TRUE(kept.Allocate(2, 0, node, subset));
  EXPECT_EQ(node, 0u) << "the nodes are free again";
  ASSERT_TRUE(kept.Allocate(2, 3, node, subset));
  EXPECT_EQ(subset, 1u);
}

TEST(KeptRoomTest, SmallBudgetsHaveNoLeaves) {
  Random random(33);
  const Mesh mesh = MakeSoup(random, 12000, 1, 0.05f);
  Kept least(mesh, 0), plenty(mesh, 32 * 12000);
  EXPECT_FALSE(least.partition.HasLeafRoom());
  EXPECT_TRUE(plenty.partition.HasLeafRoom());
  uint32_t place;
  EXPECT_FALSE(least.partition.AllocateLeaf(16, place));
  EXPECT_TRUE(plenty.partition.AllocateLeaf(16, place));
}

}  // namespace
}  // namespace dacrt::unit

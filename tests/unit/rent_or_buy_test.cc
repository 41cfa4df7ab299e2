#include "partition/rent_or_buy.h"

#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rent_or_buy_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "kept_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

/// `rays` rays come to a subset together. True if they have bought it.
bool Come(Kept& kept, uint32_t number, uint32_t rays) {
  Subset& subset = kept.partition.subset(number);
  if (!Subset::IsRented(subset.root) || !rent_or_buy::IsDue(subset, rays)) return false;
  BuyNodes(kept.partition, subset, *kept.scratch);
  return true;
}

// Costs are counted as they are taken to be. However many rays come, and however many of them
// together, the subset costs at most twice what it would have, had one known.
void CostsAtMostTwiceTheBest() {
  Random random(61);
  for (const uint32_t triangles : {600u, 900u, 2048u}) {
    const unit::Mesh mesh = unit::MakeSoup(random, triangles, 1, 0.1f);
    const uint64_t price = uint64_t{triangles} * rent_or_buy::kPrice;
    for (const uint32_t together : {1u, 7u, 64u, 100'000u}) {
      Kept kept({mesh}, kPlenty);
      ASSERT_TRUE(Subset::IsRented(kept.Root(0)));
      uint64_t rays = 0, cost = 0;
      bool is_bought = false;
      for (int call = 0; call < 3000; ++call) {
        const uint32_t count = 1 + random.Below(together);
        rays += count;
        if (Come(kept, 0, count)) {
          ASSERT_FALSE(is_bought);
          is_bought = true;
          cost += price;
        }
        if (!is_bought) cost += uint64_t{count} * rent_or_buy::kRent;
        EXPECT_EQ(is_bought, Subset::IsNode(kept.partition.subset(0).root));
        // That rays are whole, and not parts of one, may cost one more.
        const uint64_t best = std::min(rays * rent_or_buy::kRent, price);
        ASSERT_LE(cost, 2 * best + rent_or_buy::kRent) << triangles << " triangles, " << rays;
      }
      EXPECT_TRUE(is_bought);
      Walker(kept).Walk(true);
    }
  }
}

// Rays that are enough by themselves have what is bought at once, and nothing beside it.
void ManyRaysBuyAtOnce() {
  Random random(62);
  const unit::Mesh mesh = unit::MakeSoup(random, 2000, 1, 0.1f);
  Kept few({mesh}, kPlenty), many({mesh}, kPlenty);
  many.rays = Rays::kMany;
  EXPECT_TRUE(Subset::IsRented(few.Root(0)));
  EXPECT_TRUE(Subset::IsNode(many.Root(0)));
  few.rays = Rays::kMore;
  few.Root(0);
  EXPECT_EQ(few.partition.subset(0).node_count, many.partition.subset(0).node_count);
  EXPECT_GT(few.partition.BytesUsed(), many.partition.BytesUsed());
}

// What will not live for long has the nodes that others rent, with copies of their leaves.
void ShortLivedOnesNeitherRentNorBuy() {
  Random random(68);
  const unit::Mesh mesh = unit::MakeSoup(random, 2000, 1, 0.1f);
  Kept few({mesh}, kPlenty);
  few.Root(0);
  for (const Rays rays : kAllRays) {
    Kept kept({mesh}, kPlenty);
    kept.partition.SetShortLived();
    kept.rays = rays;
    EXPECT_TRUE(Subset::IsNode(kept.Root(0)));
    EXPECT_EQ(kept.partition.BytesUsed(), few.partition.BytesUsed());
    Walker(kept).Walk(true);
  }
}

// Of threads whose rays come at once one buys.
void OneThreadBuys() {
  Random random(63);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  ASSERT_TRUE(Subset::IsRented(kept.Root(0)));
  std::atomic<int> bought{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int call = 0; call < 2000; ++call) {
        bought += Come(kept, 0, 1 + static_cast<uint32_t>(t * call) % 3);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(bought, 1);
  EXPECT_FALSE(rent_or_buy::IsDue(kept.partition.subset(0), UINT32_MAX)) << "for who came late";
  Walker(kept).Walk(true);
}

// What was rented is what the next one rents or buys.
void WhatWasRentedIsUsedAgain() {
  Random random(64);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  kept.rays = Rays::kMore;
  kept.Root(0);
  Subset& subset = kept.partition.subset(0);
  const size_t bytes = kept.partition.BytesUsed();
  for (int round = 0; round < 5; ++round) {
    subset.root = Subset::NodeOf(subset.root) | Subset::kStale;
    ASSERT_TRUE(Subset::IsNode(kept.Root(0)));
    EXPECT_EQ(kept.partition.BytesUsed(), bytes);
  }
  Walker(kept).Walk(true);
}

// Rented nodes stay while a ray is in them, and what their leaves say as long as it may have hits
// there.
void WhoIsInsideMayStay() {
  Random random(67);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  const ChildWord rented = ChildWord::Inner(Subset::NodeOf(kept.Root(0)));
  Subset& subset = kept.partition.subset(0);
  const auto is_given_back = [&] { return subset.rented == 0; };
  const std::span<const uint32_t> place = kept.partition.OrderOf(subset);
  const std::vector<uint32_t> order(place.begin(), place.end());
  {
    const rent_or_buy::Stay first(kept.partition, subset);
    ASSERT_EQ(first.root()->bits(), rented.bits());
    {
      const rent_or_buy::Stay second(kept.partition, subset);
      EXPECT_TRUE(Come(kept, 0, UINT32_MAX));
      EXPECT_FALSE(is_given_back());
      const rent_or_buy::Stay late(kept.partition, subset);
      EXPECT_FALSE(late.root().has_value()) << "it is bought";
    }
    EXPECT_FALSE(is_given_back());
    uint32_t node, no_subset;
    ASSERT_TRUE(kept.partition.Allocate(1, 0, node, no_subset));
    EXPECT_GT(node, rented.number() + subset.node_count) << "behind both";
  }
  EXPECT_TRUE(std::equal(place.begin(), place.end(), order.begin(), order.end()));
  EXPECT_NE(kept.partition.OrderOf(subset).data(), place.data());
  EXPECT_TRUE(is_given_back());
  uint32_t node, no_subset;
  ASSERT_TRUE(kept.partition.Allocate(1, 0, node, no_subset));
  EXPECT_EQ(node, rented.number());
  Walker(kept).Walk(true);
}

// Where there is no room for better nodes, those that were rented stay, and their leaves may have
// copies now.
void WithoutRoomTheRentedOnesStay() {
  Random random(65);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  const uint32_t rented = kept.Root(0);
  ASSERT_TRUE(Subset::IsRented(rented));
  uint32_t first_node, first_subset;
  while (kept.partition.Allocate(1, 0, first_node, first_subset)) continue;
  const size_t bytes = kept.partition.BytesUsed();
  EXPECT_TRUE(Come(kept, 0, UINT32_MAX));
  EXPECT_EQ(kept.partition.subset(0).root, Subset::NodeOf(rented));
  EXPECT_EQ(kept.partition.BytesUsed(), bytes);
  EXPECT_FALSE(kept.partition.Allocate(1, 0, first_node, first_subset)) << "nothing is given back";
  Walker(kept).Walk(true);
}

// The same where there is room for another order, but not for nodes beside it.
void AnOrderWithoutNodesIsGivenBack() {
  Random random(69);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  const uint32_t rented = kept.Root(0);
  NodeRun order;
  uint32_t place, first_node, first_subset;
  ASSERT_TRUE(kept.partition.AllocateOrder(2000, order, place));
  while (kept.partition.Allocate(1, 0, first_node, first_subset)) continue;
  kept.partition.Free(order);
  EXPECT_TRUE(Come(kept, 0, UINT32_MAX));
  EXPECT_EQ(kept.partition.subset(0).root, Subset::NodeOf(rented));
  ASSERT_TRUE(kept.partition.Allocate(order.count, 0, first_node, first_subset));
  EXPECT_EQ(first_node, order.first);
  EXPECT_FALSE(kept.partition.Allocate(1, 0, first_node, first_subset));
  Walker(kept).Walk(true);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "engine/kernels.h"
#include "instruction_sets.h"
#include "runtime/memory_account.h"
#include "runtime/tasks.h"
#include "runtime/workspace.h"
#include "scene/scene_parts.h"

namespace dacrt {

HWY_BEFORE_TEST(RentOrBuyTest);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, CostsAtMostTwiceTheBest);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, ManyRaysBuyAtOnce);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, ShortLivedOnesNeitherRentNorBuy);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, OneThreadBuys);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WhatWasRentedIsUsedAgain);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WhoIsInsideMayStay);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WithoutRoomTheRentedOnesStay);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, AnOrderWithoutNodesIsGivenBack);

namespace unit {
namespace {

/// A scene of one subset, and packets that come to it.
class RentedTraceTest : public OnEachInstructionSet {
 protected:
  static constexpr uint32_t kTriangles = 1500;

  /// Traces a packet of `lanes` rays, each of which is another one in each round.
  void TracePacket(Query query, uint32_t lanes, uint32_t round, std::vector<float>& values) {
    values.assign(std::size_t{lanes} * kPacketComponents, 0);
    const auto set = [&](PacketComponent component, uint32_t lane, float value) {
      values[static_cast<std::size_t>(component) * lanes + lane] = value;
    };
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      Random random(round * lanes + lane);
      set(PacketComponent::kOrgX, lane, random.Uniform(-1, 1));
      set(PacketComponent::kOrgY, lane, random.Uniform(-1, 1));
      set(PacketComponent::kOrgZ, lane, -3);
      set(PacketComponent::kDirX, lane, random.Uniform(-0.2f, 0.2f));
      set(PacketComponent::kDirZ, lane, 1);
      set(PacketComponent::kTfar, lane, kInfinity);
    }
    const RayPacket packet{.values = values.data(), .lanes = lanes, .has_masks = false};
    const auto way = lanes == 1 ? kernels_.trace.single : kernels_.trace.lanes;
    way[static_cast<int>(query)](*scene_, packet, {}, pool_);
  }

  void SetUp() override {
    Random random(66);
    mesh_ = MakeSoup(random, kTriangles, 1, 0.1f);
  }
  void Keep() {
    scene_.reset(new SceneParts{GeometryTable(std::vector{mesh_.View()})});
    scene_->kept = std::make_unique<KeptPartition>(scene_->geometries, 64 * kTriangles,
                                                   kernels_.partition.first_look, tasks_, nullptr);
    scene_->bounds = scene_->kept->bounds();
    scene_->triangle_count = kTriangles;
  }

  const MemoryAccount memory_{MemoryMonitor{}};
  TaskPool tasks_{1};
  WorkspacePool pool_{memory_};
  Mesh mesh_;
  InstructionSet chosen_;
  const Kernels kernels_ = ChooseKernels(GetParam(), chosen_);
  std::unique_ptr<SceneParts> scene_;
};

// By every way in each ray counts once, and all have the same hits before and after.
TEST_P(RentedTraceTest, RaysBuyWithTheLastOneThatIsMissing) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    for (const uint32_t lanes : {1u, 4u, 16u}) {
      SCOPED_TRACE(std::to_string(lanes) + " lanes");
      Keep();
      const Subset& subset = scene_->kept->subset(0);
      const uint32_t most = rent_or_buy::RaysFor(kTriangles), packets = (most + lanes - 1) / lanes;
      std::vector<std::vector<float>> rented(packets);
      for (uint32_t i = 0; i < packets; ++i) {
        ASSERT_FALSE(Subset::IsNode(subset.root)) << i;
        TracePacket(query, lanes, i, rented[i]);
      }
      EXPECT_TRUE(Subset::IsNode(subset.root));
      std::vector<float> bought;
      std::size_t hits = 0;
      for (uint32_t i = 0; i < packets; ++i) {
        TracePacket(query, lanes, i, bought);
        ASSERT_EQ(std::memcmp(bought.data(), rented[i].data(), bought.size() * sizeof(float)), 0) << i;
        hits += bought[static_cast<std::size_t>(PacketComponent::kTfar) * lanes] != kInfinity;
      }
      EXPECT_GT(hits, packets / 4);
      EXPECT_LT(hits, packets);
    }
  }
}

INSTANTIATE_ON_EACH_INSTRUCTION_SET(RentedTraceTest);

}  // namespace
}  // namespace unit
}  // namespace dacrt
#endif  // HWY_ONCE

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
#include <map>
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

/// `rays` rays come to a subset together. Whether they buy nodes.
bool Come(Kept& kept, uint32_t number, uint32_t rays) {
  Subset& subset = kept.partition.subset(number);
  if (!Subset::IsRented(subset.root) || !rent_or_buy::CountRays(subset, rays)) return false;
  BuyNodes(kept.partition, subset, *kept.scratch);
  return true;
}

// Costs are counted as they are taken to be. However many rays come, and however many of them
// together, nodes cost at most twice what they would have, had one known.
void CostsAtMostTwiceTheBest() {
  Random random(61);
  for (const uint32_t triangles : {600u, 900u, 2048u}) {
    const unit::Mesh mesh = unit::MakeSoup(random, triangles, 1, 0.1f);
    for (const uint32_t together : {1u, 7u, 64u, 100'000u}) {
      Kept kept({mesh}, kPlenty);
      ASSERT_TRUE(Subset::IsRented(kept.Root(0)));
      constexpr rent_or_buy::Offer kOffer = rent_or_buy::kNodes;
      const uint64_t price = uint64_t{triangles} * kOffer.price;
      uint64_t rays = 0, cost = 0;
      bool is_bought = false;
      for (int call = 0; call < 3000; ++call) {
        const uint32_t count = 1 + random.Below(together);
        // A few pay as much as some more.
        const uint64_t counted = std::max<uint64_t>(count, rent_or_buy::kFewestRays);
        rays += counted;
        if (Come(kept, 0, count)) {
          ASSERT_FALSE(is_bought);
          cost += price;
          is_bought = true;
        }
        if (!is_bought) cost += counted * kOffer.rent;
        // That rays are whole, and not parts of one, may cost one more.
        const uint64_t best = std::min(rays * kOffer.rent, price);
        ASSERT_LE(cost, 2 * best + kOffer.rent) << triangles << " triangles, " << rays;
        ASSERT_EQ(is_bought, Subset::IsNode(kept.partition.subset(0).root));
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
  EXPECT_EQ(few.partition.subset(0).node_slots, many.partition.subset(0).node_slots);
  EXPECT_GT(few.partition.BytesUsed(), many.partition.BytesUsed());
}

// Of threads whose rays come at once one buys the nodes.
void NodesAreBoughtOnce() {
  Random random(63);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  ASSERT_TRUE(Subset::IsRented(kept.Root(0)));
  std::atomic<int> nodes{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int call = 0; call < 2000; ++call) {
        nodes += Come(kept, 0, 1 + static_cast<uint32_t>(t * call) % 3);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(nodes, 1);
  EXPECT_FALSE(rent_or_buy::CountRays(kept.partition.subset(0), UINT32_MAX)) << "who came late";
  Walker(kept).Walk(true);
}

// Nodes that are bought have the copies that leaves got in the rented ones, but for what is wrong;
// and who stays in those makes no others there.
void LeavesKeepTheirCopies() {
  Random random(70);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  const uint32_t rented = Subset::NodeOf(kept.Root(0));
  Subset& subset = kept.partition.subset(0);
  const NodeRun rented_nodes{rented, subset.node_slots};
  std::map<uint32_t, uint32_t> copies;  // by where their items stand
  uint32_t stale_place = UINT32_MAX;
  kept.partition.ForEachNode(rented_nodes, [&](WideNode& node) {
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      if (!child.IsRange()) continue;
      ASSERT_TRUE(node.bare >> k & 1);
      ASSERT_TRUE(node.UnvisitedLeaves(1u << k));
      if (copies.size() >= 100) continue;
      uint32_t place;
      ASSERT_TRUE(kept.partition.AllocateLeaf(sizeof(LeafBlock), place));
      auto& block = *reinterpret_cast<LeafBlock*>(kept.partition.leaf(place));
      block = LeafBlock();
      block.first = child.range();
      node.SetChild(k, ChildWord::Block(place));
      node.SetLeavesDone(1u << k);
      copies[child.range()] = ChildWord::Block(place).bits();
      if (copies.size() != 50) continue;
      node.SetLeafStale(k);
      stale_place = child.range();
    }
  });
  ASSERT_EQ(copies.size(), 100u);
  copies.erase(stale_place);
  const rent_or_buy::Stay inside(kept.partition, subset);
  EXPECT_TRUE(Come(kept, 0, UINT32_MAX));
  kept.partition.ForEachNode(rented_nodes, [&](const WideNode& node) {
    EXPECT_EQ(node.BareLeaves(UINT8_MAX), node.StaleLeaves(UINT8_MAX));
  });
  size_t kept_copies = 0;
  kept.partition.ForEachNode({subset.root, subset.node_slots}, [&](const WideNode& node) {
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      if (!child.IsLeaf()) continue;
      const auto copy = copies.find(kept.partition.PlaceOfLeaf(child));
      EXPECT_EQ(child.IsBlock(), copy != copies.end()) << "a wrong one is left behind";
      EXPECT_EQ((node.bare >> k & 1) != 0, child.IsRange()) << "the others may have one";
      EXPECT_EQ(node.UnvisitedLeaves(1u << k), 0u) << "at once";
      if (copy == copies.end()) continue;
      EXPECT_EQ(child.bits(), copy->second);
      ++kept_copies;
    }
  });
  EXPECT_EQ(kept_copies, 99u);
}

// Memory that another partition had is as good as new.
void WhatMemoryHeldBeforeDoesNotMatter() {
  Random random(71);
  const unit::Mesh mesh = unit::MakeSoup(random, 9000, 1, 0.1f);
  for (const Rays rays : kAllRays) {
    SparePages spare;
    Pages junk = spare.Take(kPlenty, nullptr);
    const std::byte* const place = junk.data();
    std::memset(junk.data(), 0xFF, junk.bytes());
    spare.Keep(std::move(junk));
    Kept used({mesh}, kPlenty, nullptr, 1, &spare), fresh({mesh}, kPlenty);
    ASSERT_EQ(used.partition.view().leaves, place);
    used.rays = fresh.rays = rays;
    Walker(used).Walk(true);
    Walker(fresh).Walk(true);
    ASSERT_EQ(used.partition.subset_count(), fresh.partition.subset_count());
    ASSERT_EQ(used.partition.BytesUsed(), fresh.partition.BytesUsed());
    for (uint32_t i = 0; i < fresh.partition.subset_count(); ++i) {
      const Subset &one = used.partition.subset(i), &other = fresh.partition.subset(i);
      ASSERT_EQ(one.root, other.root);
      ASSERT_EQ(one.parent, other.parent);
      ASSERT_EQ(one.rays, other.rays);
      ASSERT_EQ(one.inside, other.inside);
      ASSERT_EQ(one.rented, other.rented);
      ASSERT_EQ(one.node_slots, other.node_slots);
      ASSERT_EQ(one.has_its_nodes, other.has_its_nodes);
      ASSERT_EQ(one.geometry_bits, other.geometry_bits);
    }
  }
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

// Triangles that move may move again. A copy of a partition is as careful as that.
void WhatHasMovedIsSplitWithoutCare() {
  Random random(68);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  kept.rays = Rays::kExpected;
  ASSERT_TRUE(Subset::IsNode(kept.Root(0)));
  EXPECT_TRUE(KeptPartition(kept.partition).splits_with_care());
  Subset& subset = kept.partition.subset(0);
  subset.root = Subset::NodeOf(subset.root) | Subset::kStale;
  EXPECT_TRUE(Subset::IsRented(kept.Root(0)));
}

// Rented nodes stay while a ray is in them.
void WhoIsInsideMayStay() {
  Random random(67);
  Kept kept({unit::MakeSoup(random, 2000, 1, 0.1f)}, kPlenty);
  const ChildWord rented = ChildWord::Inner(Subset::NodeOf(kept.Root(0)));
  Subset& subset = kept.partition.subset(0);
  const auto is_given_back = [&] { return subset.rented == 0; };
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
    EXPECT_GE(node, subset.root + subset.node_slots) << "behind both";
  }
  EXPECT_TRUE(is_given_back());
  uint32_t node, no_subset;
  for (const uint32_t next : {0u, 1u}) {
    ASSERT_TRUE(kept.partition.Allocate(1, 0, node, no_subset));
    EXPECT_EQ(node, rented.number() + next) << "what is longer stays free";
  }
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
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, NodesAreBoughtOnce);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, LeavesKeepTheirCopies);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WhatMemoryHeldBeforeDoesNotMatter);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WhatWasRentedIsUsedAgain);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WhatHasMovedIsSplitWithoutCare);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WhoIsInsideMayStay);
HWY_EXPORT_AND_TEST_P(RentOrBuyTest, WithoutRoomTheRentedOnesStay);

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

  /// Leaves that have copies, in the nodes of the only subset.
  std::size_t Copies() const {
    const Subset& subset = scene_->kept->subset(0);
    std::size_t copies = 0;
    std::as_const(*scene_->kept)
        .ForEachNode({Subset::NodeOf(subset.root), subset.node_slots}, [&](const WideNode& node) {
          for (std::size_t k = 0; k < node.count; ++k) copies += node.Child(k).IsBlock();
        });
    return copies;
  }

  const MemoryAccount memory_{MemoryMonitor{}};
  TaskPool tasks_{1};
  WorkspacePool pool_{memory_};
  Mesh mesh_;
  InstructionSet chosen_;
  const Kernels kernels_ = ChooseKernels(GetParam(), chosen_);
  std::unique_ptr<SceneParts> scene_;
};

// By every way in each ray counts once or, where a packet's go their own ways, as a few, and all
// have the same hits before and after. Leaves that rays have come to have their copies by then, and
// keep them.
TEST_P(RentedTraceTest, RaysBuyByEveryWayIn) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    for (const uint32_t lanes : {1u, 4u, 16u}) {
      SCOPED_TRACE(std::to_string(lanes) + " lanes");
      Keep();
      const Subset& subset = scene_->kept->subset(0);
      const uint32_t most = rent_or_buy::kNodes.RaysFor(kTriangles);
      const uint32_t each = std::max<uint32_t>(lanes, rent_or_buy::kFewestRays);
      const uint32_t packets = (most + each - 1) / each;
      std::vector<std::vector<float>> rented(packets);
      for (uint32_t i = 0; i < packets; ++i) {
        if (i < most / (lanes * rent_or_buy::kFewestRays)) {
          ASSERT_FALSE(Subset::IsNode(subset.root)) << i;
        }
        TracePacket(query, lanes, i, rented[i]);
      }
      ASSERT_TRUE(Subset::IsNode(subset.root));
      EXPECT_GT(Copies(), 10u);
      std::vector<float> bought;
      std::size_t hits = 0;
      for (uint32_t i = 0; i < packets; ++i) {
        TracePacket(query, lanes, i, bought);
        ASSERT_EQ(std::memcmp(bought.data(), rented[i].data(), bought.size() * sizeof(float)), 0)
            << i;
        hits += bought[static_cast<std::size_t>(PacketComponent::kTfar) * lanes] != kInfinity;
      }
      EXPECT_GT(hits, packets / 4);
      EXPECT_LT(hits, packets);
    }
  }
}

// A leaf gets its copy when rays come to it the second time, by every way in.
TEST_P(RentedTraceTest, LeavesAreCopiedTheSecondTime) {
  for (const bool with_care : {false, true}) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      for (const uint32_t lanes : {1u, 4u, 16u}) {
        SCOPED_TRACE(std::to_string(lanes) + (with_care ? " lanes, with care" : " lanes"));
        // On a thread that has learnt nothing: else packets may look in another order.
        const auto trace = [&] {
          std::thread([&] {
            std::vector<float> values;
            TracePacket(query, lanes, 0, values);
          }).join();
        };
        Keep();
        if (with_care) scene_->kept->SplitWithCare();
        trace();
        ASSERT_EQ(Subset::IsRented(scene_->kept->subset(0).root), !with_care);
        // Those of a packet may come one by one.
        if (lanes == 1) {
          EXPECT_EQ(Copies(), 0u);
        }
        trace();
        ASSERT_EQ(Subset::IsRented(scene_->kept->subset(0).root), !with_care);
        const std::size_t copies = Copies();
        EXPECT_GT(copies, 0u);
        trace();
        EXPECT_EQ(Copies(), copies) << "there is nothing left to copy";
      }
    }
  }
}

INSTANTIATE_ON_EACH_INSTRUCTION_SET(RentedTraceTest);

}  // namespace
}  // namespace unit
}  // namespace dacrt
#endif  // HWY_ONCE

#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kept_partition_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "partition/kept_partition.h"
#include "partition/list_triangles-inl.h"
#include "partition/split_by_grid-inl.h"
#include "scene/scene_parts.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Float3;
using unit::Mesh;
using unit::Random;

constexpr size_t kPlenty = size_t{1} << 24;

/// A partition with all that it needs.
class Kept {
 public:
  /// `account` as for KeptPartition.
  Kept(std::vector<Mesh> meshes, size_t budget, const MemoryAccount* account = nullptr)
      : meshes_(std::move(meshes)),
        table_(unit::Views(meshes_)),
        tasks_(1),
        partition(table_, budget, ListTriangles, tasks_, account),
        scratch(std::make_unique<SubsetScratch>()) {}

  /// Of geometries of every shape, whose memory is the caller's.
  Kept(std::span<const Geometry> geometries, size_t budget)
      : table_(geometries, std::vector<const SceneParts*>(geometries.size()), false),
        tasks_(1),
        partition(table_, budget, ListTriangles, tasks_),
        scratch(std::make_unique<SubsetScratch>()) {}

  uint32_t Root(uint32_t subset) {
    return *RootOf(partition, subset, scratch.get(), nullptr, [] { FAIL() << "no memory"; });
  }
  const MeshTable& table() const { return table_; }

 private:
  std::vector<Mesh> meshes_;
  MeshTable table_;
  TaskPool tasks_;

 public:
  KeptPartition partition;
  std::unique_ptr<SubsetScratch> scratch;
};

/// What a partition is made of.
struct Counts {
  size_t nodes = 0;
  size_t children = 0;
  size_t leaves = 0;
  size_t subsets = 0;
  size_t without_room = 0;
  size_t deepest = 0;
};

/// Walks the whole partition, splits what is not split, and checks what a solver relies on.
class Walker : public Counts {
 public:
  explicit Walker(Kept& kept) : kept_(kept) {}

  /// Whether every subset is expected to find room.
  void Walk(bool has_room) {
    has_room_ = has_room;
    Subset& all = kept_.partition.subset(0);
    ASSERT_EQ(all.begin, 0u);
    ASSERT_EQ(all.count, kept_.partition.triangle_count());
    WalkSubset(0, {}, 1);
    if (testing::Test::HasFatalFailure()) return;
    ExpectEachOnce();
    EXPECT_LE(kept_.partition.BytesUsed(), kept_.partition.BytesReserved());
  }

 private:
  struct Volume {
    float lower[3];
    float upper[3];
  };
  using Volumes = std::vector<Volume>;

  /// The nodes of a subset hold just its triangles.
  void WalkSubset(uint32_t number, const Volumes& above, size_t depth) {
    ++subsets;
    ASSERT_TRUE(seen_subsets_.insert(number).second) << "a subset with two parents";
    const uint32_t root = kept_.Root(number);
    Subset& subset = kept_.partition.subset(number);
    ASSERT_EQ(root, subset.root.load());
    ASSERT_EQ(root, kept_.Root(number)) << "what is split stays";
    const size_t begin = subset.begin, end = begin + subset.count;
    ASSERT_GE(subset.count, 1u);
    if (root == Subset::kNoRoom) {
      ASSERT_FALSE(has_room_);
      ++without_room;
      AddTriangles(begin, subset.count, above);
      return;
    }
    ASSERT_LT(root, Subset::kNoRoom);
    const size_t before = count_;
    WalkNode(root, above, depth, begin, end);
    ASSERT_EQ(count_ - before, subset.count);
  }

  void WalkNode(uint32_t number, const Volumes& above, size_t depth, size_t begin, size_t end) {
    ++nodes;
    ASSERT_LT(depth, 3000u);
    deepest = std::max(deepest, depth);
    ASSERT_TRUE(seen_nodes_.insert(number).second) << "a node with two parents";
    const WideNode& node = kept_.partition.node(number);
    ASSERT_GE(node.count, 1u);
    ASSERT_LE(node.count, WideNode::kWidth);
    children += node.count;
    const ChildPlanes planes(node, PlaneOffsets(0));
    HWY_ALIGN float lower[3][WideNode::kWidth], upper[3][WideNode::kWidth];
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t part = 0; part < kParts; ++part) {
        hn::Store(planes.near[part][axis], kEightTag, lower[axis] + part * kPartLanes);
        hn::Store(planes.far[part][axis], kEightTag, upper[axis] + part * kPartLanes);
      }
    }
    for (size_t i = 0; i < node.count; ++i) {
      Volumes volumes = above;
      Volume& own = volumes.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        own.lower[axis] = lower[axis][i];
        own.upper[axis] = upper[axis][i];
      }
      const ChildWord child = node.Child(i);
      if (child.IsLeaf()) {
        WalkLeaf(child, volumes, begin, end);
      } else if (child.IsSubset()) {
        Subset& subset = kept_.partition.subset(child.number());
        ASSERT_GE(subset.begin, begin);
        ASSERT_LE(subset.begin + subset.count, end);
        ASSERT_EQ(subset.parent, number * WideNode::kWidth + i);
        WalkSubset(child.number(), volumes, depth + 1);
        // Once split, the way to it is the shorter one.
        const uint32_t root = subset.root;
        ASSERT_EQ(node.Child(i).bits(),
                  root < Subset::kNoRoom ? ChildWord::Inner(root).bits() : child.bits());
      } else {
        const Subset* const subset = SubsetWithRoot(child.number());
        WalkNode(child.number(), volumes, depth + 1, subset ? subset->begin : begin,
                 subset ? subset->begin + subset->count : end);
      }
      if (testing::Test::HasFatalFailure()) return;
    }
  }

  /// The subset that a node is the first one of; null if it is in the middle of one.
  const Subset* SubsetWithRoot(uint32_t node) {
    for (const uint32_t number : seen_subsets_) {
      if (kept_.partition.subset(number).root == node) return &kept_.partition.subset(number);
    }
    return nullptr;
  }

  /// Of one item or of at most kLeafLanes lanes, of which the last item is marked, and no other.
  void WalkLeaf(ChildWord leaf, const Volumes& volumes, size_t begin, size_t end) {
    ++leaves;
    ASSERT_TRUE(leaf.IsRange());
    size_t place = leaf.range(), lanes = 0, count = 0;
    ASSERT_GE(place, begin);
    for (bool is_last = false; !is_last; ++place, ++count) {
      ASSERT_LT(place, end) << "no mark in the subset";
      const uint32_t entry = kept_.partition.triangles()[place];
      is_last = (entry & KeptOrder::kLastOfLeaf) != 0;
      lanes += kept_.table().LanesOf(kept_.table().Locate(KeptOrder::NumberOf(entry)).mesh);
    }
    ASSERT_LE(lanes, kept_.partition.leaf_lanes());
    AddTriangles(leaf.range(), count, volumes);
  }

  /// Triangles of a leaf, which every volume on the way there must hold.
  void AddTriangles(size_t begin, size_t count, const Volumes& volumes) {
    for (size_t place = begin; place < begin + count; ++place) {
      const uint32_t number = KeptOrder::NumberOf(kept_.partition.triangles()[place]);
      ++count_;
      ASSERT_TRUE(places_.insert(place).second) << "two leaves for a place";
      ASSERT_TRUE(numbers_.insert(number).second) << "two places for a triangle";
      TriangleRef ref;
      ASSERT_TRUE(BoundTriangle(kept_.table(), kept_.table().Locate(number), ref));
      const WideBox wide = Widen(ref.lower, ref.upper);
      for (const Volume& volume : volumes) {
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_LE(volume.lower[axis], hn::GetLane(wide.lower[axis]));
          ASSERT_GE(volume.upper[axis], hn::GetLane(wide.upper[axis]));
        }
      }
    }
  }

  void ExpectEachOnce() const {
    size_t expected = 0;
    const auto meshes = kept_.table().meshes();
    for (uint32_t mesh = 0; mesh < meshes.size(); ++mesh) {
      for (uint32_t primitive = 0; primitive < meshes[mesh].triangle_count; ++primitive) {
        TriangleRef ref;
        const bool can_be_hit = BoundTriangle(kept_.table(), mesh, primitive, ref);
        expected += can_be_hit;
        ASSERT_EQ(numbers_.contains(kept_.table().Number(mesh, primitive)), can_be_hit);
      }
    }
    ASSERT_EQ(kept_.partition.triangle_count(), expected);
    ASSERT_EQ(count_, expected);
  }

  Kept& kept_;
  bool has_room_ = true;
  size_t count_ = 0;
  std::set<uint32_t> seen_subsets_, seen_nodes_, numbers_;
  std::set<size_t> places_;
};

/// With all the room that a partition can want.
Counts ExpectWholePartition(std::vector<Mesh> meshes, const std::string& what) {
  SCOPED_TRACE(what);
  // Split fast, then split well.
  Kept fast(meshes, kPlenty);
  fast.partition.SetShortLived();
  Walker fast_walker(fast);
  fast_walker.Walk(true);
  Kept kept(std::move(meshes), kPlenty);
  Walker walker(kept);
  walker.Walk(true);
  EXPECT_LE(fast_walker.nodes, 2 * walker.nodes + 2);
  EXPECT_LE(fast_walker.leaves, 2 * walker.leaves + 2);
  return walker;
}

// Around the sizes at which leaves, nodes, subsets and the grid begin.
void PartitionsOfEverySize() {
  Random random(1);
  for (const size_t count : {1u,  2u,  3u,  4u,  5u,   8u,    11u,   12u,   13u,   14u,   24u,
                             25u, 33u, 96u, 97u, 500u, 2047u, 2048u, 2049u, 2100u, 5000u, 20000u}) {
    ExpectWholePartition({unit::MakeSoup(random, count, 1, 0.1f)}, std::to_string(count));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Few bytes a triangle hold it all: nodes are not stacked without need.
void TakesFewBytes() {
  Random random(2);
  constexpr size_t kTriangles = 50000;
  Kept kept({unit::MakeSoup(random, kTriangles, 1, 0.05f)}, kPlenty);
  Walker walker(kept);
  walker.Walk(true);
  // Four bytes of order, and the nodes.
  EXPECT_LT(kept.partition.BytesUsed(), 10 * kTriangles);
  EXPECT_GT(walker.subsets, kTriangles / SubsetScratch::kTriangles);
  EXPECT_LT(walker.leaves, kTriangles / 3);
  EXPECT_GT(walker.children, 3 * walker.nodes);
  EXPECT_LT(walker.deepest, 16u);
}

void TrianglesThatCoincide() {
  Mesh same;
  same.vertices = {{1, -1, -1}, {1, 1, -1}, {1, 0, 1}};
  for (const size_t count : {13u, 5000u, 70000u}) {
    same.triangles.assign(count, {0, 1, 2});
    ExpectWholePartition({same}, "identical " + std::to_string(count));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Boxes around one point, of 100,000 sizes: the grid can only tell them apart by their order.
void TrianglesAroundOnePoint() {
  Mesh mesh;
  for (int i = 1; i <= 100000; ++i) {
    const float s = static_cast<float>(i);
    mesh.Add({-s, -s, -s}, {s, s, -s}, {0, 0, s});
  }
  const Counts counts = ExpectWholePartition({mesh}, "one centre");
  EXPECT_LT(counts.deepest, 40u);
}

// Points, lines, and centres that differ on one axis only, by next to nothing.
void DegenerateTriangles() {
  Random random(3);
  Mesh points, line, close;
  for (int i = 0; i < 6000; ++i) {
    const Float3 p = random.InCube(-1, 1);
    points.Add(p, p, p);
    const float x = static_cast<float>(i);
    line.Add({x, 0, 0}, {x + 1, 0, 0}, {x, 0, 0});
    const float y = 1 + static_cast<float>(i % 5) * 0x1p-23f;
    close.Add({0, y, 0}, {1, y, 0}, {0, y, 1});
  }
  ExpectWholePartition({points}, "points");
  ExpectWholePartition({line}, "a line");
  ExpectWholePartition({close}, "next to each other");
}

// Nearly all triangles in one cell of the first grid, and in one of the next.
void TeapotInAStadium() {
  Random random(4);
  for (const float size : {1e-3f, 1e-6f}) {
    Mesh stadium = unit::MakeSoup(random, 300, 1000, 100), teapot, spout;
    for (const auto& [mesh, count, extent] :
         {std::tuple<Mesh*, size_t, float>{&teapot, 15000, 1}, {&spout, 15000, size}}) {
      *mesh = unit::MakeSoup(random, count, extent, extent * 0.02f);
    }
    teapot.geometry_id = 1;
    spout.geometry_id = 2;
    ExpectWholePartition({stadium, teapot, spout}, "teapot");
    if (testing::Test::HasFatalFailure()) return;
  }
}

// From the least to the largest that can be hit, in a geometric series.
void ScalesOfAllKinds() {
  Mesh series;
  for (int i = 0; i < 20000; ++i) {
    const float s = std::exp2(static_cast<float>(i % 100) - 40 + static_cast<float>(i) * 1e-5f);
    if (s > 1e18f) continue;
    series.Add({s, -s, -s}, {s, s, -s}, {s, 0, s});
  }
  ExpectWholePartition({series}, "series");
  Random random(5);
  for (const float extent : {1e-25f, 1e-19f, 1e-6f, 1e6f, 1.7e18f}) {
    ExpectWholePartition({unit::MakeSoup(random, 5000, extent, extent * 0.01f)},
                         std::to_string(extent));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Those that no ray can hit are in no subset.
void InvalidTrianglesAreLeftOut() {
  Random random(6);
  Mesh first = unit::MakeSoup(random, 4000, 1, 0.1f), second = unit::MakeSoup(random, 900, 1, 0.1f);
  second.geometry_id = 7;
  size_t invalid = 0;
  for (size_t i = 0; i < 4000; i += 3, ++invalid) {
    switch (i % 4) {
      case 0:
        first.triangles[i][random.Below(3)] = 12000;
        break;
      case 1:
        first.vertices[3 * i + random.Below(3)][random.Below(3)] = unit::kNaN;
        break;
      case 2:
        first.vertices[3 * i + random.Below(3)][random.Below(3)] = -unit::kInfinity;
        break;
      default:
        first.vertices[3 * i + random.Below(3)][random.Below(3)] = 2e18f;
    }
  }
  Kept kept({first, second}, kPlenty);
  EXPECT_EQ(kept.partition.triangle_count(), 4900 - invalid);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(kept.partition.bounds().lower[axis], -1.2f);
    EXPECT_LT(kept.partition.bounds().upper[axis], 1.2f);
  }
  Walker(kept).Walk(true);
}

// With any budget every subset finds room for nodes over leaves that are as large as it takes;
// where others took it those that find none stay whole. What is used is within the budget.
//
// With five bytes a triangle there were nodes for half of the subsets, and of the others every
// triangle was tested: rays took a hundred times as long as with eight.
void TheBudgetIsNeverExceeded() {
  Random random(7);
  constexpr size_t kTriangles = 12000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.05f);
  const size_t least = KeptPartition::LeastBytes(kTriangles);
  EXPECT_LT(least, 6 * kTriangles);
  size_t last_nodes = 0;
  for (const size_t budget :
       {size_t{0}, least - 1, least, least + 100, least + 3000, least + 5000, least + 8000,
        least + 12000, 6 * kTriangles, 7 * kTriangles, 16 * kTriangles}) {
    SCOPED_TRACE(budget);
    Kept kept({mesh}, budget);
    EXPECT_LE(kept.partition.BytesReserved(), std::max(least, budget));
    EXPECT_GT(kept.partition.BytesReserved() + KeptPartition::kLeafUnit, std::max(least, budget));
    Walker walker(kept);
    walker.Walk(false);
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_EQ(walker.without_room, 0u);
    EXPECT_GE(walker.nodes, last_nodes) << "more room, more nodes";
    last_nodes = walker.nodes;

    Kept narrow({mesh}, budget);
    uint32_t first_node, first_subset;
    while (narrow.partition.Allocate(25, 0, first_node, first_subset)) continue;
    Walker narrow_walker(narrow);
    narrow_walker.Walk(false);
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_GT(narrow_walker.without_room, 0u);
  }
}

// --- Room
// ------------------------------------------------------------------------------------------

/// Bytes that have an owner, by their addresses.
class Owned {
 public:
  /// False if somebody has one of them already.
  bool Take(const void* begin, size_t bytes) {
    const auto from = reinterpret_cast<uintptr_t>(begin);
    const auto next = ranges_.lower_bound(from);
    if (next != ranges_.end() && next->first < from + bytes) return false;
    if (next != ranges_.begin() && std::prev(next)->second > from) return false;
    ranges_.emplace(from, from + bytes);
    return true;
  }

 private:
  std::map<uintptr_t, uintptr_t> ranges_;
};

/// What one thread got.
struct Room {
  std::vector<std::pair<uint32_t, size_t>> nodes;
  std::vector<std::pair<uint32_t, size_t>> leaves;
};

/// Asks for nodes and leaves in turn, in no order, until there is neither.
void AskForRoom(KeptPartition& kept, uint64_t seed, uint32_t largest_leaf, Room& room) {
  Random random(seed);
  for (int refused = 0; refused < 200;) {
    if (random.Below(3) == 0) {
      const size_t count = 1 + random.Below(20);
      uint32_t first, first_subset;
      if (kept.Allocate(count, 0, first, first_subset)) {
        room.nodes.emplace_back(first, count);
        continue;
      }
    } else if (kept.HasLeafRoom()) {
      const size_t bytes = 1 + random.Below(largest_leaf);
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
void NodesAndLeavesNeverMeet() {
  Random random(31);
  const Mesh mesh = unit::MakeSoup(random, 3000, 1, 0.05f);
  const size_t least = KeptPartition::LeastBytes(3000);
  for (const size_t threads : {1u, 4u}) {
    for (const size_t budget : {least, least + 1, least + 20000, 8 * mesh.triangles.size(),
                                32 * mesh.triangles.size(), 100 * mesh.triangles.size()}) {
      for (const uint32_t largest_leaf : {16u, 300u, static_cast<uint32_t>(kMostLeafBytes)}) {
        SCOPED_TRACE(std::to_string(budget) + " bytes, " + std::to_string(threads) + " threads");
        Kept owner({mesh}, budget);
        KeptPartition& kept = owner.partition;
        const bool had_leaf_room = kept.HasLeafRoom();
        std::vector<Room> rooms(threads);
        {
          std::vector<std::thread> running;
          for (size_t t = 0; t < threads; ++t) {
            running.emplace_back([&, t] { AskForRoom(kept, t, largest_leaf, rooms[t]); });
          }
          for (std::thread& thread : running) thread.join();
        }
        const std::byte* const begin = kept.view().leaves;
        const std::byte* const end = begin + kept.BytesReserved();
        Owned owned;
        ASSERT_TRUE(owned.Take(kept.triangles().data(), kept.triangles().size_bytes()));
        ASSERT_TRUE(owned.Take(&kept.subset(0), sizeof(Subset)));
        size_t node_bytes = 0, leaf_bytes = 0;
        for (const Room& room : rooms) {
          for (const auto& [first, count] : room.nodes) {
            const std::byte* const node = reinterpret_cast<const std::byte*>(&kept.node(first));
            ASSERT_EQ(reinterpret_cast<uintptr_t>(node) % 64, 0u);
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

/// Where leaves take all that they may, a whole partition still has its nodes.
void ExpectRoomForNodes(bool is_short_lived) {
  Random random(32);
  constexpr size_t kTriangles = 30000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.03f);
  Kept kept({mesh}, 32 * kTriangles);
  if (is_short_lived) kept.partition.SetShortLived();
  uint32_t place;
  size_t leaves = 0;
  while (kept.partition.AllocateLeaf(100, place)) ++leaves;
  EXPECT_GT(100 * leaves, 15 * kTriangles);
  Walker(kept).Walk(true);
}
void LeavesLeaveRoomForNodes() { ExpectRoomForNodes(false); }
void LeavesLeaveRoomForNodesThatAreMadeFast() { ExpectRoomForNodes(true); }

// Without room for a leaf the order still says what is in it.
void SmallBudgetsHaveNoLeaves() {
  Random random(33);
  const Mesh mesh = unit::MakeSoup(random, 12000, 1, 0.05f);
  Kept least({mesh}, 0), eight({mesh}, 8 * 12000), plenty({mesh}, 32 * 12000);
  EXPECT_FALSE(least.partition.HasLeafRoom());
  EXPECT_TRUE(plenty.partition.HasLeafRoom());
  uint32_t place;
  EXPECT_FALSE(least.partition.AllocateLeaf(16, place));
  EXPECT_TRUE(plenty.partition.AllocateLeaf(16, place));
}

// Quads and cells fill two lanes, so that a leaf holds fewer of them; triangles beside them one.
void ItemsOfTwoLanes() {
  Random random(34);
  Mesh mesh = unit::MakeSoup(random, 4000, 1, 0.05f);
  std::vector<uint32_t> quads;
  for (uint32_t i = 0; i < 3000; ++i) {
    for (const uint32_t corner : {0u, 1u, 2u, 4u}) quads.push_back(3 * i + corner);
  }
  for (const size_t triangles : {size_t{0}, size_t{1}, size_t{37}, mesh.triangles.size()}) {
    std::vector<Geometry> geometries(2);
    for (Geometry& geometry : geometries) {
      geometry.vertices = {{mesh.vertices.data(), sizeof(Float3)}};
      geometry.vertex_count = mesh.vertices.size();
    }
    geometries[0].shape = Shape::kQuads;
    geometries[0].primitives = {quads.data(), 4 * sizeof(uint32_t)};
    geometries[0].primitive_count = quads.size() / 4;
    geometries[1].geometry_id = 1;
    geometries[1].primitives = {mesh.triangles.data(), 12};
    geometries[1].primitive_count = triangles;
    Kept kept(geometries, kPlenty);
    EXPECT_FALSE(kept.table().all_fill_one_lane());
    Walker walker(kept);
    walker.Walk(true);
    EXPECT_GE(walker.leaves, 3000u / 4);
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Threads that split a large subset together leave the triangles in the order in which one does.
void ThreadsTogetherSplitAsOneDoes() {
  Random random(9);
  const Mesh mesh = unit::MakeSoup(random, 100000, 1, 0.01f);
  Kept by_one({mesh}, kPlenty), by_all({mesh}, kPlenty);
  TaskPool tasks(0);
  const uint32_t root = by_one.Root(0);
  ASSERT_EQ(RootOf(by_all.partition, 0, by_all.scratch.get(), &tasks, [] {}), root);
  const auto one = by_one.partition.triangles(), all = by_all.partition.triangles();
  EXPECT_TRUE(std::equal(one.begin(), one.end(), all.begin(), all.end()));
  EXPECT_EQ(by_all.partition.BytesUsed(), by_one.partition.BytesUsed());
  for (uint32_t node = root; node < root + by_one.partition.subset(0).node_count; ++node) {
    const WideNode &a = by_one.partition.node(node), &b = by_all.partition.node(node);
    ASSERT_EQ(memcmp(&a, &b, sizeof(WideNode)), 0) << node;
  }
  Walker(by_all).Walk(true);
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
    EXPECT_TRUE(Subset::IsNode(partition.subset(subsets[i]).root));
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
                *RootOf(kept.partition, subsets[i], scratch.get(), nullptr, [] {});
            roots[t].push_back(root);
            if (root == Subset::kNoRoom) continue;
            std::vector<uint32_t> open = {root};
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
  const auto root = RootOf(kept.partition, 0, nullptr, nullptr, [&] {
    called = true;
    EXPECT_EQ(kept.partition.subset(0).root.load(), Subset::kBeingSplit);
  });
  EXPECT_FALSE(root.has_value());
  EXPECT_TRUE(called);
  EXPECT_EQ(kept.partition.subset(0).root.load(), Subset::kUnsplit);
  EXPECT_THROW(RootOf(kept.partition, 0, nullptr, nullptr, [] { throw std::bad_alloc(); }),
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
      RootOf(kept.partition, 0, nullptr, nullptr, [] { FAIL() << "a large one needs none"; });
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
  Grid grid(kTriangles, 1, nullptr);
  for (size_t i = 0; i < kTriangles; ++i) {
    grid.triangles[i] = triangles[i];
    grid.cell_of[i] = static_cast<uint16_t>(i % 2);
  }
  const auto move = [&](bool fails) {
    grid.place[0] = kTriangles / 2;
    grid.place[1] = 0;
    MoveAll(triangles, grid, [&](const auto& body) {
      body(GridPart{0, 0, 3000});
      if (fails) throw std::bad_alloc();
      body(GridPart{0, 3000, kTriangles});
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

HWY_BEFORE_TEST(KeptPartitionTest);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, PartitionsOfEverySize);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TakesFewBytes);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TrianglesThatCoincide);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TrianglesAroundOnePoint);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, DegenerateTriangles);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TeapotInAStadium);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, ScalesOfAllKinds);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, InvalidTrianglesAreLeftOut);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TheBudgetIsNeverExceeded);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, ThreadsTogetherSplitAsOneDoes);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, WhoWouldWaitSplitsANeighbour);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, ThreadsAgree);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, SplitsWhereAsked);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, NodesAndLeavesNeverMeet);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, LeavesLeaveRoomForNodes);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, LeavesLeaveRoomForNodesThatAreMadeFast);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, SmallBudgetsHaveNoLeaves);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, ItemsOfTwoLanes);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, WithoutScratchTheSubsetStays);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, LargeSubsetsAreSplitWhereThereIsNoMemoryForAGrid);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, IfOnePartCannotBeMovedNoneIs);

}  // namespace dacrt
#endif  // HWY_ONCE

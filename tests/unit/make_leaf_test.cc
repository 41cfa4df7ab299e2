// From names to the blocks of a leaf.

#include "leaf/make_leaf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <tuple>
#include <string>
#include <vector>

#include "all_shapes.h"
#include "leaf/instance_leaf.h"
#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::AllShapes;
using unit::Float3;
using unit::kShapes;
using unit::Random;

/// A leaf in memory that ends at a page that may not be touched.
class Leaf {
 public:
  Leaf(const GeometryTable& table, const std::vector<GeometryTable::Name>& names,
       uint32_t first = 0, SharedVertices shared = SharedVertices::kFind)
      : memory_(kMostLeafBytes, 64) {
    std::memset(memory_.data(), 0xA5, kMostLeafBytes);
    order.assign(first, 0);
    for (const GeometryTable::Name& name : names) {
      order.push_back(table.Number(name.geometry, name.primitive));
    }
    order.back() |= KeptOrder::kLastOfLeaf;
    const LeafItems items = FindItems(table, order.data(), first, kLeafLanes);
    bytes = MakeLeaf(table, items, first, shared, memory_.data()).bytes;
  }

  std::vector<const LeafBlock*> Blocks() const {
    std::vector<const LeafBlock*> blocks;
    const auto* block = reinterpret_cast<const LeafBlock*>(memory_.data());
    for (;; block = block->Next()) {
      blocks.push_back(block);
      if (block->is_last) return blocks;
      if (blocks.size() > kLeafLanes) return blocks;
    }
  }

  std::size_t EndOfBlocks() const {
    return static_cast<std::size_t>(reinterpret_cast<const std::byte*>(Blocks().back()->Next()) -
                                    memory_.data());
  }

  std::vector<uint32_t> order;
  std::size_t bytes;

 private:
  unit::GuardedArray<std::byte> memory_;
};

/// Corner `corner` of a lane, as the leaf test reads it.
Float3 CornerOf(const LeafBlock& block, std::size_t lane, std::size_t corner,
                uint32_t step = 0) {
  const uint8_t index = block.indices()[corner * kLeafLanes + lane];
  EXPECT_LT(index, block.vertices);
  Float3 v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    v[axis] = block.vertex_data()[(3 * step + axis) * block.vertices + index];
  }
  return v;
}

bool SameVertex(const Float3& v, const float* expected) {
  return std::memcmp(v.data(), expected, sizeof(v)) == 0;
}

LeafKind KindOf(Shape shape) {
  switch (shape) {
    case Shape::kSpheres:
      return LeafKind::kSpheres;
    case Shape::kDiscs:
      return LeafKind::kDiscs;
    case Shape::kOrientedDiscs:
      return LeafKind::kOrientedDiscs;
    case Shape::kUser:
      return LeafKind::kUser;
    case Shape::kInstance:
      return LeafKind::kInstances;
    default:
      return LeafKind::kFacets;
  }
}

/// The corners of a facet's first or second triangle.
void ExpectTriangle(const GeometryTable& table, const GeometryTable::Name& name, bool second,
                    const LeafBlock& block, std::size_t lane, uint32_t step) {
  Facet facet;
  ASSERT_TRUE(table.shapes().ReadFacet(name.geometry, name.primitive, step, facet));
  constexpr int kTriangle[3] = {0, 1, 2}, kFirst[3] = {0, 1, 3}, kSecond[3] = {2, 3, 1};
  const bool is_triangle = table.shapes()[name.geometry].shape == Shape::kTriangles;
  const int* const corners = is_triangle ? kTriangle : second ? kSecond : kFirst;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    EXPECT_TRUE(SameVertex(CornerOf(block, lane, corner, step), facet.corner[corners[corner]]))
        << "lane " << lane << " corner " << corner;
  }
}

/// Every item of the leaf stands in the block of its kind, and each block says what it holds.
void ExpectLeaf(const GeometryTable& table, const std::vector<GeometryTable::Name>& names,
                const Leaf& leaf, uint32_t first) {
  ASSERT_EQ(leaf.bytes, leaf.EndOfBlocks());
  ASSERT_LE(leaf.bytes + KeptPartition::kReadBehind, kMostLeafBytes);
  std::multiset<uint32_t> places;
  std::set<std::tuple<LeafKind, bool, uint32_t>> kinds;
  for (const LeafBlock* block : leaf.Blocks()) {
    ASSERT_EQ(block->first, first);
    ASSERT_GE(block->lanes, 1u);
    ASSERT_LE(block->lanes, kLeafLanes);
    // Facets between time steps are apart by geometry.
    const uint32_t apart = block->kind == LeafKind::kMovingFacets ? block->geometry : 0;
    ASSERT_TRUE(kinds.emplace(block->kind, block->is_timed, apart).second)
        << "two blocks of a kind";
    std::set<uint32_t> geometries_of_block;
    for (std::size_t lane = 0; lane < block->lanes; ++lane) {
      const uint32_t place = block->PlaceOf(lane) - first;
      ASSERT_LT(place, names.size());
      const GeometryTable::Name name = names[place];
      const Shape shape = table.shapes()[name.geometry].shape;
      geometries_of_block.insert(name.geometry);
      const uint32_t steps = table.shapes().StepCount(name.geometry);
      const bool carries_steps =
          KindOf(shape) == LeafKind::kFacets && steps > 1 && steps <= kMostLeafSteps;
      ASSERT_EQ(block->kind, carries_steps ? LeafKind::kMovingFacets : KindOf(shape));
      ASSERT_EQ(block->is_timed, steps > 1 && !carries_steps);
      const bool second = block->second >> lane & 1;
      if (!second) places.insert(place);
      if (block->is_timed) continue;
      if (block->kind == LeafKind::kFacets || carries_steps) {
        for (uint32_t step = 0; step < steps; ++step) {
          ExpectTriangle(table, name, second, *block, lane, step);
        }
        continue;
      }
      if (shape == Shape::kUser || shape == Shape::kInstance) {
        const Box& bounds = table.shapes().StillBounds(name.geometry, name.primitive);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          ASSERT_EQ(block->bounds_data()[axis * block->lanes + lane], bounds.lower[axis]);
          ASSERT_EQ(block->bounds_data()[(3 + axis) * block->lanes + lane], bounds.upper[axis]);
        }
        if (shape != Shape::kInstance) continue;
        ASSERT_EQ(block->lanes, 1);
        InstanceLeaf instance;  // the block may stand anywhere here
        std::memcpy(static_cast<void*>(&instance), block->bounds_data(), sizeof(instance));
        EXPECT_EQ(instance.scene, table.shapes().InstancedScene(name.geometry));
        const AffineTransform& to_instance = table.shapes().ToStillInstance(name.geometry);
        EXPECT_EQ(std::memcmp(&instance.to_instance, &to_instance, sizeof(to_instance)), 0);
        continue;
      }
      Point point;
      table.shapes().ReadPoint(name.geometry, name.primitive, Moment{}, point);
      const float* const data = block->point_data();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(data[axis * block->lanes + lane], point.center[axis]);
      }
      ASSERT_EQ(data[3 * block->lanes + lane], point.radius);
      if (block->kind != LeafKind::kOrientedDiscs) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(data[(4 + axis) * block->lanes + lane], point.normal[axis]);
      }
    }
    if (geometries_of_block.size() == 1) {
      EXPECT_EQ(block->geometry, *geometries_of_block.begin());
    } else {
      EXPECT_EQ(block->geometry, LeafBlock::kSeveral);
    }
  }
  // Each item once.
  ASSERT_EQ(places.size(), names.size());
  for (uint32_t place = 0; place < names.size(); ++place) ASSERT_EQ(places.count(place), 1u);
}

TEST(MakeLeafTest, EachShapeAlone) {
  const AllShapes all(1);
  for (const Shape shape : kShapes) {
    for (const bool moves : {false, true}) {
      const GeometryTable table = all.Table({all.Make(shape, 0, moves)});
      const std::size_t most = shape == Shape::kInstance ? 1 : kLeafLanes / table.LanesOf(0);
      for (std::size_t count = 1; count <= most; ++count) {
        for (const uint32_t first : {0u, 5u}) {
          SCOPED_TRACE("shape " + std::to_string(static_cast<int>(shape)) + ", " +
                       std::to_string(count) + (moves ? " that move" : ""));
          std::vector<GeometryTable::Name> names;
          for (uint32_t i = 0; i < count; ++i) names.push_back({0, (7 * i + 3) % 40});
          if (shape == Shape::kInstance) names = {{0, 0}};
          for (const SharedVertices shared : {SharedVertices::kFind, SharedVertices::kRepeat}) {
            const Leaf leaf(table, names, first, shared);
            ExpectLeaf(table, names, leaf, first);
            ASSERT_EQ(leaf.Blocks().size(), 1u);
            if (HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

// Up to as many time steps as leaves have copies of.
TEST(MakeLeafTest, FacetsOfManyTimeSteps) {
  const AllShapes all(6);
  for (const Shape shape : {Shape::kTriangles, Shape::kQuads, Shape::kGrids}) {
    for (uint32_t steps = 1; steps <= AllShapes::kMostSteps; ++steps) {
      SCOPED_TRACE(std::to_string(steps) + " steps");
      const GeometryTable table = all.Table({all.MakeInSteps(shape, 0, steps)});
      std::vector<GeometryTable::Name> names;
      for (uint32_t i = 0; i < kLeafLanes / table.LanesOf(0); ++i) names.push_back({0, 5 * i});
      for (const SharedVertices shared : {SharedVertices::kFind, SharedVertices::kRepeat}) {
        ExpectLeaf(table, names, Leaf(table, names, 0, shared), 0);
        if (HasFatalFailure()) return;
      }
    }
  }
}

// Whatever stands side by side, and in whatever order: a block for each kind.
TEST(MakeLeafTest, MixedLeavesOfEveryShape) {
  const AllShapes all(2);
  std::vector<Geometry> geometries;
  // Two of each, so that blocks hold several geometries, too.
  for (uint32_t i = 0; i < 2; ++i) {
    for (const Shape shape : kShapes) {
      for (const bool moves : {false, true}) {
        geometries.push_back(all.Make(shape, static_cast<uint32_t>(geometries.size()), moves));
      }
    }
  }
  const GeometryTable table = all.Table(geometries);
  Random random(3);
  std::size_t most_blocks = 0, most_bytes = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<GeometryTable::Name> names;
    std::set<std::pair<uint32_t, uint32_t>> taken;
    std::size_t lanes = 0;
    // Some rounds take from a few geometries only.
    const uint32_t some = 1 + random.Below(static_cast<uint32_t>(geometries.size()));
    const uint32_t begin = random.Below(static_cast<uint32_t>(geometries.size()));
    for (int tries = 0; tries < 20 && lanes < kLeafLanes; ++tries) {
      const uint32_t mesh = (begin + random.Below(some)) % geometries.size();
      const uint32_t item = random.Below(static_cast<uint32_t>(table[mesh].triangle_count));
      if (lanes + table.LanesOf(mesh) > kLeafLanes || !taken.emplace(mesh, item).second) continue;
      lanes += table.LanesOf(mesh);
      names.push_back({mesh, item});
    }
    const Leaf leaf(table, names, 0, round % 2 ? SharedVertices::kFind : SharedVertices::kRepeat);
    ExpectLeaf(table, names, leaf, 0);
    if (HasFatalFailure()) return;
    most_blocks = std::max(most_blocks, leaf.Blocks().size());
    most_bytes = std::max(most_bytes, leaf.bytes);
  }
  EXPECT_GE(most_blocks, 6u);
  EXPECT_GT(most_bytes, 300u);
}

// The largest leaves that there are, with what whole vectors read behind them.
TEST(MakeLeafTest, TheWorstMixesFit) {
  const AllShapes all(4);
  std::vector<Geometry> geometries;
  for (const Shape shape : kShapes) {
    for (const bool moves : {false, true}) {
      geometries.push_back(all.Make(shape, static_cast<uint32_t>(geometries.size()), moves));
    }
  }
  const GeometryTable table = all.Table(geometries);
  std::size_t largest = 0;
  // Every number of triangles, and of each kind of points, in eight lanes; the rest is some that
  // move, a block each.
  for (uint32_t triangles = 0; triangles <= 8; ++triangles) {
    for (uint32_t oriented = 0; triangles + oriented <= 8; ++oriented) {
      for (uint32_t spheres = 0; triangles + oriented + spheres <= 8; ++spheres) {
        for (uint32_t discs = 0; triangles + oriented + spheres + discs <= 8; ++discs) {
          std::vector<GeometryTable::Name> names;
          const auto add = [&](uint32_t mesh, uint32_t count) {
            for (uint32_t i = 0; i < count; ++i) names.push_back({mesh, i});
          };
          add(0, triangles);
          add(10, oriented);
          add(6, spheres);
          add(8, discs);
          for (const uint32_t mesh : {11u, 7u, 9u, 1u}) {
            if (names.size() < 8) add(mesh, 1);
          }
          for (const SharedVertices shared : {SharedVertices::kFind, SharedVertices::kRepeat}) {
            const Leaf leaf(table, names, 0, shared);
            ASSERT_LE(leaf.bytes + KeptPartition::kReadBehind, kMostLeafBytes);
            ExpectLeaf(table, names, leaf, 0);
            if (HasFatalFailure()) return;
            largest = std::max(largest, leaf.bytes);
          }
        }
      }
    }
  }
  EXPECT_GT(largest, 16u + 24u + 8 * 36u - 1);
  // Triangles that move, a block each.
  geometries.clear();
  std::vector<GeometryTable::Name> names;
  for (uint32_t i = 0; i < kLeafLanes; ++i) {
    geometries.push_back(all.MakeInSteps(Shape::kTriangles, i, kMostLeafSteps));
    names.push_back({i, i});
  }
  const Leaf leaf(all.Table(geometries), names);
  EXPECT_EQ(leaf.Blocks().size(), kLeafLanes);
  EXPECT_LE(leaf.bytes + KeptPartition::kReadBehind, kMostLeafBytes);
  EXPECT_GT(leaf.bytes, kMostLeafBytes / 2);
}

/// A leaf of some triangles over given vertices.
LeafBlock BlockOf(const std::vector<Float3>& vertices,
                  const std::vector<std::array<uint32_t, 3>>& triangles,
                  std::vector<Float3>* corners = nullptr) {
  unit::Mesh mesh;
  mesh.vertices = vertices;
  mesh.triangles = triangles;
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});
  std::vector<GeometryTable::Name> names;
  for (uint32_t i = 0; i < triangles.size(); ++i) names.push_back({0, i});
  const Leaf leaf(table, names);
  const LeafBlock& block = *leaf.Blocks()[0];
  if (corners) {
    for (std::size_t lane = 0; lane < block.lanes; ++lane) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        corners->push_back(CornerOf(block, lane, corner));
      }
    }
  }
  return block;
}

// A vertex that several triangles share is kept once, whatever its index.
TEST(MakeLeafTest, VerticesThatAreTheSameAreKeptOnce) {
  const std::vector<Float3> strip = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0},
                                     {0, 1, 0}, {1, 0, 0}};
  EXPECT_EQ(BlockOf(strip, {{0, 1, 2}}).vertices, 3u);
  EXPECT_EQ(BlockOf(strip, {{0, 1, 2}, {2, 1, 3}}).vertices, 4u);
  EXPECT_EQ(BlockOf(strip, {{0, 1, 2}, {5, 6, 3}}).vertices, 4u) << "equal numbers";
  EXPECT_EQ(BlockOf(strip, {{0, 0, 0}}).vertices, 1u);
  std::vector<Float3> apart;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i < 8; ++i) {
    for (uint32_t k = 0; k < 3; ++k) apart.push_back({static_cast<float>(i), float(k), 0});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  EXPECT_EQ(BlockOf(apart, triangles).vertices, 24u);
}

// What whole vectors are loaded from: each corner of a lane in its place, and nothing in lanes
// without a triangle.
TEST(MakeLeafTest, RepeatedVerticesStandByLane) {
  const AllShapes all(5);
  for (const bool moves : {false, true}) {
    for (const Shape shape : {Shape::kTriangles, Shape::kQuads, Shape::kGrids}) {
      const GeometryTable table = all.Table({all.Make(shape, 0, moves)});
      for (std::size_t count = 1; count <= kLeafLanes / table.LanesOf(0); ++count) {
        std::vector<GeometryTable::Name> names;
        for (uint32_t i = 0; i < count; ++i) names.push_back({0, i});
        const Leaf leaf(table, names, 0, SharedVertices::kRepeat);
        const LeafBlock& block = *leaf.Blocks()[0];
        if (block.is_timed) continue;
        ASSERT_EQ(block.vertices, LeafBlock::kByLane);
        const uint32_t steps = moves ? 2 : 1;
        for (std::size_t corner = 0; corner < 3; ++corner) {
          for (std::size_t lane = 0; lane < kLeafLanes; ++lane) {
            const std::size_t place = corner * kLeafLanes + lane;
            if (lane < block.lanes) {
              ASSERT_EQ(block.indices()[place], place);
              continue;
            }
            for (uint32_t i = 0; i < 3 * steps; ++i) {
              ASSERT_EQ(block.vertex_data()[i * LeafBlock::kByLane + place], 0.0f);
            }
          }
        }
      }
    }
  }
}

// By bits, so that -0 stays -0, and what has the same key is still told apart.
TEST(MakeLeafTest, VerticesAreToldApartByTheirBits) {
  const std::vector<Float3> zeros = {{0, 0, 0},    {-0.0f, 0, 0}, {0, -0.0f, 0},
                                     {0, 0, -0.0f}, {-0.0f, -0.0f, -0.0f}, {0, 0, 0}};
  std::vector<Float3> corners;
  const LeafBlock block = BlockOf(zeros, {{0, 1, 2}, {3, 4, 5}}, &corners);
  EXPECT_EQ(block.vertices, 5u);
  for (std::size_t i = 0; i < zeros.size(); ++i) {
    EXPECT_TRUE(SameVertex(corners[i], zeros[i].data())) << i;
  }
  // Vertices whose keys, of 64 bits for 96, are equal: x ^ rot(z) with the bits moved between them.
  const auto from_bits = [](uint32_t x, uint32_t y, uint32_t z) {
    Float3 v;
    const uint32_t bits[3] = {x, y, z};
    std::memcpy(v.data(), bits, sizeof(bits));
    return v;
  };
  const Float3 plain = from_bits(0, 0, 0), same_key = from_bits(0, 1u << 17, 1);
  const Float3 other = from_bits(1, 0, 1u << 15);
  corners.clear();
  EXPECT_EQ(BlockOf({plain, same_key, other}, {{0, 1, 2}}, &corners).vertices, 3u);
  EXPECT_TRUE(SameVertex(corners[0], plain.data()));
  EXPECT_TRUE(SameVertex(corners[1], same_key.data()));
  EXPECT_TRUE(SameVertex(corners[2], other.data()));
}

// A program that changed its indices after the commit harms itself only.
TEST(MakeLeafTest, IndicesThatAreNoLongerLegalGiveTrianglesOfNoArea) {
  unit::Mesh mesh;
  mesh.Add({1, 2, 3}, {4, 5, 6}, {7, 8, 10});
  mesh.Add({1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  mesh.triangles[0][1] = 6;
  mesh.triangles.push_back({UINT32_MAX, 0, 1});
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});
  const Leaf leaf(table, {{0, 0}, {0, 1}, {0, 2}});
  const LeafBlock& block = *leaf.Blocks()[0];
  ASSERT_EQ(block.lanes, 3u);
  for (const std::size_t lane : {0u, 2u}) {
    const Float3 v = CornerOf(block, lane, 0);
    EXPECT_TRUE(SameVertex(CornerOf(block, lane, 1), v.data()));
    EXPECT_TRUE(SameVertex(CornerOf(block, lane, 2), v.data()));
  }
  for (std::size_t corner = 0; corner < 3; ++corner) {
    EXPECT_TRUE(SameVertex(CornerOf(block, 1, corner), mesh.Corner(1, int(corner)).data()));
  }
}

// Up to the mark, or up to so many where nothing is marked.
TEST(MakeLeafTest, EndsAtTheMarkOrAtTheMost) {
  Random random(5);
  const unit::Mesh mesh = unit::MakeSoup(random, 20, 1, 1);
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});
  std::vector<uint32_t> order(20);
  for (uint32_t i = 0; i < 20; ++i) order[i] = i;
  alignas(64) std::byte blocks[kMostLeafBytes];
  const auto lanes = [&](uint32_t first, std::size_t most) {
    const LeafItems items = FindItems(table, order.data(), first, most);
    MakeLeaf(table, items, first, SharedVertices::kRepeat, blocks);
    return std::size_t{reinterpret_cast<const LeafBlock*>(blocks)->lanes};
  };
  for (std::size_t most = 1; most <= kLeafLanes; ++most) EXPECT_EQ(lanes(2, most), most);
  order[5] |= KeptOrder::kLastOfLeaf;
  EXPECT_EQ(lanes(2, kLeafLanes), 4u);
  EXPECT_EQ(lanes(2, 3), 3u);
  EXPECT_EQ(lanes(5, kLeafLanes), 1u);
  EXPECT_EQ(lanes(6, kLeafLanes), kLeafLanes);
}

}  // namespace
}  // namespace dacrt

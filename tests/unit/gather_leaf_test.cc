// Leaves that are made for one visit, against MakeLeaf.

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "all_shapes.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gather_leaf_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "leaf/gather_leaf-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::AllShapes;
using unit::Float3;
using unit::GuardedArray;
using unit::Random;

/// Made by `leaves` in `gathered`.
void ExpectSameBlocks(const GeometryTable& table, const uint32_t* order, uint32_t first,
                      std::size_t most, LeafGather& leaves, std::byte* gathered) {
  const LeafItems items = FindItems(table, order, first, most);
  alignas(64) std::byte made[kMostLeafBytes];
  std::memset(gathered, 0xA5, kMostLeafBytes);
  std::memset(made, 0xA5, sizeof(made));
  const LeafGather::Gathered leaf = leaves.Gather(first, most, gathered);
  ASSERT_EQ(leaf.count, items.count);
  ASSERT_EQ(leaf.is_last, items.is_last);
  MakeLeaf(table, items, first, SharedVertices::kRepeat, made);
  ASSERT_EQ(std::memcmp(gathered, made, kMostLeafBytes), 0)
      << items.count << " items from " << first << " on";
}

/// Meshes whose last vertex ends where memory that may be read does. Of the second one some indices
/// are no longer legal; all vertices of the third one stand in one place.
class GuardedMeshes {
 public:
  explicit GuardedMeshes(Random& random) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (float& value : vertices_[k]) value = random.Uniform(-9, 9);
      for (uint32_t& index : indices_[k]) index = random.Below(kVertices);
      indices_[k][0] = kVertices - 1;
    }
    indices_[1][1] = kVertices;
    indices_[1][6] = UINT32_MAX;
  }

  GeometryTable Table() const {
    std::vector<TriangleMesh> views;
    for (uint32_t k = 0; k < 3; ++k) {
      views.push_back({vertices_[k].data(), k == 2 ? 0 : sizeof(Float3), kVertices,
                       indices_[k].data(), 3 * sizeof(uint32_t), kTriangles, k, UINT32_MAX});
    }
    return GeometryTable(views);
  }

 private:
  static constexpr uint32_t kVertices = 6, kTriangles = 10;

  GuardedArray<float> vertices_[3] = {GuardedArray<float>(3 * kVertices),
                                      GuardedArray<float>(3 * kVertices), GuardedArray<float>(3)};
  GuardedArray<uint32_t> indices_[3] = {GuardedArray<uint32_t>(3 * kTriangles),
                                        GuardedArray<uint32_t>(3 * kTriangles),
                                        GuardedArray<uint32_t>(3 * kTriangles)};
};

void TrianglesOfSeveralMeshes() {
  Random random(1);
  const GuardedMeshes meshes(random);
  const GeometryTable table = meshes.Table();
  alignas(64) std::byte gathered[kMostLeafBytes];
  for (int i = 0; i < 2000; ++i) {
    std::vector<uint32_t> order(20);
    for (uint32_t& entry : order) entry = random.Below(30);
    const uint32_t first = random.Below(10), most = 1 + random.Below(kLeafLanes);
    const LeafItems items = FindItems(table, order.data(), first, most);
    ASSERT_EQ(items.count, most);
    for (std::size_t k = 0; k < most; ++k) {
      const GeometryTable::Name name = table.Locate(order[first + k]);
      ASSERT_EQ(items.names[k].geometry, name.geometry);
      ASSERT_EQ(items.names[k].primitive, name.primitive);
    }
    LeafGather leaves(table, order.data());
    leaves.Fetch(first, most);
    ASSERT_NO_FATAL_FAILURE(ExpectSameBlocks(table, order.data(), first, most, leaves, gathered));
    // Those behind it, too, with what is at hand by then.
    ASSERT_NO_FATAL_FAILURE(
        ExpectSameBlocks(table, order.data(), first + 1, kLeafLanes, leaves, gathered));
  }
}

// What is not a still triangle is made by MakeLeaf, beside triangles too.
void ShapesOfAllKinds() {
  Random random(2);
  const AllShapes all(5);
  std::vector<Geometry> geometries;
  for (const Shape shape : unit::kShapes) {
    for (const bool moves : {false, true}) {
      geometries.push_back(all.Make(shape, static_cast<uint32_t>(geometries.size()), moves));
    }
  }
  const GeometryTable table = all.Table(geometries);
  const auto count = static_cast<uint32_t>(table.triangle_count());
  alignas(64) std::byte gathered[kMostLeafBytes];
  for (int i = 0; i < 2000; ++i) {
    std::vector<uint32_t> order(8);
    for (uint32_t& entry : order) entry = random.Below(count);
    order.back() |= KeptOrder::kLastOfLeaf;
    LeafGather leaves(table, order.data());
    for (uint32_t first = 0; first < 3; ++first) {
      ASSERT_NO_FATAL_FAILURE(
          ExpectSameBlocks(table, order.data(), first, kLeafLanes, leaves, gathered));
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(GatherLeafTest);
HWY_EXPORT_AND_TEST_P(GatherLeafTest, TrianglesOfSeveralMeshes);
HWY_EXPORT_AND_TEST_P(GatherLeafTest, ShapesOfAllKinds);

}  // namespace dacrt
#endif  // HWY_ONCE

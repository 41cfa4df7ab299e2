// The way from the engine's hits to the caller's records. The way in is in load_rays_test.cc.

#include <gtest/gtest.h>

#include <memory>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "store_hits_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "paper/store_hits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BatchMemory;
using unit::Mesh;
using unit::Random;
using unit::Ray;

/// Records of which some are inactive and some of the others have been found to hit the triangle at
/// which they are aimed, just at t = 1.
class Piece {
 public:
  Piece(Random& random, size_t first, size_t count)
      : first_(first),
        mesh_(unit::MakeSoup(random, 50, 1, 1)),
        table_(Table(mesh_)),
        memory_(1024, count),
        triangles_(std::make_unique<TriangleBlock>()),
        aims_(count) {
    records = unit::MakeRays(random, first + count + 3, 2);
    for (size_t i = 0; i < count; ++i) {
      Ray& record = records[first + i];
      record.primitive_id = 1000;  // what a miss must leave alone
      if (random.Below(4) == 0) record.tfar = -1;
      Aim& aim = aims_[i];
      aim = {random.Below(50), random.Uniform(0.1f, 0.4f), random.Uniform(0.1f, 0.4f)};
      for (size_t axis = 0; axis < 3; ++axis) {
        const float v0 = mesh_.Corner(aim.triangle, 0)[axis];
        record.dir[axis] = v0 + aim.u * (mesh_.Corner(aim.triangle, 1)[axis] - v0) +
                           aim.v * (mesh_.Corner(aim.triangle, 2)[axis] - v0) - record.org[axis];
      }
    }
    block_ = LoadRays(ViewOf(records), first, count, Query::kClosest, table_, memory_.batch);
    for (size_t slot = 0; slot < block_.count; ++slot) {
      if (random.Below(3) == 0) continue;
      const uint32_t index = memory_.batch.index[slot];
      PaperHit& hit = memory_.batch.hits[index];
      hit.primitive = aims_[index].triangle;
      hit.geometry = random.Below(4) == 0 ? PaperHit::kAtLimit : 0;
      memory_.batch.tfar[slot] = 1;
      slots_.push_back(slot);
    }
    before = records;
  }

  size_t Store(const RayView& view) {
    return StoreClosest(view, first_, table_, memory_.batch, block_, *triangles_);
  }

  size_t Block(const RayView& view) {
    for (const size_t slot : slots_) memory_.batch.tfar[slot] = -unit::kInfinity;
    return StoreBlocked(view, first_, memory_.batch, block_);
  }

  /// The records as they must be, with the components of a hit that `view` has. What is computed is
  /// taken from the records themselves: see ExpectComputed.
  std::vector<Ray> Expected(const RayView& view) const {
    std::vector<Ray> expected = before;
    for (const size_t slot : slots_) {
      const uint32_t index = memory_.batch.index[slot];
      const Ray& record = records[first_ + index];
      Ray& ray = expected[first_ + index];
      ray.tfar = record.tfar;
      ray.ng = record.ng;
      if (view.u != RayView::kAbsent) ray.u = record.u;
      if (view.v != RayView::kAbsent) ray.v = record.v;
      if (view.primitive_id != RayView::kAbsent) ray.primitive_id = aims_[index].triangle;
      if (view.geometry_id != RayView::kAbsent) ray.geometry_id = kGeometry;
      if (view.instance_id != RayView::kAbsent) ray.instance_id = view.instance_value;
    }
    return expected;
  }

  /// t, u and v of the aim, and the normal (v2 - v0) x (v0 - v1) in double precision.
  void ExpectComputed() const {
    for (const size_t slot : slots_) {
      const uint32_t index = memory_.batch.index[slot];
      const Ray& ray = records[first_ + index];
      const Aim& aim = aims_[index];
      const unit::ExactHit exact =
          unit::IntersectExactly(before[first_ + index], mesh_, aim.triangle);
      double e1[3], e2[3], ng[3], length = 0, along = 0;
      for (size_t axis = 0; axis < 3; ++axis) {
        e1[axis] =
            double{mesh_.Corner(aim.triangle, 0)[axis]} - mesh_.Corner(aim.triangle, 1)[axis];
        e2[axis] =
            double{mesh_.Corner(aim.triangle, 2)[axis]} - mesh_.Corner(aim.triangle, 0)[axis];
      }
      for (size_t axis = 0; axis < 3; ++axis) {
        const size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
        ng[axis] = e2[b] * e1[c] - e2[c] * e1[b];
        ASSERT_NEAR(ray.ng[axis], ng[axis], 1e-6);
        length += ng[axis] * ng[axis];
        along += ng[axis] * ray.dir[axis];
      }
      // Grazing rays have distances that single precision can not tell.
      if (std::abs(along) < 0.1 * std::sqrt(length)) continue;
      ASSERT_NEAR(ray.tfar, exact.t, 1e-4);
      ASSERT_NEAR(ray.u, exact.u, 1e-3);
      ASSERT_NEAR(ray.v, exact.v, 1e-3);
    }
  }

  size_t hits() const { return slots_.size(); }

  std::vector<Ray> records;
  std::vector<Ray> before;

 private:
  static constexpr uint32_t kGeometry = 77;

  struct Aim {
    uint32_t triangle;
    float u, v;
  };

  static GeometryTable Table(const Mesh& mesh) {
    TriangleMesh view = mesh.View();
    view.geometry_id = kGeometry;
    return GeometryTable({&view, 1});
  }

  size_t first_;
  Mesh mesh_;
  GeometryTable table_;
  BatchMemory memory_;
  std::unique_ptr<TriangleBlock> triangles_;
  std::vector<Aim> aims_;
  RayBlock block_{};
  std::vector<size_t> slots_;
};

void ExpectSameRecords(const std::vector<Ray>& actual, const std::vector<Ray>& expected) {
  for (size_t i = 0; i < actual.size(); ++i) {
    ASSERT_TRUE(SameBits(actual[i], expected[i])) << "record " << i;
  }
}

void WritesHitsAndNothingElse() {
  Random random(1);
  for (const size_t count : {1u, 2u, 16u, 63u, 64u, 65u, 300u}) {
    for (const size_t first : {0u, 5u}) {
      Piece piece(random, first, count);
      RayView view = ViewOf(piece.records);
      view.instance_value = 42;
      ASSERT_EQ(piece.Store(view), piece.hits());
      piece.ExpectComputed();
      ExpectSameRecords(piece.records, piece.Expected(view));
    }
  }
}

// A record without the component in question keeps all its bytes there.
void AbsentComponentsAreNotWritten() {
  Random random(2);
  for (RayView::Component RayView::*component : {&RayView::u, &RayView::v, &RayView::primitive_id,
                                                 &RayView::geometry_id, &RayView::instance_id}) {
    Piece piece(random, 0, 100);
    RayView view = ViewOf(piece.records);
    view.*component = RayView::kAbsent;
    piece.Store(view);
    ExpectSameRecords(piece.records, piece.Expected(view));
  }
  Piece piece(random, 0, 100);
  RayView view = ViewOf(piece.records);
  view.ng_x = view.ng_y = view.ng_z = RayView::kAbsent;
  piece.Store(view);
  for (size_t i = 0; i < piece.records.size(); ++i) {
    ASSERT_EQ(piece.records[i].ng, piece.before[i].ng);
  }
}

void BlockedRaysGetMinusInfinityAndNothingElse() {
  Random random(3);
  for (const size_t count : {1u, 17u, 100u}) {
    Piece piece(random, 2, count);
    ASSERT_EQ(piece.Block(ViewOf(piece.records)), piece.hits());
    size_t blocked = 0;
    for (size_t i = 0; i < piece.records.size(); ++i) {
      Ray expected = piece.before[i];
      if (piece.records[i].tfar == -unit::kInfinity) {
        expected.tfar = -unit::kInfinity;
        ++blocked;
      }
      ASSERT_TRUE(SameBits(piece.records[i], expected));
    }
    ASSERT_EQ(blocked, piece.hits());
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(StoreHitsTest);
HWY_EXPORT_AND_TEST_P(StoreHitsTest, WritesHitsAndNothingElse);
HWY_EXPORT_AND_TEST_P(StoreHitsTest, AbsentComponentsAreNotWritten);
HWY_EXPORT_AND_TEST_P(StoreHitsTest, BlockedRaysGetMinusInfinityAndNothingElse);

}  // namespace dacrt
#endif  // HWY_ONCE

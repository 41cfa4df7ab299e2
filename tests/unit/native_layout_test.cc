// A program's own rays in any layout: ray_layout.h.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "native_scene.h"

namespace dacrt {
namespace {

class NativeLayoutTest : public NativeTest {};

/// As strange as it gets.
struct Beam {
  double power = 1;
  int surface = -1;
  Vector towards;
  float t;
  unsigned visible;
  std::array<float, 4> from;
  float ng[3];
  char name[3];
  float weights[2];
  float start;
  unsigned geometry;
};

Beam BeamOf(const RayHit& ray) {
  Beam beam{};
  beam.surface = static_cast<int>(ray.hit.primitive_id);
  beam.towards = {ray.ray.dir[0], ray.ray.dir[1], ray.ray.dir[2]};
  beam.t = ray.ray.tfar;
  beam.visible = ray.ray.mask;
  beam.from = {ray.ray.org[0], ray.ray.org[1], ray.ray.org[2], -7};
  std::ranges::copy(ray.hit.ng, beam.ng);
  beam.start = ray.ray.tnear;
  beam.geometry = ray.hit.geometry_id;
  return beam;
}

void ExpectBeam(const Beam& beam, const RayHit& ray) {
  Beam expected = BeamOf(ray);
  EXPECT_EQ(beam.t, expected.t);
  EXPECT_EQ(beam.surface, expected.surface);
  EXPECT_EQ(beam.geometry, expected.geometry);
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(beam.ng[axis], expected.ng[axis]);
  EXPECT_EQ(beam.from, expected.from);
  EXPECT_EQ(beam.power, 1);
}

template <class Builder>
RayView BeamView(Builder builder) {
  return builder.Origin(&Beam::from)
      .Direction(&Beam::towards)
      .Tnear(&Beam::start)
      .Tfar(&Beam::t)
      .Mask(&Beam::visible)
      .Normal(&Beam::ng)
      .PrimitiveId(&Beam::surface)
      .GeometryId(&Beam::geometry);
}

TEST_F(NativeLayoutTest, ArraysOfStructsAndPointersToThem) {
  std::vector<Beam> beams;
  for (const RayHit& ray : rays_) beams.push_back(BeamOf(ray));
  std::vector<Beam> others = beams;
  scene_->Trace(Query::kClosest, BeamView(RaysIn(beams)));
  std::vector<Beam*> pointers;
  for (std::size_t i = others.size(); i-- > 0;) pointers.push_back(&others[i]);
  scene_->Trace(Query::kClosest, BeamView(RaysIn(pointers)));
  for (std::size_t i = 0; i < beams.size(); ++i) {
    ExpectBeam(beams[i], found_[i]);
    ExpectBeam(others[i], found_[i]);
  }
  std::vector<Beam> none;
  EXPECT_NO_THROW(scene_->Trace(Query::kClosest, BeamView(RaysIn(none))));
  EXPECT_EQ(BeamView(RaysIn(std::span(beams).first(3))).count, 3u);
}

TEST_F(NativeLayoutTest, StructuresOfArrays) {
  std::vector<std::vector<float>> floats(9);
  std::vector<uint32_t> primitives(rays_.size(), Hit::kNone);
  for (const RayHit& ray : rays_) {
    for (int axis = 0; axis < 3; ++axis) {
      floats[axis].push_back(ray.ray.org[axis]);
      floats[3 + axis].push_back(ray.ray.dir[axis]);
    }
    floats[6].push_back(ray.ray.tfar);
    floats[7].push_back(0);
    floats[8].push_back(0);
  }
  const std::vector<std::vector<float>>& read = floats;  // what is read only may be const
  const float* none = nullptr;
  scene_->Trace(Query::kClosest, RaysInArrays(rays_.size())
                                     .Origin(read[0].data(), read[1].data(), read[2].data())
                                     .Direction(read[3].data(), read[4].data(), read[5].data())
                                     .Tnear(none)
                                     .Tfar(floats[6].data())
                                     .Uv(floats[7].data(), floats[8].data())
                                     .PrimitiveId(primitives.data()));
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    EXPECT_EQ(floats[6][i], found_[i].ray.tfar);
    EXPECT_EQ(floats[7][i], found_[i].hit.u);
    EXPECT_EQ(floats[8][i], found_[i].hit.v);
    EXPECT_EQ(primitives[i], found_[i].hit.primitive_id);
  }
}

// A matrix with a row for each ray, as Python's libraries have them.
TEST_F(NativeLayoutTest, RowsOfAMatrix) {
  constexpr std::size_t kColumns = 7;
  std::vector<float> rows;
  for (const RayHit& ray : rays_) {
    rows.insert(rows.end(), std::begin(ray.ray.org), std::end(ray.ray.org));
    rows.insert(rows.end(), std::begin(ray.ray.dir), std::end(ray.ray.dir));
    rows.push_back(ray.ray.tfar);
  }
  scene_->Trace(Query::kClosest, RaysInArrays(rays_.size(), kColumns * sizeof(float))
                                     .Origin(rows.data())
                                     .Direction(rows.data() + 3)
                                     .Tfar(rows.data() + 6));
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    EXPECT_EQ(rows[i * kColumns + 6], found_[i].ray.tfar);
  }
}

struct Eight {
  float x[8], y[8], z[8];
  float t[8];
  float dx[8], dy[8], dz[8];
  unsigned primitive[8];
  double unused[8];
};

TEST_F(NativeLayoutTest, InterleavedPackets) {
  std::vector<Eight> packets((rays_.size() + 7) / 8);
  std::memset(packets.data(), 0xFF, packets.size() * sizeof(Eight));  // not numbers where no ray is
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    Eight& packet = packets[i / 8];
    const Ray& ray = rays_[i].ray;
    packet.x[i % 8] = ray.org[0];
    packet.y[i % 8] = ray.org[1];
    packet.z[i % 8] = ray.org[2];
    packet.dx[i % 8] = ray.dir[0];
    packet.dy[i % 8] = ray.dir[1];
    packet.dz[i % 8] = ray.dir[2];
    packet.t[i % 8] = ray.tfar;
  }
  const RayView view = RaysIn(packets)
                           .Origin(&Eight::x, &Eight::y, &Eight::z)
                           .Direction(&Eight::dx, &Eight::dy, &Eight::dz)
                           .Tfar(&Eight::t)
                           .PrimitiveId(&Eight::primitive)
                           .Count(rays_.size());
  EXPECT_EQ(view.lanes, 8u);
  EXPECT_EQ(RayView(RaysIn(packets).Tfar(&Eight::t)).count, packets.size() * 8);
  const Statistics statistics = scene_->Trace(Query::kClosest, view);
  EXPECT_EQ(statistics.rays, rays_.size());
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    EXPECT_EQ(packets[i / 8].t[i % 8], found_[i].ray.tfar);
    EXPECT_EQ(packets[i / 8].primitive[i % 8], found_[i].hit.primitive_id);
  }
}

TEST_F(NativeLayoutTest, PacketsOfDifferentWidthsAreRefused) {
  struct Uneven {
    float x[8], y[8], z[8], t[4];
  };
  std::vector<Uneven> packets(1);
  EXPECT_THROW(RaysIn(packets).Origin(&Uneven::x, &Uneven::y, &Uneven::z).Tfar(&Uneven::t), Error);
}

}  // namespace
}  // namespace dacrt

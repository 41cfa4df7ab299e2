#include "lidar/street.h"

#include "scenes/mesh_builder.h"

namespace lidar {
namespace {

using Imath::V3d;
using scenes::Frame;
using scenes::MeshBuilder;
using scenes::Random;

constexpr double kKerb = 5, kHouseFront = 9;  // metres from the middle of the street
constexpr double kDetail = 1;

void AddHouse(MeshBuilder& build, Random& random, double begin, double end, double side) {
  const double height = random.Between(7, 16), depth = random.Between(8, 12);
  // z away from the street.
  const Frame house{{begin, 0, side * kHouseFront}, {1, 0, 0}, {0, 1, 0}, {0, 0, side}};
  const double width = end - begin;
  build.Box(house, {0, 0, 0}, {width, height, depth});
  // A roof of two slopes, whose ridge runs along the street.
  const double ridge = height + random.Between(2, 4);
  build.Quad(house, {0, height, -0.4}, {width, height, -0.4}, {width, ridge, depth / 2},
             {0, ridge, depth / 2});
  build.Quad(house, {0, ridge, depth / 2}, {width, ridge, depth / 2}, {width, height, depth + 0.4},
             {0, height, depth + 0.4});
  // Window sills and frames, which stand out from the front.
  for (double y = 1.2; y + 2 < height; y += 3) {
    for (double x = 1; x + 2 < width; x += 2.6) {
      build.Box(house, {x, y, -0.15}, {x + 1.4, y + 0.1, 0});
      build.Box(house, {x, y + 1.6, -0.1}, {x + 1.4, y + 1.7, 0});
      build.Box(house, {x, y, -0.1}, {x + 0.08, y + 1.7, 0});
      build.Box(house, {x + 1.32, y, -0.1}, {x + 1.4, y + 1.7, 0});
    }
  }
}

void AddTree(MeshBuilder& build, Random& random, double x, double z) {
  const double height = random.Between(2, 3);
  const Frame tree{{x, 0, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  build.Rod(tree, {0, 0, 0}, {0, height, 0}, 0.15, 8);
  for (int leaf = 0; leaf < 150; ++leaf) {
    const V3d place(random.Between(-1, 1), random.Between(-1, 1), random.Between(-1, 1));
    if (place.length() > 1) continue;
    build.Ellipsoid(tree.At(place.x * 1.6, height + 1.5 + place.y * 1.6, place.z * 1.6)
                        .TurnedAboutX(random.Between(0, 1))
                        .TurnedAboutY(random.Between(0, 1)),
                    {0.35, 0.05, 0.25}, 6);
  }
}

void AddLamp(MeshBuilder& build, double x, double side) {
  const Frame lamp{{x, 0, side * (kKerb + 0.4)}, {1, 0, 0}, {0, 1, 0}, {0, 0, side}};
  build.Rod(lamp, {0, 0, 0}, {0, 6, 0}, 0.08, 8);
  build.Rod(lamp, {0, 6, 0}, {0, 6.3, -1.5}, 0.05, 6);
  build.Ellipsoid(lamp.At(0, 6.2, -1.6), {0.2, 0.15, 0.4}, 10);
}

}  // namespace

scenes::Mesh MakeStreet(uint32_t seed) {
  scenes::Mesh mesh;
  MeshBuilder build(kDetail, &mesh);
  Random random(seed);
  const Frame world;
  const double length = kStreetLength;
  build.Quad(world, {-20, 0, -30}, {length + 20, 0, -30}, {length + 20, 0, 30}, {-20, 0, 30});
  for (const double side : {-1.0, 1.0}) {
    const Frame pavement{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, side}};
    build.Box(pavement, {-20, 0, kKerb}, {length + 20, 0.15, kHouseFront});
    for (double x = -10; x < length + 10;) {
      const double end = x + random.Between(8, 15);
      AddHouse(build, random, x, end, side);
      x = end + (random.Between(0, 1) < 0.2 ? random.Between(2, 5) : 0);  // sometimes a gap
    }
    for (double x = 5; x < length; x += random.Between(9, 14)) {
      AddTree(build, random, x, side * (kKerb + 1.2));
    }
    for (double x = 12; x < length; x += 30) AddLamp(build, x, side);
  }
  return mesh;
}

scenes::Mesh MakeVan() {
  scenes::Mesh mesh;
  MeshBuilder build(kDetail, &mesh);
  const Frame van;
  build.Box(van, {-0.8, 0.4, -0.95}, {2.6, 2.3, 0.95});
  build.Box(van, {2.6, 0.4, -0.95}, {3.9, 1.2, 0.95});
  build.Quad(van, {3.4, 1.2, -0.9}, {3.4, 1.2, 0.9}, {2.6, 2.2, 0.9}, {2.6, 2.2, -0.9});
  for (const double x : {0.0, 3.0}) {
    for (const double z : {-0.9, 0.9}) build.Ellipsoid(van.At(x, 0.35, z), {0.35, 0.35, 0.12}, 20);
  }
  return mesh;
}

void Place(const scenes::Mesh& model, const Imath::V3f& at, scenes::Mesh* mesh) {
  for (size_t i = 0; i < model.positions.size(); ++i) {
    mesh->positions[i] = model.positions[i] + at[int(i % 3)];
  }
}

}  // namespace lidar

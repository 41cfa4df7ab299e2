// The native API, from two arrays to hits, shadows, and a shape that only the program knows.
// Copy this file to begin with: it needs libdacrt and nothing else.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <vector>

#include "dacrt/callback_of.h"
#include "dacrt/dacrt.h"

namespace {

// A square on the ground, and a tent over a part of it.
const std::vector<float> kVertices = {-4, 0, -4, 4, 0, -4, 4, 0, 4, -4, 0, 4,  // the ground
                                      -1, 0, -1, 1, 0, -1, 0, 2, 0};           // the tent
const std::vector<uint32_t> kTriangles = {0, 1, 2, 0, 2, 3, 4, 5, 6};

enum GeometryId : uint32_t { kMesh, kBall };

// Where rays that fall straight down hit the mesh.
void FindHits(const dacrt::Scene& scene) {
  std::vector<dacrt::RayHit> rays;
  for (const float x : {-2.0f, 0.0f, 2.0f, 6.0f}) {
    rays.push_back({.ray = {.org = {x, 10, -0.5f}, .dir = {0, -1, 0}}, .hit = {}});
  }
  scene.ClosestHits(rays);
  for (const auto& [ray, hit] : rays) {
    if (hit) {
      std::printf("from x = %g down: triangle %u of geometry %u, %g below\n", ray.org[0],
                  hit.primitive_id, hit.geometry_id, ray.tfar);
    } else {
      std::printf("from x = %g down: nothing\n", ray.org[0]);
    }
  }
}

// What lies between points of the ground and a lamp. The program's rays have a layout of their own:
// the library is told where their parts are.
void FindShadows(const dacrt::Scene& scene) {
  struct LineOfSight {
    double brightness;
    float from[3], to_lamp[3];
    float reach = 1;  // in units of to_lamp: as far as the lamp
  };
  const float lamp[3] = {0, 3, 4};
  std::vector<LineOfSight> lines;
  for (const float x : {0.0f, 3.0f}) {
    lines.push_back({100, {x, 0.001f, -2}, {lamp[0] - x, lamp[1], lamp[2] + 2}});
  }
  scene.Trace(dacrt::Query::kAny, dacrt::RaysIn(lines)
                                      .Origin(&LineOfSight::from)
                                      .Direction(&LineOfSight::to_lamp)
                                      .Tfar(&LineOfSight::reach));
  for (const LineOfSight& line : lines) {
    std::printf("x = %g is %s\n", line.from[0], line.reach < 0 ? "in the shadow" : "lit");
  }
}

// A ball that is no mesh beside the tent: the program says where it is, and what hits it.
void AddABall(const std::shared_ptr<dacrt::Device>& device, const dacrt::Geometry& mesh) {
  const float centre[3] = {2, 1, 0}, radius = 1;
  const auto bounds = [&](uint32_t) {
    return dacrt::Bounds{{centre[0] - radius, centre[1] - radius, centre[2] - radius},
                         {centre[0] + radius, centre[1] + radius, centre[2] + radius}};
  };
  const auto test = [&](uint32_t, dacrt::RayHit& ray) {
    float b = 0, c = -radius * radius, a = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float to_origin = ray.ray.org[axis] - centre[axis];
      a += ray.ray.dir[axis] * ray.ray.dir[axis];
      b += ray.ray.dir[axis] * to_origin;
      c += to_origin * to_origin;
    }
    const float t = (-b - std::sqrt(b * b - a * c)) / a;  // not a number where there is no hit
    if (!(t > ray.ray.tnear && t <= ray.ray.tfar)) return false;
    ray.ray.tfar = t;
    for (int axis = 0; axis < 3; ++axis) ray.hit.ng[axis] = ray.ray.At(t)[axis] - centre[axis];
    return true;
  };
  const dacrt::Geometry ball =
      dacrt::UserPrimitives(1, dacrt::BoundsOf(bounds), dacrt::HitTestOf(test), kBall);

  // A scene does not change: what came to it makes another one.
  const std::vector<dacrt::Geometry> geometries = {mesh, ball};
  const dacrt::Scene scene(device, geometries);
  dacrt::RayHit ray{.ray = {.org = {2, 10, 0}, .dir = {0, -1, 0}}, .hit = {}};
  scene.ClosestHit(ray);
  std::printf("with the ball, from x = 2 down: geometry %u, %g below\n", ray.hit.geometry_id,
              ray.ray.tfar);
}

}  // namespace

int main() try {
  const auto device = std::make_shared<dacrt::Device>();
  const dacrt::Geometry mesh = dacrt::Triangles(kVertices, kTriangles, kMesh);
  const dacrt::Scene scene(device, mesh);
  FindHits(scene);
  FindShadows(scene);
  AddABall(device, mesh);
} catch (const std::exception& error) {  // dacrt::Error says which argument, if one cares
  std::fprintf(stderr, "native: %s\n", error.what());
  return 1;
}

#include "scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "random.h"
#include "scenes/hall.h"

namespace dacrt::tests {
namespace {

constexpr float kPi = 3.14159265358979f;

TestScene SceneOf(std::string name, std::vector<TestMesh> meshes,
                  std::vector<Camera> cameras = {}) {
  return {std::move(name), std::move(meshes), std::move(cameras)};
}

void AddTriangle(TestMesh& mesh, const Float3& a, const Float3& b, const Float3& c) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({{first, first + 1, first + 2}});
}

/// Two triangles that share the edge a-c.
void AddQuad(TestMesh& mesh, const Float3& a, const Float3& b, const Float3& c, const Float3& d) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c, d});
  mesh.triangles.push_back({{first, first + 1, first + 2}});
  mesh.triangles.push_back({{first, first + 2, first + 3}});
}

/// Twelve triangles over eight shared vertices.
void AddBox(TestMesh& mesh, const Float3& lower, const Float3& upper) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (int corner = 0; corner < 8; ++corner) {
    mesh.positions.push_back({corner & 1 ? upper.x : lower.x, corner & 2 ? upper.y : lower.y,
                              corner & 4 ? upper.z : lower.z});
  }
  constexpr uint32_t kFaces[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
  for (const auto& face : kFaces) {
    mesh.triangles.push_back({{first + face[0], first + face[1], first + face[2]}});
    mesh.triangles.push_back({{first + face[0], first + face[2], first + face[3]}});
  }
}

/// A grid of columns x rows cells over the unit square, two triangles a cell; `position` maps
/// (x, z) in [0, 1]^2 to a point.
template <typename Position>
TestMesh Grid(uint32_t columns, uint32_t rows, const Position& position) {
  TestMesh mesh;
  for (uint32_t row = 0; row <= rows; ++row) {
    for (uint32_t column = 0; column <= columns; ++column) {
      mesh.positions.push_back(position(static_cast<float>(column) / static_cast<float>(columns),
                                        static_cast<float>(row) / static_cast<float>(rows)));
    }
  }
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      const uint32_t corner = row * (columns + 1) + column;
      const uint32_t below = corner + columns + 1;
      mesh.triangles.push_back({{corner, below, corner + 1}});
      mesh.triangles.push_back({{corner + 1, below, below + 1}});
    }
  }
  return mesh;
}

TestMesh Sphere(const Float3& center, float radius, uint32_t rows) {
  return Grid(2 * rows, rows, [&](float turn, float height) {
    const float phi = 2 * kPi * turn;
    const float theta = kPi * height;
    return center + radius * Float3{std::sin(theta) * std::cos(phi), std::cos(theta),
                                    std::sin(theta) * std::sin(phi)};
  });
}

void Append(TestMesh& mesh, const TestMesh& other) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& triangle : other.triangles) {
    const auto& v = triangle.vertex;
    mesh.triangles.push_back({{first + v[0], first + v[1], first + v[2]}});
  }
}

Float3 RandomPoint(Random& random, float extent) {
  return {random.Uniform(-extent, extent), random.Uniform(-extent, extent),
          random.Uniform(-extent, extent)};
}

Float3 RandomDirection(Random& random) {
  const float z = random.Uniform(-1, 1);
  const float phi = random.Uniform(0, 2 * kPi);
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// A room with a few round and square things in it: small, closed, with every depth and slope.
TestMesh Furnished(uint32_t sphere_rows) {
  TestMesh mesh;
  AddBox(mesh, {-1, -1, -1}, {1, 1, 1});
  Append(mesh, Sphere({-0.4f, -0.5f, 0.1f}, 0.45f, sphere_rows));
  Append(mesh, Sphere({0.5f, 0.3f, -0.2f}, 0.3f, sphere_rows));
  Append(mesh, Sphere({0.1f, -0.7f, 0.7f}, 0.2f, sphere_rows / 2));
  AddBox(mesh, {0.25f, -1, -0.75f}, {0.75f, -0.1f, -0.25f});
  return mesh;
}

const Camera kRoomCamera{{0.1f, 0.2f, 0.95f}, {-0.1f, -0.2f, -0.3f}, 75};

TestScene Hall() {
  scenes::Mesh hall = scenes::MakeHall(250'000);
  TestMesh mesh;
  for (std::size_t i = 0; i < hall.VertexCount(); ++i) {
    const float* const p = &hall.positions[3 * i];
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (std::size_t i = 0; i < hall.TriangleCount(); ++i) {
    const uint32_t* const v = &hall.indices[3 * i];
    mesh.triangles.push_back({{v[0], v[1], v[2]}});
  }
  const scenes::Camera view = scenes::HallCamera();
  return SceneOf("hall", {std::move(mesh)},
                 {{{view.eye[0], view.eye[1], view.eye[2]},
                   {view.look_at[0], view.look_at[1], view.look_at[2]},
                   view.vertical_fov}});
}

/// Height of a fractal terrain: octaves of value noise over a lattice of random numbers.
float FractalHeight(float x, float z) {
  const auto lattice = [](int32_t i, int32_t k) {
    return Random(static_cast<uint64_t>(i) * 0x1f123bb5u + static_cast<uint64_t>(k)).Uniform();
  };
  float height = 0;
  float amplitude = 0.25f;
  for (float frequency = 4; frequency <= 256; frequency *= 2, amplitude *= 0.5f) {
    const float fx = x * frequency, fz = z * frequency;
    const float ix = std::floor(fx), iz = std::floor(fz);
    const auto i = static_cast<int32_t>(ix), k = static_cast<int32_t>(iz);
    const float near = std::lerp(lattice(i, k), lattice(i + 1, k), fx - ix);
    const float far = std::lerp(lattice(i, k + 1), lattice(i + 1, k + 1), fx - ix);
    height += amplitude * std::lerp(near, far, fz - iz);
  }
  return height;
}

TestScene Terrain() {
  TestMesh mesh = Grid(316, 316, [](float x, float z) {
    return Float3{10 * x - 5, 2 * FractalHeight(x, z), 10 * z - 5};
  });
  return SceneOf("terrain", {std::move(mesh)}, {{{-4.5f, 2.5f, -4.5f}, {2, 0, 2}, 60}});
}

TestScene Soup() {
  Random random(SeedFor("soup", 0));
  TestMesh mesh;
  for (int i = 0; i < 20'000; ++i) {
    const Float3 center = RandomPoint(random, 1);
    // Sizes over three decades, so that boxes of all sizes overlap.
    const float size = std::pow(10.0f, random.Uniform(-3, -0.3f));
    AddTriangle(mesh, center + RandomPoint(random, size), center + RandomPoint(random, size),
                center + RandomPoint(random, size));
  }
  return SceneOf("soup", {std::move(mesh)});
}

/// Hairs: triangles a million times longer than wide, at any angle, and long strips of them.
TestScene Slivers() {
  Random random(SeedFor("slivers", 0));
  TestMesh mesh;
  for (int i = 0; i < 8'000; ++i) {
    const Float3 root = RandomPoint(random, 1);
    const Float3 tip = root + random.Uniform(0.1f, 1.5f) * RandomDirection(random);
    const float width = std::pow(10.0f, random.Uniform(-6, -2));
    AddTriangle(mesh, root, root + width * RandomDirection(random), tip);
  }
  Append(mesh, Grid(1'000, 1, [](float x, float z) {
           return Float3{-1 + 2 * x, -0.5f + 1e-3f * std::sin(40 * x), -1 + 2 * z};
         }));
  return SceneOf("slivers", {std::move(mesh)});
}

/// The same triangles again: in one mesh and in another one, with the vertices in the same order,
/// rotated and turned over.
TestScene Coincident() {
  const TestMesh once = Furnished(10);
  TestMesh first = once;
  Append(first, once);
  TestMesh second = once;
  for (Triangle triangle : once.triangles) {
    std::rotate(triangle.vertex, triangle.vertex + 1, triangle.vertex + 3);
    second.triangles.push_back(triangle);
  }
  for (Triangle triangle : once.triangles) {
    std::swap(triangle.vertex[0], triangle.vertex[1]);
    second.triangles.push_back(triangle);
  }
  first.geometry_id = 1;
  second.geometry_id = 0;
  return SceneOf("coincident", {std::move(first), std::move(second)}, {kRoomCamera});
}

/// Overlapping quads in common planes, and vertices on the middle of other triangles' edges.
TestScene Coplanar() {
  Random random(SeedFor("coplanar", 0));
  TestMesh mesh;
  for (int i = 0; i < 600; ++i) {
    // Few different planes: each holds dozens of overlapping quads.
    const float height = 0.25f * static_cast<float>(random.Below(9)) - 1;
    const float x = random.Uniform(-1, 0.5f), z = random.Uniform(-1, 0.5f);
    const float dx = random.Uniform(0.1f, 0.5f), dz = random.Uniform(0.1f, 0.5f);
    AddQuad(mesh, {x, height, z}, {x + dx, height, z}, {x + dx, height, z + dz},
            {x, height, z + dz});
  }
  for (int i = 0; i < 16; ++i) {
    // One long edge at x = 0; on its other side eight short ones.
    const float z = 0.125f * static_cast<float>(i) - 1;
    AddTriangle(mesh, {0, -1, z}, {0, 1, z}, {1, 0, z});
    for (int k = 0; k < 8; ++k) {
      const float y = 0.25f * static_cast<float>(k) - 1;
      AddTriangle(mesh, {0, y, z}, {-1, y + 0.125f, z}, {0, y + 0.25f, z});
    }
  }
  return SceneOf("coplanar", {std::move(mesh)}, {{{0.3f, 3, 2.5f}, {0, 0, 0}, 50}});
}

/// Meshes with masks, attached out of order under ids with gaps, one of them disabled.
TestScene Masks() {
  constexpr std::array<std::pair<uint32_t, uint32_t>, 8> kIdsAndMasks = {{{17, 0x1},
                                                                          {3, 0x2},
                                                                          {900, 0xffffffff},
                                                                          {0, 0x80000000},
                                                                          {41, 0x3},
                                                                          {5, 0x0},
                                                                          {2, 0xff00},
                                                                          {11, 0xfffffffe}}};
  Random random(SeedFor("masks", 0));
  std::vector<TestMesh> meshes;
  for (const auto& [id, mask] : kIdsAndMasks) {
    TestMesh mesh;
    for (int i = 0; i < 12; ++i) {
      Append(mesh, Sphere(RandomPoint(random, 1), random.Uniform(0.05f, 0.3f), 6));
    }
    mesh.geometry_id = id;
    mesh.mask = mask;
    meshes.push_back(std::move(mesh));
  }
  meshes[4].enabled = false;
  return SceneOf("masks", std::move(meshes));
}

/// Unit boxes on integer coordinates: rays through their edges and corners meet several triangles
/// in the very same point, and all arithmetic on them is exact.
TestScene Boxes() {
  TestMesh mesh;
  for (int x = -4; x < 4; ++x) {
    for (int y = -4; y < 4; ++y) {
      for (int z = -4; z < 4; ++z) {
        const Float3 lower{static_cast<float>(2 * x), static_cast<float>(2 * y),
                           static_cast<float>(2 * z)};
        if ((x + y + z) % 3 != 0) AddBox(mesh, lower, lower + Float3{1, 1, 1});
      }
    }
  }
  return SceneOf("boxes", {std::move(mesh)});
}

/// The furnished room, scaled, then moved.
TestScene Placed(const std::string& name, float scale, const Float3& offset) {
  TestMesh mesh = Furnished(24);
  for (Float3& position : mesh.positions) position = scale * position + offset;
  const Camera camera{scale * kRoomCamera.eye + offset, scale * kRoomCamera.target + offset,
                      kRoomCamera.vertical_fov_degrees};
  return SceneOf(name, {std::move(mesh)}, {camera});
}

TestScene SingleTriangle() {
  TestMesh mesh;
  AddTriangle(mesh, {-1, -0.5f, 0.25f}, {1, -0.75f, -0.25f}, {0.125f, 1, 0});
  return SceneOf("single", {std::move(mesh)});
}

/// Triangles without area, and ones that no ray may hit, among ordinary ones.
TestScene Degenerate() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Random random(SeedFor("degenerate", 0));
  TestMesh mesh = Furnished(8);
  for (int i = 0; i < 500; ++i) {
    const Float3 a = RandomPoint(random, 1), b = RandomPoint(random, 1);
    AddTriangle(mesh, a, a, a);
    AddTriangle(mesh, a, b, a);
    AddTriangle(mesh, a, a, b);
    AddTriangle(mesh, a, 0.5f * (a + b), b);
    AddTriangle(mesh, a, b, {b.x, b.y, std::nextafter(b.z, 2.0f)});
  }
  for (const float bad : {kNan, kInfinity, -kInfinity, 3e38f}) {
    AddTriangle(mesh, {bad, 0, 0}, {0, 1, 0}, {0, 0, 1});
    AddTriangle(mesh, {0, 0, 0}, {0, 1, 0}, {0, bad, 1});
  }
  return SceneOf("degenerate", {std::move(mesh)}, {kRoomCamera});
}

/// Ordinary meshes in every kind of legal buffer.
TestScene Layouts() {
  constexpr BufferLayout kLayouts[] = {
      {0, 12, 0, 12}, {0, 16, 0, 16}, {4, 12, 8, 12}, {16, 32, 0, 20}, {20, 44, 64, 24},
  };
  std::vector<TestMesh> meshes;
  for (const BufferLayout& layout : kLayouts) {
    const float x = static_cast<float>(meshes.size()) - 2;
    TestMesh mesh = Sphere({x, 0.2f * x, 0}, 0.7f, 16);
    mesh.layout = layout;
    mesh.geometry_id = static_cast<uint32_t>(meshes.size());
    meshes.push_back(std::move(mesh));
  }
  return SceneOf("layouts", std::move(meshes));
}

TestScene Empty() { return SceneOf("empty", {}); }

}  // namespace

std::size_t TestScene::TriangleCount() const {
  std::size_t count = 0;
  for (const TestMesh& mesh : meshes) count += mesh.triangles.size();
  return count;
}

TestScene::Corners TestScene::Bounds() const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Corners corners{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const TestMesh& mesh : meshes) {
    for (const Float3& position : mesh.positions) {
      // As Embree, which leaves out triangles whose vertices it cannot bound.
      constexpr float kLargest = 1.844e18f;
      const auto is_legal = [](float value) { return std::abs(value) < kLargest; };
      if (!is_legal(position.x) || !is_legal(position.y) || !is_legal(position.z)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        corners.lower[axis] = std::min(corners.lower[axis], position[axis]);
        corners.upper[axis] = std::max(corners.upper[axis], position[axis]);
      }
    }
  }
  return corners.lower.x <= corners.upper.x ? corners : Corners{};
}

std::vector<SceneSource> GeneratedScenes() {
  return {
      {"hall", Hall},
      {"terrain", Terrain},
      {"soup", Soup},
      {"slivers", Slivers},
      {"coincident", Coincident},
      {"coplanar", Coplanar},
      {"masks", Masks},
      {"boxes", Boxes},
      {"tiny", [] { return Placed("tiny", 1e-3f, {}); }},
      {"huge", [] { return Placed("huge", 1e6f, {}); }},
      {"offset",
       [] {
         return Placed("offset", 1, {1e4f, -2e4f, 3e3f});
       }},
      {"far",
       [] {
         return Placed("far", 100, {1e6f, 1e6f, -1e6f});
       }},
      {"single", SingleTriangle},
      {"degenerate", Degenerate},
      {"layouts", Layouts},
      {"empty", Empty},
  };
}

}  // namespace dacrt::tests

#include "box_scene.h"

#include <array>
#include <cmath>

namespace dacrt::bench {
namespace {

using Imath::V3f;

// Corners in order around the face.
void AddQuad(const std::array<V3f, 4>& corners, scenes::Mesh& mesh) {
  const auto first = static_cast<uint32_t>(mesh.VertexCount());
  for (const V3f& corner : corners) {
    mesh.positions.insert(mesh.positions.end(), {corner.x, corner.y, corner.z});
  }
  for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + corner);
}

// Stands at `foot`, turned about y by `angle`; `half` is half of its sides, and all of its height.
void AddBlock(const V3f& foot, const V3f& half, float angle, scenes::Mesh& mesh) {
  const float c = std::cos(angle), s = std::sin(angle);
  const auto corner = [&](int x, int y, int z) {
    const float across = x * half.x, along = z * half.z;
    return foot + V3f(c * across + s * along, y * half.y, c * along - s * across);
  };
  for (const int side : {-1, 1}) {
    AddQuad({corner(side, 0, -1), corner(side, 0, 1), corner(side, 1, 1), corner(side, 1, -1)},
            mesh);
    AddQuad({corner(-1, 0, side), corner(1, 0, side), corner(1, 1, side), corner(-1, 1, side)},
            mesh);
  }
  for (const int level : {0, 1}) {
    AddQuad(
        {corner(-1, level, -1), corner(1, level, -1), corner(1, level, 1), corner(-1, level, 1)},
        mesh);
  }
}

}  // namespace

BenchScene MakeBox() {
  constexpr float kTop = 2;
  constexpr float kLampHeight = 1.98f, kLampHalf = 0.25f;
  BenchScene scene{.name = "box-36",
                   .mesh = {},
                   .view = {{0, 1, 3.2f}, {0, 1, 0}, 40},
                   .lamp = {{0.1f, 1.8f, 0.05f}, kLampHalf}};
  scenes::Mesh& mesh = scene.mesh;
  for (const float y : {0.0f, kTop}) {
    AddQuad({V3f(-1, y, -1), V3f(1, y, -1), V3f(1, y, 1), V3f(-1, y, 1)}, mesh);
  }
  for (const float x : {-1.0f, 1.0f}) {
    AddQuad({V3f(x, 0, -1), V3f(x, 0, 1), V3f(x, kTop, 1), V3f(x, kTop, -1)}, mesh);
  }
  AddQuad({V3f(-1, 0, -1), V3f(1, 0, -1), V3f(1, kTop, -1), V3f(-1, kTop, -1)}, mesh);
  AddQuad({V3f(-kLampHalf, kLampHeight, -kLampHalf), V3f(kLampHalf, kLampHeight, -kLampHalf),
           V3f(kLampHalf, kLampHeight, kLampHalf), V3f(-kLampHalf, kLampHeight, kLampHalf)},
          mesh);
  AddBlock({-0.35f, 0, -0.35f}, {0.3f, 1.2f, 0.3f}, 0.3f, mesh);
  AddBlock({0.35f, 0, 0.3f}, {0.3f, 0.6f, 0.3f}, -0.3f, mesh);
  return scene;
}

}  // namespace dacrt::bench

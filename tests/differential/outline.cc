#include "outline.h"

#include "motion.h"

namespace dacrt::tests {
namespace {

Float3 Transformed(const ApproximateTransform& transform, const Float3& p) {
  Float3 result;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& c = transform.column;
    result[axis] = static_cast<float>(c[0][axis].value * p.x + c[1][axis].value * p.y +
                                      c[2][axis].value * p.z + c[3][axis].value);
  }
  return result;
}

ApproximateTransform ToWorldAtBegin(const WorldGeometry& instance) {
  return ToWorld(instance, MomentAt(instance, instance.time_begin));
}

void AddQuad(TestMesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  mesh.triangles.push_back({{a, b, d}});
  mesh.triangles.push_back({{c, d, b}});
}

TestMesh OutlineOf(const WorldGeometry& geometry) {
  TestMesh mesh;
  for (const Vertex& vertex : geometry.vertices[0]) {
    const Float3 center{vertex.x, vertex.y, vertex.z};
    if (!HasPoints(geometry.shape)) {
      mesh.positions.push_back(center);
      continue;
    }
    const float r = vertex.radius;
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.push_back(center + Float3{r, 0, 0});
    mesh.positions.push_back(center + Float3{0, r, 0});
    mesh.positions.push_back(center + Float3{-r, -r, r});
    mesh.triangles.push_back({{first, first + 1, first + 2}});
  }
  for (const auto& p : geometry.primitives) {
    if (geometry.shape == Shape::kTriangles) {
      mesh.triangles.push_back({{p[0], p[1], p[2]}});
    } else if (geometry.shape == Shape::kQuads) {
      AddQuad(mesh, p[0], p[1], p[2], p[3]);
    } else {
      const uint32_t last = p[0] + (p[3] - 1) * p[1] + p[2] - 1;
      AddQuad(mesh, p[0], p[0] + p[2] - 1, last, last - p[2] + 1);
    }
  }
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    for (const uint32_t vertex : triangle.vertex) {
      if (vertex >= mesh.positions.size()) return true;
    }
    return false;
  });
  return mesh;
}

}  // namespace

TestScene Outline(const std::vector<WorldScene>& scenes) {
  TestScene outline;
  for (const WorldGeometry& geometry : scenes.back().geometries) {
    if (geometry.shape != Shape::kInstance) {
      outline.meshes.push_back(OutlineOf(geometry));
      continue;
    }
    const ApproximateTransform to_world = ToWorldAtBegin(geometry);
    for (const WorldGeometry& inner : scenes[geometry.instanced_scene].geometries) {
      if (inner.shape == Shape::kInstance) continue;
      TestMesh mesh = OutlineOf(inner);
      for (Float3& position : mesh.positions) position = Transformed(to_world, position);
      outline.meshes.push_back(std::move(mesh));
    }
  }
  return outline;
}

}  // namespace dacrt::tests

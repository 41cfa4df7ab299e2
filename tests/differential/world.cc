#include "world.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "random.h"

namespace dacrt::tests {

const char* Name(Shape shape) {
  constexpr const char* kNames[kShapeCount] = {"triangles", "quads",          "grids", "spheres",
                                               "discs",     "oriented_discs", "user",  "instances"};
  return kNames[static_cast<uint32_t>(shape)];
}

bool HasPoints(Shape shape) {
  return shape == Shape::kSpheres || shape == Shape::kDiscs || shape == Shape::kOrientedDiscs ||
         shape == Shape::kUser;
}

bool HasFacets(Shape shape) {
  return shape == Shape::kTriangles || shape == Shape::kQuads || shape == Shape::kGrids;
}

const char* Name(FilterKind kind) {
  constexpr const char* kNames[] = {"none", "accept", "reject_some", "reject_all", "change"};
  return kNames[static_cast<uint32_t>(kind)];
}

uint32_t WorldGeometry::StepCount() const {
  return static_cast<uint32_t>(shape == Shape::kInstance ? placements.size() : vertices.size());
}

uint32_t WorldGeometry::PrimitiveCount() const {
  if (shape == Shape::kInstance) return 1;
  return static_cast<uint32_t>(HasFacets(shape) ? primitives.size() : vertices.front().size());
}

namespace {

/// `move(vertex, i)` for each vertex i of each time step.
template <class Move>
void MoveVertices(WorldGeometry& geometry, const Move& move) {
  for (auto& step : geometry.vertices) {
    for (std::size_t i = 0; i < step.size(); ++i) move(step[i], i);
  }
}

void MoveBy(const Float3& shift, float factor, Vertex& vertex) {
  vertex.x += factor * shift.x;
  vertex.y += factor * shift.y;
  vertex.z += factor * shift.z;
}

}  // namespace

void Apply(const Change& change, std::vector<WorldScene>& scenes) {
  WorldGeometry& geometry = scenes[change.scene].geometries[change.geometry];
  switch (change.kind) {
    case Change::Kind::kEnable:
      geometry.enabled = true;
      return;
    case Change::Kind::kDisable:
      geometry.enabled = false;
      return;
    case Change::Kind::kDetach:
      geometry.attached = false;
      return;
    case Change::Kind::kAttach:
      geometry.attached = true;
      return;
    case Change::Kind::kReplace:
      return;
    case Change::Kind::kMask:
      geometry.mask = change.mask;
      return;
    case Change::Kind::kFilters:
      geometry.closest_filter = change.closest_filter;
      geometry.any_filter = change.any_filter;
      return;
    case Change::Kind::kPrimitives: {
      const uint32_t left = (geometry.PrimitiveCount() + 1) / 2;
      if (HasFacets(geometry.shape)) geometry.primitives.resize(left);
      if (!HasPoints(geometry.shape)) return;
      for (auto& step : geometry.vertices) step.resize(left);
      for (auto& step : geometry.normals) step.resize(left);
      return;
    }
    case Change::Kind::kBend:
      return MoveVertices(geometry, [&](Vertex& vertex, std::size_t i) {
        MoveBy(change.shift, 0.2f * std::sin(0.1f * static_cast<float>(i)), vertex);
      });
    case Change::Kind::kScatter:
      return MoveVertices(geometry, [&](Vertex& vertex, std::size_t i) {
        MoveBy(change.shift, static_cast<float>(Random(i).Next() >> 40) * 0x1p-24f, vertex);
      });
    case Change::Kind::kSpoil:
      return MoveVertices(geometry, [&](Vertex& vertex, std::size_t i) {
        if (i % 5 != 2) return;
        vertex.y = std::isnan(vertex.y) ? 0.125f * static_cast<float>(i % 8)
                                        : std::numeric_limits<float>::quiet_NaN();
      });
    case Change::Kind::kShift:
      MoveVertices(geometry, [&](Vertex& vertex, std::size_t) { MoveBy(change.shift, 1, vertex); });
      for (Placement& placement : geometry.placements) {
        for (int axis = 0; axis < 3; ++axis) {
          placement.matrix[9 + axis] += change.shift[axis];
          placement.parts[13 + axis] += change.shift[axis];
        }
      }
  }
}

bool Rejects(FilterKind kind, uint32_t ray_id, const RTCHit& hit) {
  if (kind != FilterKind::kRejectSome) return kind == FilterKind::kRejectAll;
  uint64_t seed = ray_id;
  for (const uint32_t part : {hit.instID[0], hit.geomID, hit.primID}) {
    seed = seed * 0x100000001b3u + part;
  }
  return Random(seed).Next() % 2 == 0;
}

}  // namespace dacrt::tests

// What a scene is made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "dacrt/callback.h"
#include "dacrt/point_query.h"
#include "dacrt/transform.h"

namespace dacrt {

class Scene;

/// An axis-aligned box. An empty one has lower = +infinity and upper = -infinity.
struct Bounds {
  float lower[3];
  float upper[3];
};

/// Bounds that move: those at time t from 0 to 1 lie in (1 - t) * begin + t * end.
struct LinearBounds {
  Bounds begin;
  Bounds end;
};

/// An indexed triangle mesh in the caller's memory, which is read during Scene's constructor and
/// during each Trace: it must stay in place and unchanged while a scene that was made from it
/// exists. (The partition that a scene keeps holds copies of triangles, made when rays come to
/// them, at no promised time.)
struct TriangleMesh {
  /// Three floats a vertex, `vertex_stride` bytes apart. Four-byte aligned.
  const void* vertices = nullptr;
  std::size_t vertex_stride = 12;
  std::size_t vertex_count = 0;

  /// Three uint32_t a triangle, `triangle_stride` bytes apart. Four-byte aligned.
  const void* triangles = nullptr;
  std::size_t triangle_stride = 12;
  std::size_t triangle_count = 0;

  /// What a hit reports. Also the first key by which equal distances are decided.
  uint32_t geometry_id = 0;

  /// A ray meets this mesh only if (ray mask & mesh mask) != 0.
  uint32_t mask = UINT32_MAX;
};

/// What the primitives of a geometry are.
enum class Shape : uint8_t {
  kTriangles,      ///< three indices each
  kQuads,          ///< four indices each; the triangles (0, 1, 3) and (2, 3, 1)
  kGrids,          ///< a GridPrimitive each: a rectangle of vertices, a quad between each four
  kSpheres,        ///< a vertex each: centre and radius
  kDiscs,          ///< the same, facing the ray; none for rays from within the sphere
  kOrientedDiscs,  ///< the same, with a normal each
  kUser,           ///< known by callbacks only
  kInstance,       ///< another scene, in one primitive
};

/// A grid of `width` x `height` vertices: the one in column x and row y has the index
/// first_vertex + y * vertex_stride + x. Hits have u from 0 to 1 along the rows, v along the
/// columns. A grid that reaches beyond the vertices is left out as a whole.
struct GridPrimitive {
  uint32_t first_vertex;
  uint32_t vertex_stride;
  uint16_t width, height;  ///< 1 to 32767; without two of each there is nothing to hit
};

/// Values in the caller's memory, `stride` bytes apart, four-byte aligned.
struct Array {
  const void* data = nullptr;
  std::size_t stride = 0;
};

/// Fills in the bounds of a user primitive at a time step. Bounds that are empty, inverted or not
/// finite leave the primitive out.
struct BoundsCallback {
  void (*function)(void* data, uint32_t primitive, uint32_t time_step, Bounds& bounds) = nullptr;
  void* data = nullptr;
};

/// A geometry in the caller's memory, which is read and kept as TriangleMesh says. Which members
/// count depends on the shape.
struct Geometry {
  Shape shape = Shape::kTriangles;
  uint32_t geometry_id = 0;         ///< as in TriangleMesh
  uint32_t mask = UINT32_MAX;       ///< as in TriangleMesh
  TimeRange time_range;             ///< counts where there are several time steps
  std::size_t primitive_count = 0;  ///< 1 for an instance

  /// Says which contents the geometry has now: where a scene follows another one (see
  /// Scene::TakeOver), geometries with the same number, places and counts have the same contents.
  /// 0 says nothing.
  uint64_t revision = 0;

  /// Says that the geometry takes no part: no ray meets it, and nothing of it is read, called or
  /// kept, nor what an instance shows. With Scene::Update geometries go and come back so.
  bool hidden = false;

  /// All but user geometries and instances: one array for each of 1 to 129 time steps. Three floats
  /// a vertex; centre and radius, four floats, for spheres and discs.
  std::vector<Array> vertices;
  std::size_t vertex_count = 0;  ///< of the shortest array
  std::vector<Array> normals;    ///< oriented discs: three floats each, an array a time step
  Array primitives;              ///< indices (uint32_t), or GridPrimitive; triangles, quads, grids

  uint32_t user_time_steps = 1;  ///< of user geometries
  BoundsCallback bounds;         ///< called while a scene is made or updated, by that thread
  Callback intersect;            ///< for Query::kClosest; without it no ray hits
  Callback occluded;             ///< for Query::kAny; without it no ray hits

  /// Instances: the scene, and where it stands at each of 1 to 129 time steps. Instances in the
  /// instanced scene are left out: there is one level.
  std::shared_ptr<const Scene> instanced_scene;
  std::vector<TransformStep> transforms;

  /// Filter functions, offered each pair of a ray and a primitive that meet, once, as long as no
  /// closer hit was accepted; grids offer each of their hits, spheres and discs near and far ones.
  /// In which order, and so which pairs before the closest one, is not promised.
  Callback closest_filter;  ///< for Query::kClosest
  Callback any_filter;      ///< for Query::kAny

  /// Called by Scene::QueryPoint. Without it point queries skip the geometry; instances have no
  /// callback of their own.
  PointCallback point_callback;
};

/// Where an instance stands from now on: see Scene::Update.
struct Placement {
  uint32_t geometry_id;

  /// As many as the instance has.
  std::span<const TransformStep> transforms;
};

}  // namespace dacrt

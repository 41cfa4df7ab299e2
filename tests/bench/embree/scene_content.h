// What a scene is made of, in memory that both libraries share: the same mesh as triangles, quads,
// instances, in parts ...
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace dacrt::bench {

/// What rays must have beside an origin and a direction.
struct RayNeeds {
  bool times = false;  ///< spread over the shutter's interval
  bool masks = false;  ///< half of the rays see half of the scene
};

/// A transform of instances: three columns of a matrix and a translation.
using Transform = std::vector<float>;

/// One geometry. Its arrays are not copied by the libraries.
struct GeometryContent {
  RTCGeometryType type = RTC_GEOMETRY_TYPE_TRIANGLE;
  std::vector<const float*> vertices;  ///< an array for each time step
  std::size_t vertex_count = 0;
  const uint32_t* primitives = nullptr;  ///< vertex numbers, or grids; null for points
  std::size_t primitive_count = 0;
  unsigned mask = UINT32_MAX;
  bool is_filtered = false;    ///< by the filter function of callbacks.h
  const void* user = nullptr;  ///< for a user geometry: the sphere of callbacks.h
  std::size_t scene = 0;       ///< for an instance: its number among the instanced scenes
  Transform transform;
};

/// A scene. What it owns stays where it is when the scene is moved.
struct SceneContent {
  std::vector<GeometryContent> geometries;
  RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
  std::vector<SceneContent> instanced;
  RayNeeds needs;

  std::deque<std::vector<float>> floats;      ///< arrays that the geometries refer to
  std::deque<std::vector<uint32_t>> numbers;  ///< the same
};

/// What has become of a run of a scene's geometries.
struct ContentChange {
  enum class Of {
    kVertices,    ///< moved, where they are
    kPrimitives,  ///< others, in another array
    kTransform,   ///< of instances
    kAll,         ///< another geometry
  };

  Of of;
  std::size_t first, count;  ///< geometries
};

}  // namespace dacrt::bench

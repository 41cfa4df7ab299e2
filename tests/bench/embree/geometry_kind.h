// The kinds of geometry that the libraries are compared on: the same mesh in different forms.
#pragma once

#include <span>
#include <string>

#include "bench_scene.h"
#include "scene_content.h"

namespace dacrt::bench {

struct GeometryKind {
  const char* name;
  SceneContent (*make)(const BenchScene& scene);
};

/// triangles, robust, compact, quads, grids, spheres, masked, filter, user, instance,
/// instances-1000, moving, parts-200, parts-10000. The content refers to the mesh of the scene,
/// which must outlive it.
std::span<const GeometryKind> GeometryKinds();

/// Null if there is none of this name.
const GeometryKind* FindGeometryKind(const std::string& name);

}  // namespace dacrt::bench

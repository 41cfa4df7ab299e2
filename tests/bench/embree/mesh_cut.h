// A mesh as triangle geometries: whole, or cut into parts.
#pragma once

#include "scene_content.h"
#include "scenes/hall.h"

namespace dacrt::bench {

/// All triangles as one geometry. The mesh must outlive it.
GeometryContent WholeMesh(const scenes::Mesh& mesh);

/// Adds a geometry for each of `count` runs of triangles, of equal length but for one triangle; as
/// many as there are triangles if those are fewer. Each has the range of vertices that it uses.
void CutIntoParts(const scenes::Mesh& mesh, std::size_t count, SceneContent& content);

}  // namespace dacrt::bench

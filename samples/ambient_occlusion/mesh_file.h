// Loading a mesh from a file.
#pragma once

#include <string>

#include "scenes/hall.h"

namespace ao {

// Reads an OBJ, PLY, glTF (.gltf, .glb) or STL file and joins all of its triangles, placed as the
// nodes of the file say; polygons are cut into triangles, points and lines left out.
// Throws Error with kMesh if the file cannot be read or holds no triangle. Call it before there are
// threads (see isolated.h).
scenes::Mesh LoadMesh(const std::string& path);

}  // namespace ao

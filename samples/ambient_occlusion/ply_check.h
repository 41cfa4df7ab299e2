// Whether a PLY file holds all that its header announces.
#pragma once

#include <string>

namespace ao {

// Assimp's reader never returns from some PLY files that end too early, and fills the gaps of
// others with whatever it finds. So they are looked through beforehand. Throws Error with kMesh if
// the file ends too early; says nothing about what Assimp reports itself.
void CheckPlyIsComplete(const std::string& path);

}  // namespace ao

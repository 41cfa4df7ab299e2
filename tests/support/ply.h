// Triangle meshes from PLY files, in the one form that the test scenes have.
#pragma once

#include <filesystem>
#include <vector>

#include "scenes.h"

namespace dacrt::tests {

/// Reads a binary little-endian PLY file: vertices of three floats x, y, z, faces of one
/// `list uchar int vertex_indices`, triangles only.
/// Throws std::runtime_error that names the file and the fault.
TestMesh ReadPly(const std::filesystem::path& path);

}  // namespace dacrt::tests

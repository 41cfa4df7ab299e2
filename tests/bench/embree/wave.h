// A wave that runs through a mesh: every vertex moves, and the triangles stay what they are.
#pragma once

#include <vector>

#include "scenes/hall.h"

namespace dacrt::bench {

class Wave {
 public:
  /// The mesh at rest, which must outlive this.
  explicit Wave(const scenes::Mesh& rest);

  /// Where the vertices are after `turns` full turns. Writes as many floats as the mesh has
  /// vertices to the beginning of `positions`.
  void Apply(float turns, std::vector<float>& positions) const;

 private:
  const scenes::Mesh& rest_;
  float height_;  ///< how far a vertex moves, along y
  float length_;  ///< from crest to crest, along x
};

}  // namespace dacrt::bench

// A wave that runs through a mesh: every vertex moves, and the triangles stay what they are.
#pragma once

#include <cstddef>
#include <span>

#include "scenes/hall.h"

namespace dacrt::bench {

class Wave {
 public:
  /// The mesh at rest, which must outlive this.
  explicit Wave(const scenes::Mesh& rest);

  /// Where the vertices from the `first` on are after `turns` full turns: as many as `positions`
  /// has room for.
  void Apply(float turns, std::size_t first, std::span<float> positions) const;

 private:
  const scenes::Mesh& rest_;
  float height_;  ///< how far a vertex moves, along y
  float length_;  ///< from crest to crest, along x
};

}  // namespace dacrt::bench

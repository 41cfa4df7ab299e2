// How far behind t the key of a hit can lie (see hit_key.h), by a look at the triangle: mostly so
// little that nobody has to be asked.
#pragma once

#include <map>
#include <span>

#include "dacrt/mpi.h"
#include "ray_bundle.h"

namespace dacrt::mpi {

/// The triangles of a rank's part of a scene, where they lie in the program's memory.
class KeyBounds {
 public:
  explicit KeyBounds(std::span<const Geometry> geometries);

  /// A ray with the hit that was found for it, and a number that the key is not above: infinity
  /// where the hit is not one of a still triangle mesh.
  struct Asked {
    const RayRecord* ray;
    float most = kInfinity;
  };
  static constexpr std::size_t kMost = 64;

  /// Finds the numbers of kMost hits at most. Where triangles lie is known for all before the first
  /// is looked at, so that memory is waited for once and not for each.
  void Find(std::span<Asked> hits) const;

 private:
  struct Triangles {
    Array vertices, primitives;
    bool is_known = false;  ///< false for what is no still triangle mesh, and for IDs used twice
  };
  const Triangles* TrianglesOf(const RayRecord& ray) const;

  std::map<uint32_t, Triangles> by_id_;
};

}  // namespace dacrt::mpi

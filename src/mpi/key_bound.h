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

  /// A number that the key of `hit` is not above; infinity where the hit is not one of a still
  /// triangle mesh.
  float MostOf(const TravellingRay& ray, const HitRecord& hit) const;

 private:
  struct Triangles {
    Array vertices, primitives;
    bool is_known = false;  ///< false for what is no still triangle mesh, and for IDs used twice
  };
  std::map<uint32_t, Triangles> by_id_;
};

}  // namespace dacrt::mpi

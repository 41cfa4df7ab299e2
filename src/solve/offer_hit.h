// Hits in scenes of more than still triangles: from a candidate to the hit of a ray, by mask,
// distance, and the program's filter function.
#pragma once

#include <cstddef>
#include <cstdint>

#include "solve/solve_task.h"

namespace dacrt {

/// Where a ray meets a primitive.
struct Candidate {
  float key;          ///< the distance that decides (see direct_solve-inl.h)
  bool within_limit;  ///< it passes Embree's test against tfar
  float t;
  float ng[3];
  float u, v;
  uint32_t geometry;  ///< by its place in the scene's shapes
  uint32_t primitive_id;
};

/// Offers the ray in `slot` a candidate. The ray has it for its hit then, unless one that it has is
/// closer, its mask forbids it, or the filter function rejects it.
template <Query kQuery>
void OfferHit(const SolveTask& task, std::size_t slot, const Candidate& candidate);

/// Whether the ray in `slot` may meet a geometry, by its mask.
bool MayMeet(const SolveTask& task, std::size_t slot, uint32_t geometry);

}  // namespace dacrt

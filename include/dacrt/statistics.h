// What one call did, counted while it ran.
#pragma once

#include <cstdint>

#include "dacrt/export.h"

namespace dacrt {

/// Counts of one `Scene::Trace`. Adding two gives the counts of both calls, and the larger depth.
struct DACRT_API Statistics {
  uint64_t rays = 0;            ///< active rays (see RayView); 0 where there is no triangle to hit
  uint64_t hits = 0;            ///< of these, rays that hit something
  uint64_t pieces = 0;          ///< pieces that the batch was cut into
  uint64_t subproblems = 0;     ///< calls of the recursion, but none for rays in groups
  uint64_t max_depth = 0;       ///< deepest level of the recursion; the root is level 1
  uint64_t sampled_splits = 0;  ///< splits chosen by sample rays
  uint64_t sah_splits = 0;      ///< splits chosen by the surface area heuristic
  uint64_t space_cuts = 0;      ///< cuts of space
  uint64_t straddling = 0;      ///< sum over cuts of the triangles that went to both sides
  uint64_t median_splits = 0;   ///< splits by count, where centres coincide or the depth is bounded
  uint64_t box_tests = 0;       ///< tests of one ray against one child volume while filtering
  uint64_t rays_filtered = 0;   ///< rays that filtering removed
  uint64_t packet_tests = 0;    ///< tests of one ray packet or cone against one child volume
  uint64_t filters = 0;         ///< child volumes that were filtered
  uint64_t filters_skipped = 0;  ///< child volumes that took over the parent's rays
  uint64_t direct_solves = 0;    ///< subproblems solved directly; the same
  uint64_t direct_rays = 0;      ///< sum over direct solves of the active rays
  uint64_t triangle_tests = 0;   ///< tests of one ray against one triangle

  // Where the time of the published methods went, in seconds of all threads together, by the time
  // stamp counter; 0 over a kept partition, where a clock would cost as much as a step.
  double seconds_loading = 0;    ///< from the caller's records to the engine's arrays
  double seconds_sampling = 0;   ///< taking sample rays, and tracing them against candidates
  double seconds_binning = 0;    ///< references, bins and candidates
  double seconds_partition = 0;  ///< moving references
  double seconds_filtering = 0;  ///< filtering, and returning distances
  double seconds_direct = 0;     ///< direct solves
  double seconds_storing = 0;    ///< from the engine's hits to the caller's records

  Statistics& operator+=(const Statistics& other);
};

}  // namespace dacrt

#include "dacrt/statistics.h"

#include <algorithm>

namespace dacrt {

Statistics& Statistics::operator+=(const Statistics& other) {
  rays += other.rays;
  hits += other.hits;
  pieces += other.pieces;
  subproblems += other.subproblems;
  max_depth = std::max(max_depth, other.max_depth);
  sampled_splits += other.sampled_splits;
  sah_splits += other.sah_splits;
  space_cuts += other.space_cuts;
  straddling += other.straddling;
  median_splits += other.median_splits;
  box_tests += other.box_tests;
  rays_filtered += other.rays_filtered;
  packet_tests += other.packet_tests;
  filters += other.filters;
  filters_skipped += other.filters_skipped;
  direct_solves += other.direct_solves;
  direct_rays += other.direct_rays;
  triangle_tests += other.triangle_tests;
  seconds_loading += other.seconds_loading;
  seconds_sampling += other.seconds_sampling;
  seconds_binning += other.seconds_binning;
  seconds_partition += other.seconds_partition;
  seconds_filtering += other.seconds_filtering;
  seconds_direct += other.seconds_direct;
  seconds_storing += other.seconds_storing;
  return *this;
}

}  // namespace dacrt

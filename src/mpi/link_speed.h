// How fast messages are, and from which size on it pays to send rays to others.
#pragma once

#include <cstddef>

#include "crew.h"

namespace dacrt::mpi {

struct LinkSpeed {
  double round_trip_seconds = 0;
  double bytes_per_second = 0;
};

/// The slowest of the workers, each measured alone. Workers that do not answer are lost.
LinkSpeed MeasureLink(Crew& crew);

/// The smallest call that is worth sharing between `ranks` ranks; SIZE_MAX if none is.
std::size_t LeastRays(const LinkSpeed& speed, std::size_t ranks);

}  // namespace dacrt::mpi

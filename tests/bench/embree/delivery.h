// Handing rays to a library, timed.
#pragma once

#include <cstddef>

#include "embree_library.h"

namespace dacrt::bench {

/// How a program sends its rays.
struct Delivery {
  Call call;
  std::size_t batch;  ///< rays that the program has at a time: the next wait for their results
  std::size_t slice;  ///< rays of one call: the callers take the slices of a batch as they are free
  int callers;

  bool operator==(const Delivery&) const = default;
};

/// The seconds that all batches of the rays take, one after the other.
double Deliver(const CommittedScene& scene, Query query, const Delivery& delivery, RayBuffer& rays);

/// Sends batches until `seconds` have passed or all are done, and returns how many those were.
std::size_t DeliverFor(double seconds, const CommittedScene& scene, Query query,
                       const Delivery& delivery, RayBuffer& rays);

}  // namespace dacrt::bench

// Handing rays to a library, timed.
#pragma once

#include <cstddef>

#include "committed_scene.h"

namespace dacrt::bench {

/// How a program sends its rays. Packets fill batches and slices.
struct Delivery {
  Call call;
  std::size_t batch;  ///< rays that the program has at a time: the next wait for their results
  std::size_t slice;  ///< the callers take the slices of a batch as they are free; of a stream, a
                      ///< slice is one call
  int callers;

  bool operator==(const Delivery&) const = default;
};

/// The seconds that all batches of the rays take, one after the other.
double Deliver(const CommittedScene& scene, Query query, const Delivery& delivery, RayBuffer& rays);

/// Sends batches until `seconds` have passed or all are done, and returns how many those were.
std::size_t DeliverFor(double seconds, const CommittedScene& scene, Query query,
                       const Delivery& delivery, RayBuffer& rays);

}  // namespace dacrt::bench

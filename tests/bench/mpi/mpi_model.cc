#include "mpi_model.h"

#include <algorithm>
#include <cmath>

namespace dacrt::bench {

double PredictReplicate(const MeasuredRank& measured, const Network& network, int ranks,
                        double rays) {
  const double rate = measured.rays_per_second, moving = measured.moving_seconds_per_ray;
  const double others = ranks - 1;
  // Rank 0 traces what moving the others' rays leaves it time for.
  const double left = std::max(0.0, 1 - rate * others * moving);
  const double tracing = rays / (rate * (others + left));
  const double share = others / (others + left);  // of the rays that travel
  const double rank_0 = rays * share * moving;
  const double link = rays * share *
                      std::max(measured.bytes_out_per_ray, measured.bytes_in_per_ray) /
                      network.bytes_per_second;
  return rays / (std::max({tracing, rank_0, link}) + 2 * network.round_trip_seconds);
}

double PredictDivide(const MeasuredDivide& measured, const Network& network, int ranks,
                     double rays) {
  if (ranks == 1) return measured.rays_per_second;
  // A ray crosses parts as it crosses cells of a grid: with the cube root of their number.
  const double growth = (std::cbrt(ranks) - 1) / (std::cbrt(measured.ranks) - 1);
  const double visits = 1 + (measured.visits_per_ray - 1) * growth;
  const double hops = measured.hops_per_ray * growth;
  const double tracing = rays * visits / measured.rays_per_second;
  const double moving = rays * hops * measured.moving_seconds_per_hop;
  const double link = rays * hops * measured.bytes_per_hop / network.bytes_per_second;
  // The last rays go from rank to rank while nothing else is left to do.
  const double tail = (hops + 1) * network.round_trip_seconds;
  return ranks * rays / (std::max(tracing + moving, link) + tail);
}

}  // namespace dacrt::bench

// What a run on one machine says about runs on many. The formulas are explained in MPI.md.
#pragma once

namespace dacrt::bench {

/// A network, as each rank sees it.
struct Network {
  double bytes_per_second;
  double round_trip_seconds;
};

/// What is measured on one machine.
struct MeasuredRank {
  double rays_per_second;         ///< that one rank traces, of the whole scene
  double moving_seconds_per_ray;  ///< rank 0 packs, sends, receives and unpacks one
  double bytes_out_per_ray, bytes_in_per_ray;
};

/// Rays a second of one call of `rays` on `ranks` ranks, Mode::kReplicate.
double PredictReplicate(const MeasuredRank& measured, const Network& network, int ranks,
                        double rays);

/// What a divided scene adds: how far its rays go.
struct MeasuredDivide {
  double visits_per_ray;  ///< ranks that trace a ray, on `ranks` ranks
  double hops_per_ray;    ///< ranks that a ray goes to
  int ranks;
  double rays_per_second;  ///< that one rank traces, of its part of the scene
  double moving_seconds_per_hop;
  double bytes_per_hop;  ///< there, and the share of the way home
};

/// Rays a second of all ranks together, each with `rays` of its own, Mode::kDivide.
double PredictDivide(const MeasuredDivide& measured, const Network& network, int ranks,
                     double rays);

}  // namespace dacrt::bench

#include "engine/call_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "rays/ray_record.h"

namespace dacrt {
namespace {

/// Rays of a piece over a kept partition. The records of one octant of directions, which are looked
/// at together, take half a megabyte then where directions are even, and stay in a second-level
/// cache. On Sponza diffuse rays took 1,057 ns each in calls of 4,096, 833 in 16,384, 779 in
/// 65,536. To take rays of four pieces together, by octants, gains a tenth or two where they have
/// no order at all, but where neighbours in a call are neighbours in space, fewer of these meet
/// then: of 12.2 million ambient rays a second, a million a call, remained 10.4.
constexpr std::size_t kKeptPieceRays = 65536;
static_assert(kKeptPieceRays <= kMostPieceRays, "lists hold the numbers of a piece's rays");

/// Rays are handed out in rounds, in which each thread gets an equal piece: the first ones hold
/// this part of all, the next ones the same part of what is left, so that pieces are large, for
/// what lists gain from many rays, and threads end together all the same. Hummel, Schonberg, Flynn,
/// "Factoring: a method for scheduling parallel loops", Communications of the ACM, 1992.
constexpr double kPartOfRound = 2.0 / 3;

/// But a thread gets no smaller piece than a sixteenth of its share of the whole, so that it is not
/// busier with pieces than with rays; nor fewer rays than are worth waking it, some 10 us of work.
constexpr std::size_t kLeastPartOfShare = 16;
constexpr std::size_t kFewestShared = 32;
constexpr std::size_t kMostAsLeast = 1024;

/// Pieces of rays that run close together: so many for each thread, of no more than so many rays.
/// The rays of a picture that meet something for the first time cost the most, and lie side by side
/// in it.
constexpr std::size_t kEvenPieces = 16, kMostInEven = 8192;

/// Below this a piece is not worth its call, and there is nothing to gain: the constant part of the
/// workspace is larger.
constexpr std::size_t kLeastPieceRays = 1024;

}  // namespace

CallPlan::CallPlan(std::size_t rays, std::size_t threads, bool keeps, const Settings& settings)
    : piece_rays(std::min<std::size_t>(rays, settings.piece_rays)),
      workers(1),
      rays_(rays),
      can_shrink_(keeps) {
  if (!keeps || rays == 0) return;
  piece_rays = std::min(piece_rays, kKeptPieceRays);
  least_piece_ = std::clamp(rays / (threads * kLeastPartOfShare), kFewestShared, kMostAsLeast);
  workers = std::min(threads, (rays + least_piece_ - 1) / least_piece_);
  piece_rays = NextPiece(rays);
}

std::size_t CallPlan::NextPiece(std::size_t left) const {
  std::size_t count = std::min(left, piece_rays);
  if (workers > 1 && !is_even_) {
    double round = static_cast<double>(rays_);  // left at its beginning
    while (static_cast<double>(left) <= (1 - kPartOfRound) * round) round *= 1 - kPartOfRound;
    const double share = std::ceil(kPartOfRound * round / static_cast<double>(workers));
    count = std::min(count, std::max(static_cast<std::size_t>(share), least_piece_));
  }
  return count;
}

void CallPlan::MakeEven(std::size_t fewest) {
  const std::size_t even = std::clamp(rays_ / (workers * kEvenPieces), fewest, kMostInEven);
  if (even >= piece_rays) return;
  is_even_ = true;
  piece_rays = even;
}

bool CallPlan::Shrink() {
  // Without a kept partition smaller pieces would each partition anew.
  if (!can_shrink_) return false;
  if (workers > 1) {
    workers = 1;
    return true;
  }
  if (piece_rays <= kLeastPieceRays) return false;
  piece_rays = std::max(piece_rays / 4, kLeastPieceRays);
  return true;
}

CallPlan CallPlan::Least(bool keeps, const Settings& settings) {
  CallPlan plan(std::numeric_limits<uint32_t>::max(), 1, keeps, settings);
  while (plan.Shrink()) {
  }
  return plan;
}

}  // namespace dacrt

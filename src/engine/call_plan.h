// How a call is cut into pieces, and how many threads work on them.
#pragma once

#include <cstddef>

#include "dacrt/settings.h"
#include "runtime/workspace.h"

namespace dacrt {

struct CallPlan {
  /// For `rays` rays where `threads` threads are free.
  CallPlan(std::size_t rays, std::size_t threads, bool keeps, const Settings& settings);

  /// The next best plan for less memory: fewer threads, then smaller pieces. False if there is
  /// none.
  bool Shrink();

  /// For rays that run close together, which gain nothing from large pieces: smaller ones of one
  /// size, of so many rays and more, so that threads end together even where some rays cost many
  /// times what others do. Nothing changes where pieces are as small.
  void MakeEven(std::size_t fewest);

  /// The plan that every call can fall back to: one thread, and the smallest pieces.
  static CallPlan Least(bool keeps, const Settings& settings);

  /// How many rays the next piece has where `left` are left.
  std::size_t NextPiece(std::size_t left) const;

  std::size_t piece_rays;  ///< of the largest piece
  std::size_t workers;     ///< threads that each need a workspace

 private:
  std::size_t rays_;
  bool can_shrink_;
  bool is_even_ = false;
  std::size_t least_piece_ = 1;
};

}  // namespace dacrt

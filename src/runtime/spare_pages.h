// Memory that is handed on: what one had is the next one's, as it is.
//
// To touch a page for the first time costs the system a fault and zeros, a tenth of what it takes
// to partition a scene and trace a thousand rays. Where a scene is made anew from frame to frame
// its partition gets what the one before the last had.
#pragma once

#include <array>
#include <cstddef>
#include <mutex>

#include "runtime/memory_account.h"
#include "runtime/pages.h"

namespace dacrt {

/// Of a device. Any number of threads may take pages and keep some.
class SparePages {
 public:
  /// Pages of any content. Throws std::bad_alloc.
  Pages Take(std::size_t bytes, const MemoryAccount* account);

  /// Keeps pages that nobody uses any more, if they are neither few nor very many, in the place of
  /// the oldest ones. The account does not count them from now on, and the system may take them
  /// when it has no others.
  void Keep(Pages&& pages) noexcept;

  /// Gives all back. False if there are none.
  bool Clear() noexcept;

  /// How many are kept.
  std::size_t bytes() const;

 private:
  static constexpr std::size_t kPlaces = 4, kMostBytes = 32 * 1024 * 1024;

  bool TakeKept(std::size_t bytes, Pages& pages);

  mutable std::mutex mutex_;
  std::array<Pages, kPlaces> kept_;  ///< the newest first
};

}  // namespace dacrt

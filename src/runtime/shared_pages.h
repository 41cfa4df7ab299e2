// Small blocks of memory side by side in large pages.
//
// Where a program has a thousand small scenes, and rays come to several of them each, the processor
// waits for the addresses of pages more than for what is in them. A thousand instances of 270
// triangles each, frames of 1K to 100K rays, AVX-512: 1.03 to 1.13 times as fast.
#pragma once

#include <bitset>
#include <cstddef>
#include <map>
#include <mutex>

namespace dacrt {

/// Any number of threads may take blocks and return them.
class SharedPages {
 public:
  /// The largest block: a fifth of a large page at most stays unused behind such ones.
  static constexpr std::size_t kMostBytes = 512 * 1024;

  /// Those of the process. They are there until it ends, also for who ends later.
  static SharedPages& Get();

  SharedPages() = default;
  SharedPages(const SharedPages&) = delete;
  SharedPages& operator=(const SharedPages&) = delete;

  /// Zeros, at the beginning of a page; null if there is no memory.
  std::byte* Take(std::size_t bytes) noexcept;
  void Return(std::byte* block, std::size_t bytes) noexcept;

  /// Large pages that are there: none of which nothing is taken.
  std::size_t large_pages() const { return large_pages_.size(); }

 private:
  static constexpr std::size_t kLargePage = 2 * 1024 * 1024, kUnit = 4096;
  static constexpr std::size_t UnitsOf(std::size_t bytes) { return (bytes + kUnit - 1) / kUnit; }
  using Units = std::bitset<kLargePage / kUnit>;

  /// At the beginning of each large page, in its first unit.
  struct LargePage {
    Units taken;
    Units written;  ///< not zeros any more, unless it is taken
    std::multimap<std::size_t, LargePage*>::iterator place;

    std::byte* unit(std::size_t i) { return reinterpret_cast<std::byte*>(this) + i * kUnit; }
    /// The first of so many in a row that are free.
    std::size_t FindFree(std::size_t units) const;
    std::size_t LongestFree() const;
  };
  static_assert(sizeof(LargePage) <= kUnit);

  static LargePage* Map();
  LargePage* Add();
  void SetPlace(LargePage& page);

  std::mutex mutex_;
  std::multimap<std::size_t, LargePage*> large_pages_;  ///< by the free units in a row
};

}  // namespace dacrt

#include "runtime/shared_pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

#include "runtime/assert.h"

namespace dacrt {

SharedPages& SharedPages::Get() {
  static SharedPages& pages = *new SharedPages;
  return pages;
}

std::size_t SharedPages::LargePage::FindFree(std::size_t units) const {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < taken.size() && i - begin < units; ++i) {
    if (taken[i]) begin = i + 1;
  }
  return begin;
}

std::size_t SharedPages::LargePage::LongestFree() const {
  std::size_t longest = 0, begin = 0;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken[i]) begin = i + 1;
    longest = std::max(longest, i + 1 - begin);
  }
  return longest;
}

/// The system hands out addresses by small pages: of twice as many as are wanted a large page is
/// kept.
SharedPages::LargePage* SharedPages::Map() {
  void* const memory =
      mmap(nullptr, 2 * kLargePage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  auto* const begin = static_cast<std::byte*>(memory);
  const std::size_t before = -reinterpret_cast<std::uintptr_t>(begin) % kLargePage;
  if (before > 0) munmap(begin, before);
  munmap(begin + before + kLargePage, kLargePage - before);
  // Without large pages all still works.
  madvise(begin + before, kLargePage, MADV_HUGEPAGE);
  auto* const page = new (begin + before) LargePage;
  page->taken.set(0);
  return page;
}

SharedPages::LargePage* SharedPages::Add() {
  LargePage* const page = Map();
  if (!page) return nullptr;
  try {
    page->place = large_pages_.emplace(page->LongestFree(), page);
    return page;
  } catch (const std::bad_alloc&) {
    munmap(page, kLargePage);
    return nullptr;
  }
}

void SharedPages::SetPlace(LargePage& page) {
  auto node = large_pages_.extract(page.place);
  node.key() = page.LongestFree();
  page.place = large_pages_.insert(std::move(node));
}

std::byte* SharedPages::Take(std::size_t bytes) noexcept {
  DACRT_ASSERT(bytes > 0 && bytes <= kMostBytes);
  const std::size_t units = UnitsOf(bytes);
  const std::lock_guard lock(mutex_);
  const auto fullest = large_pages_.lower_bound(units);
  LargePage* const page = fullest != large_pages_.end() ? fullest->second : Add();
  if (!page) return nullptr;
  const std::size_t first = page->FindFree(units);
  for (std::size_t i = first; i < first + units; ++i) {
    page->taken.set(i);
    if (page->written[i]) std::memset(page->unit(i), 0, kUnit);
  }
  SetPlace(*page);
  return page->unit(first);
}

void SharedPages::Return(std::byte* block, std::size_t bytes) noexcept {
  const auto address = reinterpret_cast<std::uintptr_t>(block);
  auto* const page = reinterpret_cast<LargePage*>(address / kLargePage * kLargePage);
  const std::size_t first = address % kLargePage / kUnit, units = UnitsOf(bytes);
  const std::lock_guard lock(mutex_);
  for (std::size_t i = first; i < first + units; ++i) {
    page->taken.reset(i);
    page->written.set(i);
  }
  if (page->taken.count() > 1) return SetPlace(*page);
  large_pages_.erase(page->place);
  munmap(page, kLargePage);
}

}  // namespace dacrt

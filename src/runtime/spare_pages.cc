#include "runtime/spare_pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "runtime/assert.h"
#include "runtime/shared_pages.h"

namespace dacrt {

Pages SparePages::Take(std::size_t bytes, const MemoryAccount* account) {
  MemoryClaim claim(bytes, account);
  Pages pages;
  if (TakeKept(bytes, pages)) {
    pages.SetClaim(std::move(claim));
#if defined(DACRT_ASSERTIONS) || !defined(NDEBUG)
    std::memset(pages.data(), 0xA5, bytes);  // nobody shall rely on what there was
#endif
    return pages;
  }
  try {
    return Pages(std::move(claim));
  } catch (const std::bad_alloc&) {
    if (!Clear()) throw;
  }
  return Pages(bytes, account);
}

/// The fewest that suffice, unless most of them would lie idle.
bool SparePages::TakeKept(std::size_t bytes, Pages& pages) {
  const std::lock_guard lock(mutex_);
  Pages* best = nullptr;
  for (Pages& kept : kept_) {
    if (kept.span() < bytes || kept.span() > bytes + bytes / 2) continue;
    if (!best || kept.span() < best->span()) best = &kept;
  }
  if (!best) return false;
  pages = std::move(*best);
  return true;
}

void SparePages::Keep(Pages&& pages) noexcept {
  Pages kept = std::move(pages);
  if (kept.span() <= SharedPages::kMostBytes || kept.span() > kMostBytes) return;
  kept.SetClaim(MemoryClaim());
  if (madvise(kept.data(), kept.span(), MADV_FREE) != 0) return;
  const std::lock_guard lock(mutex_);
  const auto is_empty = [](const Pages& place) { return place.span() == 0; };
  auto place = std::find_if(kept_.begin(), kept_.end(), is_empty);
  if (place == kept_.end()) --place;
  std::swap(*place, kept);
  // What is in its place was the oldest before.
  std::rotate(kept_.begin(), place, place + 1);
}

bool SparePages::Clear() noexcept {
  std::array<Pages, kPlaces> kept;
  const std::lock_guard lock(mutex_);
  std::swap(kept, kept_);
  return std::any_of(kept.begin(), kept.end(), [](const Pages& pages) { return pages.span() > 0; });
}

std::size_t SparePages::bytes() const {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = 0;
  for (const Pages& kept : kept_) bytes += kept.span();
  return bytes;
}

}  // namespace dacrt

#include "trace/learnt.h"

#include <cstddef>
#include <cstdint>
#include <mutex>

#include "runtime/at_thread_end.h"

namespace dacrt {
namespace {

struct Entry {
  const void* scene = nullptr;
  Learnt learnt;
};

constexpr std::size_t kEntries = 8;

thread_local Entry entries[kEntries];

/// What threads that have ended knew: programs that make threads for each frame would have each
/// learn anew.
Entry left[kEntries];
std::mutex left_mutex;

const AtThreadEnd leave([](void* of_thread) {
  const Entry* const own = static_cast<const Entry*>(of_thread);
  const std::lock_guard lock(left_mutex);
  for (std::size_t i = 0; i < kEntries; ++i) {
    if (own[i].scene) left[i] = own[i];
  }
});

[[gnu::noinline]] void Begin(std::size_t place, const void* scene) {
  entries[place] = {scene, {}};
  leave.Call(entries);
  const std::lock_guard lock(left_mutex);
  if (left[place].scene == scene) entries[place] = left[place];
}

}  // namespace

Learnt& LearntAbout(const void* scene) {
  // Scenes are apart by more than what lies below these bits.
  const std::size_t place = reinterpret_cast<std::uintptr_t>(scene) / 256 % kEntries;
  if (entries[place].scene != scene) Begin(place, scene);
  return entries[place].learnt;
}

}  // namespace dacrt

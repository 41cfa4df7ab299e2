#include "trace/learnt.h"

#include <cstddef>
#include <cstdint>

namespace dacrt {

Learnt& LearntAbout(const void* scene) {
  struct Entry {
    const void* scene = nullptr;
    Learnt learnt;
  };
  constexpr std::size_t kEntries = 8;
  static thread_local Entry entries[kEntries];
  // Scenes are apart by more than what lies below these bits.
  Entry& entry = entries[reinterpret_cast<std::uintptr_t>(scene) / 256 % kEntries];
  if (entry.scene != scene) entry = {scene, {}};
  return entry.learnt;
}

}  // namespace dacrt

// Lists of ray numbers: from a node's list and a byte of masks for each ray, which says which of the
// eight children it enters, to the list of a child.

#if defined(DACRT_TRACE_RAY_LISTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_RAY_LISTS_INL_H_
#undef DACRT_TRACE_RAY_LISTS_INL_H_
#else
#define DACRT_TRACE_RAY_LISTS_INL_H_
#endif

#include <hwy/highway.h>

#include "rays/ray_record.h"
#include "trace/trace_task.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Numbers in a vector, of at most 256 bits: longer ones gained nothing.
using NumberTag = hn::CappedTag<RayNumber, 16>;

/// The numbers of `list` whose mask has the bit `child`, in order. Returns how many there are.
HWY_INLINE size_t FilterList(const RayNumber* HWY_RESTRICT list, const uint8_t* HWY_RESTRICT masks,
                             size_t count, size_t child, RayNumber* HWY_RESTRICT out) {
  const NumberTag d;
  const hn::Rebind<uint8_t, NumberTag> d8;
  const auto bit = hn::Set(d, static_cast<RayNumber>(1u << child));
  size_t filtered = 0;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto mask = hn::TestBit(hn::PromoteTo(d, hn::LoadU(d8, masks + i)), bit);
    hn::StoreU(hn::Compress(hn::LoadU(d, list + i), mask), d, out + filtered);
    filtered += hn::CountTrue(d, mask);
  }
  return filtered;
}

/// Cuts arrays off the memory of lists.
template <class T>
HWY_INLINE T* CutList(ListMemory& memory, size_t count) {
  T* const array = reinterpret_cast<T*>(memory.top);
  memory.top += (count * sizeof(T) + 63) / 64 * 64;
  return array;
}

HWY_INLINE bool HasRoom(const ListMemory& memory, size_t bytes) {
  return static_cast<size_t>(memory.end - memory.top) >= bytes;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_RAY_LISTS_INL_H_

// Lists of ray numbers: from a node's list and a byte of masks for each ray, which says which of
// the eight children it enters, to the list of a child.

#if defined(DACRT_TRACE_RAY_LISTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_RAY_LISTS_INL_H_
#undef DACRT_TRACE_RAY_LISTS_INL_H_
#else
#define DACRT_TRACE_RAY_LISTS_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

#include "rays/ray_record.h"
#include "runtime/assert.h"
#include "trace/compress_table.h"
#include "trace/trace_task.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The numbers of `list` whose mask has the bit `child`, in order. Returns how many there are.
HWY_INLINE size_t FilterList(const RayNumber* HWY_RESTRICT list, const uint8_t* HWY_RESTRICT masks,
                             size_t count, size_t child, RayNumber* HWY_RESTRICT out) {
  size_t filtered = 0;
#if HWY_TARGET == HWY_SCALAR
  for (size_t i = 0; i < count; ++i) {
    out[filtered] = list[i];
    filtered += masks[i] >> child & 1;
  }
#elif HWY_TARGET <= HWY_AVX3
  // Numbers of 32 bits are moved by one instruction that all processors with AVX-512 have.
  const __m128i bit = _mm_set1_epi8(static_cast<char>(1u << child));
  for (size_t i = 0; i < count; i += 16) {
    const __m128i all = _mm_loadu_si128(reinterpret_cast<const __m128i*>(masks + i));
    const __mmask16 bits = _mm_test_epi8_mask(all, bit);
    const __m512i numbers =
        _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(list + i)));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + filtered),
                        _mm512_cvtepi32_epi16(_mm512_maskz_compress_epi32(bits, numbers)));
    filtered += hwy::PopCount(bits);
  }
#else
  const hn::FixedTag<RayNumber, 8> d;  // eight numbers in a vector
  const hn::Repartition<uint8_t, decltype(d)> d8;
  for (size_t i = 0; i < count; i += 8) {
    uint64_t bytes;
    memcpy(&bytes, masks + i, sizeof(bytes));
    // The multiplication gathers the lowest bits of the bytes in the highest byte.
    const uint64_t bits = ((bytes >> child & 0x0101010101010101u) * 0x0102040810204080u) >> 56;
    const auto numbers = hn::BitCast(d8, hn::LoadU(d, list + i));
    const auto moved = hn::TableLookupBytes(numbers, hn::Load(d8, kCompressTable.bytes[bits]));
    hn::StoreU(hn::BitCast(d, moved), d, out + filtered);
    filtered += hwy::PopCount(bits);
  }
#endif
  DACRT_ASSERT(filtered <= count);
  return filtered;
}

/// Cuts arrays off the memory of lists.
template <class T>
HWY_INLINE T* CutList(ListMemory& memory, size_t count) {
  T* const array = reinterpret_cast<T*>(memory.top);
  memory.top += (count * sizeof(T) + 63) / 64 * 64;
  DACRT_ASSERT(memory.top <= memory.end);
  return array;
}

HWY_INLINE bool HasRoom(const ListMemory& memory, size_t bytes) {
  return static_cast<size_t>(memory.end - memory.top) >= bytes;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_RAY_LISTS_INL_H_

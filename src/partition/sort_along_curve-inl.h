// Sorting triangles along a curve through their centres.
// Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM
// 1966.

#if defined(DACRT_PARTITION_SORT_ALONG_CURVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SORT_ALONG_CURVE_INL_H_
#undef DACRT_PARTITION_SORT_ALONG_CURVE_INL_H_
#else
#define DACRT_PARTITION_SORT_ALONG_CURVE_INL_H_
#endif

#include <array>
#include <utility>

#include "partition/bin_map-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Of a triangle's number among those of a subset, and of a cell of the curve on an axis: together
/// they fill a word.
inline constexpr uint32_t kNumberBits = 11, kCurveBits = 7;
static_assert(SubsetScratch::kTriangles == 1u << kNumberBits);

/// Sorts the references of a range, which begins with scratch.spare, along a Morton curve into
/// scratch.refs.
inline void SortAlongCurve(const TriangleRange& range, SubsetScratch& scratch) {
  constexpr uint32_t kCells = 1u << kCurveBits;
  // Bits of a number, two places apart.
  static constexpr auto kSpread = [] {
    std::array<uint32_t, kCells> spread{};
    for (uint32_t i = 0; i < kCells; ++i) {
      for (uint32_t bit = 0; bit < kCurveBits; ++bit) spread[i] |= (i >> bit & 1) << (3 * bit);
    }
    return spread;
  }();
  // Cells are cubes: an axis on which triangles hardly differ should not be split as often.
  Box cube = range.centers;
  float size = 0;
  for (int axis = 0; axis < 3; ++axis) size = HWY_MAX(size, cube.upper[axis] - cube.lower[axis]);
  for (int axis = 0; axis < 3; ++axis) cube.upper[axis] = cube.lower[axis] + size;
  const BinMap map(cube, kCells);

  const size_t count = range.count();
  uint32_t places[3][kCells] = {};
  uint32_t* from = scratch.codes[1];
  uint32_t* to = scratch.codes[0];
  for (size_t i = 0; i < count; ++i) {
    const TriangleRef& ref = scratch.spare[i];
    HWY_ALIGN int32_t cell[4];
    map.Map(TwiceCenter(Corner::Load(ref.lower), Corner::Load(ref.upper)), cell);
    const uint32_t code = kSpread[cell[0]] | kSpread[cell[1]] << 1 | kSpread[cell[2]] << 2;
    for (uint32_t digit = 0; digit < 3; ++digit) {
      ++places[digit][code >> (digit * kCurveBits) & (kCells - 1)];
    }
    from[i] = code << kNumberBits | static_cast<uint32_t>(i);
  }
  for (uint32_t digit = 0; digit < 3; ++digit) {
    uint32_t next = 0;
    for (uint32_t& place : places[digit]) next += std::exchange(place, next);
    const uint32_t shift = kNumberBits + digit * kCurveBits;
    for (size_t i = 0; i < count; ++i) {
      to[places[digit][from[i] >> shift & (kCells - 1)]++] = from[i];
    }
    std::swap(from, to);
  }
  // Three passes end where the second one began.
  DACRT_ASSERT(from == scratch.codes[0]);
  for (size_t i = 0; i < count; ++i) {
    scratch.refs[i] = scratch.spare[from[i] & (SubsetScratch::kTriangles - 1)];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SORT_ALONG_CURVE_INL_H_

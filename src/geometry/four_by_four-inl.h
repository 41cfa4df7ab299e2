// Four rows of four values as four columns.

#if defined(DACRT_GEOMETRY_FOUR_BY_FOUR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_FOUR_BY_FOUR_INL_H_
#undef DACRT_GEOMETRY_FOUR_BY_FOUR_INL_H_
#else
#define DACRT_GEOMETRY_FOUR_BY_FOUR_INL_H_
#endif

#include "geometry/corner-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR
/// Of vectors with eight lanes, two such side by side.
template <class Tag>
struct FourByFour {
  hn::Vec<Tag> v[4];

  /// Of four values each at `row(i)`: the first four rows, and beside them the next four.
  template <class Row>
  static HWY_INLINE FourByFour Load(const Row& row) {
    FourByFour rows;
    for (size_t i = 0; i < 4; ++i) {
      if constexpr (hn::MaxLanes(Tag()) == 8) {
        rows.v[i] =
            hn::Combine(Tag(), hn::LoadU(kCornerTag, row(i + 4)), hn::LoadU(kCornerTag, row(i)));
      } else {
        rows.v[i] = hn::LoadU(kCornerTag, row(i));
      }
    }
    return rows;
  }

  HWY_INLINE void Transpose() {
    const Tag d;
    const auto xy01 = hn::InterleaveLower(d, v[0], v[1]), xy23 = hn::InterleaveLower(d, v[2], v[3]);
    const auto zw01 = hn::InterleaveUpper(d, v[0], v[1]), zw23 = hn::InterleaveUpper(d, v[2], v[3]);
    // Four lanes as floats: moving between instructions for floats and for integers takes time.
    if constexpr (hn::MaxLanes(Tag()) == 4) {
      v[0] = hn::ConcatLowerLower(d, xy23, xy01);
      v[1] = hn::ConcatUpperUpper(d, xy23, xy01);
      v[2] = hn::ConcatLowerLower(d, zw23, zw01);
      v[3] = hn::ConcatUpperUpper(d, zw23, zw01);
      return;
    }
    const hn::Repartition<uint64_t, Tag> pairs;
    const auto lower = [&](auto a, auto b) HWY_ATTR {
      return hn::BitCast(d,
                         hn::InterleaveLower(pairs, hn::BitCast(pairs, a), hn::BitCast(pairs, b)));
    };
    const auto upper = [&](auto a, auto b) HWY_ATTR {
      return hn::BitCast(d,
                         hn::InterleaveUpper(pairs, hn::BitCast(pairs, a), hn::BitCast(pairs, b)));
    };
    v[0] = lower(xy01, xy23);
    v[1] = upper(xy01, xy23);
    v[2] = lower(zw01, zw23);
    v[3] = upper(zw01, zw23);
  }
};
#endif

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_FOUR_BY_FOUR_INL_H_

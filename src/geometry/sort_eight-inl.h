// Eight values in order.

#if defined(DACRT_GEOMETRY_SORT_EIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_SORT_EIGHT_INL_H_
#undef DACRT_GEOMETRY_SORT_EIGHT_INL_H_
#else
#define DACRT_GEOMETRY_SORT_EIGHT_INL_H_
#endif

#include "geometry/wide_node-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The places of eight values from the least to the greatest; of equal ones the last comes first.
HWY_INLINE void SortEight(const EightPart (&values)[kParts], uint8_t* order) {
  constexpr size_t kCount = kParts * kPartLanes;
  HWY_ALIGN float each[kCount];
  for (size_t part = 0; part < kParts; ++part) {
    hn::Store(values[part], kEightTag, each + part * kPartLanes);
  }
  // The rank of each is the number of those before it.
  HWY_ALIGN int32_t ranks[kCount];
  const hn::RebindToSigned<EightTag> di;
  for (size_t part = 0; part < kParts; ++part) {
    const auto own = hn::Iota(di, static_cast<int32_t>(part * kPartLanes));
    auto rank = hn::Zero(di);
    for (size_t other = 0; other < kCount; ++other) {
      const EightPart value = hn::Set(kEightTag, each[other]);
      const auto place = hn::Set(di, static_cast<int32_t>(other));
      const auto before =
          hn::Or(hn::RebindMask(di, hn::Lt(value, values[part])),
                 hn::And(hn::RebindMask(di, hn::Eq(value, values[part])), hn::Gt(place, own)));
      rank = hn::Sub(rank, hn::VecFromMask(di, before));
    }
    hn::Store(rank, di, ranks + part * kPartLanes);
  }
  // What is no number has no rank of its own; every place is filled all the same.
  for (size_t i = 0; i < kCount; ++i) order[i] = static_cast<uint8_t>(i);
  for (size_t i = 0; i < kCount; ++i) order[ranks[i] & 7] = static_cast<uint8_t>(i);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_SORT_EIGHT_INL_H_

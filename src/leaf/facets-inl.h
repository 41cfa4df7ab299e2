// The leaf test of facets: triangles, quads and cells of grids. The triangles of the leaf stand in
// the lanes of a vector, and rays come one after the other.

#if defined(DACRT_LEAF_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_FACETS_INL_H_
#undef DACRT_LEAF_FACETS_INL_H_
#else
#define DACRT_LEAF_FACETS_INL_H_
#endif

#include <hwy/cache_control.h>

#include <optional>

#include "leaf/ask_facets-inl.h"
#include "leaf/found_in_part-inl.h"
#include "leaf/own_box-inl.h"
#include "leaf/take_hit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The triangles of a block of moving facets, at one time.
struct TimedFacets {
  HWY_ALIGN float corner[3][3][kLeafLanes];
  uint8_t item[kLeafLanes];
  uint8_t second;
  float time;

  void Gather(const TraceTask& task, const LeafBlock& block, float at_time) {
    const GeometryTable& geometries = task.scene.geometries;
    const Shapes& shapes = geometries.shapes();
    memset(corner, 0, sizeof(corner));
    second = 0;
    time = at_time;
    size_t lane = 0;
    const auto place = [&](const Facet& facet, const int* order, size_t i) {
      for (int c = 0; c < 3; ++c) {
        for (int axis = 0; axis < 3; ++axis) corner[c][axis][lane] = facet.corner[order[c]][axis];
      }
      item[lane++] = static_cast<uint8_t>(i);
    };
    for (size_t i = 0; i < block.lanes; ++i) {
      const GeometryTable::Name name = NameOfLane(task, block, i);
      const std::optional<Moment> moment = shapes.MomentAt(name.geometry, at_time);
      Facet facet;
      if (!moment || !shapes.ReadFacet(name.geometry, name.primitive, *moment, facet)) continue;
      constexpr int kTriangle[3] = {0, 1, 2}, kFirst[3] = {0, 1, 3}, kSecond[3] = {2, 3, 1};
      if (shapes[name.geometry].shape == Shape::kTriangles) {
        place(facet, kTriangle, i);
        continue;
      }
      place(facet, kFirst, i);
      second |= static_cast<uint8_t>(1u << lane);
      place(facet, kSecond, i);
    }
  }

  HWY_INLINE CornerLanes Corners(size_t part) const {
    CornerLanes lanes;
    EightPart* const corners[3] = {lanes.v0, lanes.v1, lanes.v2};
    for (int c = 0; c < 3; ++c) {
      for (int axis = 0; axis < 3; ++axis) {
        corners[c][axis] = hn::Load(kEightTag, corner[c][axis] + part * kPartLanes);
      }
    }
    return lanes;
  }
};

/// Whether masks are asked about each triangle of a block that is met: about those of one geometry
/// they are asked before.
HWY_INLINE bool AsksMasksOfEach(const TraceTask& task, const LeafBlock& block) {
  return task.checks_masks && block.geometry == LeafBlock::kSeveral;
}

template <Query kQuery, bool kRobust>
class FacetTest {
 public:
  FacetTest(const TraceTask& task, ChildWord leaf, const LeafBlock& block)
      : task_(task), leaf_(leaf), block_(block) {}

  /// One ray against facets that do not move, where hits are kept by leaf and lane.
  HWY_INLINE void TestOne(RayNumber number) const {
    switch (LayoutOf(block_)) {
      case CornerLayout::kFew:
        return TestOne<CornerLayout::kFew>(number);
      case CornerLayout::kPrepared:
        return TestOne<CornerLayout::kPrepared>(number);
      case CornerLayout::kByLane:
        return TestOne<CornerLayout::kByLane>(number);
      default:
        return TestOne<CornerLayout::kMany>(number);
    }
  }

  void Test(const RayNumber* list, size_t count) const {
    if (HWY_UNLIKELY(block_.is_timed)) return TestTimed(list, count);
    if (HWY_UNLIKELY(block_.kind == LeafKind::kMovingFacets)) return TestMoving(list, count);
    if (HWY_UNLIKELY(task_.AsksFilters(kQuery))) {
      FetchForFilters(list, count);
      if (count > 1 && task_.keeps_leaf_hits && !AsksMasks()) return TestAsking(list, count);
    }
    if (HWY_LIKELY(task_.keeps_leaf_hits)) return TestStill<true>(list, count);
    TestStill<false>(list, count);
  }

  /// Offers a closest-hit ray a triangle of the block that it meets, of which no more is kept than
  /// which it is.
  HWY_INLINE void TakeInLeaf(RayNumber number, float key, bool within_limit,
                             size_t block_lane) const {
    RayRecord& ray = task_.rays[number];
    if (HWY_UNLIKELY(AsksMasks()) &&
        !MayMeet(task_, ray, GeometryOfLane(task_, block_, block_lane))) {
      return;
    }
    const Closeness closeness = Compare(ray, key, within_limit);
    if (closeness == Closeness::kFarther) return;
    if (HWY_UNLIKELY(closeness == Closeness::kEqual) && !ComesFirstInLeaf(number, block_lane)) {
      return;
    }
    SetHit(ray, key,
           RayRecord::kInLeaf | static_cast<uint32_t>(block_lane << RayRecord::kLaneShift),
           leaf_.bits());
  }

  /// Offers a ray a candidate with what the triangle test has found, and the number of its item.
  static void Offer(const TraceTask& task, RayNumber number, Candidate& candidate, bool is_second) {
    if (is_second) {
      candidate.u = 1 - candidate.u;
      candidate.v = 1 - candidate.v;
    }
    const Shapes& shapes = task.scene.geometries.shapes();
    if (shapes[candidate.geometry].shape == Shape::kGrids) {
      candidate.primitive_id =
          shapes.PlaceInGrid(candidate.geometry, candidate.primitive_id, candidate.u, candidate.v);
    }
    TakeHit<kQuery>(task, number, candidate);
  }

 private:
  static constexpr size_t kAhead = 4;

  HWY_INLINE bool AsksMasks() const { return AsksMasksOfEach(task_, block_); }
  /// Whether the mask of a ray excludes all of the block, which is of one geometry.
  HWY_INLINE bool IsExcluded(const RayRecord& ray) const {
    return HWY_UNLIKELY(task_.checks_masks) && block_.geometry != LeafBlock::kSeveral &&
           !MayMeet(task_, ray, block_.geometry);
  }

  template <CornerLayout kLayout>
  HWY_INLINE void TestOne(RayNumber number) const {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      const LeafCorners<kLayout> corners{block_, part};
      TestRay<true>(number, corners.Triangles(), corners.Again(), part, nullptr);
    }
  }

  template <bool kInLeaf>
  HWY_INLINE void TestStill(const RayNumber* list, size_t count) const {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      const CornerLanes corners = DecodeCorners(block_, part);
      const auto triangles = corners.Triangles();
      const CornersAndBoxes boxes(corners);
      for (size_t i = 0; i < count; ++i) {
        Fetch(list, i + kAhead, count);
        TestRay<kInLeaf>(list[i], triangles, boxes, part, nullptr);
      }
    }
  }

  /// Several rays that do not move, where filter functions are asked.
  HWY_NOINLINE void TestAsking(const RayNumber* list, size_t count) const {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      const CornerLanes corners = DecodeCorners(block_, part);
      const auto triangles = corners.Triangles();
      const CornersAndBoxes boxes(corners);
      const FilteredPart<kQuery, CornersAndBoxes> filtered(task_, leaf_, block_, part, triangles,
                                                           boxes);
      const auto resume = [&](RayNumber number, uint64_t lanes) HWY_ATTR {
        FacetCrossing crossing =
            CrossFacets<kRobust>(SpreadRay{task_.rays[number]}, triangles, boxes);
        crossing.lanes &= lanes;
        TakeCrossed<true>(number, crossing, triangles, boxes, part, nullptr);
      };
      AskTogether ask(task_, filtered, resume);
      for (size_t i = 0; i < count; ++i) {
        Fetch(list, i + kAhead, count);
        const RayRecord& ray = task_.rays[list[i]];
        if (MeetsNothing(ray)) continue;
        FacetCrossing crossing = CrossFacets<kRobust>(SpreadRay{ray}, triangles, boxes);
        if (HWY_UNLIKELY(crossing.lanes != 0)) ask.Add(list[i], crossing);
      }
      ask.Ask();
    }
  }

  HWY_INLINE void Fetch(const RayNumber* list, size_t i, size_t count) const {
    hwy::Prefetch(&task_.rays[list[i < count ? i : count - 1]]);
  }

  /// What filter functions will ask: names, and what only they want to know of rays.
  HWY_INLINE void FetchForFilters(const RayNumber* list, size_t count) const {
    hwy::Prefetch(task_.partition.order + block_.first);
    for (size_t i = 0; i < count; ++i) {
      if (task_.callers) hwy::Prefetch(task_.callers + list[i]);
      if (task_.tags) hwy::Prefetch(task_.tags + list[i]);
    }
  }

  void TestTimed(const RayNumber* list, size_t count) const {
    TimedFacets facets;
    for (size_t i = 0; i < count; ++i) {
      const float time = task_.rays[list[i]].time;
      if (i == 0 || time != facets.time) facets.Gather(task_, block_, time);
      for (size_t part = 0; part < kParts; ++part) {
        const CornerLanes corners = facets.Corners(part);
        TestRay<false>(list[i], corners.Triangles(), corners, part, &facets);
      }
    }
  }

  void TestMoving(const RayNumber* list, size_t count) const {
    const TimeSteps steps = task_.scene.geometries.shapes().StepsOf(block_.geometry);
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      uint32_t step = UINT32_MAX;  // none yet
      CornerLanes begin, end;
      for (size_t i = 0; i < count; ++i) {
        Fetch(list, i + kAhead, count);
        const std::optional<Moment> moment = steps.At(task_.rays[list[i]].time);
        if (!moment) continue;
        if (moment->step != step) {
          step = moment->step;
          begin = DecodeCorners(block_, part, step);
          end = DecodeCorners(block_, part, step + 1);
        }
        const CornerLanes corners = Interpolate(begin, end, moment->fraction);
        TestRay<false>(list[i], corners.Triangles(), corners, part, nullptr);
      }
    }
  }

  /// With kInLeaf, hits are kept by leaf and lane, unless a filter function may change them: not
  /// where what is hit depends on the time.
  template <bool kInLeaf, class Corners>
  HWY_INLINE void TestRay(RayNumber number, const TestTrianglesOf<EightPart>& triangles,
                          const Corners& corners, size_t part, const TimedFacets* timed) const {
    const RayRecord& ray = task_.rays[number];
    if (MeetsNothing(ray)) return;
    FacetCrossing crossing = CrossFacets<kRobust>(SpreadRay{ray}, triangles, corners);
    if (HWY_LIKELY(crossing.lanes == 0)) return;
    TakeCrossed<kInLeaf>(number, crossing, triangles, corners, part, timed);
  }

  /// Whether a ray meets nothing more of the block: it is blocked, or excluded.
  HWY_INLINE bool MeetsNothing(const RayRecord& ray) const {
    return (kQuery == Query::kAny && ray.tfar < 0) || IsExcluded(ray);
  }

  /// Offers a ray the triangles that it meets.
  template <bool kInLeaf, class Corners>
  HWY_INLINE void TakeCrossed(RayNumber number, FacetCrossing& crossing,
                              const TestTrianglesOf<EightPart>& triangles, const Corners& corners,
                              size_t part, const TimedFacets* timed) const {
    if constexpr (kInLeaf) {
      if (HWY_UNLIKELY(task_.AsksFilters(kQuery))) {
        const FilteredPart<kQuery, Corners> filtered(task_, leaf_, block_, part, triangles,
                                                     corners);
        if (!AsksMasks() && filtered.Ask(number, crossing)) return;
      } else if constexpr (kQuery == Query::kClosest) {
        if (HWY_LIKELY(TakeNearest(number, crossing, corners, part))) return;
      }
    }
    const EightPart keys = KeepInOwnBoxes(SpreadRay{task_.rays[number]}, corners, crossing);
    if (crossing.lanes != 0) TakeCrossing<kInLeaf>(number, crossing, keys, triangles, part, timed);
  }

  /// Offers a closest-hit ray what it meets, where no more is to be asked than whether the nearest
  /// triangle counts; false, and nothing was done, where there is.
  template <class Corners>
  HWY_INLINE bool TakeNearest(RayNumber number, const FacetCrossing& crossing,
                              const Corners& corners, size_t part) const {
    if (HWY_UNLIKELY(AsksMasks())) return false;
    RayRecord& ray = task_.rays[number];
    float nearest;
    size_t lane;
    if (HWY_UNLIKELY(!crossing.FindFirst<kQuery>(ray, nearest, lane))) return false;
    if (lane == kPartLanes) return true;
    const size_t block_lane = part * kPartLanes + lane;
    if (!task_.asks_boxes_last &&
        HWY_UNLIKELY(!EntersOwnBox(SpreadRay{ray}, corners, block_, block_lane, nearest))) {
      return false;
    }
    SetHit(ray, nearest,
           RayRecord::kInLeaf | static_cast<uint32_t>(block_lane << RayRecord::kLaneShift),
           leaf_.bits());
    return true;
  }

  template <bool kInLeaf>
  HWY_INLINE void TakeCrossing(RayNumber number, const FacetCrossing& crossing, EightPart its_keys,
                               const TestTrianglesOf<EightPart>& triangles, size_t part,
                               const TimedFacets* timed) const {
    const RayRecord& ray = task_.rays[number];
    // Any hit needs no more than the lane, which is the block's unless facets were gathered for a
    // time.
    const bool names_wait = kInLeaf || (kQuery == Query::kAny && timed == nullptr);
    if (!names_wait || HWY_UNLIKELY(task_.AsksFilters(kQuery))) {
      TakeLanes<kInLeaf>(number, crossing, its_keys, triangles, part, timed);
    } else if constexpr (kQuery == Query::kAny) {
      BlockInLeaf(number, crossing.lanes & crossing.within_limit, part);
    } else {
      HWY_ALIGN float keys[kPartLanes];
      hn::Store(its_keys, kEightTag, keys);
      for (uint64_t lanes = crossing.lanes; lanes != 0; lanes &= lanes - 1) {
        size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
        if (HWY_UNLIKELY(keys[lane] == ray.tfar)) {
          lanes = OneOfEqual(lanes, crossing.within_limit, keys, part);
          lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
        }
        TakeInLeaf(number, keys[lane], (crossing.within_limit >> lane) & 1,
                   part * kPartLanes + lane);
      }
    }
  }

  /// Lanes that a ray meets, but of those that it meets where it meets the first of them only one:
  /// where thousands of triangles coincide, the hit that a ray has is compared with one a leaf.
  HWY_NOINLINE uint64_t OneOfEqual(uint64_t lanes, uint64_t within_limit, const float* keys,
                                   size_t part) const {
    const size_t first = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
    const auto is_equal = hn::Eq(hn::Load(kEightTag, keys), hn::Set(kEightTag, keys[first]));
    const uint64_t equal = Bits(kEightTag, is_equal) & lanes;
    const uint64_t within = equal & within_limit;
    if (HWY_LIKELY((equal & (equal - 1)) == 0) || (within != 0 && within != equal) || AsksMasks() ||
        !task_.scene.geometries.all_fill_one_lane()) {
      return lanes;
    }
    return (lanes & ~equal) | LeastNumber(equal, part);
  }

  /// Of some lanes that whose triangle has the least number, as a bit.
  HWY_INLINE uint64_t LeastNumber(uint64_t lanes, size_t part) const {
    const hn::RebindToUnsigned<EightTag> du;
    const hn::RebindToSigned<EightTag> di;
    const auto shift = hn::Iota(du, static_cast<uint32_t>(part * kPartLanes));
    const auto place = hn::Add(
        hn::Set(du, block_.first),
        hn::And(hn::Shr(hn::Set(du, block_.items), hn::ShiftLeft<2>(shift)), hn::Set(du, 15)));
    const auto number = hn::And(hn::GatherIndex(du, task_.partition.order, hn::BitCast(di, place)),
                                hn::Set(du, ~KeptOrder::kLastOfLeaf));
    const auto among = hn::IfThenElse(hn::RebindMask(du, MaskOf(kEightTag, lanes)), number,
                                      hn::Set(du, UINT32_MAX));
    const auto least = hn::Set(du, hn::GetLane(hn::MinOfLanes(du, among)));
    return Bits(kEightTag, hn::RebindMask(kEightTag, hn::Eq(among, least)));
  }

  /// Whether a filter function is to be asked about hits of a lane.
  bool IsFiltered(size_t block_lane) const {
    const uint32_t geometry = GeometryOfLane(task_, block_, block_lane);
    return static_cast<bool>(FilterOf<kQuery>(task_.scene.geometries.shapes()[geometry]));
  }

  /// Blocks an any-hit ray, if its mask allows one of some lanes.
  HWY_INLINE void BlockInLeaf(RayNumber number, uint64_t lanes, size_t part) const {
    RayRecord& ray = task_.rays[number];
    if (HWY_UNLIKELY(AsksMasks())) {
      lanes = LanesOfMask(task_.scene.geometries, task_.partition.order, block_, part * kPartLanes,
                          ray.mask, lanes);
    }
    if (lanes != 0) ray.tfar = -std::numeric_limits<float>::infinity();
  }

  template <bool kInLeaf>
  HWY_NOINLINE void TakeLanes(RayNumber number, const FacetCrossing& crossing, EightPart keys,
                              const TestTrianglesOf<EightPart>& triangles, size_t part,
                              const TimedFacets* timed) const {
    HWY_ALIGN float key[kPartLanes], t[kPartLanes], u[kPartLanes], v[kPartLanes];
    HWY_ALIGN float ng[3][kPartLanes];
    const EightPart one = hn::Set(kEightTag, 1.0f);
    hn::Store(keys, kEightTag, key);
    hn::Store(crossing.t, kEightTag, t);
    hn::Store(hn::Min(hn::Div(crossing.u, crossing.divisor), one), kEightTag, u);
    hn::Store(hn::Min(hn::Div(crossing.v, crossing.divisor), one), kEightTag, v);
    for (int axis = 0; axis < 3; ++axis) hn::Store(triangles.ng[axis], kEightTag, ng[axis]);
    // Near ones first, because a filter function may end the ray, and counts what it sees.
    for (uint64_t lanes = crossing.lanes; lanes != 0;) {
      const size_t nearest = NearestLane(lanes, key);
      lanes &= ~(uint64_t{1} << nearest);
      const size_t block_lane = part * kPartLanes + nearest;
      if (kInLeaf && !IsFiltered(block_lane)) {
        const bool within_limit = (crossing.within_limit >> nearest) & 1;
        if constexpr (kQuery == Query::kAny) {
          BlockInLeaf(number, uint64_t{within_limit} << nearest, part);
        } else {
          TakeInLeaf(number, key[nearest], within_limit, block_lane);
        }
        continue;
      }
      Candidate candidate;
      candidate.within_limit = (crossing.within_limit >> nearest) & 1;
      candidate.key = key[nearest];
      candidate.t = t[nearest];
      candidate.u = u[nearest];
      candidate.v = v[nearest];
      for (int axis = 0; axis < 3; ++axis) candidate.ng[axis] = ng[axis][nearest];
      Take(number, candidate, block_lane, timed);
    }
  }

  /// ComesFirst for a lane of this leaf.
  HWY_NOINLINE bool ComesFirstInLeaf(RayNumber number, size_t block_lane) const {
    RayRecord& ray = task_.rays[number];
    const ChildWord other_leaf(ray.hit);
    constexpr uint32_t kWhose = RayRecord::kInLeaf | RayRecord::kOfOuter;
    if ((ray.state & kWhose) == RayRecord::kInLeaf && other_leaf.IsBlock()) {
      // Names tell nearly always, and cost less than the hits; numbers in their place, less again.
      const LeafBlock& other_block = FacetsOf(task_, other_leaf);
      const size_t other_lane = ray.state >> RayRecord::kLaneShift;
      if (task_.scene.geometries.all_fill_one_lane()) {
        const uint32_t* const order = task_.partition.order;
        return NumberOfLane(order, block_, block_lane) <
               NumberOfLane(order, other_block, other_lane);
      }
      const GeometryTable::Name own = NameOfLane(task_, block_, block_lane);
      const GeometryTable::Name other = NameOfLane(task_, other_block, other_lane);
      if (own.geometry != other.geometry) return own.geometry < other.geometry;
      if (task_.scene.geometries.shapes()[own.geometry].shape != Shape::kGrids &&
          own.primitive != other.primitive) {
        return own.primitive < other.primitive;
      }
    }
    const RayRecord now = ray;
    ray.state = RayRecord::kInLeaf | static_cast<uint32_t>(block_lane << RayRecord::kLaneShift);
    ray.hit = leaf_.bits();
    uint32_t geometry;
    const FullHit found = FinishHit(task_, number, geometry);
    ray = now;
    return ComesFirst(task_, number, found, geometry);
  }

  void Take(RayNumber number, Candidate& candidate, size_t block_lane,
            const TimedFacets* timed) const {
    const uint8_t second = timed ? timed->second : block_.second;
    const GeometryTable::Name name =
        NameOfLane(task_, block_, timed ? timed->item[block_lane] : block_lane);
    candidate.geometry = name.geometry;
    candidate.primitive_id = name.primitive;
    Offer(task_, number, candidate, second >> block_lane & 1);
  }

  const TraceTask& task_;
  const ChildWord leaf_;
  const LeafBlock& block_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_FACETS_INL_H_

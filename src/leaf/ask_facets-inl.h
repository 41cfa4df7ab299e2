// Filter functions about what rays meet in a part of a block of facets that do not move.

#if defined(DACRT_LEAF_ASK_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_ASK_FACETS_INL_H_
#undef DACRT_LEAF_ASK_FACETS_INL_H_
#else
#define DACRT_LEAF_ASK_FACETS_INL_H_
#endif

#include <limits>

#include "leaf/callback_packet.h"
#include "leaf/found_in_part-inl.h"
#include "leaf/own_box-inl.h"
#include "leaf/take_hit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// One ray after the other, each from near to far. Masks are not asked about: a ray that comes here
/// may meet all of the block.
template <Query kQuery, class Corners>
class FilteredPart {
 public:
  FilteredPart(const TraceTask& task, ChildWord leaf, const LeafBlock& block, size_t part,
               const TestTrianglesOf<EightPart>& triangles, const Corners& corners)
      : task_(task),
        leaf_(leaf),
        block_(block),
        part_(part),
        triangles_(triangles),
        corners_(corners) {}

  /// What comes next for a ray.
  enum class Next {
    kQuestion,
    kNothing,
    kNames,  ///< or keys: not the nearest by its distance comes first
  };

  /// Where a hit that is shown stands.
  struct Place {
    float key;
    size_t block_lane;
  };

  /// Takes from `crossing` what a filter function is to be asked about.
  HWY_INLINE Next Find(RayNumber number, FacetCrossing& crossing, ShownHit& shown,
                       Place& place) const {
    RayRecord& ray = task_.rays[number];
    while (crossing.lanes != 0) {
      size_t lane;
      if (HWY_UNLIKELY(!crossing.FindFirst<kQuery>(ray, place.key, lane))) return Next::kNames;
      if (lane == kPartLanes) return Next::kNothing;
      place.block_lane = part_ * kPartLanes + lane;
      if (HWY_UNLIKELY(
              !EntersOwnBox(SpreadRay{ray}, corners_, block_, place.block_lane, place.key))) {
        return Next::kNames;
      }
      crossing.lanes ^= uint64_t{1} << lane;
      const GeometryTable::Name name = NameOfLane(task_, block_, place.block_lane);
      if (HWY_UNLIKELY(!FilterAbout(name.geometry))) {
        Take(ray, place);
        return Next::kNothing;
      }
      FoundInPart found;
      found.Keep(crossing, triangles_.ng);
      const bool is_second = block_.second >> place.block_lane & 1;
      shown = {number, name.geometry,
               found.Hit(lane, task_.scene, task_.instance_id, name, is_second)};
      return Next::kQuestion;
    }
    return Next::kNothing;
  }

  const Callback& FilterAbout(uint32_t geometry) const {
    return FilterOf<kQuery>(task_.scene.geometries.shapes()[geometry]);
  }

  /// Gives a ray what it was asked about, and has been accepted as `answer`. Returns whether the
  /// ray is done with the part: it may still meet something nearer than what was moved away.
  HWY_INLINE bool TakeAnswer(const ShownHit& shown, const Place& place,
                             const FullHit& answer) const {
    RayRecord& ray = task_.rays[shown.ray];
    if (kQuery == Query::kAny || HWY_LIKELY(IsSame(answer, shown.hit))) {
      Take(ray, place);
      return true;
    }
    SetHit(ray, answer.t != shown.hit.t ? answer.t : place.key, 0, shown.geometry);
    task_.hits[shown.ray] = answer;
    return false;
  }

  /// Asks about what one ray meets. False where names decide; then `crossing` is what is left.
  HWY_NOINLINE bool Ask(RayNumber number, FacetCrossing& crossing) const {
    for (;;) {
      ShownHit shown;
      Place place;
      const Next next = Find(number, crossing, shown, place);
      if (next != Next::kQuestion) return next == Next::kNothing;
      FullHit hit = shown.hit;
      const Callback& filter = FilterAbout(shown.geometry);
      if (PassesFilter(task_, filter, kQuery, number, shown.geometry, hit) &&
          TakeAnswer(shown, place, hit)) {
        return true;
      }
    }
  }

 private:
  /// Gives a ray what it meets first.
  HWY_INLINE void Take(RayRecord& ray, const Place& place) const {
    if constexpr (kQuery == Query::kAny) {
      ray.tfar = -std::numeric_limits<float>::infinity();
    } else {
      SetHit(ray, place.key,
             RayRecord::kInLeaf | static_cast<uint32_t>(place.block_lane << RayRecord::kLaneShift),
             leaf_.bits());
    }
  }

  const TraceTask& task_;
  const ChildWord leaf_;
  const LeafBlock& block_;
  const size_t part_;
  const TestTrianglesOf<EightPart>& triangles_;
  const Corners& corners_;
};

/// Several rays, about what each meets first: as many at once as a packet holds. `resume(number,
/// lanes)` is called, sooner or later, for those that are not done and meet more.
template <Query kQuery, class Corners, class Resume>
class AskTogether {
 public:
  using Part = FilteredPart<kQuery, Corners>;

  AskTogether(const TraceTask& task, const Part& part, const Resume& resume)
      : task_(task), part_(part), resume_(resume), most_(task.frame.options.callback_width) {}

  HWY_INLINE void Add(RayNumber number, FacetCrossing& crossing) {
    const typename Part::Next next = part_.Find(number, crossing, shown_[count_], places_[count_]);
    if (HWY_UNLIKELY(next == Part::Next::kNames)) return resume_(number, crossing.lanes);
    if (next == Part::Next::kNothing) return;
    left_[count_++] = crossing.lanes;
    if (count_ == most_) Ask();
  }

  /// About those that have not been asked about yet.
  void Ask() {
    for (size_t begin = 0, end; begin < count_; begin = end) {
      // A packet is about one geometry.
      const uint32_t geometry = shown_[begin].geometry;
      for (end = begin + 1; end < count_ && shown_[end].geometry == geometry;) ++end;
      FullHit answers[CallbackPacket::kMostLanes];
      const uint32_t accepted = ShowHits(task_, part_.FilterAbout(geometry), kQuery,
                                         {shown_ + begin, end - begin}, answers);
      for (size_t i = begin; i < end; ++i) {
        const size_t turn = i - begin;
        const bool is_done =
            (accepted >> turn & 1) != 0 && part_.TakeAnswer(shown_[i], places_[i], answers[turn]);
        if (!is_done && left_[i] != 0) resume_(shown_[i].ray, left_[i]);
      }
    }
    count_ = 0;
  }

 private:
  const TraceTask& task_;
  const Part& part_;
  const Resume& resume_;
  const size_t most_;
  size_t count_ = 0;
  ShownHit shown_[CallbackPacket::kMostLanes];
  typename Part::Place places_[CallbackPacket::kMostLanes];
  uint64_t left_[CallbackPacket::kMostLanes];  ///< lanes that the ray meets besides
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_ASK_FACETS_INL_H_

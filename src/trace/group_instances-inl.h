// A group of rays in an instance: transformed in its lanes, and traced there as a group.

#if defined(DACRT_TRACE_GROUP_INSTANCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_INSTANCES_INL_H_
#undef DACRT_TRACE_GROUP_INSTANCES_INL_H_
#else
#define DACRT_TRACE_GROUP_INSTANCES_INL_H_
#endif

#include "leaf/instances-inl.h"
#include "trace/group_hits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery, size_t kMost>
class GroupTracer;

/// Rays as they are in the space of an instance, with the bits that InstanceTransform gives them,
/// and the hits that they have outside.
template <size_t kMost>
HWY_INLINE void TransformLanes(const AffineTransform& transform, const GroupLanes<kMost>& outer,
                               GroupLanes<kMost>& inner) {
  inner.SetCount(outer.parts() * Lanes());
  for (size_t first = 0; first < outer.parts() * Lanes(); first += Lanes()) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto map = [&](const float(*vector)[kMost], V value) HWY_ATTR {
        for (size_t i = 3; i-- > 0;) {
          value = hn::MulAdd(hn::Load(kFloat, vector[i] + first),
                             hn::Set(kFloat, transform.column[i][axis]), value);
        }
        return value;
      };
      const V dir = map(outer.dir, hn::Zero(kFloat));
      hn::Store(map(outer.org, hn::Set(kFloat, transform.column[3][axis])), kFloat,
                inner.org[axis] + first);
      hn::Store(dir, kFloat, inner.dir[axis] + first);
      hn::Store(SafeReciprocal(dir), kFloat, inner.reciprocal[axis] + first);
    }
    const auto copy = [&](auto tag, const auto& from, auto& to)
                          HWY_ATTR { hn::Store(hn::Load(tag, from + first), tag, to + first); };
    copy(kFloat, outer.start, inner.start);
    copy(kFloat, outer.tnear, inner.tnear);
    copy(kFloat, outer.tfar, inner.tfar);
    copy(kFloat, outer.time, inner.time);
    copy(kUint, outer.mask, inner.mask);
    copy(kUint, outer.hit, inner.hit);
    const auto state = hn::Load(kUint, outer.state + first);
    const auto has_hit = hn::TestBit(state, hn::Set(kUint, RayRecord::kHasHit));
    const auto of_outer = hn::IfThenElseZero(has_hit, hn::Set(kUint, RayRecord::kOfOuter));
    hn::Store(hn::Or(state, of_outer), kUint, inner.state + first);
  }
}

/// Those of some lanes that enter the bounds of an item of a block.
template <size_t kMost>
HWY_INLINE LaneMask EnterItem(const GroupLanes<kMost>& lanes, const LeafBlock& block, size_t i,
                              LaneMask active) {
  const float* const data = block.bounds_data() + i;
  WideBox box;
  for (size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = WidenDown(hn::Set(kFloat, data[axis * block.lanes]));
    box.upper[axis] = WidenUp(hn::Set(kFloat, data[(3 + axis) * block.lanes]));
  }
  LaneMask entering = 0;
  for (size_t part = 0; part < lanes.parts(); ++part) {
    V org[3], reciprocal[3];
    lanes.LoadPart(part, org, reciprocal);
    const size_t first = part * Lanes();
    entering |=
        Bits(Enters(IntersectBox(box, org, reciprocal), hn::Load(kFloat, lanes.tnear + first),
                    hn::Load(kFloat, lanes.tfar + first)))
        << first;
  }
  return active & entering;
}

/// The rays of some lanes in an instance that does not move. Lanes of hits of the outer scene have
/// records, whose numbers are `numbers`.
template <Query kQuery, size_t kMost>
class GroupInInstance {
 public:
  GroupInInstance(const TraceTask& task, const InstanceLeaf& leaf, uint32_t geometry,
                  const RayNumber* numbers)
      : outer_(task),
        numbers_(numbers),
        leaf_(leaf),
        task_(TaskInInstance(task, geometry, *leaf.scene, leaf.partition, numbers)) {}

  /// Whether a group of so many vectors can go into a scene: user functions are shown what a ray
  /// has hit outside, which its lane does not say.
  static bool CanBe(const TraceTask& task, const InstanceLeaf& leaf, size_t parts) {
    return HWY_NATIVE_FMA && leaf.all && !leaf.scene->geometries.shapes().has_user_primitives() &&
           task.instance_memory.count >= parts * Lanes();
  }

  void Trace(GroupLanes<kMost>& outer, GroupLanes<kMost>& inner, LaneMask active,
             ListMemory memory) {
    GroupTracer<kQuery, kMost>(task_, inner).TraceLanes(leaf_.Root(), active, memory);
    for (size_t first = 0; first < outer.parts() * Lanes(); first += Lanes()) {
      const V own = hn::Load(kFloat, outer.tfar + first);
      const V tfar = hn::Min(own, hn::Load(kFloat, inner.tfar + first));
      hn::Store(hn::IfThenElse(MaskOf(active >> first), tfar, own), kFloat, outer.tfar + first);
    }
    if constexpr (kQuery == Query::kClosest) TakeHits(outer, inner, active);
  }

 private:
  void TakeHits(GroupLanes<kMost>& outer, const GroupLanes<kMost>& inner, LaneMask active) {
    LaneMask in_lanes = 0;
    const LaneMask of_outer = inner.LanesInState(active, RayRecord::kOfOuter);
    ForEachLane(inner.LanesInState(active, RayRecord::kHasHit) & ~of_outer, [&](size_t lane) {
      const uint32_t state = inner.state[lane];
      if (!(state & RayRecord::kInLeaf)) {
        Take(outer, inner, lane, inner.hit[lane], task_.hits[lane]);
      } else if (state & RayRecord::kInLanes) {
        in_lanes |= LaneMask{1} << lane;
      } else {
        uint32_t geometry;
        const FullHit hit = task_.finish_hit(task_, static_cast<RayNumber>(lane), geometry);
        Take(outer, inner, lane, geometry, hit);
      }
    });
    if (in_lanes == 0) return;
    const GroupHits<kMost> found(task_, inner, in_lanes);
    ForEachLane(in_lanes, [&](size_t lane) {
      LeafRoom room;
      const LeafBlock& block = FacetsOf(task_, ChildWord(inner.hit[lane]), room);
      const size_t block_lane = inner.state[lane] >> RayRecord::kLaneShift;
      Take(outer, inner, lane, GeometryOfLane(task_, block, block_lane), found.Get(lane));
    });
  }

  void Take(GroupLanes<kMost>& outer, const GroupLanes<kMost>& inner, size_t lane,
            uint32_t geometry, const FullHit& hit) const {
    outer.state[lane] = RayRecord::kHasHit | (inner.state[lane] & RayRecord::kAtLimit);
    outer.hit[lane] = geometry;
    outer_.hits[numbers_[lane]] = hit;
  }

  const TraceTask& outer_;
  const RayNumber* const numbers_;
  const InstanceLeaf& leaf_;
  const TraceTask task_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_INSTANCES_INL_H_

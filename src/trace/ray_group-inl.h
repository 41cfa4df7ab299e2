// The rays of a group on their way: in lanes, where one needs it also as a record, and where the
// program's functions are called as packets.

#if defined(DACRT_TRACE_RAY_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_RAY_GROUP_INL_H_
#undef DACRT_TRACE_RAY_GROUP_INL_H_
#else
#define DACRT_TRACE_RAY_GROUP_INL_H_
#endif

#include <optional>

#include "trace/group_packets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

class RayGroup {
 public:
  RayGroup(const TraceTask& task, GroupLanes& lanes) : task_(task), lanes_(lanes) {}

  /// The rays of some lanes, which the caller has loaded. One that needs a record of its own gets
  /// task.rays[lane].
  void BeginLanes(uint32_t active) {
    numbers_ = kLanes;
    with_record_ = 0;
    all_ = active;
  }

  /// The rays `numbers[0]` to `numbers[count - 1]` of the task, at most kGroupRays.
  void BeginRecords(const RayNumber* numbers, size_t count) {
    numbers_ = numbers;
    with_record_ = UINT32_MAX;
    lanes_.SetCount(count);
    for (size_t lane = 0; lane < lanes_.parts() * Lanes(); ++lane) {
      lanes_.Load(lane, task_.rays[numbers[lane < count ? lane : 0]]);
    }
  }

  const TraceTask& task() const { return task_; }
  GroupLanes& lanes() const { return lanes_; }
  /// Of the records of the rays in the lanes.
  const RayNumber* numbers() const { return numbers_; }
  /// Whether the record of a lane holds the ray, if not its hit.
  bool HasRecord(size_t lane) const { return (with_record_ >> lane & 1) != 0; }

  /// The record of the ray in a lane, as it stands now.
  RayRecord& RecordOf(size_t lane) {
    RayRecord& ray = task_.rays[numbers_[lane]];
    if (with_record_ >> lane & 1) {
      lanes_.StoreHit(lane, ray);
    } else {
      lanes_.Store(lane, ray);
      with_record_ |= 1u << lane;
    }
    return ray;
  }

  /// The numbers of the rays in some lanes, whose records stand as the rays do.
  HWY_INLINE size_t ListOf(uint32_t lanes, RayNumber* list) {
    size_t count = 0;
    ForEachLane(lanes, [&](size_t lane) {
      RecordOf(lane);
      list[count++] = numbers_[lane];
    });
    return count;
  }
  HWY_INLINE void LoadHits(uint32_t lanes) {
    ForEachLane(lanes, [&](size_t lane) { lanes_.LoadHit(lane, task_.rays[numbers_[lane]]); });
  }

  /// `test(list, count)` tests the rays of some lanes by their records, to which their numbers
  /// lead.
  template <class Test>
  HWY_INLINE void TestRecords(uint32_t active, const Test& test) {
    RayNumber list[kGroupRays] = {};
    const size_t count = ListOf(active, list);
    test(list, count);
    LoadHits(active);
  }

  /// Whether functions can be called for the lanes as they are.
  bool CanCall() const {
    return numbers_ == kLanes && GroupPackets::CanBe(task_.frame.options.callback_width);
  }
  GroupPackets& Packets() {
    if (!packets_) packets_.emplace(task_, lanes_, all_);
    return *packets_;
  }

 private:
  static constexpr RayNumber kLanes[kGroupRays] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                   8, 9, 10, 11, 12, 13, 14, 15};

  const TraceTask& task_;
  GroupLanes& lanes_;
  const RayNumber* numbers_ = kLanes;
  uint32_t with_record_ = 0;             ///< lanes whose records hold the ray
  uint32_t all_ = 0;                     ///< lanes that hold a ray
  std::optional<GroupPackets> packets_;  ///< where functions are called
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_RAY_GROUP_INL_H_

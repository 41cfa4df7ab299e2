// The rays of a group on their way: in lanes, where one needs it also as a record, and where the
// program's functions are called as packets.

#if defined(DACRT_TRACE_RAY_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_RAY_GROUP_INL_H_
#undef DACRT_TRACE_RAY_GROUP_INL_H_
#else
#define DACRT_TRACE_RAY_GROUP_INL_H_
#endif

#include <array>
#include <optional>

#include "trace/group_packets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <size_t kMost>
class RayGroup {
 public:
  RayGroup(const TraceTask& task, GroupLanes<kMost>& lanes) : task_(task), lanes_(lanes) {}

  /// The rays of some lanes, which the caller has loaded. One that needs a record of its own gets
  /// task.rays[lane].
  void BeginLanes(LaneMask active) {
    numbers_ = kLanes.data();
    with_record_ = 0;
    all_ = active;
  }

  /// The rays `numbers[0]` to `numbers[count - 1]` of the task, at most kMost.
  void BeginRecords(const RayNumber* numbers, size_t count) {
    numbers_ = numbers;
    with_record_ = ~LaneMask{0};
    lanes_.SetCount(count);
    for (size_t lane = 0; lane < lanes_.parts() * Lanes(); ++lane) {
      lanes_.Load(lane, task_.rays[numbers[lane < count ? lane : 0]]);
    }
  }

  const TraceTask& task() const { return task_; }
  GroupLanes<kMost>& lanes() const { return lanes_; }
  /// Of the records of the rays in the lanes.
  const RayNumber* numbers() const { return numbers_; }

  /// The record of the ray in a lane, as it stands now.
  RayRecord& RecordOf(size_t lane) {
    RayRecord& ray = task_.rays[numbers_[lane]];
    if (with_record_ >> lane & 1) {
      lanes_.StoreHit(lane, ray);
    } else {
      lanes_.Store(lane, ray);
      with_record_ |= LaneMask{1} << lane;
    }
    return ray;
  }

  /// The numbers of the rays in some lanes, whose records stand as the rays do.
  HWY_INLINE size_t ListOf(LaneMask lanes, RayNumber* list) {
    size_t count = 0;
    ForEachLane(lanes, [&](size_t lane) {
      RecordOf(lane);
      list[count++] = numbers_[lane];
    });
    return count;
  }
  HWY_INLINE void LoadHits(LaneMask lanes) {
    ForEachLane(lanes, [&](size_t lane) { lanes_.LoadHit(lane, task_.rays[numbers_[lane]]); });
  }

  /// `test(list, count)` tests the rays of some lanes by their records, to which their numbers
  /// lead.
  template <class Test>
  HWY_INLINE void TestRecords(LaneMask active, const Test& test) {
    RayNumber list[kMost] = {};
    const size_t count = ListOf(active, list);
    test(list, count);
    LoadHits(active);
  }

  /// Whether functions can be called for the lanes as they are.
  bool CanCall() const {
    return numbers_ == kLanes.data() &&
           GroupPackets<kMost>::CanBe(task_.frame.options.callback_width);
  }
  GroupPackets<kMost>& Packets() {
    if (!packets_) packets_.emplace(task_, lanes_, all_);
    return *packets_;
  }

 private:
  static constexpr auto kLanes = [] {
    std::array<RayNumber, kMost> lanes{};
    for (size_t lane = 0; lane < kMost; ++lane) lanes[lane] = static_cast<RayNumber>(lane);
    return lanes;
  }();

  const TraceTask& task_;
  GroupLanes<kMost>& lanes_;
  const RayNumber* numbers_ = kLanes.data();
  LaneMask with_record_ = 0;             ///< lanes whose records hold the ray
  LaneMask all_ = 0;                     ///< lanes that hold a ray
  std::optional<GroupPackets<kMost>> packets_;  ///< where functions are called
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_RAY_GROUP_INL_H_

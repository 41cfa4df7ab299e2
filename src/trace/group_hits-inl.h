// From the lanes of a group to the hits of its rays.

#if defined(DACRT_TRACE_GROUP_HITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_HITS_INL_H_
#undef DACRT_TRACE_GROUP_HITS_INL_H_
#else
#define DACRT_TRACE_GROUP_HITS_INL_H_
#endif

#include "leaf/finish_hit-inl.h"
#include "trace/group_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The hits of a group, in the order of FullHit, as structure of arrays.
template <size_t kMost>
struct GroupHits {
  LaneMask lanes = 0;  ///< that have one, a bit each
  HWY_ALIGN float ng[3][kMost];
  HWY_ALIGN float u[kMost];
  HWY_ALIGN float v[kMost];
  HWY_ALIGN uint32_t primitive_id[kMost];
  HWY_ALIGN uint32_t geometry_id[kMost];
  HWY_ALIGN uint32_t instance_id[kMost];
  HWY_ALIGN float t[kMost];

  GroupHits() {}  // nothing is set

  /// Says of the other lanes that they have none.
  void SetNone() {
    for (size_t lane = 0; lane < kMost; ++lane) {
      if (!(lanes >> lane & 1)) Set(lane, kNoHit);
    }
  }

  /// Those of the active rays of a group.
  GroupHits(const TraceTask& task, const GroupLanes<kMost>& group, LaneMask active) {
    lanes = group.LanesInState(active, RayRecord::kHasHit);
    const LaneMask in_lanes = group.LanesInState(lanes, RayRecord::kInLanes);
    HitTriangle triangle(task);
    for (size_t first = 0; first < group.parts() * Lanes(); first += Lanes()) {
      const V one = hn::Set(kFloat, 1.0f), den = hn::Load(kFloat, group.den + first);
      const auto load = [&](const float* values)
                            HWY_ATTR { return hn::Load(kFloat, values + first); };
      hn::Store(hn::Min(hn::Div(load(group.u), den), one), kFloat, u + first);
      hn::Store(hn::Min(hn::Div(load(group.v), den), one), kFloat, v + first);
      hn::Store(load(group.t), kFloat, t + first);
      for (int axis = 0; axis < 3; ++axis) {
        hn::Store(load(group.ng[axis]), kFloat, ng[axis] + first);
      }
      hn::Store(hn::Set(kUint, task.instance_id), kUint, instance_id + first);
      NameTriangles(triangle, group, (in_lanes >> first) & FirstLanes(Lanes()), first);
    }
    if (HWY_UNLIKELY(in_lanes != lanes)) Finish(task, group, lanes & ~in_lanes);
  }

  /// Lanes whose hits are of a geometry, or would be.
  HWY_INLINE LaneMask LanesIn(uint32_t geometry) const {
    LaneMask in = 0;
    for (size_t first = 0; first < kMost; first += Lanes()) {
      const auto is_in = hn::Eq(hn::Load(kUint, geometry_id + first), hn::Set(kUint, geometry));
      in |= Bits(hn::RebindMask(kFloat, is_in)) << first;
    }
    return in;
  }

  /// Calls `body(component, values)` for each component of a hit and the distances `ends`.
  template <class Body>
  HWY_INLINE void ForEachRow(const float* ends, const Body& body) const {
    using enum PacketComponent;
    body(kTfar, ends);
    body(kNgX, ng[0]);
    body(kNgY, ng[1]);
    body(kNgZ, ng[2]);
    body(kU, u);
    body(kV, v);
    body(kPrimitiveId, primitive_id);
    body(kGeometryId, geometry_id);
    body(kInstanceId, instance_id);
  }

  void Set(size_t lane, const FullHit& hit) {
    for (int axis = 0; axis < 3; ++axis) ng[axis][lane] = hit.ng[axis];
    u[lane] = hit.u;
    v[lane] = hit.v;
    primitive_id[lane] = hit.primitive_id;
    geometry_id[lane] = hit.geometry_id;
    instance_id[lane] = hit.instance_id;
    t[lane] = hit.t;
  }
  FullHit Get(size_t lane) const {
    return {{ng[0][lane], ng[1][lane], ng[2][lane]},
            u[lane],
            v[lane],
            primitive_id[lane],
            geometry_id[lane],
            instance_id[lane],
            t[lane]};
  }

  /// Sets what a lane has in the end, null if that is nothing.
  void Take(size_t lane, const FullHit* hit) {
    if (hit) {
      Set(lane, *hit);
    } else {
      lanes &= ~(LaneMask{1} << lane);
    }
  }

  /// Writes them to the rays of a view that they come from, which are those from `first` on.
  HWY_INLINE void Write(const RecordLayout& layout, size_t first) const {
    LaneMask left = lanes;
#if HWY_TARGET != HWY_SCALAR
    if (HWY_LIKELY(layout.has_hit_records())) {
      for (size_t lane = 0; left != 0; lane += 4, left >>= 4) {
        if ((left & 15) == 0) continue;
        const auto load = [&](const auto* values) HWY_ATTR {
          return hn::Load(kCornerTag, reinterpret_cast<const float*>(values) + lane);
        };
        FourByFour<CornerTag> begin{{load(ng[0]), load(ng[1]), load(ng[2]), load(u)}};
        FourByFour<CornerTag> end{
            {load(v), load(primitive_id), load(geometry_id), load(instance_id)}};
        begin.Transpose();
        end.Transpose();
        for (size_t i = 0; i < 4; ++i) {
          if (!(left >> i & 1)) continue;
          float* const record = layout.Record(first + lane + i);
          float* const hit = record + static_cast<size_t>(PacketComponent::kNgX);
          record[static_cast<size_t>(PacketComponent::kTfar)] = t[lane + i];
          hn::StoreU(begin.v[i], kCornerTag, hit);
          hn::StoreU(end.v[i], kCornerTag, hit + 4);
        }
      }
      return;
    }
#endif
    ForEachLane(left, [&](size_t lane) { layout.WriteHit(first + lane, Get(lane)); });
  }

  /// Writes them to the packet that the rays come from.
  HWY_INLINE void Write(const RayPacket& packet) const {
    if (HWY_UNLIKELY(packet.lanes % 4 != 0)) {
      ForEachLane(lanes, [&](size_t lane) {
        RecordLayout::WriteLane(packet, static_cast<uint32_t>(lane), Get(lane));
      });
      return;
    }
    if (packet.lanes % Lanes() == 0) {
      Write(kFloat, packet);
    } else {
      Write(kCornerTag, packet);
    }
  }

 private:
  /// The triangle that was looked up last: neighbours hit the same one.
  struct HitTriangle {
    const TraceTask& task;
    uint32_t leaf = 0, state = 0;
    GeometryTable::Name name{};
    uint32_t geometry_id = 0;
    bool is_second = false;
    bool has_own_values = false;  ///< u and v are not those of the triangle test

    explicit HitTriangle(const TraceTask& task_) : task(task_) {}

    HWY_INLINE void Find(uint32_t its_leaf, uint32_t its_state) {
      if (leaf == its_leaf && state == its_state) return;
      leaf = its_leaf;
      state = its_state;
      LeafRoom room;
      const LeafBlock& block = FacetsOf(task, ChildWord(leaf), room);
      const size_t block_lane = state >> RayRecord::kLaneShift;
      name = NameOfLane(task, block, block_lane);
      geometry_id = task.scene.geometries[name.geometry].geometry_id;
      is_second = block.second >> block_lane & 1;
      has_own_values =
          is_second || task.scene.geometries.shapes()[name.geometry].shape == Shape::kGrids;
    }
  };

  /// Sets whose triangles some lanes of the vector from `first` on have hit.
  HWY_INLINE void NameTriangles(HitTriangle& triangle, const GroupLanes<kMost>& group,
                                LaneMask left, size_t first) {
    const auto leaves = hn::Load(kUint, group.hit + first);
    const auto states = hn::Load(kUint, group.state + first);
    auto primitives = hn::Zero(kUint), geometries = hn::Zero(kUint);
    while (left != 0) {
      const size_t lane = first + hwy::Num0BitsBelowLS1Bit_Nonzero64(left);
      triangle.Find(group.hit[lane], group.state[lane]);
      const auto is_same = hn::And(hn::Eq(leaves, hn::Set(kUint, triangle.leaf)),
                                   hn::Eq(states, hn::Set(kUint, triangle.state)));
      const LaneMask same = left & Bits(hn::RebindMask(kFloat, is_same));
      left &= ~same;
      uint32_t primitive = triangle.name.primitive;
      if (HWY_UNLIKELY(triangle.has_own_values)) {
        ForEachLane(same << first, [&](size_t i) {
          const FullHit hit =
              HitOf(triangle.task.scene, triangle.task.instance_id, triangle.name,
                    triangle.is_second, t[i], u[i], v[i], ng[0][i], ng[1][i], ng[2][i]);
          Set(i, hit);
          primitive = hit.primitive_id;
        });
      }
      primitives = hn::IfThenElse(is_same, hn::Set(kUint, primitive), primitives);
      geometries = hn::IfThenElse(is_same, hn::Set(kUint, triangle.geometry_id), geometries);
    }
    hn::Store(primitives, kUint, primitive_id + first);
    hn::Store(geometries, kUint, geometry_id + first);
  }

  /// Sets those of lanes whose hits are not in the group.
  HWY_NOINLINE void Finish(const TraceTask& task, const GroupLanes<kMost>& group, LaneMask others) {
    FinishedHits finished(task);
    const auto finish = [&]() HWY_ATTR {
      finished.Finish([&](size_t i, uint32_t, const FullHit& hit)
                          HWY_ATTR { Set(finished.number(i), hit); });
    };
    ForEachLane(others, [&](size_t lane) HWY_ATTR {
      const uint32_t state = group.state[lane];
      if (!(state & RayRecord::kInLeaf)) {
        return Set(lane, task.FullHitOf(static_cast<RayNumber>(lane), state));
      }
      finished.Add(static_cast<RayNumber>(lane));
      if (finished.count() == FinishedHits::kMost) finish();
    });
    if (finished.count() > 0) finish();
  }

  template <class Tag>
  HWY_INLINE void Write(Tag d, const RayPacket& packet) const {
    const size_t count = packet.lanes;
    float* const values = static_cast<float*>(packet.values);
    for (size_t first = 0; first < count; first += hn::MaxLanes(d)) {
      const LaneMask of_part = (lanes >> first) & FirstLanes(hn::MaxLanes(d));
      // Whole vectors are stored plainly: on some processors a store with a mask takes ten times as
      // long.
      if (of_part == FirstLanes(hn::MaxLanes(d))) {
        WritePart(d, values + first, count, first,
                  [d](auto v, float* to) HWY_ATTR { hn::StoreU(v, d, to); });
      } else if (of_part != 0) {
        WritePart(d, values + first, count, first,
                  [d, mask = MaskOf(d, of_part)](auto v, float* to)
                      HWY_ATTR { hn::BlendedStore(v, mask, d, to); });
      }
    }
  }

  /// One vector of lanes, to the rows of a packet with `count` lanes from `to` on.
  template <class Tag, class Store>
  HWY_INLINE void WritePart(Tag d, float* to, size_t count, size_t first,
                            const Store& store) const {
    ForEachRow(t, [&](PacketComponent component, const auto* from) HWY_ATTR {
      store(hn::Load(d, reinterpret_cast<const float*>(from) + first),
            to + static_cast<size_t>(component) * count);
    });
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_HITS_INL_H_

// At most a vector of rays over the kept partition: masks instead of copies, and a ray that is left
// alone is traced against the children of a node side by side.

#if defined(DACRT_SOLVE_SOLVE_FEW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_FEW_INL_H_
#undef DACRT_SOLVE_SOLVE_FEW_INL_H_
#else
#define DACRT_SOLVE_SOLVE_FEW_INL_H_
#endif

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "partition/split_by_grid-inl.h"
#include "solve/direct_solve-inl.h"
#include "solve/solve_items-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays up to which each goes its own way.
constexpr size_t kLonelyRays = 2;

/// Triangles [begin, begin + count) of the kept order, for a direct solve with `rays` rays.
/// False if they are solved then, because the scene holds more than still triangles; else they are
/// in the scratch.
template <Query kQuery>
HWY_INLINE bool GatherKept(const SolveTask& task, size_t begin, size_t count, size_t rays,
                           const RaySelection& selection) {
  const uint32_t* const numbers = task.kept->triangles().data() + begin;
  const auto name = [&](size_t k) { return task.meshes.Locate(numbers[k]); };
  ++task.statistics.direct_solves;
  task.statistics.direct_rays += rays;
  task.statistics.triangle_tests += rays * count;
  if (HWY_UNLIKELY(task.frame != nullptr)) {
    ItemSolver<kQuery>(task).Solve(count, name, selection);
    return false;
  }
  GatherTriangles(task.meshes, count, name, task.scratch.triangles);
  return true;
}

/// Asks for the memory of child i of `node`, which will be needed soon.
HWY_INLINE void PrefetchChild(const KeptPartition& kept, const WideNode& node, size_t i) {
  if (node.IsLeaf(i)) {
    hwy::Prefetch(kept.triangles().data() + node.Number(i));
  } else if (!node.IsSubset(i)) {
    hwy::Prefetch(&kept.node(node.Number(i)));
  }
}

/// The same for the triangles of leaf i, which PrefetchChild has been called for.
HWY_INLINE void PrefetchLeaf(const SolveTask& task, const WideNode& node, size_t i) {
  if (HWY_UNLIKELY(task.frame != nullptr)) return;
  const uint32_t* const numbers = task.kept->triangles().data() + node.Number(i);
  for (size_t k = 0; k < node.Kind(i); ++k) {
    const MeshTable::Name name = task.meshes.Locate(numbers[k]);
    hwy::Prefetch(task.meshes.IndicesOf(name.mesh, name.primitive));
  }
}

/// Tests every ray of `rays` against every triangle of leaf i of `node`.
template <Query kQuery>
inline void SolveLeaf(const SolveTask& task, const WideNode& node, size_t i, const RayBlock& rays) {
  if (GatherKept<kQuery>(task, node.Number(i), node.Kind(i), rays.count, RaySelection::All(rays))) {
    TestBlock<kQuery>(task, rays);
  }
}

/// Tests a ray against every triangle of a subset.
template <Query kQuery>
inline void SolveSubsetDirectly(const SolveTask& task, const Subset& subset, size_t slot) {
  for (size_t begin = 0; begin < subset.count; begin += TriangleBlock::kCapacity) {
    const size_t count = std::min(subset.count - begin, TriangleBlock::kCapacity);
    if (GatherKept<kQuery>(task, subset.begin + begin, count, 1, {slot, 1})) {
      TestRayByTriangles<kQuery>(task, slot);
    }
  }
}

template <Query kQuery>
class FewSolver {
 public:
  explicit FewSolver(const SolveTask& task) : task_(task), kept_(*task.kept) {}

  /// For at most a vector of rays.
  void SolveNode(const WideNode& node, const RayBlock& rays) const {
    SolveNode(node, rays.begin, AllOf(rays));
  }

  /// The same for children [begin, end) of a node.
  void SolveChildren(const WideNode& node, const ChildBoxes& boxes, size_t begin, size_t end,
                     const RayBlock& rays) const {
    SolveChildren(node, boxes, begin, end, rays.begin, AllOf(rays));
  }

 private:
  static uint64_t AllOf(const RayBlock& rays) { return (uint64_t{1} << rays.count) - 1; }

  /// A child that rays enter.
  struct Entered {
    float distance;  ///< at which the first of them does
    uint32_t child;
    uint64_t lanes;
  };

  void SolveNode(const WideNode& node, size_t slot, uint64_t active) const {
    ChildBoxes boxes;
    DecodeChildren(node, boxes);
    SolveChildren(node, boxes, 0, node.count, slot, active);
  }

  void SolveChildren(const WideNode& node, const ChildBoxes& boxes, size_t begin, size_t end,
                     size_t slot, uint64_t active) const {
    const RayBatch& batch = task_.batch;
    const TestRays rays = LoadTestRays(batch, slot);
    const V never = hn::Set(kFloat, std::numeric_limits<float>::infinity());
    HWY_ALIGN float entry[WideNode::kWidth][kMaxLanes];
    Entered entered[WideNode::kWidth];
    size_t count = 0;
    for (size_t i = begin; i < end; ++i) {
      const Interval interval = IntersectBox(WideChild(boxes, i), rays.org, rays.reciprocal);
      const uint64_t lanes = Bits(Enters(interval, rays.tnear, rays.tfar)) & active;
      if (lanes == 0) continue;
      PrefetchChild(kept_, node, i);
      hn::Store(interval.entry, kFloat, entry[i]);
      const float distance =
          hn::GetLane(hn::MinOfLanes(kFloat, hn::IfThenElse(MaskOf(lanes), interval.entry, never)));
      InsertByDistance(entered, count, {distance, static_cast<uint32_t>(i), lanes});
    }
    task_.statistics.box_tests += hwy::PopCount(active) * (end - begin);
    for (size_t k = 0; k < count; ++k) {
      const size_t i = entered[k].child;
      // Hits in the children before may have come closer.
      const V tfar = hn::Load(kFloat, batch.tfar + slot);
      const uint64_t lanes = entered[k].lanes & Bits(hn::Le(hn::Load(kFloat, entry[i]), tfar));
      if (lanes != 0) SolveChild(node, i, slot, lanes);
    }
  }

  static void InsertByDistance(Entered* entered, size_t& count, const Entered& next) {
    size_t place = count++;
    for (; place > 0 && entered[place - 1].distance > next.distance; --place) {
      entered[place] = entered[place - 1];
    }
    entered[place] = next;
  }

  void SolveChild(const WideNode& node, size_t i, size_t slot, uint64_t lanes) const {
    const size_t rays = hwy::PopCount(lanes);
    if (node.IsLeaf(i)) {
      const RaySelection selection = RaySelection::Lanes(slot, lanes);
      if (!GatherKept<kQuery>(task_, node.Number(i), node.Kind(i), rays, selection)) return;
      const size_t vectors_by_triangles = rays * hwy::DivCeil(size_t{node.Kind(i)}, Lanes());
      if (vectors_by_triangles < node.Kind(i)) {
        ForEachLane(lanes, [&](size_t lane) { TestRayByTriangles<kQuery>(task_, slot + lane); });
      } else {
        TestVectorByRays<kQuery>(task_, slot, MaskOf(lanes));
      }
      return;
    }
    uint32_t number = node.Number(i);
    if (node.IsSubset(i)) {
      const uint32_t root = RootOf(kept_, number, task_.scratch.subset);
      if (root == Subset::kNoRoom) {
        const Subset& subset = kept_.subset(number);
        ForEachLane(lanes,
                    [&](size_t lane) { SolveSubsetDirectly<kQuery>(task_, subset, slot + lane); });
        return;
      }
      number = root;
    }
    if (rays > kLonelyRays) return SolveNode(kept_.node(number), slot, lanes);
    ForEachLane(lanes, [&](size_t lane) { SolveOne(number, slot + lane); });
  }

  /// What a lonely ray has still to look at.
  struct Open {
    float distance;  ///< at which the ray enters it
    uint32_t number;
    uint16_t kind;  ///< as in WideNode; of leaves with the number of triangles
  };

  /// Children of a node on a path, and those beside it: seven more a level.
  static constexpr size_t kMostOpen = 1024;

  void SolveOne(uint32_t root, size_t slot) const {
    const float& tfar = task_.batch.tfar[slot];
    const LonelyRay ray(task_.batch, slot);
    Open open[kMostOpen];
    size_t count = 0;
    open[count++] = {ray.tnear, root, WideNode::kInner};
    while (count > 0) {
      Open next = open[--count];
      if (!(next.distance <= tfar)) continue;
      if (next.kind <= WideNode::kMostLeafTriangles) {
        SolveTriangles(next, slot);
        continue;
      }
      if (next.kind == WideNode::kSubset) {
        const uint32_t number = RootOf(kept_, next.number, task_.scratch.subset);
        if (number == Subset::kNoRoom) {
          SolveSubsetDirectly<kQuery>(task_, kept_.subset(next.number), slot);
          continue;
        }
        next.number = number;
      }
      const WideNode& node = kept_.node(next.number);
      if (count + WideNode::kWidth > kMostOpen) {
        // Deeper than any sound partition: the other way has no stack of its own.
        SolveNode(node, slot - slot % Lanes(), uint64_t{1} << slot % Lanes());
        continue;
      }
      HWY_ALIGN float distance[WideNode::kWidth];
      uint64_t entered = ray.EnterChildren(node, tfar, distance);
      task_.statistics.box_tests += node.count;
      const size_t bottom = count;
      ForEachLane(entered, [&](size_t i) {
        PrefetchChild(kept_, node, i);
        size_t place = count++;
        for (; place > bottom && open[place - 1].distance < distance[i]; --place) {
          open[place] = open[place - 1];
        }
        open[place] = {distance[i], node.Number(i), node.Kind(i)};
      });
    }
  }

  void SolveTriangles(const Open& leaf, size_t slot) const {
    if (GatherKept<kQuery>(task_, leaf.number, leaf.kind, 1, {slot, 1})) {
      TestRayByTriangles<kQuery>(task_, slot);
    }
  }

  /// A ray in all lanes of a vector of children.
  struct LonelyRay {
    LonelyRay(const RayBatch& batch, size_t slot) : tnear(std::max(batch.tnear[slot], 0.0f)) {
      for (int axis = 0; axis < 3; ++axis) {
        org[axis] = hn::Set(kChildTag, batch.org[axis][slot]);
        const V direction = hn::Set(kFloat, batch.dir[axis][slot]);
        reciprocal[axis] = hn::Set(kChildTag, hn::GetLane(SafeReciprocal(direction)));
      }
    }

    /// The children that the ray enters, a bit each, and where; the test of ray_box-inl.h.
    HWY_INLINE uint64_t EnterChildren(const WideNode& node, float tfar, float* distance) const {
      uint64_t entered = 0;
      for (size_t part = 0; part < WideNode::kWidth; part += ChildLanes()) {
        ChildVec entry, exit;
        for (int axis = 0; axis < 3; ++axis) {
          const ChildVec t0 =
              hn::Mul(hn::Sub(WideLower(node, axis, part), org[axis]), reciprocal[axis]);
          const ChildVec t1 =
              hn::Mul(hn::Sub(WideUpper(node, axis, part), org[axis]), reciprocal[axis]);
          const ChildVec near = hn::Min(t0, t1), far = hn::Max(t0, t1);
          entry = axis == 0 ? near : hn::Max(entry, near);
          exit = axis == 0 ? far : hn::Min(exit, far);
        }
        entry = hn::Max(hn::Mul(entry, hn::Set(kChildTag, 1.0f - kDistanceSlack)),
                        hn::Set(kChildTag, tnear));
        exit = hn::Min(hn::Mul(exit, hn::Set(kChildTag, 1.0f + kDistanceSlack)),
                       hn::Set(kChildTag, tfar));
        uint8_t bytes[8] = {};
        hn::StoreMaskBits(kChildTag, hn::Le(entry, exit), bytes);
        entered |= uint64_t{bytes[0]} << part;
        hn::Store(entry, kChildTag, distance + part);
      }
      return entered & ((uint64_t{1} << node.count) - 1);
    }

    ChildVec org[3];
    ChildVec reciprocal[3];
    float tnear;
  };

  const SolveTask& task_;
  KeptPartition& kept_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_FEW_INL_H_

// Divide-and-conquer ray tracing over the kept partition: the recursion of solve_objects-inl.h
// where the triangles are already partitioned. Sample rays decide the order and whether rays are
// filtered.
//
// Three ways, by how many rays are left:
//   many    rays, or packets of coherent rays, are filtered into a new block for each side of the
//           binary tree inside of a node
//   few     one vector of rays: masks instead of copies
//   one     a ray alone: the children of a node side by side in a vector

#if defined(DACRT_SOLVE_SOLVE_KEPT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_KEPT_INL_H_
#undef DACRT_SOLVE_SOLVE_KEPT_INL_H_
#else
#define DACRT_SOLVE_SOLVE_KEPT_INL_H_
#endif

#include <algorithm>
#include <type_traits>

#include "partition/split_by_grid-inl.h"
#include "rays/ray_packets-inl.h"
#include "rays/sample_children-inl.h"
#include "solve/solve_few-inl.h"
#include "solve/solve_objects-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Packets up to which they are taken apart whatever the sample says: more of them would leave most
/// of a vector empty.
constexpr size_t kFewPackets = 8;

/// Packets that are taken apart at once; a quarter of a mebibyte of rays.
constexpr size_t kPacketsAtOnce = 256;

template <Query kQuery>
class KeptSolver : Solver<kQuery> {
 public:
  explicit KeptSolver(const SolveTask& task) : Base(task), kept_(*task.kept) {}

  void Solve(const RayBlock& rays) const {
    if (rays.count > kFewPackets * kMaxLanes) {
      const PacketBlock packets = MakeRayPackets(task_.batch, rays, task_.packets);
      if (AreCoherent(task_.packets, packets, kept_.bounds())) {
        return SolveSubset(task_.packets, 0, packets);
      }
    }
    SolveSubset(task_.batch, 0, rays);
  }

 private:
  using Base = Solver<kQuery>;
  using Base::task_;

  template <class Batch>
  static constexpr bool kArePackets = std::is_same_v<Batch, PacketBatch>;

  /// Children [begin, end) of a node, with what is known of them all.
  struct Siblings {
    const WideNode& node;
    const ChildBoxes& boxes;
    const ChildSamples& samples;
    size_t begin;
    size_t end;

    size_t count() const { return end - begin; }
    bool IsLeaf() const { return count() == 1 && node.IsLeaf(begin); }
    Siblings Only(size_t first, size_t last) const { return {node, boxes, samples, first, last}; }

    /// Where the binary tree divides them.
    size_t Middle() const {
      size_t gap = begin;
      for (size_t i = begin + 1; i + 1 < end; ++i) {
        if (node.GapRank(i) < node.GapRank(gap)) gap = i;
      }
      return gap + 1;
    }
  };

  template <class Batch>
  void SolveSubset(Batch& batch, uint32_t number, const RayBlock& rays) const {
    const uint32_t root = FindRoot(number);
    if (root == Subset::kNoRoom) return SolveUnsplit(batch, kept_.subset(number), rays);
    SolveNode(batch, kept_.node(root), rays);
  }

  uint32_t FindRoot(uint32_t subset) const {
    const StepClock::Charge charge(task_.clock, Step::kPartition);
    return RootOf(kept_, subset, task_.scratch.subset);
  }

  template <class Batch>
  void SolveNode(Batch& batch, const WideNode& node, const RayBlock& rays) const {
    ++task_.statistics.subproblems;
    if constexpr (!kArePackets<Batch>) {
      if (rays.count <= Lanes()) {
        const StepClock::Charge charge(task_.clock, Step::kFewRays);
        return FewSolver<kQuery>(task_).SolveNode(node, rays);
      }
    }
    for (size_t i = 0; i < node.count; ++i) PrefetchChild(kept_, node, i);
    ChildBoxes boxes;
    DecodeChildren(node, boxes);
    ChildSamples samples;
    {
      const StepClock::Charge charge(task_.clock, Step::kSampling);
      SampleChildren(batch, rays, boxes, node.count, samples);
    }
    SolveSiblings(batch, {node, boxes, samples, 0, node.count}, rays);
  }

  template <class Batch>
  void SolveSiblings(Batch& batch, const Siblings& siblings, const RayBlock& rays) const {
    if (siblings.count() == 1) return SolveChild(batch, siblings.node, siblings.begin, rays);
    const size_t middle = siblings.Middle();
    const Siblings left = siblings.Only(siblings.begin, middle);
    const Siblings right = siblings.Only(middle, siblings.end);
    const SampleCounts counts = siblings.samples.Count(siblings.begin, middle, siblings.end);
    if (IsRightFirst(counts)) {
      SolveSide(batch, right, counts.right_hits, rays);
      SolveSide(batch, left, counts.left_hits, rays);
    } else {
      SolveSide(batch, left, counts.left_hits, rays);
      SolveSide(batch, right, counts.right_hits, rays);
    }
  }

  /// Any-hit rays do not care which hit it is: first where most of them may be blocked. With the
  /// closer side first, rays without an end took a tenth longer.
  static bool IsRightFirst(const SampleCounts& counts) {
    return kQuery == Query::kAny ? counts.right_hits > counts.left_hits
                                 : counts.right_closer > counts.left_closer;
  }

  /// The rays that enter one side, which `sample_hits` of the sample rays do.
  template <class Batch>
  void SolveSide(Batch& batch, const Siblings& side, size_t sample_hits,
                 const RayBlock& rays) const {
    if (SkipsFiltering<Batch>(side, sample_hits)) {
      ++task_.statistics.filters_skipped;
      return SolveSiblings(batch, side, rays);
    }
    if (side.IsLeaf()) PrefetchLeaf(task_, side.node, side.begin);
    const WideBox box = UnionOfChildren(side.boxes, side.begin, side.end);
    const bool fits = Base::WithFilteredRays(batch, {&rays, 1}, box, [&](const RayBlock& active) {
      SolveEntering(batch, side, box, active);
    });
    if (!fits) SolveSiblings(batch, side, rays);
  }

  template <class Batch>
  bool SkipsFiltering(const Siblings& side, size_t sample_hits) const {
    // Two siblings next to each other have each a box of their own to filter by: doing so by both
    // first made six per cent more box tests.
    if (side.count() == 2) return true;
    // Packets are a sixteenth of the work to filter, and all of it to test against triangles.
    if (kArePackets<Batch> && side.IsLeaf()) return false;
    const size_t triangles = side.IsLeaf() ? side.node.Kind(side.begin) : 0;
    return static_cast<double>(sample_hits) >
           SkipRatio(side.IsLeaf(), triangles) * static_cast<double>(side.samples.count);
  }

  void SolveEntering(RayBatch& batch, const Siblings& side, const WideBox&,
                     const RayBlock& rays) const {
    if (rays.count > Lanes()) return SolveSiblings(batch, side, rays);
    const StepClock::Charge charge(task_.clock, Step::kFewRays);
    FewSolver<kQuery>(task_).SolveChildren(side.node, side.boxes, side.begin, side.end, rays);
  }

  void SolveEntering(PacketBatch& packets, const Siblings& side, const WideBox& box,
                     const PacketBlock& entering) const {
    if (!side.IsLeaf() && !AreTooWide(box, entering)) {
      return SolveSiblings(packets, side, entering);
    }
    WithRaysOf(entering, box,
               [&](const RayBlock& rays) { SolveEntering(task_.batch, side, box, rays); });
  }

  template <class Batch>
  void SolveChild(Batch& batch, const WideNode& node, size_t i, const RayBlock& rays) const {
    if (node.IsSubset(i)) return SolveSubset(batch, node.Number(i), rays);
    if (!node.IsLeaf(i)) return SolveNode(batch, kept_.node(node.Number(i)), rays);
    if constexpr (kArePackets<Batch>) {
      // Their rays could not be filtered for want of room.
      for (size_t slot = rays.begin; slot < rays.begin + rays.count; ++slot) {
        SolveChild(task_.batch, node, i, RaysOf(task_.packets, slot));
        UpdateReach(task_.batch, task_.packets, slot);
      }
    } else {
      const StepClock::Charge charge(task_.clock, Step::kDirect);
      SolveLeaf<kQuery>(task_, node, i, rays);
    }
  }

  /// A subset for which the budget has no nodes: partitioned anew, as in solve_objects-inl.h.
  void SolveUnsplit(RayBatch&, const Subset& subset, const RayBlock& rays) const {
    if (subset.count > SubsetScratch::kTriangles || rays.count <= Lanes()) {
      for (size_t slot = rays.begin; slot < rays.begin + rays.count; ++slot) {
        SolveSubsetDirectly<kQuery>(task_, subset, slot);
      }
      return;
    }
    SolveTask own = task_;
    own.refs = task_.scratch.subset.refs;
    ObjectSolver<kQuery>(own).Solve(ReferSubset(kept_, subset, task_.scratch.subset), rays, 1);
  }

  void SolveUnsplit(PacketBatch&, const Subset& subset, const PacketBlock& packets) const {
    const Box& all = kept_.bounds();
    WithRaysOf(packets, Widen(all.lower, all.upper),
               [&](const RayBlock& rays) { SolveUnsplit(task_.batch, subset, rays); });
  }

  /// Whether packets that enter `box` are too wide for it: by the rays of three of them, of which
  /// half should enter. Never if there are very many, because their rays may not fit.
  bool AreTooWide(const WideBox& box, const PacketBlock& packets) const {
    constexpr size_t kLooks = 3;
    if (packets.count <= kFewPackets) return true;
    if (packets.count > kPacketsAtOnce) return false;
    size_t entering = 0, rays = 0;
    for (size_t look = 0; look < kLooks; ++look) {
      const size_t slot = packets.begin + look * (packets.count - 1) / (kLooks - 1);
      const RayBlock block = RaysOf(task_.packets, slot);
      entering += CountEntering(task_.batch, block, box);
      rays += block.count;
    }
    return 2 * entering < rays;
  }

  /// Calls `solve(block)` with those rays of the packets that enter `box`, some packets at a time.
  template <class SolveRays>
  void WithRaysOf(const PacketBlock& packets, const WideBox& box, const SolveRays& solve) const {
    RayBlock parents[kPacketsAtOnce];
    const size_t end = packets.begin + packets.count;
    for (size_t begin = packets.begin; begin < end; begin += kPacketsAtOnce) {
      const size_t count = std::min(kPacketsAtOnce, end - begin);
      for (size_t i = 0; i < count; ++i) {
        parents[i] = RaysOf(task_.packets, begin + i);
      }
      const std::span<const RayBlock> rays(parents, count);
      if (!Base::WithFilteredRays(task_.batch, rays, box, solve)) {
        for (const RayBlock& some : rays) solve(some);
      }
      for (size_t i = 0; i < count; ++i) UpdateReach(task_.batch, task_.packets, begin + i);
    }
  }

  KeptPartition& kept_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_KEPT_INL_H_

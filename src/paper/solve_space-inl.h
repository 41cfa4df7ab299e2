// Divide-and-conquer ray tracing by space partition: mora2011.
// Mora, "Naive ray-tracing: a divide-and-conquer approach", ACM TOG 30(5), 2011.

#if defined(DACRT_PAPER_SOLVE_SPACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_SOLVE_SPACE_INL_H_
#undef DACRT_PAPER_SOLVE_SPACE_INL_H_
#else
#define DACRT_PAPER_SOLVE_SPACE_INL_H_
#endif

#include <optional>
#include <span>
#include <tuple>

#include "paper/cut_space-inl.h"
#include "paper/conic_packets-inl.h"
#include "paper/solver-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Triangles below which packets are taken apart: smaller volumes are narrower than the cones.
constexpr size_t kPacketTriangles = 256;

/// Tangent of a cone that is too wide to be of use. Rays from one point whose directions are in no
/// order, like those from a lamp to what a mirror shows, make such cones.
constexpr float kWideTangent = 0.25f;

/// `spare` is the first free reference behind the scene's, `free_packet` the first free entry of
/// the lists of packets: both are stacks that a subproblem gives back by returning.
template <Query kQuery>
class SpaceSolver : Solver<kQuery> {
 public:
  explicit SpaceSolver(const PaperTask& task) : Base(task) {}

  void Solve(const TriangleRange& triangles, const RayBlock& rays) const {
    if (!HaveCommonOrigin(task_.batch, rays)) return SolveRays(triangles, rays, triangles.end, 1);
    const std::span<const RayBlock> packets = [&] {
      const StepClock::Charge charge(task_.clock, Step::kFiltering);
      return MakeConicPackets(task_.batch, rays);
    }();
    const float* tangents = task_.batch.cones.tangent;
    const size_t wide = std::count_if(tangents, tangents + packets.size(),
                                      [](float tangent) { return tangent > kWideTangent; });
    if (2 * wide > packets.size()) return SolveRays(triangles, rays, triangles.end, 1);
    SolvePackets(triangles, packets, triangles.end, packets.size(), 1);
  }

 private:
  using Base = Solver<kQuery>;
  using Base::task_;

  void SolveRays(const TriangleRange& triangles, const RayBlock& rays, size_t spare,
                 size_t depth) const {
    if (Base::IsDirect(triangles, rays, depth)) return Base::SolveDirectly(triangles, rays);
    Base::TakeSamples(rays, kFewSampleRays);
    PartitionSpace(triangles, spare, depth, [&](const TriangleRange& child, size_t child_spare) {
      const auto solve = [&](const RayBlock& active_rays) {
        SolveRays(child, active_rays, child_spare, depth + 1);
      };
      if (!Base::WithFilteredRays({&rays, 1}, child.bounds, solve)) solve(rays);
    });
  }

  void SolvePackets(const TriangleRange& triangles, std::span<const RayBlock> packets, size_t spare,
                    size_t free_packet, size_t depth) const {
    if (triangles.count() <= kPacketTriangles ||
        free_packet + packets.size() > task_.batch.packets.size()) {
      return SolvePacketRays(triangles, packets, spare, depth);
    }
    ++task_.statistics.subproblems;
    Base::TakeSamples(packets.front(), kFewSampleRays);
    PartitionSpace(triangles, spare, depth, [&](const TriangleRange& child, size_t child_spare) {
      RayBlock* const filtered = task_.batch.packets.data() + free_packet;
      const size_t count = [&] {
        const StepClock::Charge charge(task_.clock, Step::kFiltering);
        return FilterPackets(task_.batch.cones, packets, child.bounds, filtered);
      }();
      task_.statistics.packet_tests += packets.size();
      if (count == 0) return;
      SolvePackets(child, {filtered, count}, child_spare, free_packet + count, depth + 1);
    });
  }

  /// From packets to single rays.
  void SolvePacketRays(const TriangleRange& triangles, std::span<const RayBlock> packets,
                       size_t spare, size_t depth) const {
    const auto solve = [&](const RayBlock& rays) { SolveRays(triangles, rays, spare, depth); };
    if (!Base::WithFilteredRays(packets, triangles.bounds, solve)) {
      // At once, with those between them: whoever came second would find the triangles clipped.
      const RayBlock& first = packets.front();
      const RayBlock& last = packets.back();
      solve({first.begin, last.begin + last.count - first.begin});
    }
    const StepClock::Charge charge(task_.clock, Step::kFiltering);
    for (const RayBlock& packet : packets) UpdateReach(task_.batch, packet, task_.batch.cones);
  }

  /// Calls `solve(child, spare)` for both sides of a cut, or of a partition of the objects where no
  /// cut helps, in the order in which most sample rays come to them.
  template <class Solve>
  void PartitionSpace(const TriangleRange& triangles, size_t spare, size_t depth,
                      const Solve& solve) const {
    const std::optional<Cut> cut = FindCut(triangles, spare, depth);
    if (!cut) {
      const Children children = Base::PartitionObjects(triangles, /*sampled=*/false, depth);
      solve(children.left, spare);
      solve(children.right, spare);
      return;
    }
    TriangleRef* const refs = task_.refs.data();
    size_t left_end, right_begin;
    {
      const StepClock::Charge charge(task_.clock, Step::kPartition);
      std::tie(left_end, right_begin) = SortBySide(refs, triangles, *cut);
    }
    // Both sides want the triangles in the middle, each clipped, and each reorders its own range:
    // so the second side gets them from a copy.
    const size_t straddling = right_begin - left_end;
    task_.statistics.straddling += straddling;
    std::copy(refs + left_end, refs + right_begin, refs + spare);
    bool left = LeftComesFirst(*cut);
    for (int side = 0; side < 2; ++side, left = !left) {
      const TriangleRange child = [&] {
        const StepClock::Charge charge(task_.clock, Step::kPartition);
        if (side == 1) std::copy_n(refs + spare, straddling, refs + left_end);
        ClipTriangles({refs + left_end, straddling}, cut->axis, cut->plane, left);
        return left ? MeasureTriangles(refs, triangles.begin, right_begin)
                    : MeasureTriangles(refs, left_end, triangles.end);
      }();
      solve(child, spare + straddling);
    }
  }

  /// The best cut, if it helps and the triangles that straddle it can be copied.
  std::optional<Cut> FindCut(const TriangleRange& triangles, size_t spare, size_t depth) const {
    if (depth > kMaxBinnedDepth) return std::nullopt;
    const StepClock::Charge charge(task_.clock, Step::kBinning);
    std::optional<Cut> cut =
        ChooseCut(task_.refs.data(), triangles, task_.settings.bins, task_.scratch);
    if (cut && spare + cut->left_count + cut->right_count - triangles.count() > task_.refs.size()) {
      cut.reset();
    }
    task_.statistics.space_cuts += cut.has_value();
    return cut;
  }

  /// Front to back along the axis of the cut: the side on which most sample rays start.
  bool LeftComesFirst(const Cut& cut) const {
    const SampleRays& samples = task_.scratch.samples;
    size_t left = 0;
    for (size_t i = 0; i < samples.count; ++i) left += samples.org[cut.axis][i] < cut.plane;
    return 2 * left >= samples.count;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_SOLVE_SPACE_INL_H_

// Subsets on the way: split when rays come, or, where they cannot be kept split, for the rays at
// hand.

#if defined(DACRT_TRACE_UNSPLIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_UNSPLIT_INL_H_
#undef DACRT_TRACE_UNSPLIT_INL_H_
#else
#define DACRT_TRACE_UNSPLIT_INL_H_
#endif

#include <algorithm>
#include <new>
#include <optional>

#include "leaf/test_leaf-inl.h"
#include "partition/split_by_grid-inl.h"
#include "trace/policy.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays against every triangle in [begin, begin + count) of the order.
template <Query kQuery>
void TestAll(const TraceTask& task, size_t begin, size_t count, const RayNumber* list, size_t rays,
             ListMemory memory) {
  // The order may be another one before hits are asked for.
  TestRange<kQuery>(task.Within(task.partition), static_cast<uint32_t>(begin), count, list, rays,
                    memory);
}

/// A subset that the budget has no nodes for: split in private memory, and forgotten afterwards.
/// `trace(task, root)` traces the rays there.
template <Query kQuery, class Trace>
void TraceForgotten(const TraceTask& task, const Subset& subset, const RayNumber* list, size_t rays,
                    ListMemory memory, const Trace& trace) {
  const auto test_all = [&] {
    TestAll<kQuery>(task, subset.begin, subset.count, list, rays, memory);
  };
  // Instances may have subsets to split in that memory, too.
  if (task.scene.has_instances || rays < policy::kRaysToSplitFor) return test_all();
  const SplitMemory::Use scratch(task.split_memory);
  if (!scratch.get()) return test_all();
  const auto all = task.scene.kept->triangles().subspan(subset.begin, subset.count);
  for (size_t begin = 0; begin < all.size(); begin += SubsetScratch::kTriangles) {
    const auto some = all.subspan(begin, std::min(all.size() - begin, SubsetScratch::kTriangles));
    const std::span<uint32_t> order(scratch.get()->order, some.size());
    std::copy(some.begin(), some.end(), order.begin());
    const size_t nodes = SplitTriangles(task.scene.geometries, kLeafLanes, 0, order,
                                        SplitRule::kFast, *scratch.get());
    if (nodes == 0) {
      TestAll<kQuery>(task, subset.begin + begin, some.size(), list, rays, memory);
      continue;
    }
    for (size_t i = 0; i < nodes; ++i) scratch.get()->nodes[i].SetLeavesDone();
    trace(task.Within({scratch.get()->nodes, order.data(), nullptr}), ChildWord::Inner(0));
  }
}

/// An instanced scene of which nothing is kept: its triangles are split some at a time, for the
/// rays at hand. `trace(task, root)` traces them there.
template <class Trace>
void TraceUnkept(const TraceTask& task, const Trace& trace) {
  const SplitMemory::Use use(task.split_memory);
  if (!use.get()) throw std::bad_alloc();
  SubsetScratch& scratch = *use.get();
  const GeometryTable& geometries = task.scene.geometries;
  for (size_t number = 0; number < geometries.triangle_count();) {
    size_t count = 0;
    for (; number < geometries.triangle_count() && count < SubsetScratch::kTriangles; ++number) {
      TriangleRef ref;
      const auto name = geometries.Locate(static_cast<uint32_t>(number));
      if (BoundTriangle(geometries, name, ref))
        scratch.order[count++] = static_cast<uint32_t>(number);
    }
    if (count == 0) return;
    const size_t nodes = SplitTriangles(geometries, kLeafLanes, 0, {scratch.order, count},
                                        SplitRule::kFast, scratch);
    for (size_t i = 0; i < nodes; ++i) scratch.nodes[i].SetLeavesDone();
    trace(task.Within({scratch.nodes, scratch.order, nullptr}), ChildWord::Inner(0));
  }
}

/// The node behind a subset, which is split now if it is not yet; nothing if its triangles have
/// been tested instead.
template <Query kQuery, class Trace>
HWY_NOINLINE std::optional<ChildWord> OpenSubset(const TraceTask& task, uint32_t number,
                                                 const RayNumber* list, size_t rays,
                                                 ListMemory memory, const Trace& trace) {
  KeptPartition& kept = *task.scene.kept;
  const Subset& subset = kept.subset(number);
  std::optional<uint32_t> root;
  {
    const SplitMemory::Use scratch(task.split_memory);
    root = RootOf(kept, number, scratch.get(), nullptr, [&] {
      // A callback may trace rays that come here again.
      if (task.scene.has_callbacks) throw std::bad_alloc();
      TestAll<kQuery>(task, subset.begin, subset.count, list, rays, memory);
    });
  }
  if (!root) return std::nullopt;
  if (Subset::IsNode(*root)) return ChildWord::Inner(*root);
  TraceForgotten<kQuery>(task, subset, list, rays, memory, trace);
  return std::nullopt;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_UNSPLIT_INL_H_

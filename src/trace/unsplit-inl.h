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
#include "partition/buy_nodes-inl.h"
#include "partition/rent_or_buy.h"
#include "partition/split_by_grid-inl.h"
#include "runtime/ordinary_arithmetic.h"
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
  const auto all = task.scene.kept->OrderOf(subset);
  for (size_t begin = 0; begin < all.size(); begin += SubsetScratch::kTriangles) {
    const auto some = all.subspan(begin, std::min(all.size() - begin, SubsetScratch::kTriangles));
    const std::span<uint32_t> order(scratch.get()->order, some.size());
    std::copy(some.begin(), some.end(), order.begin());
    const size_t nodes = SplitTriangles(task.scene.geometries, kLeafLanes, 0, order,
                                        SplitRule::kRent, *scratch.get());
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
  if (task.scene.triangle_count == 0) return;  // a hidden instance wants no memory
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
                                        SplitRule::kRent, scratch);
    for (size_t i = 0; i < nodes; ++i) scratch.nodes[i].SetLeavesDone();
    trace(task.Within({scratch.nodes, scratch.order, nullptr}), ChildWord::Inner(0));
  }
}

/// The root of a subset, which is split now if it is not yet; nothing if the rays of the list have
/// been tested against its triangles instead.
template <Query kQuery>
std::optional<uint32_t> SplitForRays(const TraceTask& task, uint32_t number, const RayNumber* list,
                                     size_t rays, ListMemory memory) {
  KeptPartition& kept = *task.scene.kept;
  const Subset& subset = kept.subset(number);
  const SplitMemory::Use scratch(task.split_memory);
  return RootOf(kept, number, rays, scratch.get(), nullptr, [&] {
    // A callback may trace rays that come here again.
    if (task.scene.has_callbacks) throw std::bad_alloc();
    TestAll<kQuery>(task, subset.begin, subset.count, list, rays, memory);
  });
}

/// Buys nodes for a subset, if there is memory to make them in.
inline void BuyNodes(const TraceTask& task, Subset& subset) {
  const SplitMemory::Use scratch(task.split_memory);
  if (!scratch.get()) {
    subset.rays = 0;
    return;
  }
  const OrdinaryArithmetic ordinary;
  BuyNodes(*task.scene.kept, subset, *scratch.get());
}

/// Rays at a subset whose nodes are rented: unless they buy others, `trace(node)` traces them
/// there, and nothing is returned. The root of what is bought otherwise.
template <class Trace>
std::optional<uint32_t> RentOrBuy(const TraceTask& task, Subset& subset, size_t rays,
                                  const Trace& trace) {
  if (rent_or_buy::CountRays(subset, rays)) BuyNodes(task, subset);
  const rent_or_buy::Stay stay(*task.scene.kept, subset);
  if (!stay.root()) return subset.root;
  trace(*stay.root());
  return std::nullopt;
}

/// The node behind a subset, from which `rays` rays shall go on; nothing if they have been traced
/// in it. What they are is asked for where it matters:
///   with_list(f)              calls f(list, rays), and takes the hits from their records then
///   trace(node)               traces them from a node on
///   trace_list(task, node)    the same for rays whose records are in use, in another task
template <Query kQuery, class WithList, class Trace, class TraceList>
HWY_NOINLINE std::optional<ChildWord> OpenSubset(const TraceTask& task, uint32_t number,
                                                 size_t rays, ListMemory memory,
                                                 const WithList& with_list, const Trace& trace,
                                                 const TraceList& trace_list) {
  Subset& subset = task.scene.kept->subset(number);
  std::optional<uint32_t> root = subset.root.load(std::memory_order_acquire);
  if (!Subset::HasNodes(*root)) {
    with_list([&](const RayNumber* list, size_t count) {
      root = SplitForRays<kQuery>(task, number, list, count, memory);
    });
  }
  if (root && Subset::IsRented(*root)) root = RentOrBuy(task, subset, rays, trace);
  if (!root) return std::nullopt;
  if (Subset::IsNode(*root)) return ChildWord::Inner(*root);
  with_list([&](const RayNumber* list, size_t count) {
    TraceForgotten<kQuery>(task, subset, list, count, memory, trace_list);
  });
  return std::nullopt;
}

/// The same for rays that are a list.
template <Query kQuery, class TraceList>
std::optional<ChildWord> OpenSubset(const TraceTask& task, uint32_t number, const RayNumber* list,
                                    size_t rays, ListMemory memory, const TraceList& trace_list) {
  return OpenSubset<kQuery>(
      task, number, rays, memory, [&](const auto& with) { with(list, rays); },
      [&](ChildWord node) { trace_list(task, node); }, trace_list);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_UNSPLIT_INL_H_

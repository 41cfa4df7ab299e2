#include <numeric>
#include <vector>

#include "step_bench.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "order_children_bench.cc"
#include <hwy/foreach_target.h>

#include "rays/load_records-inl.h"
#include "trace/order_children-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

constexpr size_t kRays = 1024;

/// A node of eight random volumes, and rays through them in one octant.
struct Visit {
  Visit() : list(kRays) {
    unit::Random random(1);
    Box boxes[WideNode::kWidth];
    const Box* children[WideNode::kWidth];
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      boxes[i] = Box::Empty();
      boxes[i].Extend(random.InCube(-1, 1).data());
      boxes[i].Extend(random.InCube(-1, 1).data());
      children[i] = &boxes[i];
    }
    node.is_exact = true;
    EncodeChildren(children, WideNode::kWidth, node);
    while (rays.size() < kRays) {
      const unit::Float3 org = random.InCube(-2, 0), to = random.InCube(0, 1);
      RayRecord ray{};
      for (size_t axis = 0; axis < 3; ++axis) {
        ray.org[axis] = org[axis];
        ray.dir[axis] = to[axis] - org[axis];
      }
      ray.tfar = unit::kInfinity;
      ray.mask = UINT32_MAX;
      if (FinishRecord(ray) && ray.Octant() == 0) rays.push_back(ray);
    }
    std::iota(list.begin(), list.end(), RayNumber{0});
  }

  ExactNode node{};
  std::vector<RayRecord> rays;
  std::vector<RayNumber> list;
};

void EnterNode(benchmark::State& state) {
  const Visit visit;
  const ChildPlanes planes(visit.node, PlaneOffsets(0));
  for (auto _ : state) {
    uint32_t any = 0;
    for (const RayRecord& ray : visit.rays) {
      any += EnterChildren(planes, SlabRay(ray), ray.tfar, [](size_t, EightPart) {});
    }
    benchmark::DoNotOptimize(any);
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * kRays));
}

void OrderNode(benchmark::State& state) {
  const Visit visit;
  const ChildPlanes planes(visit.node, PlaneOffsets(0));
  uint8_t order[WideNode::kWidth];
  for (auto _ : state) {
    OrderChildren(planes, visit.rays.data(), visit.list.data(), kRays, order);
    benchmark::DoNotOptimize(order);
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations()));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
DACRT_STEP_BENCHMARK("EnterChildren", EnterNode);
DACRT_STEP_BENCHMARK("OrderChildren", OrderNode);
}  // namespace
}  // namespace dacrt
#endif

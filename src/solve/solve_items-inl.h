// Direct solve in scenes of more than still triangles: rays against items of any shape.

#if defined(DACRT_SOLVE_SOLVE_ITEMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_ITEMS_INL_H_
#undef DACRT_SOLVE_SOLVE_ITEMS_INL_H_
#else
#define DACRT_SOLVE_SOLVE_ITEMS_INL_H_
#endif

#include <algorithm>

#include "solve/solve_facets-inl.h"
#include "solve/solve_instance.h"
#include "solve/solve_points-inl.h"
#include "solve/solve_user.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery>
class ItemSolver {
 public:
  explicit ItemSolver(const SolveTask& task) : task_(task), shapes_(task.meshes.shapes()) {}

  /// Tests the rays against the items named by `name(i)`, i < count.
  template <class Name>
  void Solve(size_t count, const Name& name, const RaySelection& rays) const {
    static_assert(FacetSolver<kQuery>::kMostItems <= PointBlock::kCapacity);
    constexpr size_t kAtOnce = FacetSolver<kQuery>::kMostItems;
    for (size_t begin = 0; begin < count; begin += kAtOnce) {
      MeshTable::Name items[kAtOnce];
      const size_t some = std::min(count - begin, kAtOnce);
      for (size_t i = 0; i < some; ++i) items[i] = name(begin + i);
      SolveSome({items, some}, rays);
    }
  }

 private:
  void SolveSome(std::span<MeshTable::Name> items, const RaySelection& rays) const {
    auto rest = items.begin();
    // Moves the items for which `belongs` holds to the front, and returns them.
    const auto take = [&](const auto& belongs) {
      const auto begin = rest;
      rest = std::stable_partition(rest, items.end(), [&](const MeshTable::Name& item) {
        return belongs(shapes_[item.mesh].shape);
      });
      return std::span<const MeshTable::Name>(begin, rest);
    };
    const auto facets = take([](Shape shape) {
      return shape == Shape::kTriangles || shape == Shape::kQuads || shape == Shape::kGrids;
    });
    if (!facets.empty()) FacetSolver<kQuery>(task_).Solve(facets, rays);
    for (const Shape points : {Shape::kSpheres, Shape::kDiscs, Shape::kOrientedDiscs}) {
      const auto some = take([&](Shape shape) { return shape == points; });
      if (!some.empty()) PointSolver<kQuery>(task_).Solve(points, some, rays);
    }
    for (; rest != items.end(); ++rest) {
      if (shapes_[rest->mesh].shape == Shape::kUser) {
        SolveUser(*rest, rays);
      } else {
        SolveInstanced(rest->mesh, rays);
      }
    }
  }

  /// Calls `function(slot)` for the rays that enter an item's own bounds and may meet it.
  template <class Function>
  void ForEachEntering(const MeshTable::Name& item, const RaySelection& rays,
                       const Function& function) const {
    Box bounds;
    if (!shapes_.BoundItem(item.mesh, item.primitive, bounds)) return;
    const WideBox box = Widen(bounds.lower, bounds.upper);
    ForEachRay(rays, [&](size_t slot) HWY_ATTR {
      if (!MayMeet(task_, slot, item.mesh)) return;
      const TestRays ray = BroadcastTestRay(task_.batch, slot);
      const M enters = Enters(IntersectBox(box, ray.org, ray.reciprocal), ray.tnear, ray.tfar);
      if (hn::AllFalse(kFloat, enters)) return;
      const float time = task_.frame->TimeOf(task_.batch.index[slot]);
      if (shapes_.MomentAt(item.mesh, time)) function(slot);
    });
  }

  void SolveUser(const MeshTable::Name& item, const RaySelection& rays) const {
    size_t slots[CallbackPacket::kMostLanes];
    const size_t most = task_.frame->options.callback_width;
    size_t count = 0;
    const auto call = [&] {
      CallUserFunction(kQuery, task_, item.mesh, item.primitive, {slots, count});
      count = 0;
    };
    ForEachEntering(item, rays, [&](size_t slot) {
      slots[count++] = slot;
      if (count == most) call();
    });
    if (count > 0) call();
  }

  void SolveInstanced(uint32_t geometry, const RaySelection& rays) const {
    if (!task_.frame->for_instance) return;  // There is one level of instances.
    InstanceRays entering(task_, geometry);
    ForEachEntering({geometry, 0}, rays, [&](size_t slot) {
      entering.Add(slot);
      if (entering.IsFull()) entering.Solve(kQuery);
    });
    entering.Solve(kQuery);
  }

  const SolveTask& task_;
  const Shapes& shapes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_ITEMS_INL_H_

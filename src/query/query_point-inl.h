// The walk of a point query over a scene: nearer subsets of the kept partition first.
// Roussopoulos, Kelley, Vincent, "Nearest neighbor queries", SIGMOD 1995, section 3: children in
// the order of their distance, those beyond what was found are left out.

#if defined(DACRT_QUERY_QUERY_POINT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_QUERY_QUERY_POINT_INL_H_
#undef DACRT_QUERY_QUERY_POINT_INL_H_
#else
#define DACRT_QUERY_QUERY_POINT_INL_H_
#endif

#include <optional>
#include <unordered_set>

#include "geometry/wide_node-inl.h"
#include "leaf/leaf_block.h"
#include "partition/rent_or_buy.h"
#include "partition/split_by_grid-inl.h"
#include "query/point_domain.h"
#include "query/point_task.h"
#include "runtime/split_memory.h"
#include "scene/scene_parts.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A point query in one scene: the one that was asked, or one that it has an instance of.
class PointWalk {
 public:
  /// `instance` is the one that `scene` is seen in, null outside of instances; `to_scene` as in
  /// PointDomain.
  PointWalk(PointTask& task, const SceneParts& scene, const AffineTransform* to_scene,
            const InstanceSpace* instance)
      : task_(task),
        scene_(scene),
        instance_(instance),
        is_top_(!to_scene),
        domain_(to_scene, task.query.point),
        split_memory_(task.workspaces) {
    domain_.SetRadius(task.radius);
  }

  void Walk() {
    if (!domain_.IsValid() || scene_.triangle_count == 0) return;
    if (scene_.kept) return WalkSubset(0);
    const GeometryTable& all = scene_.geometries;
    for (uint32_t geometry = 0; geometry < all.size(); ++geometry) {
      for (uint32_t item = 0; item < all[geometry].triangle_count; ++item) {
        VisitItem({geometry, item});
      }
    }
  }

 private:
  void WalkSubset(uint32_t number) {
    KeptPartition& kept = *scene_.kept;
    Subset& subset = kept.subset(number);
    const auto visit_all = [&] {
      for (const uint32_t entry : kept.OrderOf(subset)) VisitEntry(entry);
    };
    std::optional<uint32_t> root;
    {
      const SplitMemory::Use scratch(split_memory_);
      root = RootOf(kept, number, 1, scratch.get(), nullptr, [] { throw std::bad_alloc(); });
    }
    if (root == Subset::kNoRoom) return visit_all();
    if (root && Subset::IsRented(*root)) {
      const rent_or_buy::Stay stay(kept, subset);
      if (stay.root()) return WalkNode(kept.node(stay.root()->number()));
      root = subset.root;
    }
    if (root) WalkNode(kept.node(*root));
  }

  void WalkNode(const WideNode& node) {
    HWY_ALIGN float squares[WideNode::kWidth];
    uint64_t near = ChildrenInDomain(node, squares);
    while (near != 0) {
      const size_t i = TakeNearest(near, squares);
      if (!(squares[i] <= domain_.square())) return;
      const ChildWord child = node.Child(i);
      if (child.IsLeaf()) {
        VisitLeaf(child);
      } else if (child.IsSubset()) {
        WalkSubset(child.number());
      } else {
        WalkNode(scene_.kept->node(child.number()));
      }
    }
  }

  /// The children that have a part in the domain, a bit each, and the squares of their distances.
  uint64_t ChildrenInDomain(const WideNode& node, float* squares) const {
    uint64_t near = 0;
    // Through the planes of no octant in particular: lower ones are near.
    const ChildPlanes planes(node, PlaneOffsets(0));
    for (size_t part = 0; part < kParts; ++part) {
      EightPart square = hn::Zero(kEightTag);
      hn::Mask<EightTag> meets = hn::FirstN(kEightTag, kPartLanes);
      for (int axis = 0; axis < 3; ++axis) {
        const EightPart center = hn::Set(kEightTag, domain_.center()[axis]);
        const EightPart below = hn::Sub(planes.near[part][axis], center);
        const EightPart above = hn::Sub(center, planes.far[part][axis]);
        const EightPart distance = hn::Max(hn::Max(below, above), hn::Zero(kEightTag));
        meets = hn::And(meets, hn::Le(distance, hn::Set(kEightTag, domain_.reach()[axis])));
        square = hn::Add(square, hn::Mul(distance, distance));
      }
      meets = hn::And(meets, hn::Le(square, hn::Set(kEightTag, domain_.square())));
      near |= Bits(kEightTag, meets) << (part * kPartLanes);
      hn::Store(square, kEightTag, squares + part * kPartLanes);
    }
    return near & node.UsedChildren();
  }

  /// Takes the child with the least distance out of `children`, which are not empty.
  static size_t TakeNearest(uint64_t& children, const float* squares) {
    size_t nearest = hwy::Num0BitsBelowLS1Bit_Nonzero64(children);
    for (uint64_t rest = children & (children - 1); rest != 0; rest &= rest - 1) {
      const size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero64(rest);
      if (squares[i] < squares[nearest]) nearest = i;
    }
    children &= ~(uint64_t{1} << nearest);
    return nearest;
  }

  void VisitLeaf(ChildWord leaf) {
    const PartitionView partition = scene_.kept->view();
    uint32_t first = leaf.IsBlock() ? partition.FirstBlock(leaf)->first : leaf.range();
    for (bool is_last = false; !is_last; ++first) {
      is_last = (partition.order[first] & KeptOrder::kLastOfLeaf) != 0;
      VisitEntry(partition.order[first]);
    }
  }

  void VisitEntry(uint32_t entry) {
    VisitItem(scene_.geometries.Locate(KeptOrder::NumberOf(entry)));
  }

  void VisitItem(GeometryTable::Name item) {
    const Shapes& shapes = scene_.geometries.shapes();
    const Geometry& geometry = shapes[item.geometry];
    const bool is_instance = geometry.shape == Shape::kInstance;
    if (!is_instance && !geometry.point_callback) return;
    TriangleRef bounds;
    if (!BoundTriangle(scene_.geometries, item, bounds)) return;
    if (!domain_.Meets(bounds.lower, bounds.upper)) return;
    if (shapes.IsMoving(item.geometry) && !MeetsNow(item)) return;
    if (is_instance) return WalkInstance(item.geometry);
    const uint32_t primitive = shapes.PrimitiveOf(item.geometry, item.primitive);
    if (geometry.shape == Shape::kGrids && !MarkGrid(item.geometry, primitive)) return;
    const float radius = geometry.point_callback(
        {geometry.geometry_id, primitive, instance_, task_.radius, task_.query.call});
    if (radius < task_.radius) ShrinkTo(radius);
  }

  /// Whether a moving item is there at the query's time, and then in the domain.
  bool MeetsNow(GeometryTable::Name item) const {
    const Shapes& shapes = scene_.geometries.shapes();
    const std::optional<Moment> moment = shapes.MomentAt(item.geometry, task_.query.time);
    if (!moment) return false;
    const Box bounds = shapes.BoundItemAt(item.geometry, item.primitive, *moment);
    return domain_.Meets(bounds.lower, bounds.upper);
  }

  /// False if the grid was visited before: it has an item for each of its cells.
  bool MarkGrid(uint32_t geometry, uint32_t primitive) {
    return visited_grids_.insert(uint64_t{geometry} << 32 | primitive).second;
  }

  void WalkInstance(uint32_t geometry) {
    if (!is_top_) return;  // There is one level of instances.
    const Shapes& shapes = scene_.geometries.shapes();
    const Geometry& instance = shapes[geometry];
    InstanceSpace space;
    space.instance_id = instance.geometry_id;
    space.to_instance = shapes.ToInstance(geometry, task_.query.time);
    space.from_instance = TransformAt(instance.transforms, instance.time_range, task_.query.time);
    space.similarity_scale = SimilarityScale(space.to_instance);
    PointWalk(task_, *shapes.InstancedScene(geometry), &space.to_instance, &space).Walk();
    ShrinkTo(task_.radius);
  }

  void ShrinkTo(float radius) {
    task_.radius = radius;
    domain_.SetRadius(radius);
  }

  PointTask& task_;
  const SceneParts& scene_;
  const InstanceSpace* const instance_;
  const bool is_top_;
  PointDomain domain_;
  SplitMemory split_memory_;
  std::unordered_set<uint64_t> visited_grids_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_QUERY_QUERY_POINT_INL_H_

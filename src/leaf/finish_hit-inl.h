// From leaf and lane to the hit: the triangle test once more for the pairs that won, a lane each,
// in the operations of the leaf test, so that what it gives is what that one found.

#if defined(DACRT_LEAF_FINISH_HIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_FINISH_HIT_INL_H_
#undef DACRT_LEAF_FINISH_HIT_INL_H_
#else
#define DACRT_LEAF_FINISH_HIT_INL_H_
#endif

#include <hwy/cache_control.h>

#include "geometry/robust_test-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/gather_leaf-inl.h"
#include "leaf/leaf_block.h"
#include "leaf/leaf_names.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The block of a leaf in which facets that do not move stand.
HWY_INLINE const LeafBlock& FacetsIn(const LeafBlock* block) {
  while (HWY_UNLIKELY(block->kind != LeafKind::kFacets || block->is_timed)) block = block->Next();
  return *block;
}
/// The same of a leaf that carries its geometry.
HWY_INLINE const LeafBlock& FacetsOf(const TraceTask& task, ChildWord leaf) {
  return FacetsIn(task.partition.FirstBlock(leaf));
}

/// Room for a leaf that carries none, made to be looked at once.
struct LeafRoom {
  alignas(64) std::byte blocks[kMostLeafBytes];
};
/// Apart, so that the common way stays short.
inline HWY_NOINLINE const LeafBlock& MakeFacets(const TraceTask& task, ChildWord leaf,
                                                LeafRoom& room) {
  LeafGather(task.scene.geometries, task.partition.order)
      .Gather(leaf.range(), kLeafLanes, room.blocks);
  return FacetsIn(reinterpret_cast<const LeafBlock*>(room.blocks));
}
HWY_INLINE const LeafBlock& FacetsOf(const TraceTask& task, ChildWord leaf, LeafRoom& room) {
  return HWY_LIKELY(leaf.IsBlock()) ? FacetsOf(task, leaf) : MakeFacets(task, leaf, room);
}

/// A hit, with t, u and v as the triangle test has them.
HWY_INLINE FullHit HitOf(const SceneParts& scene, uint32_t instance_id, GeometryTable::Name name,
                         bool is_second, float t, float u, float v, float ng_x, float ng_y,
                         float ng_z) {
  FullHit hit{{ng_x, ng_y, ng_z},
              is_second ? 1 - u : u,
              is_second ? 1 - v : v,
              name.primitive,
              scene.geometries[name.geometry].geometry_id,
              instance_id,
              t};
  const Shapes& shapes = scene.geometries.shapes();
  if (HWY_UNLIKELY(shapes[name.geometry].shape == Shape::kGrids)) {
    hit.primitive_id = shapes.PlaceInGrid(name.geometry, name.primitive, hit.u, hit.v);
  }
  return hit;
}

/// Some rays with the triangles that they hit, a lane each. With kAsksBoxes it is asked as well
/// whether they enter the triangles' own boxes before.
template <class Tag, bool kAsksBoxes = false>
class FinishedHitsOf {
 public:
  explicit FinishedHitsOf(const TraceTask& task) : task_(task) {}

  static constexpr size_t kMost = hn::MaxLanes(Tag());

  /// Asks for the memory of the leaf that a ray hits; the record may be scrap.
  HWY_INLINE void Prefetch(const RayRecord& ray) const {
    const auto* const block =
        reinterpret_cast<const std::byte*>(task_.partition.FirstBlock(ChildWord(ray.hit)));
    hwy::Prefetch(block);
    hwy::Prefetch(block + 64);
    hwy::Prefetch(block + 128);
  }

  void Add(RayNumber number) {
    const RayRecord& ray = task_.rays[number];
    const ChildWord leaf(ray.hit);
    const size_t block_lane = ray.state >> RayRecord::kLaneShift;
    if (HWY_LIKELY(leaf.IsBlock())) return Add(number, ray, block_lane, FacetsOf(task_, leaf));
    AddFromRange(number, ray, block_lane, leaf);
  }

  size_t count() const { return count_; }
  RayNumber number(size_t i) const { return numbers_[i]; }

  /// Calls `take(i, geometry, hit)` for each, and is empty then. With kAsksBoxes `take` has one
  /// more argument: whether the hit counts, and its key is its distance (see triangle_test-inl.h).
  template <class Take>
  HWY_INLINE void Finish(const Take& take) {
    for (size_t i = count_; i < kMost; ++i) CopyLane(0, i);
    TestRaysOf<Vec> rays;
    Vec v[3][3];
    for (int axis = 0; axis < 3; ++axis) {
      rays.org[axis] = hn::Load(Tag(), org_[axis]);
      rays.dir[axis] = hn::Load(Tag(), dir_[axis]);
      for (int corner = 0; corner < 3; ++corner) {
        v[corner][axis] = hn::Load(Tag(), corner_[corner][axis]);
      }
    }
    const auto triangles = TrianglesOf(v[0], v[1], v[2]);
    Vec t, u, w;
    if (task_.scene.geometries.shapes().robust()) {
      const auto terms = TestRobustly(rays, triangles, v[1], v[2]);
      t = hn::Div(Dot(triangles.ng, terms.v0), terms.den);
      u = hn::Div(terms.u, terms.sum);
      w = hn::Div(terms.v, terms.sum);
    } else {
      const auto terms = EdgeTerms(rays.org, rays.dir, triangles);
      t = hn::Div(DepthTerm(triangles, terms), terms.den);
      u = hn::Div(terms.u, terms.den);
      w = hn::Div(terms.v, terms.den);
    }
    const uint64_t enter = kAsksBoxes ? EnterOwnBoxes(rays, v, t) : 0;
    const Vec one = hn::Set(Tag(), 1.0f);
    HWY_ALIGN float out[6][kMost];
    hn::Store(t, Tag(), out[0]);
    hn::Store(hn::Min(u, one), Tag(), out[1]);
    hn::Store(hn::Min(w, one), Tag(), out[2]);
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(triangles.ng[axis], Tag(), out[3 + axis]);
    }
    for (size_t i = 0; i < count_; ++i) {
      const GeometryTable::Name name = NameOf(task_.scene.geometries, *places_[i], geometries_[i]);
      const FullHit hit = HitOf(task_.scene, task_.instance_id, name, is_second_[i], out[0][i],
                                out[1][i], out[2][i], out[3][i], out[4][i], out[5][i]);
      if constexpr (kAsksBoxes) {
        take(i, name.geometry, hit, (enter >> i & 1) != 0);
      } else {
        take(i, name.geometry, hit);
      }
    }
    count_ = 0;
  }

 private:
  using Vec = hn::Vec<Tag>;

  /// Lanes that enter their triangles' own boxes before `t`.
  HWY_INLINE uint64_t EnterOwnBoxes(const TestRaysOf<Vec>& rays, const Vec (*v)[3], Vec t) const {
    const auto interval = IntersectSlabs([&](int axis) HWY_ATTR {
      return SlabsOf<Vec>::Of(OwnLower(v[0][axis], v[1][axis], v[2][axis]),
                              OwnUpper(v[0][axis], v[1][axis], v[2][axis]), rays.org[axis],
                              hn::Load(Tag(), reciprocal_[axis]));
    });
    return Bits(Tag(), Enters(interval, hn::Load(Tag(), tnear_), t));
  }

  HWY_INLINE void Add(RayNumber number, const RayRecord& ray, size_t block_lane,
                      const LeafBlock& block) {
    const float* const vertices = block.vertex_data();
    for (size_t corner = 0; corner < 3; ++corner) {
      const float* const vertex = vertices + block.indices()[corner * kLeafLanes + block_lane];
      for (size_t axis = 0; axis < 3; ++axis) {
        corner_[corner][axis][count_] = vertex[axis * block.vertices];
      }
    }
    AddRay(number, ray, block.PlaceOf(block_lane), block.geometry, block.second >> block_lane & 1);
  }

  /// Of a leaf that carries no geometry.
  HWY_NOINLINE void AddFromRange(RayNumber number, const RayRecord& ray, size_t block_lane,
                                 ChildWord leaf) {
    const LeafItems items =
        FindItems(task_.scene.geometries, task_.partition.order, leaf.range(), block_lane + 1);
    if (HWY_LIKELY(items.is_plain)) {
      return Add(number, ray, leaf.range() + block_lane, items.names[block_lane]);
    }
    LeafRoom room;
    Add(number, ray, block_lane, MakeFacets(task_, leaf, room));
  }

  /// A triangle that stands in the lane of its place in the leaf.
  HWY_INLINE void Add(RayNumber number, const RayRecord& ray, size_t place,
                      GeometryTable::Name name) {
    Corners corners = {};
    task_.scene.geometries.ReadCorners(name.geometry, name.primitive, corners);
    for (size_t corner = 0; corner < 3; ++corner) {
      for (size_t axis = 0; axis < 3; ++axis) {
        corner_[corner][axis][count_] = corners.v[corner][axis];
      }
    }
    AddRay(number, ray, place, name.geometry, false);
  }

  HWY_INLINE void AddRay(RayNumber number, const RayRecord& ray, size_t place, uint32_t geometry,
                         bool is_second) {
    for (int axis = 0; axis < 3; ++axis) {
      org_[axis][count_] = ray.org[axis];
      dir_[axis][count_] = ray.dir[axis];
      if constexpr (kAsksBoxes) reciprocal_[axis][count_] = ray.reciprocal[axis];
    }
    if constexpr (kAsksBoxes) tnear_[count_] = ray.tnear;
    // Its name, which is far away, is wanted last.
    places_[count_] = task_.partition.order + place;
    hwy::Prefetch(places_[count_]);
    geometries_[count_] = geometry;
    is_second_[count_] = is_second;
    numbers_[count_++] = number;
  }

  void CopyLane(size_t from, size_t to) {
    for (int axis = 0; axis < 3; ++axis) {
      org_[axis][to] = org_[axis][from];
      dir_[axis][to] = dir_[axis][from];
      for (auto& corner : corner_) corner[axis][to] = corner[axis][from];
    }
  }

  const TraceTask& task_;
  HWY_ALIGN float org_[3][kMost];
  HWY_ALIGN float dir_[3][kMost];
  HWY_ALIGN float reciprocal_[3][kMost];
  HWY_ALIGN float tnear_[kMost];
  HWY_ALIGN float corner_[3][3][kMost];
  const uint32_t* places_[kMost];
  uint32_t geometries_[kMost];
  bool is_second_[kMost];
  RayNumber numbers_[kMost];
  size_t count_ = 0;
};

using FinishedHits = FinishedHitsOf<EightTag>;

/// The hit of one ray.
inline FullHit FinishHit(const TraceTask& task, RayNumber number, uint32_t& geometry) {
  FinishedHitsOf<hn::CappedTag<float, 1>> hits(task);
  hits.Add(number);
  FullHit finished;
  hits.Finish([&](size_t, uint32_t its_geometry, const FullHit& hit) HWY_ATTR {
    geometry = its_geometry;
    finished = hit;
  });
  return finished;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_FINISH_HIT_INL_H_

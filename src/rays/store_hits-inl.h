// From the engine's hits to the caller's records: the only place that writes them.

#if defined(DACRT_RAYS_STORE_HITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_STORE_HITS_INL_H_
#undef DACRT_RAYS_STORE_HITS_INL_H_
#else
#define DACRT_RAYS_STORE_HITS_INL_H_
#endif

#include <algorithm>
#include <cstring>
#include <limits>

#include "geometry/triangle_test-inl.h"
#include "rays/ray_batch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <class T>
HWY_INLINE void WriteComponent(const RayView& view, RayView::Component component, size_t i,
                               T value) {
  if (component == RayView::kAbsent) return;
  memcpy(reinterpret_cast<void*>(view.Address(component, i)), &value, sizeof(value));
}

/// Marks the blocked rays of `block`. Returns their number.
inline size_t StoreBlocked(const RayView& view, size_t first, const RayBatch& batch,
                           const RayBlock& block) {
  size_t blocked = 0;
  for (size_t slot = block.begin; slot < block.begin + block.count; ++slot) {
    if (batch.tfar[slot] >= 0) continue;
    WriteComponent(view, view.tfar, first + batch.index[slot],
                   -std::numeric_limits<float>::infinity());
    ++blocked;
  }
  return blocked;
}

/// Writes the hits of `block` that were kept in full. Returns their number.
inline size_t StoreFullHits(const RayView& view, size_t first, const RayBatch& batch,
                            const RayBlock& block) {
  size_t hits = 0;
  for (size_t slot = block.begin; slot < block.begin + block.count; ++slot) {
    const uint32_t index = batch.index[slot];
    if (batch.hits[index].mesh == Hit::kNone) continue;
    const FullHit& hit = batch.full_hits[index];
    const size_t ray = first + index;
    WriteComponent(view, view.tfar, ray, hit.t);
    WriteComponent(view, view.ng_x, ray, hit.ng[0]);
    WriteComponent(view, view.ng_y, ray, hit.ng[1]);
    WriteComponent(view, view.ng_z, ray, hit.ng[2]);
    WriteComponent(view, view.u, ray, hit.u);
    WriteComponent(view, view.v, ray, hit.v);
    WriteComponent(view, view.primitive_id, ray, hit.primitive_id);
    WriteComponent(view, view.geometry_id, ray, hit.geometry_id);
    WriteComponent(view, view.instance_id, ray, hit.instance_id);
    ++hits;
  }
  return hits;
}

/// Rays with hits, a lane each with the triangle at the same place of a triangle block.
struct StoredRays {
  HWY_ALIGN float org[3][TriangleBlock::kCapacity];
  HWY_ALIGN float dir[3][TriangleBlock::kCapacity];
  uint32_t index[TriangleBlock::kCapacity];
  Hit hits[TriangleBlock::kCapacity];
};

/// Writes the closest hits of `block`. Returns their number. Everything but the triangle's name is
/// computed here from ray and corners, just as the direct solve did, which is cheaper than to carry
/// it along.
inline size_t StoreClosest(const RayView& view, size_t first, const MeshTable& meshes,
                           const RayBatch& batch, const RayBlock& block, TriangleBlock& triangles) {
  StoredRays rays;
  HWY_ALIGN float t[kMaxLanes], u[kMaxLanes], v[kMaxLanes];
  const V one = hn::Set(kFloat, 1.0f);
  size_t hits = 0;
  const size_t end = block.begin + block.count;
  for (size_t slot = block.begin; slot < end;) {
    size_t count = 0;
    for (; slot < end && count < TriangleBlock::kCapacity; ++slot) {
      const Hit hit = batch.hits[batch.index[slot]];
      if (hit.mesh == Hit::kNone) continue;
      rays.hits[count] = {hit.primitive, hit.mesh & ~Hit::kAtLimit};
      rays.index[count] = batch.index[slot];
      for (int axis = 0; axis < 3; ++axis) {
        rays.org[axis][count] = batch.org[axis][slot];
        rays.dir[axis][count] = batch.dir[axis][slot];
      }
      ++count;
    }
    GatherTriangles(
        meshes, count, [&](size_t i) -> const Hit& { return rays.hits[i]; }, triangles);
    for (size_t i = 0; i < count; ++i) {
      const size_t lane = i % Lanes();
      if (lane == 0) {
        V org[3], dir[3];
        for (int axis = 0; axis < 3; ++axis) {
          org[axis] = hn::Load(kFloat, rays.org[axis] + i);
          dir[axis] = hn::Load(kFloat, rays.dir[axis] + i);
        }
        const TestTriangles test_triangles = LoadTestTriangles<false>(triangles, i);
        const PairTerms terms = EdgeTerms(org, dir, test_triangles);
        hn::Store(hn::Div(DepthTerm(test_triangles, terms), terms.den), kFloat, t);
        hn::Store(hn::Min(hn::Div(terms.u, terms.den), one), kFloat, u);
        hn::Store(hn::Min(hn::Div(terms.v, terms.den), one), kFloat, v);
      }
      const size_t ray = first + rays.index[i];
      WriteComponent(view, view.tfar, ray, t[lane]);
      WriteComponent(view, view.ng_x, ray, triangles.ng[0][i]);
      WriteComponent(view, view.ng_y, ray, triangles.ng[1][i]);
      WriteComponent(view, view.ng_z, ray, triangles.ng[2][i]);
      WriteComponent(view, view.u, ray, u[lane]);
      WriteComponent(view, view.v, ray, v[lane]);
      WriteComponent(view, view.primitive_id, ray, rays.hits[i].primitive);
      WriteComponent(view, view.geometry_id, ray, meshes[rays.hits[i].mesh].geometry_id);
      WriteComponent(view, view.instance_id, ray, view.instance_value);
    }
    hits += count;
  }
  return hits;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_STORE_HITS_INL_H_

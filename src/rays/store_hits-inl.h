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

#include "rays/ray_batch.h"
#include "solve/triangle_block-inl.h"

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

/// Writes the closest hits of `block`. Returns their number. The normals are computed anew from the
/// corners, as the triangle test computed them, which is cheaper than to carry them along.
inline size_t StoreClosest(const RayView& view, size_t first, const MeshTable& meshes,
                           const RayBatch& batch, const RayBlock& block, TriangleBlock& triangles) {
  struct Name {
    uint32_t mesh;
    uint32_t primitive;
    size_t slot;
  };
  Name names[TriangleBlock::kCapacity];
  size_t hits = 0;
  const size_t end = block.begin + block.count;
  for (size_t slot = block.begin; slot < end;) {
    size_t count = 0;
    for (; slot < end && count < TriangleBlock::kCapacity; ++slot) {
      const Hit& hit = batch.hits[batch.index[slot]];
      if (hit.mesh == Hit::kNone) continue;
      names[count++] = {hit.mesh & ~Hit::kAtLimit, hit.primitive, slot};
    }
    GatherTriangles(
        meshes, count, [&](size_t i) -> const Name& { return names[i]; }, triangles);
    for (size_t i = 0; i < count; ++i) {
      const Name& name = names[i];
      const Hit& hit = batch.hits[batch.index[name.slot]];
      const size_t ray = first + batch.index[name.slot];
      WriteComponent(view, view.tfar, ray, batch.tfar[name.slot]);
      WriteComponent(view, view.ng_x, ray, triangles.ng[0][i]);
      WriteComponent(view, view.ng_y, ray, triangles.ng[1][i]);
      WriteComponent(view, view.ng_z, ray, triangles.ng[2][i]);
      WriteComponent(view, view.u, ray, hit.u);
      WriteComponent(view, view.v, ray, hit.v);
      WriteComponent(view, view.primitive_id, ray, name.primitive);
      WriteComponent(view, view.geometry_id, ray, meshes[name.mesh].geometry_id);
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

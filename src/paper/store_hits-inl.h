// From the engine's hits to the caller's records: the only place that writes them.

#if defined(DACRT_PAPER_STORE_HITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_STORE_HITS_INL_H_
#undef DACRT_PAPER_STORE_HITS_INL_H_
#else
#define DACRT_PAPER_STORE_HITS_INL_H_
#endif

#include <algorithm>

#include "paper/direct_solve-inl.h"
#include "rays/record_layout.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Marks the blocked rays of `block`. Returns their number.
inline size_t StoreBlocked(const RayView& view, size_t first, const RayBatch& batch,
                           const RayBlock& block) {
  const RecordLayout layout(view);
  size_t blocked = 0;
  for (size_t slot = block.begin; slot < block.begin + block.count; ++slot) {
    if (batch.tfar[slot] >= 0) continue;
    layout.WriteBlocked(first + batch.index[slot]);
    ++blocked;
  }
  return blocked;
}

/// Writes the hits of `block` that were kept in full. Returns their number.
inline size_t StoreFullHits(const RayView& view, size_t first, const RayBatch& batch,
                            const RayBlock& block) {
  const RecordLayout layout(view);
  size_t hits = 0;
  for (size_t slot = block.begin; slot < block.begin + block.count; ++slot) {
    const uint32_t index = batch.index[slot];
    if (batch.hits[index].geometry == PaperHit::kNone) continue;
    layout.WriteHit(first + index, batch.full_hits[index]);
    ++hits;
  }
  return hits;
}

/// Rays with hits, a lane each with the triangle at the same place of a triangle block.
struct StoredRays {
  HWY_ALIGN float org[3][TriangleBlock::kCapacity];
  HWY_ALIGN float dir[3][TriangleBlock::kCapacity];
  uint32_t index[TriangleBlock::kCapacity];
  PaperHit hits[TriangleBlock::kCapacity];
};

/// Writes the closest hits of `block`. Returns their number. Everything but the triangle's name is
/// computed here from ray and corners, just as the direct solve did, which is cheaper than to carry
/// it along.
inline size_t StoreClosest(const RayView& view, size_t first, const GeometryTable& geometries,
                           const RayBatch& batch, const RayBlock& block, TriangleBlock& triangles) {
  const RecordLayout layout(view);
  StoredRays rays;
  HWY_ALIGN float t[kMaxLanes], u[kMaxLanes], v[kMaxLanes];
  const V one = hn::Set(kFloat, 1.0f);
  size_t hits = 0;
  const size_t end = block.begin + block.count;
  for (size_t slot = block.begin; slot < end;) {
    size_t count = 0;
    for (; slot < end && count < TriangleBlock::kCapacity; ++slot) {
      const PaperHit hit = batch.hits[batch.index[slot]];
      if (hit.geometry == PaperHit::kNone) continue;
      rays.hits[count] = {hit.primitive, hit.geometry & ~PaperHit::kAtLimit};
      rays.index[count] = batch.index[slot];
      for (int axis = 0; axis < 3; ++axis) {
        rays.org[axis][count] = batch.org[axis][slot];
        rays.dir[axis][count] = batch.dir[axis][slot];
      }
      ++count;
    }
    GatherTriangles(
        geometries, count, [&](size_t i) -> const PaperHit& { return rays.hits[i]; }, triangles);
    for (size_t i = 0; i < count; ++i) {
      const size_t lane = i % Lanes();
      if (lane == 0) {
        V org[3], dir[3];
        for (int axis = 0; axis < 3; ++axis) {
          org[axis] = hn::Load(kFloat, rays.org[axis] + i);
          dir[axis] = hn::Load(kFloat, rays.dir[axis] + i);
        }
        const TestTriangles test_triangles = LoadTriangles<false>(triangles, i).test;
        const auto terms = EdgeTerms(org, dir, test_triangles);
        hn::Store(hn::Div(DepthTerm(test_triangles, terms), terms.den), kFloat, t);
        hn::Store(hn::Min(hn::Div(terms.u, terms.den), one), kFloat, u);
        hn::Store(hn::Min(hn::Div(terms.v, terms.den), one), kFloat, v);
      }
      layout.WriteHit(first + rays.index[i],
                      {{triangles.ng[0][i], triangles.ng[1][i], triangles.ng[2][i]},
                       u[lane],
                       v[lane],
                       rays.hits[i].primitive,
                       geometries[rays.hits[i].geometry].geometry_id,
                       view.instance_value,
                       t[lane]});
    }
    hits += count;
  }
  return hits;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_STORE_HITS_INL_H_

// A leaf that carries no geometry, made for one visit: as MakeLeaf does it, with many loads at once.

#if defined(DACRT_LEAF_GATHER_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_GATHER_LEAF_INL_H_
#undef DACRT_LEAF_GATHER_LEAF_INL_H_
#else
#define DACRT_LEAF_GATHER_LEAF_INL_H_
#endif

#include "geometry/four_by_four-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/make_leaf.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR
/// Three values. What stands behind them may not be the caller's.
HWY_INLINE CornerPart LoadThree(const float* values) {
#if HWY_MEM_OPS_MIGHT_FAULT
  const hn::Half<CornerTag> two;
  const hn::Half<decltype(two)> one;
  return hn::Combine(kCornerTag, hn::ZeroExtendVector(two, hn::LoadU(one, values + 2)),
                     hn::LoadU(two, values));
#else
  return hn::MaskedLoad(hn::FirstN(kCornerTag, 3), kCornerTag, values);
#endif
}

/// A vertex in each four lanes: the first one, and the fourth behind it if there are eight.
template <class Tag>
HWY_INLINE hn::Vec<Tag> LoadVertices(Tag d, const float* const* vertices) {
  if constexpr (hn::MaxLanes(Tag()) == 8) {
    return hn::Combine(d, LoadThree(vertices[4]), LoadThree(vertices[0]));
  } else {
    return LoadThree(vertices[0]);
  }
}

/// Where the vertices of some triangles stand, by corner and lane.
struct VertexPlaces {
  static constexpr float kNothing[3] = {};

  const float* corner[3][kLeafLanes];

  VertexPlaces(const GeometryTable& geometries, const LeafItems& items) {
    for (size_t lane = 0; lane < kLeafLanes; ++lane) {
      // A lane without a triangle, or with one whose indices are no longer legal, has no area.
      const bool has = lane < items.count && Find(geometries, items.names[lane], lane);
      if (HWY_UNLIKELY(!has)) corner[0][lane] = corner[1][lane] = corner[2][lane] = kNothing;
    }
  }

 private:
  HWY_INLINE bool Find(const GeometryTable& geometries, GeometryTable::Name name, size_t lane) {
    const TriangleMesh& mesh = geometries[name.geometry];
    uint32_t index[3];
    memcpy(index, geometries.IndicesOf(name.geometry, name.primitive), sizeof(index));
    const auto* const vertices = static_cast<const char*>(mesh.vertices);
    for (size_t k = 0; k < 3; ++k) {
      if (HWY_UNLIKELY(index[k] >= mesh.vertex_count)) return false;
      corner[k][lane] = reinterpret_cast<const float*>(vertices + index[k] * mesh.vertex_stride);
    }
    return true;
  }
};

/// The values of vertices, those of an axis one behind the other, as LeafBlock::kByLane has them.
HWY_INLINE void GatherVertices(const VertexPlaces& places, float* out) {
  for (size_t corner = 0; corner < 3; ++corner) {
    for (size_t part = 0; part < kParts; ++part) {
      const size_t first = part * kPartLanes;
      const float* const* const vertices = places.corner[corner] + first;
      FourByFour<EightTag> rows;
      for (size_t i = 0; i < 4; ++i) rows.v[i] = LoadVertices(kEightTag, vertices + i);
      rows.Transpose();
      for (size_t axis = 0; axis < 3; ++axis) {
        hn::StoreU(rows.v[axis], kEightTag,
                   out + axis * LeafBlock::kByLane + corner * kLeafLanes + first);
      }
    }
  }
}
#endif

/// MakeLeaf with SharedVertices::kRepeat.
HWY_INLINE void GatherLeaf(const GeometryTable& geometries, const LeafItems& items, uint32_t first,
                           std::byte* blocks) {
#if HWY_TARGET != HWY_SCALAR
  if (HWY_LIKELY(items.is_plain)) {
    auto& block = *reinterpret_cast<LeafBlock*>(blocks);
    BeginTrianglesByLane(items, first, block);
    GatherVertices(VertexPlaces(geometries, items), block.vertex_data());
    return;
  }
#endif
  FetchVertices(geometries, items);
  MakeLeaf(geometries, items, first, SharedVertices::kRepeat, blocks);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_GATHER_LEAF_INL_H_

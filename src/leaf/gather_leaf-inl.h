// A leaf that carries no geometry, made for one visit: as MakeLeaf does it, with many loads at once.

#if defined(DACRT_LEAF_GATHER_LEAF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_GATHER_LEAF_INL_H_
#undef DACRT_LEAF_GATHER_LEAF_INL_H_
#else
#define DACRT_LEAF_GATHER_LEAF_INL_H_
#endif

#include <hwy/cache_control.h>

#include "geometry/four_by_four-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/make_leaf.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR
/// Where the vertices of some triangles stand, by corner and lane, each with one more float behind
/// it that may be read.
struct VertexPlaces {
  const float* corner[3][kLeafLanes];
  float copies[3][kLeafLanes][4];  ///< of vertices behind which there may be nothing

  /// A lane without a triangle, or with one whose indices are no longer legal, has no area.
  HWY_INLINE void SetNothing(size_t lane) {
    static constexpr float kNothing[4] = {};
    for (auto& lanes : corner) lanes[lane] = kNothing;
  }

  HWY_INLINE void SetCopy(size_t k, size_t lane, const float* vertex) {
    memcpy(copies[k][lane], vertex, 3 * sizeof(float));
    copies[k][lane][3] = 0;
    corner[k][lane] = copies[k][lane];
  }
};

/// The values of vertices, those of an axis one behind the other, as LeafBlock::kByLane has them.
HWY_INLINE void GatherVertices(const VertexPlaces& places, float* out) {
  for (size_t corner = 0; corner < 3; ++corner) {
    for (size_t part = 0; part < kParts; ++part) {
      const size_t first = part * kPartLanes;
      const float* const* const vertices = places.corner[corner] + first;
      auto rows = FourByFour<EightTag>::Load([&](size_t i) { return vertices[i]; });
      rows.Transpose();
      for (size_t axis = 0; axis < 3; ++axis) {
        hn::StoreU(rows.v[axis], kEightTag,
                   out + axis * LeafBlock::kByLane + corner * kLeafLanes + first);
      }
    }
  }
}
#endif

/// Makes leaves of the items of an order, one after the other.
class LeafGather {
 public:
  LeafGather(const GeometryTable& geometries, const uint32_t* order)
      : geometries_(geometries), order_(order) {
    Take(0);
  }

  struct Gathered {
    size_t count;
    bool is_last;  ///< the last item is marked as that of the leaf
  };

  /// MakeLeaf with SharedVertices::kRepeat, of the items that FindItems finds.
  HWY_INLINE Gathered Gather(uint32_t first, size_t most, std::byte* blocks) {
#if HWY_TARGET != HWY_SCALAR
    const Gathered triangles = GatherTriangles(first, most, blocks);
    if (HWY_LIKELY(triangles.count != 0)) return triangles;
#endif
    return GatherAny(first, most, blocks);
  }

  /// Asks for the memory of what the next leaf is made of.
  HWY_INLINE void Fetch(uint32_t first, size_t most) const {
    for (size_t i = 0; i < most; ++i) {
      const uint32_t entry = order_[first + i];
      const uint32_t primitive = KeptOrder::NumberOf(entry) - begin_;
      if (HWY_LIKELY(primitive < size_)) hwy::Prefetch(IndicesOf(primitive));
      if ((entry & KeptOrder::kLastOfLeaf) != 0) return;
    }
  }

 private:
  HWY_NOINLINE Gathered GatherAny(uint32_t first, size_t most, std::byte* blocks) {
    const LeafItems items = FindItems(geometries_, order_, first, most);
    FetchVertices(geometries_, items);
    MakeLeaf(geometries_, items, first, SharedVertices::kRepeat, blocks);
    return {items.count, items.is_last};
  }

#if HWY_TARGET != HWY_SCALAR
  /// The same of still triangles; where there is something else, none, and nothing is written. They
  /// are not named: to find out what each is costs more than to read it.
  HWY_INLINE Gathered GatherTriangles(uint32_t first, size_t most, std::byte* blocks) {
    VertexPlaces places;
    Gathered gathered{0, false};
    uint32_t geometry = LeafBlock::kSeveral;
    do {
      const uint32_t entry = order_[first + gathered.count];
      uint32_t primitive = KeptOrder::NumberOf(entry) - begin_;
      if (HWY_UNLIKELY(primitive >= size_)) {
        if (!FindMesh(KeptOrder::NumberOf(entry))) return {0, false};
        primitive = KeptOrder::NumberOf(entry) - begin_;
      }
      geometry = gathered.count == 0 || geometry == geometry_ ? geometry_ : LeafBlock::kSeveral;
      SetVertices(primitive, gathered.count++, places);
      gathered.is_last = (entry & KeptOrder::kLastOfLeaf) != 0;
    } while (!gathered.is_last && gathered.count < most);
    for (size_t lane = gathered.count; lane < kLeafLanes; ++lane) places.SetNothing(lane);
    auto& block = *reinterpret_cast<LeafBlock*>(blocks);
    BeginTrianglesByLane(gathered.count, geometry, first, block);
    GatherVertices(places, block.vertex_data());
    return gathered;
  }

  HWY_INLINE void SetVertices(uint32_t primitive, size_t lane, VertexPlaces& places) const {
    // One by one, into registers.
    uint32_t a, b, c;
    const char* const indices = IndicesOf(primitive);
    memcpy(&a, indices, sizeof(a));
    memcpy(&b, indices + sizeof(a), sizeof(b));
    memcpy(&c, indices + 2 * sizeof(a), sizeof(c));
    if (HWY_UNLIKELY(HWY_MAX(HWY_MAX(a, b), c) >= followed_)) {
      return SetLastVertices(a, b, c, lane, places);
    }
    places.corner[0][lane] = Vertex(a);
    places.corner[1][lane] = Vertex(b);
    places.corner[2][lane] = Vertex(c);
  }

  /// The same where one of the vertices may be the last of its mesh, or none.
  HWY_NOINLINE void SetLastVertices(uint32_t a, uint32_t b, uint32_t c, size_t lane,
                                    VertexPlaces& places) const {
    if (HWY_MAX(HWY_MAX(a, b), c) >= mesh_->vertex_count) return places.SetNothing(lane);
    places.SetCopy(0, lane, Vertex(a));
    places.SetCopy(1, lane, Vertex(b));
    places.SetCopy(2, lane, Vertex(c));
  }

  HWY_INLINE const float* Vertex(uint32_t index) const {
    const auto* const vertices = static_cast<const char*>(mesh_->vertices);
    return reinterpret_cast<const float*>(vertices + index * mesh_->vertex_stride);
  }

  /// Makes that of a triangle the mesh that is at hand; false if the item is none.
  HWY_NOINLINE bool FindMesh(uint32_t number) {
    const uint32_t geometry = geometries_.Locate(number).geometry;
    if (!geometries_.HasTriangles(geometry)) return false;
    Take(geometry);
    return true;
  }
#endif

  HWY_INLINE void Take(uint32_t geometry) {
    geometry_ = geometry;
    mesh_ = &geometries_[geometry];
    begin_ = geometries_.Number(geometry, 0);
    size_ = geometries_.HasTriangles(geometry) ? static_cast<uint32_t>(mesh_->triangle_count) : 0;
    const bool follow = mesh_->vertex_count > 0 && mesh_->vertex_stride >= sizeof(float);
    followed_ = follow ? mesh_->vertex_count - 1 : 0;
  }

  const char* IndicesOf(uint32_t primitive) const {
    return static_cast<const char*>(mesh_->triangles) + size_t{primitive} * mesh_->triangle_stride;
  }

  const GeometryTable& geometries_;
  const uint32_t* const order_;
  // The mesh at hand, and the numbers of its triangles: nearly always that of the triangle before.
  const TriangleMesh* mesh_;
  uint32_t geometry_, begin_, size_;
  size_t followed_;  ///< its vertices, from the first on, behind which there is a float
};

/// Makes leaves of the items from a place in the order on, up to the last one of the leaf or up to
/// `most`, which carry no geometry: each in what `room()` gives, as for MakeLeaf. Then calls
/// `body(leaf, first block)`, which says whether to go on.
template <class Room, class Body>
HWY_INLINE void ForEachMadeLeaf(const GeometryTable& geometries, const uint32_t* order,
                                uint32_t first, size_t most, const Room& room, const Body& body) {
  LeafGather leaves(geometries, order);
  for (size_t done = 0;;) {
    const auto place = static_cast<uint32_t>(first + done);
    std::byte* const blocks = room();
    const LeafGather::Gathered gathered =
        leaves.Gather(place, HWY_MIN(kLeafLanes, most - done), blocks);
    done += gathered.count;
    const bool is_done = gathered.is_last || done == most;
    if (!is_done) {
      leaves.Fetch(static_cast<uint32_t>(first + done), HWY_MIN(kLeafLanes, most - done));
    }
    const auto* const block = reinterpret_cast<const LeafBlock*>(blocks);
    if (!body(ChildWord::Range(place), block) || is_done) return;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_GATHER_LEAF_INL_H_

// Refit of a small subset: one pass over its triangles, in which its nodes get new volumes, and the
// copies that leaves have get the vertices as they are now.

#if defined(DACRT_PARTITION_REFIT_SUBSET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_REFIT_SUBSET_INL_H_
#undef DACRT_PARTITION_REFIT_SUBSET_INL_H_
#else
#define DACRT_PARTITION_REFIT_SUBSET_INL_H_
#endif

#include <hwy/cache_control.h>

#include <cstring>
#include <span>

#include "geometry/bound_triangle-inl.h"
#include "leaf/cross_facets-inl.h"
#include "leaf/instance_leaf.h"
#include "partition/read_ahead-inl.h"
#include "partition/refit.h"
#include "partition/split_subset-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

class SubsetRefit {
 public:
  SubsetRefit(KeptPartition& kept, const Subset& subset, const RefitPlan& plan)
      : kept_(kept),
        plan_(plan),
        geometries_(kept.geometries()),
        order_(kept.OrderOf(subset)),
        triangles_(geometries_),
        first_(subset.begin) {
    DACRT_ASSERT(subset.count <= SubsetScratch::kTriangles);
    ReadIndices();
  }

  /// New volumes and copies for what stands below a node. Returns its bounds.
  Box Refit(uint32_t number) {
    WideNode& node = kept_.node(number);
    FetchCopies(node);
    ChildBoxes boxes;
    CornerBounds all;
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      const Box box = child.IsInner() ? Refit(child.number()) : RefitLeaf(node, k);
      boxes.Set(k, box);
      all.Extend(Corner::Load(box.lower), Corner::Load(box.upper));
    }
    boxes.FillEmpty(node.count);
    boxes.Encode(node.count, node);
    return all.Get();
  }

  uint64_t geometry_bits() const { return geometry_bits_; }
  /// Whether there are triangles of hidden geometries.
  bool has_hidden() const { return has_hidden_; }

 private:
  /// Of all triangles before anything else is done, so that the processor waits for many at once;
  /// the vertices are on their way then.
  void ReadIndices() {
    for (size_t i = 0; i < order_.size();) {
      const uint32_t geometry = geometries_.Locate(KeptOrder::NumberOf(order_[i])).geometry;
      const uint32_t first = geometries_.Number(geometry, 0);
      const auto count = static_cast<uint32_t>(geometries_[geometry].triangle_count);
      const CornerSource source(geometries_, geometry);
      const bool has_triangles = geometries_.HasTriangles(geometry);
      geometry_bits_ |= kept_.BitOf(geometry);
      for (; i < order_.size(); ++i) {
        const uint32_t primitive = KeptOrder::NumberOf(order_[i]) - first;
        if (primitive >= count) break;
        if (!has_triangles) continue;
        if (i + kAhead < order_.size()) {
          const uint32_t far = KeptOrder::NumberOf(order_[i + kAhead]) - first;
          if (far < count) source.FetchIndices(far);
        }
        source.ReadIndices(primitive, index_[i]);
        source.FetchVertices(index_[i]);
      }
    }
  }

  /// Of the children of one node: those of a subset are more than the first cache holds.
  void FetchCopies(const WideNode& node) const {
    constexpr size_t kLine = 64, kLines = 5;  // up to 23 vertices
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      if (!child.IsBlock()) continue;
      const std::byte* const block = kept_.leaf(child.block());
      for (size_t i = 0; i < kLines; ++i) hwy::Prefetch(block + kLine * i);
    }
  }

  /// A leaf, which is child `k` of a node.
  Box RefitLeaf(WideNode& node, size_t k) {
    const ChildWord child = node.Child(k);
    CornerBounds bounds;
    uint32_t place = child.range();
    if (child.IsBlock()) {
      auto& block = *reinterpret_cast<LeafBlock*>(kept_.leaf(child.block()));
      place = block.first;
      if (block.kind == LeafKind::kInstances && !block.is_timed) return RefitInstance(block);
      if (HWY_LIKELY(RenewCopy(block, index_ + (place - first_), bounds))) return bounds.Get();
      node.SetLeafStale(k);
      bounds = CornerBounds();
    }
    bool is_last;
    size_t next = place - first_;
    do {
      const uint32_t* const index = index_[next];
      const uint32_t entry = order_[next++], number = KeptOrder::NumberOf(entry);
      triangles_.Find(number);
      Corner corners[3];
      CornerBox box;
      // All can be hit that could be before, unless they are hidden, and then they have no
      // vertices.
      if (HWY_LIKELY(triangles_.source().Load(index, corners))) {
        for (const Corner& corner : corners) bounds.Extend(corner);
      } else if (triangles_.BoundIfUsable(number, box)) {
        bounds.Extend(box.lower, box.upper);
      } else {
        has_hidden_ = true;
      }
      is_last = (entry & KeptOrder::kLastOfLeaf) != 0;
    } while (!is_last && next < order_.size());
    return bounds.Get();
  }

  /// A leaf of an instance that does not move. Where that has not changed nothing but the leaf is
  /// looked at: what is known of a thousand others is in no cache.
  Box RefitInstance(LeafBlock& block) {
    const Shapes& shapes = geometries_.shapes();
    auto& leaf = *reinterpret_cast<InstanceLeaf*>(block.point_data());
    if (plan_.changed[block.geometry]) {
      if (HWY_LIKELY(leaf.scene == shapes.InstancedScene(block.geometry))) {
        leaf.Place(shapes, block.geometry);
      } else {
        leaf = InstanceLeaf::Of(shapes, block.geometry);
      }
    }
    if (HWY_UNLIKELY(shapes.IsHidden(block.geometry))) {
      has_hidden_ = true;
      return Box::Empty();
    }
    return leaf.Bounds();
  }

  /// Copies the vertices of a leaf of still triangles of one geometry. False, and what is in the
  /// block is scrap, if it is another one, or if it has one vertex for corners whose indices
  /// differ, which were in one place and have come apart.
  HWY_INLINE bool RenewCopy(LeafBlock& block, const uint32_t (*index)[3], CornerBounds& bounds) {
    if (!block.IsPlain() || block.second != 0 || block.geometry == LeafBlock::kSeveral)
      return false;
    const TriangleMesh& mesh = geometries_[block.geometry];
    const size_t lanes = block.lanes, places = block.vertices;
    const uint8_t* const place_of = block.indices();
    uint32_t vertex[LeafBlock::kByLane];
    for (size_t lane = 0; lane < lanes; ++lane) {
      for (size_t k = 0; k < 3; ++k) vertex[place_of[k * kLeafLanes + lane]] = index[lane][k];
    }
    uint32_t differ = 0;
    for (size_t lane = 0; lane < lanes; ++lane) {
      for (size_t k = 0; k < 3; ++k) {
        differ |= vertex[place_of[k * kLeafLanes + lane]] ^ index[lane][k];
      }
    }
    if (HWY_UNLIKELY(differ != 0) && !AreTogether(mesh, lanes, place_of, vertex, index)) {
      return false;
    }
    float* const x = block.vertex_data();
    const bool is_by_lane = places == LeafBlock::kByLane;
    for (size_t place = 0; place < places; ++place) {
      if (is_by_lane && place % kLeafLanes >= lanes) continue;
      // The last one takes another way: there may be nothing behind it.
      if (HWY_UNLIKELY(size_t{vertex[place]} + 1 >= mesh.vertex_count)) return false;
      const auto* const from = reinterpret_cast<const float*>(
          static_cast<const char*>(mesh.vertices) + vertex[place] * mesh.vertex_stride);
      bounds.Extend(Corner::LoadUnaligned(from));
      x[place] = from[0];
      x[places + place] = from[1];
      x[2 * places + place] = from[2];
    }
    if (HWY_UNLIKELY(block.is_prepared)) PrepareFacets(block, block.prepared());
    return true;
  }

  /// Whether the corners of some triangles are where the vertices are that they have in a copy.
  static HWY_NOINLINE bool AreTogether(const TriangleMesh& mesh, size_t lanes,
                                       const uint8_t* place_of, const uint32_t* vertex,
                                       const uint32_t (*index)[3]) {
    const auto* const vertices = static_cast<const char*>(mesh.vertices);
    for (size_t lane = 0; lane < lanes; ++lane) {
      for (size_t k = 0; k < 3; ++k) {
        const size_t own = index[lane][k], in_copy = vertex[place_of[k * kLeafLanes + lane]];
        if (own == in_copy) continue;
        if (HWY_MAX(own, in_copy) >= mesh.vertex_count ||
            memcmp(vertices + own * mesh.vertex_stride, vertices + in_copy * mesh.vertex_stride,
                   3 * sizeof(float)) != 0) {
          return false;
        }
      }
    }
    return true;
  }

  /// Triangles ahead of which indices are fetched.
  static constexpr size_t kAhead = 64;

  KeptPartition& kept_;
  const RefitPlan& plan_;
  const GeometryTable& geometries_;
  const std::span<const uint32_t> order_;
  TriangleFinder triangles_;
  const uint32_t first_;  ///< place of the first of them
  uint64_t geometry_bits_ = 0;
  bool has_hidden_ = false;
  uint32_t index_[SubsetScratch::kTriangles][3];
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_REFIT_SUBSET_INL_H_

// The partition of a scene's triangles that is kept between calls, and grows where rays go.
//
// The triangles, four bytes each, stand in an order in which every subset of the partition is a
// range. A subset is split when a ray first comes to it: a large one by a grid into many, a small
// one into nodes with a few triangles in each leaf (split_subset-inl.h). What has been published
// never changes, so threads read it without locks.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/box.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "geometry/wide_node.h"
#include "runtime/pages.h"
#include "runtime/tasks.h"

namespace dacrt {

/// Triangles [begin, begin + count) of the kept order.
struct Subset {
  static constexpr uint32_t kUnsplit = UINT32_MAX;
  static constexpr uint32_t kBeingSplit = UINT32_MAX - 1;
  /// The budget is used up: this one stays as it is.
  static constexpr uint32_t kNoRoom = UINT32_MAX - 2;

  uint32_t begin;
  uint32_t count;
  std::atomic<uint32_t> root;  ///< number of its first node, or one of the above
};

/// The triangles of a range of numbers that can be hit.
struct ListedTriangles {
  std::size_t count;
  Box bounds;
  Box centers;  ///< bounds of lower + upper of each triangle, which is twice its centre
};

/// Writes the numbers of those among [begin, end) that can be hit (see list_triangles-inl.h).
using ListFunction = ListedTriangles (*)(const MeshTable& meshes, std::size_t begin,
                                         std::size_t end, uint32_t* numbers);

class KeptPartition {
 public:
  /// For `meshes`, whose triangles `list` lists on the threads of `tasks`, in at most `budget`
  /// bytes; a budget that does not hold the triangles and a hundredth of a byte more for each
  /// counts as one that just does. Throws std::bad_alloc.
  KeptPartition(const MeshTable& meshes, std::size_t budget, ListFunction list, TaskPool& tasks);

  /// Least budget with which anything is kept.
  static std::size_t LeastBytes(std::size_t triangles);

  /// Bounds of the triangles that can be hit, and their number.
  const Box& bounds() const { return bounds_; }
  std::size_t triangle_count() const { return triangles_.size(); }
  /// Bounds of lower + upper of each triangle, which is twice its centre.
  const Box& centers() const { return centers_; }

  const MeshTable& meshes() const { return meshes_; }
  /// The numbers of the triangles (see MeshTable::Number), in the kept order. Those of a subset may
  /// be reordered by whoever splits it.
  std::span<uint32_t> triangles() { return triangles_; }
  std::span<const uint32_t> triangles() const { return triangles_; }
  const WideNode& node(uint32_t number) const { return nodes_[number]; }
  /// Subset 0 is the whole scene.
  Subset& subset(uint32_t number) { return subsets_[number]; }

  /// Room for `node_count` nodes and `subset_count` subsets in a row, and the numbers of the first;
  /// false if there is not enough left.
  bool Allocate(std::size_t node_count, std::size_t subset_count, uint32_t& first_node,
                uint32_t& first_subset);
  WideNode& new_node(uint32_t number) { return nodes_[number]; }

  /// Bytes that are in use, of those that the budget allows.
  std::size_t BytesUsed() const;
  std::size_t BytesReserved() const { return memory_.bytes(); }

 private:
  void List(ListFunction list, TaskPool& tasks);

  const MeshTable& meshes_;
  Box bounds_ = Box::Empty();
  Box centers_ = Box::Empty();
  Pages memory_;
  std::span<uint32_t> triangles_;
  std::span<WideNode> nodes_;
  std::span<Subset> subsets_;
  std::atomic<std::size_t> node_count_{0};
  std::atomic<std::size_t> subset_count_{0};
};

}  // namespace dacrt

// The memory in which a large subset is sorted into the cells of a grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/binary_range.h"
#include "geometry/triangle_refs.h"
#include "geometry/wide_node.h"
#include "runtime/pages.h"

namespace dacrt {

class Grid {
 public:
  /// Fine enough that the planes between cells are as good as bins, and few enough that the cells
  /// stay in a cache of a mebibyte.
  static constexpr uint32_t kMostCellsAnAxis = 32;

  /// How much there is of everything.
  struct Sizes {
    Sizes(std::size_t triangles, std::size_t parts);

    uint32_t cells_an_axis;  ///< two triangles a cell and more
    std::size_t cells, ranges, nodes, subsets, bytes;
  };

  /// Parts of the triangles that threads sort side by side, each into cells of its own: one for
  /// each thread, but none that is too small to be worth its cells.
  static std::size_t PartsFor(std::size_t triangles, std::size_t threads);

  /// `account` as for Pages. Throws std::bad_alloc.
  Grid(std::size_t triangles, std::size_t parts, const MemoryAccount* account);
  /// In Bytes of the caller's memory, which begin as nodes do.
  Grid(std::size_t triangles, std::size_t parts, std::byte* memory);

  /// Bytes of a grid for `triangles` triangles in `parts` parts.
  static std::size_t Bytes(std::size_t triangles, std::size_t parts) {
    return Sizes(triangles, parts).bytes;
  }

  std::size_t CellCount() const { return sizes.cells; }
  std::span<BinaryRange> Ranges() const { return {ranges, sizes.ranges}; }
  std::span<ExactNode> Nodes() const { return {nodes, sizes.nodes}; }

  /// Ranges of cells.
  struct CellRange {
    uint32_t begin;
    uint32_t end;
    float surface;  ///< half of their bounds'
  };

  /// The cells as one part sees them. In the end the first part's are those of all that are not
  /// empty.
  TriangleRef* cells_of(std::size_t part) const { return cells + part * CellCount(); }
  uint32_t* place_of(std::size_t part) const { return place + part * CellCount(); }

  /// A part of the triangles, or of something else that threads share.
  struct Part {
    std::size_t number;
    std::size_t begin;
    std::size_t end;
  };
  Part PartOf(std::size_t number, std::size_t count) const {
    return {number, number * count / parts, (number + 1) * count / parts};
  }
  Part PartOf(std::size_t number) const { return PartOf(number, triangle_count); }

  std::size_t triangle_count, parts;
  Sizes sizes;
  TriangleRef* cells;      ///< bounds, number (as `primitive`), and triangle count
  uint32_t* place;         ///< by the cell's number: its triangles, then where the next one goes
  BinaryRange* ranges;     ///< of cells
  ExactNode* nodes;        ///< over the cells
  CellRange* subsets;      ///< that the cells became
  uint32_t* triangles;     ///< a copy, in the old order
  uint16_t* cell_of;       ///< of each triangle, in the old order

 private:
  void Cut(std::byte* memory);

  Pages memory_;
};

}  // namespace dacrt

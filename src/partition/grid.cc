#include "partition/grid.h"

#include <algorithm>

namespace dacrt {
namespace {

constexpr std::size_t kMostCells =
    std::size_t{Grid::kMostCellsAnAxis} * Grid::kMostCellsAnAxis * Grid::kMostCellsAnAxis;

}  // namespace

Grid::Sizes::Sizes(std::size_t triangles, std::size_t parts) : cells_an_axis(1) {
  const auto count = [&] { return std::size_t{cells_an_axis} * cells_an_axis * cells_an_axis; };
  while (cells_an_axis < kMostCellsAnAxis && 2 * count() < triangles) ++cells_an_axis;
  cells = count();
  // Some sixty triangles a node: those over subsets of several hundred, with some to spare.
  nodes = std::min<std::size_t>(64 + triangles / 64, 8 * 1024);
  ranges = 2 * nodes;
  subsets = WideNode::kWidth * nodes;
  bytes = parts * cells * (sizeof(TriangleRef) + sizeof(uint32_t)) + ranges * sizeof(BinaryRange) +
          nodes * sizeof(ExactNode) + subsets * sizeof(CellRange) +
          triangles * (sizeof(uint32_t) + sizeof(uint16_t));
}

std::size_t Grid::PartsFor(std::size_t triangles, std::size_t threads) {
  return std::clamp<std::size_t>(triangles / kMostCells, 1, threads);
}

Grid::Grid(std::size_t count, std::size_t part_count, const MemoryAccount* account)
    : triangle_count(count),
      parts(part_count),
      sizes(count, part_count),
      memory_(sizes.bytes, account) {
  Cut(memory_.data());
}

Grid::Grid(std::size_t count, std::size_t part_count, std::byte* memory)
    : triangle_count(count), parts(part_count), sizes(count, part_count) {
  Cut(memory);
}

void Grid::Cut(std::byte* memory) {
  const auto cut = [&memory]<class T>(T*& array, std::size_t size) {
    array = reinterpret_cast<T*>(memory);
    memory += size * sizeof(T);
  };
  cut(nodes, sizes.nodes);
  cut(cells, parts * sizes.cells);
  cut(ranges, sizes.ranges);
  cut(subsets, sizes.subsets);
  cut(place, parts * sizes.cells);
  cut(triangles, triangle_count);
  cut(cell_of, triangle_count);
}

}  // namespace dacrt

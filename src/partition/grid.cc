#include "partition/grid.h"

#include <algorithm>

namespace dacrt {
namespace {

constexpr std::size_t kMostCells =
    std::size_t{Grid::kMostCellsAnAxis} * Grid::kMostCellsAnAxis * Grid::kMostCellsAnAxis;
constexpr std::size_t kMostSubsets = WideNode::kWidth * Grid::kMostNodes;

}  // namespace

std::size_t Grid::PartsFor(std::size_t triangles, std::size_t threads) {
  return std::clamp<std::size_t>(triangles / kMostCells, 1, threads);
}

std::size_t Grid::Bytes(std::size_t triangles, std::size_t parts) {
  return parts * kMostCells * (sizeof(TriangleRef) + sizeof(uint32_t)) +
         kMostRanges * sizeof(BinaryRange) + kMostNodes * sizeof(WideNode) +
         kMostSubsets * sizeof(CellRange) + triangles * (sizeof(uint32_t) + sizeof(uint16_t));
}

Grid::Grid(std::size_t count, std::size_t parts, const MemoryAccount* account)
    : cells_an_axis(1), memory_(Bytes(count, parts), account) {
  while (cells_an_axis < kMostCellsAnAxis && CellCount() < count) ++cells_an_axis;
  std::byte* next = memory_.data();
  const auto cut = [&next]<class T>(T*& array, std::size_t size) {
    array = reinterpret_cast<T*>(next);
    next += size * sizeof(T);
  };
  cut(nodes, kMostNodes);
  cut(ranges, kMostRanges);
  cut(cells, parts * kMostCells);
  cut(subsets, kMostSubsets);
  cut(place, parts * kMostCells);
  cut(triangles, count);
  cut(cell_of, count);
}

}  // namespace dacrt

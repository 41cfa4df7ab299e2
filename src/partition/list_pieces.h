// The first look at many triangles: threads list them piece by piece.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/box.h"
#include "partition/kept_partition.h"
#include "runtime/tasks.h"

namespace dacrt {

/// Pieces of `numbers`, in each of which those that can be hit stand before the others, become one
/// such piece. `begin_of(i)` is where piece i begins.
template <class BeginOf>
ListedTriangles JoinPieces(std::span<uint32_t> numbers, std::span<const ListedTriangles> pieces,
                           const BeginOf& begin_of) {
  ListedTriangles all{0, Box::Empty(), Box::Empty()};
  std::vector<uint32_t> left_out;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const ListedTriangles& piece = pieces[i];
    const std::size_t begin = begin_of(i);
    const std::size_t end = i + 1 < pieces.size() ? begin_of(i + 1) : numbers.size();
    left_out.insert(left_out.end(), numbers.begin() + begin + piece.count, numbers.begin() + end);
    if (piece.count == 0) continue;
    if (all.count < begin) {
      std::copy_n(numbers.begin() + begin, piece.count, numbers.begin() + all.count);
    }
    all.count += piece.count;
    all.bounds.Extend(piece.bounds);
    all.centers.Extend(piece.centers);
  }
  std::copy(left_out.begin(), left_out.end(), numbers.begin() + all.count);
  return all;
}

/// Writes the numbers of the triangles from `first` on, as many as `numbers` has room for: first
/// those that can be hit.
inline ListedTriangles ListInPieces(const GeometryTable& geometries, std::size_t first,
                                    std::span<uint32_t> numbers, ListFunction list,
                                    TaskPool& tasks) {
  constexpr std::size_t kPiece = 65536;  // half a millisecond
  const std::size_t most = numbers.size();
  std::vector<ListedTriangles> pieces((most + kPiece - 1) / kPiece);
  // Each is listed where it would stand if every triangle could be hit.
  tasks.ForEach(pieces.size(), [&](std::size_t i) {
    const std::size_t begin = i * kPiece, end = std::min(begin + kPiece, most);
    pieces[i] = list(geometries, first + begin, first + end, numbers.data() + begin);
  });
  return JoinPieces(numbers, pieces, [](std::size_t i) { return i * kPiece; });
}

}  // namespace dacrt

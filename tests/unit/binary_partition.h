// Binary partitions as tests want them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/binary_range.h"
#include "unit_test.h"

namespace dacrt::unit {

using BinaryPartition = std::vector<BinaryRange>;

/// Sets what follows from the bounds of leaves and from which range is half of which, where halves
/// stand behind what they are halves of.
inline void CompletePartition(BinaryPartition& ranges) {
  for (std::size_t i = ranges.size(); i-- > 0;) {
    BinaryRange& range = ranges[i];
    if (range.IsLeaf()) continue;
    range.bounds = Box::Empty();
    for (const uint32_t half : {range.first, range.first + 1}) {
      ranges[half].parent = static_cast<uint32_t>(i);
      range.bounds.Extend(ranges[half].bounds.lower);
      range.bounds.Extend(ranges[half].bounds.upper);
    }
  }
  const float scale = ranges[0].bounds.SurfaceScale();
  for (BinaryRange& range : ranges) range.surface = range.bounds.HalfArea() * scale;
}

/// A partition of some leaves, boxes anywhere up to `size`, split at random places.
inline BinaryPartition MakePartition(Random& random, uint32_t leaves, bool is_flat,
                                     float size = 1) {
  BinaryPartition ranges(1);
  ranges[0].begin = 0;
  ranges[0].end = leaves;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const uint32_t begin = ranges[i].begin, end = ranges[i].end;
    ranges[i].first = 0;
    if (end - begin >= 2) {
      const uint32_t middle = begin + 1 + static_cast<uint32_t>(random.Next() % (end - begin - 1));
      ranges[i].first = static_cast<uint32_t>(ranges.size());
      BinaryRange left{}, right{};
      left.begin = begin;
      left.end = right.begin = middle;
      right.end = end;
      ranges.push_back(left);
      ranges.push_back(right);
      continue;
    }
    ranges[i].bounds = Box::Empty();
    for (int corner = 0; corner < 2; ++corner) {
      const float point[3] = {random.Uniform(0, size), is_flat ? 0 : random.Uniform(0, size),
                              is_flat ? 0 : random.Uniform(0, size)};
      ranges[i].bounds.Extend(point);
    }
  }
  CompletePartition(ranges);
  return ranges;
}

}  // namespace dacrt::unit

// The first look at a scene's triangles: which can be hit, and the bounds of them all.

#if defined(DACRT_PARTITION_LIST_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_LIST_TRIANGLES_INL_H_
#undef DACRT_PARTITION_LIST_TRIANGLES_INL_H_
#else
#define DACRT_PARTITION_LIST_TRIANGLES_INL_H_
#endif

#include "geometry/bound_triangle-inl.h"
#include "partition/kept_partition.h"
#include "partition/sort_into_cells-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Of the triangles numbered [begin, end), writes the numbers of those that can be hit to
/// `numbers`, and those of the others behind them. `look(number, lower, upper)` is called for those
/// that can.
template <class Look>
inline ListedTriangles ListTriangles(const GeometryTable& geometries, size_t begin, size_t end,
                                     uint32_t* numbers, const Look& look) {
  CornerBounds bounds, centers;
  size_t count = 0, left_out = end - begin;
  for (auto number = static_cast<uint32_t>(begin); number < end;) {
    const uint32_t geometry = geometries.Locate(number).geometry;
    const CornerSource source(geometries, geometry);
    const uint32_t first = geometries.Number(geometry, 0);
    const size_t behind = HWY_MIN(end, first + geometries[geometry].triangle_count);
    for (; number < behind; ++number) {
      CornerBox box;
      if (HWY_UNLIKELY(!BoundIfUsable(geometries, source, {geometry, number - first}, box))) {
        numbers[--left_out] = number;
        continue;
      }
      bounds.Extend(box.lower, box.upper);
      centers.Extend(TwiceCenter(box.lower, box.upper));
      look(number, box.lower, box.upper);
      numbers[count++] = number;
    }
  }
  return {count, bounds.Get(), centers.Get()};
}

inline ListedTriangles ListTriangles(const GeometryTable& geometries, size_t begin, size_t end,
                                     uint32_t* numbers) {
  return ListTriangles(geometries, begin, end, numbers,
                       [](uint32_t, const Corner&, const Corner&) HWY_ATTR {});
}

/// The same for a part of a grid, into the cells of which they are sorted on the way.
inline ListedTriangles ListIntoCells(const GeometryTable& geometries, const Grid& grid, size_t part,
                                     const Box& centers, uint32_t* numbers) {
  CellSorter sorter(grid, part, centers);
  const Grid::Part range = grid.PartOf(part);
  return ListTriangles(geometries, range.begin, range.end, numbers,
                       [&](uint32_t number, const Corner& lower, const Corner& upper)
                           HWY_ATTR { sorter.Add(number, number, lower, upper); });
}

/// About where the centres of all triangles lie.
inline Box SampleCenters(const GeometryTable& geometries) {
  return SampleCenters(geometries, geometries.triangle_count(),
                       [](size_t i) { return static_cast<uint32_t>(i); });
}

inline constexpr FirstLook kFirstLook{
    [](const GeometryTable& geometries, size_t begin, size_t end, uint32_t* numbers) {
      return ListTriangles(geometries, begin, end, numbers);
    },
    ListIntoCells, SampleCenters};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_LIST_TRIANGLES_INL_H_

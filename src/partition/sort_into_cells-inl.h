// Sorting triangles into the cells of a grid.

#if defined(DACRT_PARTITION_SORT_INTO_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SORT_INTO_CELLS_INL_H_
#undef DACRT_PARTITION_SORT_INTO_CELLS_INL_H_
#else
#define DACRT_PARTITION_SORT_INTO_CELLS_INL_H_
#endif

#include <algorithm>

#include "geometry/bound_triangle-inl.h"
#include "partition/bin_map-inl.h"
#include "partition/grid.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// About where the centres of `count` triangles lie, of which number_of(i) is the number: of some
/// of them, at an odd step, since of quads that were cut in two an even one sees the same half each
/// time. Where others are at the rim rays take another way, Sponza's most of all: with a step of 8
/// over the whole scene, instead of this or every triangle, a primary ray of two cameras visited
/// 15.4 and 15.8 nodes instead of 14.0 and 13.1, an ambient one 12.3 and 10.1 instead of 11.4 and
/// 9.2; Sibenik's, the kitchen's and the dragon's as many.
template <class NumberOf>
inline Box SampleCenters(const GeometryTable& geometries, size_t count, const NumberOf& number_of) {
  constexpr size_t kStep = 7;
  CornerBounds centers;
  TriangleFinder triangles(geometries);
  for (size_t i = 0; i < count; i += kStep) {
    CornerBox box;
    if (!triangles.BoundIfUsable(number_of(i), box)) continue;
    centers.Extend(TwiceCenter(box.lower, box.upper));
  }
  return centers.Get();
}

/// Sorts the triangles of a part, one after the other.
class CellSorter {
 public:
  /// `centers` are those that the grid divides; what lies outside belongs to the cells at its rim.
  CellSorter(const Grid& grid, size_t part, const Box& centers)
      : bins_(centers, grid.sizes.cells_an_axis),
        an_axis_(static_cast<int32_t>(grid.sizes.cells_an_axis)),
        by_order_(!bins_.IsUseful(0) && !bins_.IsUseful(1) && !bins_.IsUseful(2)),
        grid_(grid),
        cells_(grid.cells_of(part)),
        count_(grid.place_of(part)),
        number_(grid.triangles),
        cell_of_(grid.cell_of) {
    const Box empty = Box::Empty();
    for (size_t cell = 0; cell < grid.CellCount(); ++cell) {
      std::copy_n(empty.lower, 3, cells_[cell].lower);
      std::copy_n(empty.upper, 3, cells_[cell].upper);
      count_[cell] = 0;
    }
  }

  /// The triangle in place `i` of all.
  HWY_INLINE void Add(size_t i, uint32_t number, const Corner& lower, const Corner& upper) {
    HWY_ALIGN int32_t at[4];
    bins_.Map(TwiceCenter(lower, upper), at);
    const int32_t cell_number = (at[2] * an_axis_ + at[1]) * an_axis_ + at[0];
    auto cell = static_cast<size_t>(cell_number);
    // Triangles with one centre are told apart by their order.
    if (HWY_UNLIKELY(by_order_)) cell = i * grid_.CellCount() / grid_.triangle_count;
    number_[i] = number;
    cell_of_[i] = static_cast<uint16_t>(cell);
    TriangleRef& bounds = cells_[cell];
    Min(Corner::Load(bounds.lower), lower).Store(bounds.lower);
    Max(Corner::Load(bounds.upper), upper).Store(bounds.upper);
    ++count_[cell];
  }

 private:
  const BinMap bins_;
  const int32_t an_axis_;
  const bool by_order_;
  const Grid& grid_;
  TriangleRef* const cells_;
  uint32_t* const count_;
  uint32_t* const number_;
  uint16_t* const cell_of_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SORT_INTO_CELLS_INL_H_

// Clusters: a few triangles that lie close together, found by sorting along a curve. A small subset
// is split by the surface area heuristic over its clusters, of which there are a third as many.
// Lauterbach, Garland, Sengupta, Luebke, Manocha, "Fast BVH construction on GPUs", Eurographics
// 2009: the order; clusters under a better hierarchy: Pantaleoni, Luebke, HPG 2010 (see
// split_by_grid-inl.h).

#if defined(DACRT_PARTITION_CLUSTER_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_CLUSTER_TRIANGLES_INL_H_
#undef DACRT_PARTITION_CLUSTER_TRIANGLES_INL_H_
#else
#define DACRT_PARTITION_CLUSTER_TRIANGLES_INL_H_
#endif

#include <array>

#include "geometry/extent-inl.h"
#include "partition/bin_map-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Triangles along a Morton curve through 32 cells an axis: cell and number of each, in order.
/// Returns how many cells are not empty.
inline size_t SortByMortonCode(const TriangleRange& range, SubsetScratch& scratch) {
  constexpr uint32_t kCellsAnAxis = 32, kNumberBits = 11, kLowBits = 8;
  static_assert(SubsetScratch::kTriangles == 1u << kNumberBits);
  // Bits of a number, two places apart.
  static constexpr auto kSpread = [] {
    std::array<uint32_t, kCellsAnAxis> spread{};
    for (uint32_t i = 0; i < kCellsAnAxis; ++i) {
      for (uint32_t bit = 0; bit < 5; ++bit) spread[i] |= (i >> bit & 1) << (3 * bit);
    }
    return spread;
  }();
  const size_t count = range.count();
  const BinMap map(range.centers, kCellsAnAxis);
  uint32_t low[1u << kLowBits] = {}, high[1u << (15 - kLowBits)] = {};
  uint32_t* const first = scratch.codes[1];
  uint32_t* const sorted = scratch.codes[0];
  for (size_t i = 0; i < count; ++i) {
    const TriangleRef& ref = scratch.refs[i];
    HWY_ALIGN int32_t cell[4];
    map.Map(TwiceCenter(Corner::Load(ref.lower), Corner::Load(ref.upper)), cell);
    const uint32_t code = kSpread[cell[0]] | kSpread[cell[1]] << 1 | kSpread[cell[2]] << 2;
    ++low[code & 255];
    ++high[code >> kLowBits];
    sorted[i] = code << kNumberBits | static_cast<uint32_t>(i);
  }
  const auto to_places = [](auto& counts) {
    uint32_t next = 0;
    for (uint32_t& entry : counts) next += std::exchange(entry, next);
  };
  to_places(low);
  to_places(high);
  for (size_t i = 0; i < count; ++i) {
    first[low[sorted[i] >> kNumberBits & 255]++] = sorted[i];
  }
  for (size_t i = 0; i < count; ++i) {
    sorted[high[first[i] >> (kNumberBits + kLowBits)]++] = first[i];
  }
  size_t cells = 1;
  for (size_t i = 1; i < count; ++i) {
    cells += (sorted[i] ^ sorted[i - 1]) >> kNumberBits != 0;
  }
  return cells;
}

/// Writes clusters of scratch.refs to scratch.clusters: bounds, in the place of the primitive where
/// it begins among the numbers of scratch.codes[0], and in that of the mesh how many triangles it
/// has. Returns their number; 0 if the triangles stand in so few places that clusters would be bad.
inline size_t ClusterTriangles(const TriangleRange& range, SubsetScratch& scratch) {
  // A leaf holds several clusters.
  constexpr uint32_t kMost = 4;
  // Cells are fine enough where they do not hold many more triangles each than a cluster.
  constexpr size_t kMostACell = 3;
  const size_t count = range.count();
  if (SortByMortonCode(range, scratch) * kMostACell < count) return 0;
  // A cluster stays within a cube of cells, the larger the fewer triangles there are on a surface.
  uint32_t cube_bits = 6;
  for (size_t least = SubsetScratch::kTriangles / 2; count < least && cube_bits < 12; least /= 4) {
    cube_bits += 3;
  }
  const uint32_t shift = cube_bits + 11;
  const uint32_t* const sorted = scratch.codes[0];
  size_t clusters = 0;
  for (size_t i = 0; i < count;) {
    const uint32_t begin = static_cast<uint32_t>(i), cube = sorted[i] >> shift;
    Extent extent = Extent::Empty();
    do {
      extent.Join(Extent::Of(scratch.refs[sorted[i] & (SubsetScratch::kTriangles - 1)]));
      ++i;
    } while (i < count && i - begin < kMost && sorted[i] >> shift == cube);
    const Box box = extent.Get();
    TriangleRef& cluster = scratch.clusters[clusters++];
    std::copy_n(box.lower, 3, cluster.lower);
    std::copy_n(box.upper, 3, cluster.upper);
    cluster.primitive = begin;
    cluster.mesh = static_cast<uint32_t>(i) - begin;
  }
  return clusters;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_CLUSTER_TRIANGLES_INL_H_

// Whether a partition can be refitted (refit.h): whether the same items can be hit as when it was
// made, and its subsets still are where others are not.

#if defined(DACRT_PARTITION_CAN_REFIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_CAN_REFIT_INL_H_
#undef DACRT_PARTITION_CAN_REFIT_INL_H_
#else
#define DACRT_PARTITION_CAN_REFIT_INL_H_
#endif

#include <atomic>
#include <bit>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "geometry/bound_triangle-inl.h"
#include "partition/insert_subset-inl.h"
#include "partition/read_ahead-inl.h"
#include "partition/refit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Where triangles are that have moved.
class ChangedTriangles {
 public:
  ChangedTriangles(const KeptPartition& kept, const GeometryTable& geometries,
                   const std::vector<bool>& changed) {
    for (uint32_t geometry = 0; geometry < changed.size(); ++geometry) {
      if (!changed[geometry]) continue;
      bits_ |= kept.BitOf(geometry);
      if (rows_++ < kMostRows) {
        first_[rows_ - 1] = geometries.Number(geometry, 0);
        count_[rows_ - 1] = static_cast<uint32_t>(geometries[geometry].triangle_count);
      }
    }
  }

  /// Whether there are surely none in a subset.
  bool CannotBeIn(const Subset& subset) const {
    return subset.geometry_bits != 0 && !(subset.geometry_bits & bits_);
  }

  /// Whether there are some, or may be: by a look at its triangles, which costs little where few
  /// geometries have changed.
  bool AreIn(const KeptPartition& kept, const Subset& subset) const {
    if (CannotBeIn(subset)) return false;
    if (subset.geometry_bits == 0 || rows_ > kMostRows) return true;
    for (const uint32_t entry : kept.OrderOf(subset)) {
      const uint32_t number = KeptOrder::NumberOf(entry);
      for (size_t row = 0; row < rows_; ++row) {
        if (number - first_[row] < count_[row]) return true;
      }
    }
    return false;
  }

 private:
  static constexpr size_t kMostRows = 4;
  size_t rows_ = 0;
  uint32_t first_[kMostRows], count_[kMostRows];  ///< numbers of triangles
  uint64_t bits_ = 0;
};

/// The largest of `rows` rows of three words, `stride` bytes apart, without the bits that `mask`
/// leaves out.
inline uint32_t LargestWord(const void* rows_begin, size_t rows, size_t stride, uint32_t mask) {
  const auto* const begin = static_cast<const char*>(rows_begin);
  constexpr size_t kRow = 3 * sizeof(uint32_t);
  const hn::ScalableTag<uint32_t> du;
  const size_t lanes = hn::Lanes(du);
  auto most = hn::Zero(du);
  uint32_t largest = 0;
  size_t row = 0;
  if (stride == kRow) {
    // Three vectors are as many rows as there are lanes.
    for (; row + lanes <= rows; row += lanes) {
      const auto* const words = reinterpret_cast<const uint32_t*>(begin + row * kRow);
      for (size_t i = 0; i < 3; ++i)
        most = hn::Max(most, hn::And(hn::LoadU(du, words + i * lanes), hn::Set(du, mask)));
    }
    largest = hn::GetLane(hn::MaxOfLanes(du, most));
  }
  for (; row < rows; ++row) {
    uint32_t words[3];
    memcpy(words, begin + row * stride, sizeof(words));
    for (const uint32_t word : words) largest = HWY_MAX(largest, word & mask);
  }
  return largest;
}

/// A part of a geometry's arrays, so that threads can share a large one.
struct ArrayPart {
  uint32_t geometry;
  size_t part, parts;

  size_t begin(size_t rows) const { return rows * part / parts; }
  size_t end(size_t rows) const { return rows * (part + 1) / parts; }
};

/// Whether all triangles can be hit, as far as this part of the arrays says, each read from one end
/// to the other: coordinates that no triangle uses count, too.
inline bool AllCanBeHit(const TriangleMesh& mesh, const ArrayPart& part) {
  constexpr uint32_t kNoSign = 0x7FFFFFFFu;  // the larger the number, the larger are its bits
  const auto largest = [&](const void* array, size_t rows, size_t stride, uint32_t mask) HWY_ATTR {
    const size_t begin = part.begin(rows);
    return LargestWord(static_cast<const char*>(array) + begin * stride, part.end(rows) - begin,
                       stride, mask);
  };
  if (largest(mesh.vertices, mesh.vertex_count, mesh.vertex_stride, kNoSign) >
      std::bit_cast<uint32_t>(kLargestCoordinate)) {
    return false;
  }
  return largest(mesh.triangles, mesh.triangle_count, mesh.triangle_stride, UINT32_MAX) <
         mesh.vertex_count;
}

/// Items of a geometry that cannot be hit.
inline size_t CountUnusable(const GeometryTable& now, uint32_t geometry) {
  size_t count = 0;
  const CornerSource source(now, geometry);
  for (uint32_t primitive = 0; primitive < now[geometry].triangle_count; ++primitive) {
    CornerBox box;
    count += !BoundIfUsable(now, source, {geometry, primitive}, box);
  }
  return count;
}

/// Whether the same items can be hit as when the partition was made: those that could not still
/// cannot, and no others. A look at arrays says so where all can; elsewhere they are counted.
inline bool SameCanBeHit(const KeptPartition& kept, const GeometryTable& now,
                         const std::vector<bool>& changed, TaskPool& tasks) {
  std::vector<size_t> left_out(changed.size());
  for (const uint32_t number : kept.left_out()) {
    CornerBox box;
    const GeometryTable::Name name = now.Locate(number);
    if (BoundIfUsable(now, name, box)) return false;
    ++left_out[name.geometry];
  }
  constexpr size_t kRowsOfPart = 32768;
  std::vector<ArrayPart> parts;
  std::vector<bool> to_count(changed.size());
  size_t items = 0;
  for (uint32_t geometry = 0; geometry < changed.size(); ++geometry) {
    if (!changed[geometry] || now.shapes().IsHidden(geometry)) continue;
    const TriangleMesh& mesh = now[geometry];
    items += mesh.triangle_count;
    to_count[geometry] = left_out[geometry] > 0 || !now.HasTriangles(geometry);
    if (to_count[geometry]) continue;
    const size_t count = 1 + HWY_MAX(mesh.vertex_count, mesh.triangle_count) / kRowsOfPart;
    for (size_t part = 0; part < count; ++part) parts.push_back({geometry, part, count});
  }
  const auto for_each = [&](size_t count, const std::function<void(size_t)>& body) {
    constexpr size_t kFewItems = 16384;  // some ten microseconds: less than to wake threads
    if (items > kFewItems) return tasks.ForEach(count, body);
    for (size_t i = 0; i < count; ++i) body(i);
  };
  std::vector<uint8_t> is_usable(parts.size());  // a byte each, for threads
  for_each(parts.size(),
           [&](size_t i) { is_usable[i] = AllCanBeHit(now[parts[i].geometry], parts[i]); });
  for (size_t i = 0; i < parts.size(); ++i) {
    if (!is_usable[i]) to_count[parts[i].geometry] = true;
  }
  std::vector<uint32_t> counted;
  for (uint32_t geometry = 0; geometry < changed.size(); ++geometry) {
    if (to_count[geometry]) counted.push_back(geometry);
  }
  std::atomic<bool> is_same{true};
  for_each(counted.size(), [&](size_t i) {
    if (is_same && CountUnusable(now, counted[i]) != left_out[counted[i]]) is_same = false;
  });
  return is_same;
}

/// About the bounds that subsets will have: those of some triangles of each, or what is known.
inline void EstimateBounds(const KeptPartition& kept, const GeometryTable& now,
                           const ChangedTriangles& changed, std::span<Box> bounds, size_t begin,
                           size_t end) {
  constexpr size_t kLooks = 16;
  std::vector<uint32_t> looked_at, looks;
  for (size_t i = begin; i < end; ++i) {
    const auto number = static_cast<uint32_t>(i);
    const Subset& subset = kept.subset(number);
    bounds[i] = Box::Empty();
    if (!IsUnit(subset)) continue;
    if (changed.CannotBeIn(subset)) {
      bounds[i] = subset.bounds();
      continue;
    }
    looked_at.push_back(number);
    const auto order = kept.OrderOf(subset);
    for (size_t k = 0; k < kLooks; ++k) looks.push_back(order[k * order.size() / kLooks]);
  }
  ForEachReadAhead(now, looks,
                   [&](size_t i, GeometryTable::Name name, const CornerSource& source) HWY_ATTR {
                     CornerBox box;
                     if (!BoundIfUsable(now, source, name, box)) return;
                     ExtendBox(bounds[looked_at[i / kLooks]], box.lower, box.upper);
                   });
}

/// Whether the subsets have grown, relative to the whole, so much that rays would come to too many
/// of them.
inline bool HaveDecayed(const KeptPartition& kept, const GeometryTable& now,
                        const ChangedTriangles& changed, TaskPool& tasks) {
  constexpr size_t kPiece = 128;  // subsets
  std::vector<Box> bounds(kept.subset_count());
  tasks.ForEach((bounds.size() + kPiece - 1) / kPiece, [&](size_t piece) {
    EstimateBounds(kept, now, changed, bounds, piece * kPiece,
                   HWY_MIN(bounds.size(), (piece + 1) * kPiece));
  });
  Box all = Box::Empty();
  float surface = 0, made_surface = 0;
  for (uint32_t i = 0; i < bounds.size(); ++i) {
    const Subset& subset = kept.subset(i);
    if (!IsUnit(subset)) continue;
    surface += bounds[i].HalfArea();
    made_surface += subset.made_surface;
    if (bounds[i].IsEmpty()) continue;
    all.Extend(bounds[i]);
  }
  const float made_all = kept.subset(0).made_surface;
  return surface * made_all > refit::kMostDecay * made_surface * all.HalfArea();
}

inline bool CanRefit(const KeptPartition& kept, const GeometryTable& now, const RefitPlan& plan,
                     TaskPool& tasks) {
  if (kept.triangle_count() == 0 || kept.subset(0).root == Subset::kUnsplit) return false;
  if (kept.IsWornOut() && !plan.always) return false;
  return SameCanBeHit(kept, now, plan.changed, tasks) &&
         (plan.always || !HaveDecayed(kept, now, ChangedTriangles(kept, now, plan.changed), tasks));
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_CAN_REFIT_INL_H_

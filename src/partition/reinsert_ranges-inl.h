// Better places for the ranges of a binary partition: one at a time is taken out and put where the
// surfaces of all become the least. Splits from the top down do not foresee what is split next; a
// tenth of the surface over the cells of a grid goes so, and a tenth of the nodes that rays visit.
// Bittner, Hapala, Havran, "Fast insertion-based optimization of bounding volume hierarchies",
// Computer Graphics Forum 32(1), 2013. That a place is looked for before anything moves, on the way
// up from where the range is, is from Meister, Bittner, "Parallel reinsertion for bounding volume
// hierarchy optimization", Computer Graphics Forum 37(2), 2018.

#if defined(DACRT_PARTITION_REINSERT_RANGES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_REINSERT_RANGES_INL_H_
#undef DACRT_PARTITION_REINSERT_RANGES_INL_H_
#else
#define DACRT_PARTITION_REINSERT_RANGES_INL_H_
#endif

#include <span>

#include "geometry/binary_range.h"
#include "geometry/extent-inl.h"
#include "runtime/assert.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// How much is tried.
struct ReinsertionEffort {
  size_t passes = 0;
  /// A range is tried that has so much less surface than the one it is half of, in parts of what
  /// ranges have on average: no range saves more where it is taken out than that and what those
  /// above it lose.
  float least_saving = 0;
};

class Reinserter {
 public:
  /// Of a partition, the first range of which is all of it, with parents and surfaces.
  Reinserter(std::span<BinaryRange> ranges, float scale)
      : ranges_(ranges.data()), count_(ranges.size()), scale_(scale) {}

  void Run(const ReinsertionEffort& effort) {
    float sum = 0;
    for (size_t i = 0; i < count_; ++i) sum += ranges_[i].surface;
    const float least = effort.least_saving * sum / static_cast<float>(count_);
    for (size_t pass = 0; pass < effort.passes; ++pass) {
      bool has_moved = false;
      // What has moved is tried once more or not at all.
      for (uint32_t i = 1; i < count_; ++i) {
        const BinaryRange& range = ranges_[i];
        if (ranges_[range.parent].surface - range.surface >= least) has_moved |= TryToMove(i);
      }
      if (!has_moved) return;
    }
  }

 private:
  /// Where a range would stand beside another one, and what that saves.
  struct Place {
    float saving;
    uint32_t beside;
  };

  Extent BoundsOf(uint32_t i) const { return Extent::Of(ranges_[i].bounds); }
  float SurfaceOf(const Extent& bounds) const { return bounds.HalfArea() * scale_; }
  uint32_t SiblingOf(uint32_t i) const {
    const uint32_t first = ranges_[ranges_[i].parent].first;
    return i == first ? first + 1 : first;
  }

  bool TryToMove(uint32_t moving) {
    constexpr float kLeast = 0x1p-20f;  // of the surface of all: no rounding
    const Extent bounds = BoundsOf(moving);
    Place best{kLeast, 0};
    // What is saved by taking it out: the range that it is half of, and what those above it lose,
    // up to where it is put in again.
    uint32_t below = moving, at = ranges_[moving].parent;
    float saved = ranges_[at].surface;
    Extent rest = BoundsOf(SiblingOf(moving));
    bool shrinks = true;
    for (;;) {
      const uint32_t sibling = SiblingOf(below);
      FindPlace(bounds, ranges_[moving].surface, saved, sibling, best);
      if (at == 0) break;
      if (shrinks && below != moving) {
        rest.Join(BoundsOf(sibling));
        const float loss = ranges_[at].surface - SurfaceOf(rest);
        shrinks = loss > 0;  // if it does not, none above it does
        saved += loss;
      }
      below = at;
      at = ranges_[at].parent;
    }
    if (best.beside == 0) return false;
    Move(moving, best.beside);
    return true;
  }

  /// Looks for a better place in `root`, for a range of these bounds and surface that has been
  /// taken out elsewhere, which has saved so much.
  void FindPlace(const Extent& bounds, float surface, float saved, uint32_t root,
                 Place& best) const {
    // Halves in which there may be a better one. So many are open at once only where a partition is
    // far from balanced; then some are left out.
    struct Halves {
      uint32_t first;
      float saved;  ///< without what those grow that hold them
    };
    constexpr size_t kMostOpen = 64;
    Halves open[kMostOpen];
    size_t open_count = 0;
    const auto visit = [&](uint32_t number, float saved_so_far) HWY_ATTR {
      const BinaryRange& range = ranges_[number];
      Extent joined = BoundsOf(number);
      joined.Join(bounds);
      const float saving = saved_so_far - SurfaceOf(joined);
      if (HWY_UNLIKELY(saving > best.saving)) best = {saving, number};
      // Wherever it is put among its halves, this one grows, and it is in a range as large as it.
      const float saved_below = saving + range.surface;
      open[open_count] = {range.first, saved_below};
      const bool may_be_better = saved_below - surface > best.saving;
      open_count += static_cast<size_t>(!range.IsLeaf() & may_be_better);
    };
    visit(root, saved);
    while (open_count > 0) {
      const Halves next = open[--open_count];
      if (!(next.saved - surface > best.saving) || open_count + 2 > kMostOpen) continue;
      visit(next.first, next.saved);
      visit(next.first + 1, next.saved);
    }
  }

  /// Its sibling takes the place of both; where they were stands the range that it is put beside,
  /// and it, and those two are the halves of what takes that one's place.
  void Move(uint32_t moving, uint32_t beside) {
    const uint32_t parent = ranges_[moving].parent, sibling = SiblingOf(moving);
    const uint32_t first = ranges_[parent].first;
    DACRT_ASSERT(beside != sibling);  // there it is
    const BinaryRange range = ranges_[moving];
    Put(ranges_[sibling], parent);
    if (parent != 0) Renew(ranges_[parent].parent);
    Put(ranges_[beside], first);
    Put(range, first + 1);
    ranges_[beside].first = first;
    ranges_[first].parent = ranges_[first + 1].parent = beside;
    Renew(beside);
  }

  /// Writes a range to the place of another one.
  void Put(const BinaryRange& range, uint32_t place) {
    const uint32_t parent = ranges_[place].parent;
    ranges_[place] = range;
    ranges_[place].parent = parent;
    if (range.IsLeaf()) return;
    ranges_[range.first].parent = ranges_[range.first + 1].parent = place;
  }

  /// The bounds of one whose halves have changed, and of those above it.
  void Renew(uint32_t number) {
    for (;; number = ranges_[number].parent) {
      BinaryRange& range = ranges_[number];
      Extent bounds = BoundsOf(range.first);
      bounds.Join(BoundsOf(range.first + 1));
      bounds.Put(range.bounds);
      range.surface = SurfaceOf(bounds);
      if (number == 0) return;
    }
  }

  BinaryRange* const ranges_;
  const size_t count_;
  const float scale_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_REINSERT_RANGES_INL_H_

// The partition of a scene's triangles that is kept between calls, and grows where rays go: a
// lazily built, 8-wide bounding volume hierarchy.
//
// The triangles, four bytes each, stand in an order in which every subset of the partition is a
// range. A subset is split when a ray first comes to it: a large one by a grid into many, for which
// the whole scene is sorted while it is listed; a small one into nodes with a few triangles in each
// leaf (split_subset-inl.h), and the nodes are made anew over the same leaves when rays have paid
// for it (buy_nodes-inl.h). Leaves get a copy of their geometry (leaf/leaf_block.h) while the
// budget lasts. What has been published never changes but for a word that says the same in another
// way, so threads read it without locks.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "geometry/box.h"
#include "geometry/geometry_table.h"
#include "geometry/triangle_refs.h"
#include "geometry/wide_node.h"
#include "leaf/leaf_block.h"
#include "partition/grid.h"
#include "runtime/assert.h"
#include "runtime/memory_account.h"
#include "runtime/pages.h"
#include "runtime/spare_pages.h"
#include "runtime/tasks.h"

namespace dacrt {

/// Nodes in a row: the number of the first, and their slots.
struct NodeRun {
  static NodeRun Of(uint64_t bits) {
    return {static_cast<uint32_t>(bits >> 32), static_cast<uint32_t>(bits)};
  }
  uint64_t bits() const { return uint64_t{first} << 32 | count; }

  uint32_t first = 0;
  uint32_t count = 0;
};

/// Triangles [begin, begin + count) of the kept order, see KeptPartition::OrderOf.
struct Subset {
  static constexpr uint32_t kUnsplit = UINT32_MAX;
  static constexpr uint32_t kBeingSplit = UINT32_MAX - 1;
  /// The budget is used up: this one stays as it is.
  static constexpr uint32_t kNoRoom = UINT32_MAX - 2;
  /// Together with the number of its first node: the triangles have moved so far that they are
  /// better split anew.
  static constexpr uint32_t kStale = 1u << 30;
  /// The same: they may be left for better ones (see rent_or_buy.h), so that rays are counted here.
  static constexpr uint32_t kRented = 1u << 29;
  static constexpr uint32_t kNowhere = UINT32_MAX;

  static constexpr bool IsNode(uint32_t root) { return root < kRented; }
  static constexpr bool IsRented(uint32_t root) { return root >= kRented && root < kStale; }
  static constexpr bool HasNodes(uint32_t root) { return root < kStale; }
  static constexpr uint32_t NodeOf(uint32_t root) { return root & (kRented - 1); }
  static constexpr bool IsStale(uint32_t root) { return root >= kStale && root < kNoRoom; }

  uint32_t begin;
  uint32_t count;
  uint32_t parent;  ///< node and child, node * 8 + child, behind which it stands; or kNowhere
  std::atomic<uint32_t> root;    ///< number of its first node, or one of the above
  std::atomic<uint32_t> rays;    ///< that have come while its nodes were rented
  std::atomic<uint32_t> inside;  ///< calls in its rented nodes
  uint32_t node_slots : 31;      ///< of its nodes, which stand in a row from there
  uint32_t has_its_nodes : 1;    ///< see KeptPartition::HasItsNodes
  float made_surface;            ///< half of its bounds' surface when it came to be
  float decay_base;  ///< surface of all volumes in it, relative to its own, when it was split
  /// Which geometries have triangles here: a bit for each of 64 rows of geometries; 0 if it is not
  /// known.
  uint64_t geometry_bits;
  float lower[3], upper[3];  ///< bounds; known where geometry_bits are
  std::atomic<uint64_t>
      rented;  ///< nodes that are to be given back, a NodeRun; 0 if there are none

  /// Of triangles that nobody has split. Where it stands stays as it is.
  void SetUnsplit(uint32_t first, uint32_t triangles, float surface) {
    begin = first;
    count = triangles;
    rays = 0;
    inside = 0;
    node_slots = 0;
    has_its_nodes = false;
    made_surface = surface;
    decay_base = 0;
    geometry_bits = 0;
    rented = 0;
    root = kUnsplit;
  }

  Box bounds() const {
    Box box;
    std::copy_n(lower, 3, box.lower);
    std::copy_n(upper, 3, box.upper);
    return box;
  }
};
static_assert(sizeof(Subset) == 80);

/// The kept order, where ranges of it are leaves: the last triangle of each is marked.
struct KeptOrder {
  static constexpr uint32_t kLastOfLeaf = 1u << 31;
  static constexpr uint32_t NumberOf(uint32_t entry) { return entry & ~kLastOfLeaf; }
};

/// What is walked: the nodes, what their leaves refer to, and the scene's.
struct PartitionView {
  static constexpr std::size_t kLeafUnit = 16;

  WideNode* nodes;
  const uint32_t* order;
  const std::byte* leaves;  ///< leaf blocks, by their place in units of kLeafUnit bytes

  /// Of a leaf that carries its geometry.
  const LeafBlock* FirstBlock(ChildWord leaf) const {
    return reinterpret_cast<const LeafBlock*>(leaves + std::size_t{leaf.block()} * kLeafUnit);
  }
};

/// The triangles of a range of numbers that can be hit.
struct ListedTriangles {
  std::size_t count;
  Box bounds;
  Box centers;  ///< bounds of lower + upper of each triangle, which is twice its centre
};

/// Writes the numbers of those among [begin, end) that can be hit, and behind them, up to
/// numbers + end - begin, those of the others (see list_triangles-inl.h).
using ListFunction = ListedTriangles (*)(const GeometryTable& geometries, std::size_t begin,
                                         std::size_t end, uint32_t* numbers);

/// The first look at a scene's triangles, for an instruction set (see list_triangles-inl.h).
struct FirstLook {
  ListFunction list;
  /// The same for a part of a grid, into the cells of which they are sorted on the way; which stand
  /// where they belong if all of them can be hit.
  ListedTriangles (*list_into_cells)(const GeometryTable& geometries, const Grid& grid,
                                     std::size_t part, const Box& centers, uint32_t* numbers);
  /// About what the centres of all will be.
  Box (*sample_centers)(const GeometryTable& geometries);
};

class KeptPartition {
 public:
  static constexpr std::size_t kLeafUnit = PartitionView::kLeafUnit;
  /// Leaf blocks are read by whole vectors, which may reach so far behind their end.
  static constexpr std::size_t kReadBehind = 64;

  /// For `geometries`, whose triangles are listed on the threads of `tasks`, in at most `budget`
  /// bytes; a budget that does not hold the triangles and a byte more for each counts as one that
  /// just does. `account`, if there is one, hears of them, and of the memory
  /// that splitting takes; its memory comes from `spare`, if there is one, and goes back there.
  /// Both must outlive the partition. Throws std::bad_alloc.
  KeptPartition(const GeometryTable& geometries, std::size_t budget, const FirstLook& look,
                TaskPool& tasks, const MemoryAccount* account = nullptr,
                SparePages* spare = nullptr);
  ~KeptPartition() {
    if (spare_) spare_->Keep(std::move(memory_));
  }

  /// A number that it has only as long as its leaves are what they are, and no other partition has
  /// (until 2^32 are used up); never 0.
  uint32_t edition() const { return edition_; }

  /// For how much a partition's addresses suffice: triangles, those that cannot be hit among them,
  /// and bytes. Of those that are not used large pages may hold some.
  struct Capacity {
    std::size_t triangles;
    std::size_t bytes;
  };

  /// The same once more, with what has been split so far. Nobody may trace the other one meanwhile.
  /// Throws std::bad_alloc.
  KeptPartition(const KeptPartition& other) : KeptPartition(other, other.capacity()) {}
  KeptPartition(const KeptPartition& other, const Capacity& capacity);
  KeptPartition& operator=(const KeptPartition&) = delete;

  /// Least budget with which anything is kept.
  static std::size_t LeastBytes(std::size_t triangles);

  /// Bounds of the triangles that can be hit, and their number.
  const Box& bounds() const { return bounds_; }
  std::size_t triangle_count() const { return triangles_.size(); }
  /// Numbers of the triangles that cannot be hit.
  std::span<const uint32_t> left_out() const { return left_out_; }
  /// Bounds of lower + upper of each triangle, which is twice its centre.
  const Box& centers() const { return centers_; }
  /// The grid into which they were sorted when they were listed, where there was room for one and
  /// all can be hit: in the memory of leaves, so that it is nothing's any more when one is made.
  std::optional<Grid> TakeSorted() { return std::exchange(sorted_, std::nullopt); }

  const GeometryTable& geometries() const { return *geometries_; }
  const MemoryAccount* account() const { return account_; }
  /// The numbers of the triangles (see GeometryTable::Number), in the kept order, with marks.
  std::span<uint32_t> triangles() { return triangles_; }
  std::span<const uint32_t> triangles() const { return triangles_; }
  /// Those of a subset, which may be reordered by whoever splits it.
  std::span<uint32_t> OrderOf(const Subset& subset) {
    return {triangles_.data() + subset.begin, subset.count};
  }
  std::span<const uint32_t> OrderOf(const Subset& subset) const {
    return {triangles_.data() + subset.begin, subset.count};
  }
  WideNode& node(uint32_t number) {
    DACRT_ASSERT(number < NodesUsed());
    return nodes_[number];
  }
  const WideNode& node(uint32_t number) const {
    DACRT_ASSERT(number < NodesUsed());
    return nodes_[number];
  }
  /// Subset 0 is the whole scene.
  Subset& subset(uint32_t number) {
    DACRT_ASSERT(number < subset_count_);
    return subsets_[number];
  }
  const Subset& subset(uint32_t number) const {
    DACRT_ASSERT(number < subset_count_);
    return subsets_[number];
  }
  std::size_t subset_count() const { return subset_count_; }

  PartitionView view() { return {nodes_, triangles_.data(), memory_.data()}; }

  /// What a walk begins with: the whole scene.
  ChildWord root() {
    const uint32_t number = subsets_[0].root.load(std::memory_order_acquire);
    return Subset::IsNode(number) ? ChildWord::Inner(number) : ChildWord::Subset(0);
  }

  /// Room for nodes of `slots` slots and `subset_count` subsets in a row, and the numbers of the
  /// first; false if there is not enough left. Nodes alone may be ones that have been given back.
  bool Allocate(std::size_t slots, std::size_t subset_count, uint32_t& first_node,
                uint32_t& first_subset);

  /// Whether so many nodes may be exact, for which room is set aside then.
  bool TakeExactRoom(std::size_t node_count);
  /// Says that so many nodes, or those of a run that are, are exact no longer.
  void ReturnExactRoom(std::size_t node_count);
  void ReturnExactRoom(const NodeRun& nodes);

  /// Gives nodes back that nobody uses. A few such runs are remembered, others are lost.
  void Free(const NodeRun& nodes) {
    ReturnExactRoom(nodes);
    Remember(nodes);
  }

  /// Calls f(node) for each of some nodes.
  template <class F>
  void ForEachNode(const NodeRun& nodes, const F& f) {
    ForEachNodeOf(*this, nodes, f);
  }
  template <class F>
  void ForEachNode(const NodeRun& nodes, const F& f) const {
    ForEachNodeOf(*this, nodes, f);
  }

  /// Says that a subset has all its nodes, which are these: what stayed free for it beyond that is
  /// for leaves.
  void HasItsNodes(Subset& subset, const NodeRun& nodes);

  /// Lanes of a leaf. Where leaves are not to carry their geometry there are half as many of them:
  /// gathering is what they cost then, and nodes take half of the room.
  std::size_t leaf_lanes() const { return leaf_lanes_; }

  /// Lanes of leaves with which a subset is split with care, where none is to carry its geometry,
  /// as long as it has no more nodes than NodeShareOf it: larger leaves are for the worst scenes,
  /// and the smaller they are, the less is gathered. Single rays of COMPACT scenes were 1.08
  /// to 1.11 times as fast in a hall, 1.14 to 1.35 in Sponza, 1.34 to 1.46 in Sibenik, of 75,000
  /// triangles; calls of 64K rays 1.03 to 1.05, 1.08 to 1.16, 1.13 to 1.22.
  std::size_t tried_leaf_lanes() const { return tried_leaf_lanes_; }
  /// Of the nodes that subsets have room for, as many as a subset has triangles of all; at least 1.
  std::size_t NodeShareOf(const Subset& subset) const;

  /// Says that many rays will come: subsets are split as SplitRule::kCare says
  /// (split_subset-inl.h). Nobody may trace meanwhile.
  void SplitWithCare() { splits_with_care_ = true; }
  bool splits_with_care() const { return splits_with_care_; }

  /// Whether there may be room for leaf blocks. That can change: nodes that turn out fewer than
  /// room was set aside for leave it to leaves.
  bool HasLeafRoom() const { return leaf_room_.load(std::memory_order_relaxed); }

  /// Room for leaf blocks of `bytes` bytes, and its place in units; false if there is not enough
  /// left.
  bool AllocateLeaf(std::size_t bytes, uint32_t& place);
  /// The room that the blocks of a leaf have.
  std::size_t RoomOfLeaf(uint32_t place);
  /// The place in the order of the first item of a leaf.
  uint32_t PlaceOfLeaf(ChildWord leaf) {
    return leaf.IsRange() ? leaf.range() : view().FirstBlock(leaf)->first;
  }
  std::byte* leaf(uint32_t place) { return memory_.data() + std::size_t{place} * kLeafUnit; }

  /// Says that room for nodes or leaves is not used any more: nobody can have it again.
  void Lose(std::size_t bytes) { lost_bytes_.fetch_add(bytes, std::memory_order_relaxed); }
  /// Whether so much is lost that making the partition anew is better.
  bool IsWornOut() const { return lost_bytes_ > memory_.bytes() / kMostLost; }

  /// Bytes of a partition that is made for so many triangles with this budget.
  static std::size_t BytesFor(std::size_t triangles, std::size_t budget);

  /// Whether it can be enlarged to `bytes` bytes for the geometries `now`, which are its own and
  /// others behind them, and that is better than to make it anew (see growth.h).
  bool CanGrow(const GeometryTable& now, std::size_t bytes) const;
  Capacity capacity() const { return {most_triangles_, memory_.span()}; }
  /// What it has, or, if that does not suffice to grow so, what a copy should have.
  Capacity CapacityFor(const GeometryTable& now, std::size_t bytes) const;
  /// Does it, if its capacity suffices: by the triangles `listed` of `numbers`, which are those of
  /// the other geometries, the ones that can be hit first, and with so much more memory. They are a
  /// subset that stands nowhere yet.
  void Grow(const GeometryTable& now, const ListedTriangles& listed,
            std::span<const uint32_t> numbers, MemoryClaim&& more) noexcept;
  /// That subset, if there is one.
  std::optional<uint32_t> TakeNew() { return std::exchange(new_subset_, std::nullopt); }

  /// The bit of a geometry among Subset::geometry_bits.
  uint64_t BitOf(uint32_t geometry) const {
    return uint64_t{1} << uint64_t{geometry} * 64 / made_geometries_ % 64;
  }

  /// From now on for these geometries, of as many triangles as it has (see refit.h).
  void SetGeometries(const GeometryTable& geometries) {
    geometries_ = &geometries;
    edition_ = NewEdition();
  }
  void SetBounds(const Box& bounds) { bounds_ = bounds; }

  /// Bytes that are in use, of those that the budget allows.
  std::size_t BytesUsed() const;
  std::size_t BytesReserved() const { return memory_.bytes(); }

 private:
  template <class Kept, class F>
  static void ForEachNodeOf(Kept& kept, const NodeRun& nodes, const F& f) {
    for (uint32_t i = 0; i < nodes.count;) {
      auto& next = kept.node(nodes.first + i);
      i += next.slots();
      f(next);
    }
  }

  static uint32_t NewEdition();

  void List(const FirstLook& look, TaskPool& tasks);
  ListedTriangles ListIntoGrid(const FirstLook& look, TaskPool& tasks);
  void PlaceGrid(TaskPool& tasks);
  void AddSubset(const GeometryTable& now, const ListedTriangles& listed);
  void MoveLeaves(const KeptPartition& other);
  bool TakeFree(std::size_t slots, uint32_t& first_node);
  void Remember(const NodeRun& nodes);
  std::size_t LeafUnitsBeside(std::size_t nodes) const;
  void GiveToLeaves(std::size_t units);
  void TrySmallerLeaves(std::size_t lanes);
  std::size_t NodesToShare() const;
  std::size_t NodesUsed() const { return taken_ >> 32; }  ///< slots

  /// A budget has so little to spare beside nodes and leaves.
  static constexpr std::size_t kMostLost = 32;

  const GeometryTable* geometries_;
  const MemoryAccount* const account_;
  SparePages* const spare_;
  Box bounds_ = Box::Empty();
  Box centers_ = Box::Empty();
  Pages memory_;
  std::size_t most_triangles_;   ///< that its order has places for
  std::size_t made_triangles_;   ///< that it was made of
  std::size_t made_geometries_;  ///< the same
  std::optional<uint32_t> new_subset_;
  std::optional<Grid> sorted_;
  std::span<uint32_t> triangles_;
  std::span<uint32_t> left_out_;
  std::span<Subset> subsets_;
  WideNode* nodes_ = nullptr;
  uint32_t edition_{NewEdition()};
  /// Nodes grow upwards from the first one, leaf blocks downwards from the end of the memory; both
  /// in one word, so that they never meet: slots of nodes in the upper half, units of leaves in the
  /// lower.
  std::atomic<uint64_t> taken_{0};
  std::size_t room_units_ = 0;               ///< for nodes and leaves, in units of leaves
  std::atomic<std::size_t> leaf_units_{0};   ///< for leaves at most: nodes come first
  std::atomic<std::size_t> exact_nodes_{0};  ///< that there may still be
  std::atomic<bool> leaf_room_{false};       ///< none since one found none, until there is more
  std::size_t leaf_lanes_ = kLeafLanes;
  std::size_t tried_leaf_lanes_ = kLeafLanes;
  bool splits_with_care_ = false;
  std::atomic<std::size_t> subset_count_{0};
  std::atomic<std::size_t> lost_bytes_{0};
  std::array<std::atomic<uint64_t>, 32> free_{};  ///< a NodeRun each, or 0
};

}  // namespace dacrt

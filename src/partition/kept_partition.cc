#include "partition/kept_partition.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "partition/list_pieces.h"
#include "partition/partition_room.h"
#include "runtime/scratch.h"

namespace dacrt {
namespace {

using namespace partition_room;

/// What leaves with their geometry were measured to take at least, a triangle.
constexpr std::size_t kLeafBytes = 20;

/// Leaves of the least budget, and its nodes: subsets have several hundred triangles, and need a
/// few nodes each.
constexpr std::size_t kMostLeafLanes = 8 * kLeafLanes;
std::size_t LeastNodes(std::size_t triangles) { return 16 + triangles / 168; }

/// Real scenes have a node for every three and a half leaves, were these full.
constexpr double kFullLeavesANode = 3.5;
/// Fewer than these are not worth their nodes.
constexpr std::size_t kLeastTriedLanes = kLeafLanes + 2;

}  // namespace

std::size_t KeptPartition::LeastBytes(std::size_t triangles) {
  return HeadBytes(triangles) + sizeof(WideNode) * LeastNodes(triangles) + kReadBehind;
}

std::size_t KeptPartition::BytesFor(std::size_t triangles, std::size_t budget) {
  return std::max(budget, LeastBytes(triangles)) / kLeafUnit * kLeafUnit;
}

KeptPartition::KeptPartition(const GeometryTable& geometries, std::size_t budget,
                             const FirstLook& look, TaskPool& tasks, const MemoryAccount* account,
                             SparePages* spare)
    : geometries_(&geometries),
      account_(account),
      spare_(spare),
      most_triangles_(geometries.triangle_count()),
      made_triangles_(most_triangles_),
      made_geometries_(geometries.size()) {
  const std::size_t most = most_triangles_;
  const std::size_t bytes = BytesFor(most, budget);
  memory_ = spare ? spare->Take(bytes, account) : Pages(bytes, account);
  std::byte* next = memory_.data();
  triangles_ = {reinterpret_cast<uint32_t*>(next), most};
  next += OrderBytes(most);
  subsets_ = {reinterpret_cast<Subset*>(next), SubsetsFor(most)};
  nodes_ = reinterpret_cast<WideNode*>(memory_.data() + HeadBytes(most));
  room_units_ = UnitsFor(most, bytes);
  leaf_units_ = LeafUnitsBeside(NodesFor(LanesOf(geometries)));
  // Places have 30 bits.
  if (bytes / kLeafUnit > ChildWord::kMostBlock) leaf_units_ = 0;
  leaf_room_ = leaf_units_ > 0;
  if (leaf_lanes_ == kLeafLanes) exact_nodes_ = ExactNodesFor(LanesOf(geometries), room_units_);
  // Half of the leaves at least should find room.
  if (leaf_units_ * kLeafUnit < kLeafBytes / 2 * most) leaf_lanes_ = 2 * kLeafLanes;
  // Larger ones where nodes over those would not find room: what a large leaf costs is little
  // beside a subset without nodes, of which every triangle is tested.
  while (leaf_lanes_ < kMostLeafLanes &&
         NodesFor(LanesOf(geometries), leaf_lanes_) * kUnitsANode > room_units_) {
    leaf_lanes_ += kLeafLanes;
  }
  TrySmallerLeaves(LanesOf(geometries));

  List(look, tasks);
  subset_count_ = 1;
  subsets_[0].SetUnsplit(0, static_cast<uint32_t>(triangles_.size()), bounds_.HalfArea());
  subsets_[0].parent = Subset::kNowhere;
}

/// Where there are no leaves beside them. A little room stays free for nodes over subsets.
std::size_t KeptPartition::NodesToShare() const {
  const std::size_t nodes = room_units_ / kUnitsANode;
  return nodes - nodes / 32;
}

std::size_t KeptPartition::NodeShareOf(const Subset& subset) const {
  return std::max<std::size_t>(NodesToShare() * subset.count / triangles_.size(), 1);
}

/// For a partition of so many lanes.
void KeptPartition::TrySmallerLeaves(std::size_t lanes) {
  tried_leaf_lanes_ = leaf_lanes_;
  if (leaf_units_ > 0) return;
  const double full_leaves = kFullLeavesANode * static_cast<double>(NodesToShare());
  const auto least = static_cast<std::size_t>(static_cast<double>(lanes) / full_leaves) + 1;
  tried_leaf_lanes_ = std::min(std::max(least, kLeastTriedLanes), leaf_lanes_);
}

uint32_t KeptPartition::NewEdition() {
  static std::atomic<uint32_t> last{0};
  for (;;) {
    const uint32_t edition = last.fetch_add(1, std::memory_order_relaxed) + 1;
    if (edition != 0) return edition;
  }
}

/// What nodes leave for leaves.
std::size_t KeptPartition::LeafUnitsBeside(std::size_t nodes) const {
  const std::size_t units = nodes * kUnitsANode;
  return room_units_ > units ? room_units_ - units : 0;
}

void KeptPartition::List(const FirstLook& look, TaskPool& tasks) {
  const std::size_t most = triangles_.size();
  if (most > SubsetScratch::kTriangles) PlaceGrid(tasks);
  const ListedTriangles all = sorted_ ? ListIntoGrid(look, tasks)
                                      : ListInPieces(*geometries_, 0, triangles_, look.list, tasks);
  bounds_ = all.bounds;
  centers_ = all.centers;
  left_out_ = triangles_.subspan(all.count);
  triangles_ = triangles_.first(all.count);
  if (!left_out_.empty()) sorted_.reset();
}

ListedTriangles KeptPartition::ListIntoGrid(const FirstLook& look, TaskPool& tasks) {
  const Grid& grid = *sorted_;
  std::vector<ListedTriangles> pieces(grid.parts);
  const auto begin_of = [&](std::size_t part) { return grid.PartOf(part).begin; };
  const Box centers = look.sample_centers(*geometries_);
  tasks.ForEach(pieces.size(), [&](std::size_t i) {
    pieces[i] =
        look.list_into_cells(*geometries_, grid, i, centers, triangles_.data() + begin_of(i));
  });
  return JoinPieces(triangles_, pieces, begin_of);
}

/// A grid in the memory that leaves will have, if there is enough.
void KeptPartition::PlaceGrid(TaskPool& tasks) {
  const std::size_t parts = Grid::PartsFor(triangles_.size(), tasks.threads());
  const Grid::Sizes sizes(triangles_.size(), parts);
  const std::size_t bytes = RoundUp(sizes.bytes, alignof(WideNode));
  const auto* const nodes =
      reinterpret_cast<const std::byte*>(nodes_ + WideNode::kExactSlots * sizes.nodes);
  const std::size_t offset =
      (memory_.bytes() - std::min(memory_.bytes(), bytes + kReadBehind)) & ~(alignof(WideNode) - 1);
  if (memory_.data() + offset < nodes) return;
  sorted_.emplace(triangles_.size(), parts, memory_.data() + offset);
}

void KeptPartition::HasItsNodes(Subset& subset, const NodeRun& nodes) {
  if (subset.has_its_nodes || leaf_units_ == 0) return;
  subset.has_its_nodes = true;
  std::size_t lanes = subset.count;
  if (!geometries_->all_fill_one_lane()) {
    lanes = 0;
    for (const uint32_t entry : OrderOf(subset)) {
      lanes += geometries_->LanesOf(geometries_->Locate(KeptOrder::NumberOf(entry)).geometry);
    }
  }
  const std::size_t most = NodesOver(lanes, leaf_lanes_);
  std::size_t count = 0;
  ForEachNode(nodes, [&](const WideNode&) { ++count; });
  if (count < most) GiveToLeaves((most - count) * kUnitsANode);
}

void KeptPartition::GiveToLeaves(std::size_t units) {
  leaf_units_ += units;
  leaf_room_ = true;
}

/// What exact nodes take more than others is taken from leaves that there are not yet. (One that a
/// thread makes at this moment may take it, too: nodes have that much room to spare.)
bool KeptPartition::TakeExactRoom(std::size_t node_count) {
  const auto take = [](std::atomic<std::size_t>& room, std::size_t least, std::size_t amount) {
    std::size_t left = room.load();
    do {
      if (left < least + amount) return false;
    } while (!room.compare_exchange_weak(left, left - amount));
    return true;
  };
  if (!take(exact_nodes_, 0, node_count)) return false;
  if (take(leaf_units_, taken_ & UINT32_MAX, node_count * kUnitsMoreExact)) return true;
  exact_nodes_ += node_count;
  return false;
}

void KeptPartition::ReturnExactRoom(const NodeRun& nodes) {
  std::size_t count = 0;
  ForEachNode(nodes, [&](const WideNode& node) { count += node.is_exact; });
  ReturnExactRoom(count);
}

void KeptPartition::ReturnExactRoom(std::size_t node_count) {
  exact_nodes_ += node_count;
  GiveToLeaves(node_count * kUnitsMoreExact);
}

/// It takes the place of the shortest run that is remembered, and that one the place of another or
/// none.
void KeptPartition::Remember(const NodeRun& nodes) {
  const auto is_shorter = [](uint64_t one, uint64_t other) {
    return NodeRun::Of(one).count < NodeRun::Of(other).count;
  };
  for (NodeRun run = nodes; run.count > 0;) {
    std::atomic<uint64_t>& place = *std::min_element(free_.begin(), free_.end(), is_shorter);
    uint64_t shortest = place;
    if (!is_shorter(shortest, run.bits())) return Lose(run.count * sizeof(WideNode));
    if (place.compare_exchange_strong(shortest, run.bits())) run = NodeRun::Of(shortest);
  }
}

/// Of the shortest run that is long enough; the rest of it stays free.
bool KeptPartition::TakeFree(std::size_t slots, uint32_t& first_node) {
  std::atomic<uint64_t>* best = nullptr;
  NodeRun nodes{0, UINT32_MAX};
  for (std::atomic<uint64_t>& run : free_) {
    const NodeRun other = NodeRun::Of(run);
    if (other.count < slots || other.count >= nodes.count) continue;
    best = &run;
    nodes = other;
  }
  const auto count = static_cast<uint32_t>(slots);
  uint64_t bits = nodes.bits();
  const NodeRun rest{nodes.first + count, nodes.count - count};
  if (!best || !best->compare_exchange_strong(bits, rest.bits())) return false;
  first_node = nodes.first;
  return true;
}

bool KeptPartition::Allocate(std::size_t slots, std::size_t subset_count, uint32_t& first_node,
                             uint32_t& first_subset) {
  if (subset_count == 0 && TakeFree(slots, first_node)) return true;
  uint64_t taken = taken_.load();
  do {
    const uint64_t nodes = taken >> 32, units = taken & UINT32_MAX;
    if ((nodes + slots) * kUnitsANode + units > room_units_) return false;
    if (nodes + slots > ChildWord::kMostNumber) return false;
    first_node = static_cast<uint32_t>(nodes);
  } while (!taken_.compare_exchange_weak(taken, taken + (uint64_t{slots} << 32)));

  // Last, since every subset that is counted stands somewhere.
  std::size_t subsets = subset_count_.load();
  do {
    if (subset_count > subsets_.size() - subsets) {
      Remember({first_node, static_cast<uint32_t>(slots)});
      return false;
    }
  } while (!subset_count_.compare_exchange_weak(subsets, subsets + subset_count));
  first_subset = static_cast<uint32_t>(subsets);
  DACRT_ASSERT(BytesUsed() <= BytesReserved());
  return true;
}

bool KeptPartition::AllocateLeaf(std::size_t bytes, uint32_t& place) {
  const uint64_t units = (bytes + kLeafUnit - 1) / kLeafUnit;
  uint64_t taken = taken_.load();
  do {
    const uint64_t nodes = taken >> 32, used = taken & UINT32_MAX;
    if (used + units > leaf_units_ || nodes * kUnitsANode + used + units > room_units_) {
      leaf_room_.store(false, std::memory_order_relaxed);
      return false;
    }
    const std::size_t end = (memory_.span() - kReadBehind) / kLeafUnit;
    place = static_cast<uint32_t>(end - used - units);
  } while (!taken_.compare_exchange_weak(taken, taken + units));
  DACRT_ASSERT(BytesUsed() <= BytesReserved());
  return true;
}

std::size_t KeptPartition::RoomOfLeaf(uint32_t place) {
  const auto* block = reinterpret_cast<const LeafBlock*>(leaf(place));
  std::size_t bytes = block->Bytes();
  for (; !block->is_last; bytes += block->Bytes()) block = block->Next();
  return RoundUp(bytes, kLeafUnit);
}

std::size_t KeptPartition::BytesUsed() const {
  const uint64_t taken = taken_.load();
  return triangles_.size_bytes() + (taken >> 32) * sizeof(WideNode) +
         (taken & UINT32_MAX) * kLeafUnit + subset_count_ * sizeof(Subset);
}

}  // namespace dacrt

#include "partition/growth.h"

#include <algorithm>
#include <utility>

#include "partition/list_pieces.h"
#include "partition/partition_room.h"
#include "runtime/scratch.h"

namespace dacrt {

using namespace partition_room;

namespace {

/// Nodes that splitting them takes at most, and one over the subset and another one.
std::size_t NodesOf(std::size_t lanes, std::size_t leaf_lanes = kLeafLanes) {
  return NodesFor(lanes, leaf_lanes) - NodesFor(0) + 2;
}

}  // namespace

Growth::Growth(const KeptPartition& kept, const GeometryTable& now, std::size_t bytes,
               ListFunction list, TaskPool& tasks) {
  const std::size_t before = kept.triangle_count() + kept.left_out().size();
  memory_ = Pages(sizeof(uint32_t) * (now.triangle_count() - before), kept.account());
  listed_ = ListInPieces(now, before, numbers(), list, tasks);
  const KeptPartition::Capacity has = kept.capacity(), capacity = kept.CapacityFor(now, bytes);
  // Spare memory may have more bytes than triangles find places in.
  if (capacity.triangles > has.triangles || capacity.bytes > has.bytes) {
    copy_ = std::make_unique<KeptPartition>(kept, capacity);
  }
  more_ = MemoryClaim(bytes - kept.BytesReserved(), kept.account());
}

bool KeptPartition::CanGrow(const GeometryTable& now, std::size_t bytes) const {
  const std::size_t before = triangles_.size() + left_out_.size();
  const std::size_t triangles = now.triangle_count(), added = triangles - before;
  const Subset& all = subsets_[0];
  // One that is split in one go is cheaply made anew.
  if (!Subset::IsNode(all.root) || all.count <= SubsetScratch::kTriangles) return false;
  if (triangles > made_triangles_ + growth::Most(made_triangles_)) return false;
  // Small scenes have more for each triangle.
  if (bytes < memory_.bytes()) return false;
  if (CapacityFor(now, bytes).bytes / kLeafUnit > ChildWord::kMostBlock) return false;
  if (subset_count_ + SubsetsFor(added) > SubsetsFor(triangles)) return false;
  const uint64_t taken = taken_;
  const std::size_t used = (taken >> 32) * kUnitsANode + (taken & UINT32_MAX);
  const std::size_t lanes = LanesOf(now, static_cast<uint32_t>(geometries_->size()));
  return used + NodesOf(lanes, leaf_lanes_) * kUnitsANode <= UnitsFor(triangles, bytes);
}

/// For as many triangles as it may grow to, so that it is copied once; more often where new ones
/// have more bytes each than old ones.
KeptPartition::Capacity KeptPartition::CapacityFor(const GeometryTable& now,
                                                   std::size_t bytes) const {
  const std::size_t room = UnitsFor(now.triangle_count(), bytes) * kLeafUnit + kReadBehind;
  if (now.triangle_count() <= most_triangles_ &&
      HeadBytes(most_triangles_) + room <= memory_.span())
    return capacity();
  const std::size_t most = made_triangles_ + growth::Most(made_triangles_);
  return {most, HeadBytes(most) + RoundUp(room * most / now.triangle_count(), kLeafUnit)};
}

void KeptPartition::Grow(const GeometryTable& now, const ListedTriangles& listed,
                         std::span<const uint32_t> numbers, MemoryClaim&& more) noexcept {
  const std::size_t before = triangles_.size(), triangles = now.triangle_count();
  const std::size_t lanes = LanesOf(now, static_cast<uint32_t>(geometries_->size()));
  DACRT_ASSERT(triangles <= most_triangles_ &&
               before + left_out_.size() + numbers.size() == triangles);
  uint32_t* const end = triangles_.data() + before;
  std::copy_backward(left_out_.begin(), left_out_.end(), end + listed.count + left_out_.size());
  std::copy_n(numbers.begin(), listed.count, end);
  std::copy(numbers.begin() + listed.count, numbers.end(), end + listed.count + left_out_.size());
  triangles_ = {triangles_.data(), before + listed.count};
  left_out_ = {end + listed.count, triangles - triangles_.size()};

  memory_.Extend(std::move(more));
  subsets_ = {subsets_.data(), SubsetsFor(triangles)};
  const std::size_t room = UnitsFor(triangles, memory_.bytes());
  const std::size_t for_nodes = NodesOf(lanes) * kUnitsANode + room_units_;
  leaf_units_ = std::max(leaf_units_ + room, for_nodes) - for_nodes;
  leaf_room_ = leaf_units_ > (taken_ & UINT32_MAX);
  if (exact_nodes_ > 0 && room > room_units_) {
    exact_nodes_ += ExactNodesFor(lanes, room - room_units_);
  }
  room_units_ = room;
  DACRT_ASSERT(BytesUsed() <= BytesReserved());
  if (listed.count > 0) AddSubset(now, listed);
}

/// Of the last triangles of the order. The surface that it was made with is in proportion to what
/// the others' have come to be since.
void KeptPartition::AddSubset(const GeometryTable& now, const ListedTriangles& listed) {
  Subset& all = subsets_[0];
  Subset& subset = subsets_[subset_count_];
  const float before = bounds_.HalfArea();
  bounds_.Extend(listed.bounds);
  const float made = before > 0 ? all.made_surface / before : 1;
  all.made_surface = made * bounds_.HalfArea();
  all.count = static_cast<uint32_t>(triangles_.size());
  subset.SetUnsplit(static_cast<uint32_t>(triangles_.size() - listed.count),
                    static_cast<uint32_t>(listed.count), made * listed.bounds.HalfArea());
  subset.parent = Subset::kNowhere;
  for (auto geometry = static_cast<uint32_t>(geometries_->size()); geometry < now.size();
       ++geometry) {
    subset.geometry_bits |= BitOf(geometry);
  }
  std::copy_n(listed.bounds.lower, 3, subset.lower);
  std::copy_n(listed.bounds.upper, 3, subset.upper);
  new_subset_ = static_cast<uint32_t>(subset_count_++);
}

KeptPartition::KeptPartition(const KeptPartition& other, const Capacity& capacity)
    : geometries_(other.geometries_),
      account_(other.account_),
      spare_(other.spare_),
      bounds_(other.bounds_),
      centers_(other.centers_),
      memory_(other.memory_.bytes(), account_, capacity.bytes),
      most_triangles_(capacity.triangles),
      made_triangles_(other.made_triangles_),
      made_geometries_(other.made_geometries_),
      taken_(other.taken_.load()),
      room_units_(other.room_units_),
      leaf_units_(other.leaf_units_.load()),
      exact_nodes_(other.exact_nodes_.load()),
      leaf_room_(other.leaf_room_.load()),
      leaf_lanes_(other.leaf_lanes_),
      tried_leaf_lanes_(other.tried_leaf_lanes_),
      splits_with_care_(other.splits_with_care_),
      subset_count_(other.subset_count_.load()),
      lost_bytes_(other.lost_bytes_.load()) {
  for (std::size_t i = 0; i < free_.size(); ++i) free_[i] = other.free_[i].load();
  std::byte* const begin = memory_.data();
  const auto copy = [](const void* from, std::size_t bytes, std::byte* to) {
    std::copy_n(static_cast<const std::byte*>(from), bytes, to);
    return to;
  };
  const std::size_t listed = other.triangles_.size(), left_out = other.left_out_.size();
  auto* const order = reinterpret_cast<uint32_t*>(
      copy(other.triangles_.data(), sizeof(uint32_t) * (listed + left_out), begin));
  triangles_ = {order, listed};
  left_out_ = {order + listed, left_out};
  subsets_ = {reinterpret_cast<Subset*>(copy(other.subsets_.data(), sizeof(Subset) * subset_count_,
                                             begin + OrderBytes(capacity.triangles))),
              other.subsets_.size()};
  nodes_ = reinterpret_cast<WideNode*>(
      copy(other.nodes_, sizeof(WideNode) * NodesUsed(), begin + HeadBytes(capacity.triangles)));
  const std::size_t leaves = (taken_ & UINT32_MAX) * kLeafUnit + kReadBehind;
  copy(other.memory_.data() + other.memory_.span() - leaves, leaves,
       begin + memory_.span() - leaves);
  if (memory_.span() != other.memory_.span()) MoveLeaves(other);
}

/// Leaves of a copy with other addresses stand elsewhere.
void KeptPartition::MoveLeaves(const KeptPartition& other) {
  const auto shift = static_cast<uint32_t>((memory_.span() - other.memory_.span()) / kLeafUnit);
  for (const Subset& subset : subsets_.first(subset_count_)) {
    if (subset.root >= Subset::kNoRoom) continue;
    ForEachNode({Subset::NodeOf(subset.root), subset.node_slots}, [&](WideNode& node) {
      for (std::size_t k = 0; k < node.count; ++k) {
        const ChildWord child = node.Child(k);
        if (child.IsBlock()) node.SetChild(k, ChildWord::Block(child.block() + shift));
      }
    });
  }
}

}  // namespace dacrt

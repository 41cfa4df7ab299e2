#include "partition/kept_partition.h"

#include <algorithm>
#include <vector>

namespace dacrt {
namespace {

/// Subsets of a scene. A subset that is split by a grid becomes ones of several hundred triangles;
/// where they should not suffice, subsets stay larger.
std::size_t SubsetsFor(std::size_t triangles) { return 64 + triangles / 128; }

std::size_t TriangleBytes(std::size_t triangles) {
  // Rounded up to whole nodes, which stand behind them.
  constexpr std::size_t kNode = sizeof(WideNode);
  return (sizeof(uint32_t) * triangles + kNode - 1) / kNode * kNode;
}

/// Takes one for each of `count` from a counter, unless there are not enough.
bool Take(std::atomic<std::size_t>& counter, std::size_t count, std::size_t most, uint32_t& first) {
  std::size_t begin = counter.load();
  do {
    if (count > most - begin) return false;
  } while (!counter.compare_exchange_weak(begin, begin + count));
  first = static_cast<uint32_t>(begin);
  return true;
}

}  // namespace

std::size_t KeptPartition::LeastBytes(std::size_t triangles) {
  return TriangleBytes(triangles) + sizeof(Subset) * SubsetsFor(triangles) +
         sizeof(WideNode) * (16 + triangles / 1024);
}

KeptPartition::KeptPartition(const MeshTable& meshes, std::size_t budget, ListFunction list,
                             TaskPool& tasks)
    : meshes_(meshes) {
  const std::size_t most = meshes.triangle_count();
  memory_ = Pages(std::max(budget, LeastBytes(most)));
  std::byte* next = memory_.data();
  triangles_ = {reinterpret_cast<uint32_t*>(next), most};
  next += TriangleBytes(most);
  subsets_ = {reinterpret_cast<Subset*>(next), SubsetsFor(most)};
  std::size_t left = memory_.bytes() - TriangleBytes(most) - subsets_.size_bytes();
  next += subsets_.size_bytes();
  const std::size_t align =
      (alignof(WideNode) - reinterpret_cast<std::uintptr_t>(next)) % alignof(WideNode);
  left -= align;
  // Every node has a triangle at least.
  nodes_ = {reinterpret_cast<WideNode*>(next + align), std::min(left / sizeof(WideNode), most + 1)};

  List(list, tasks);
  subset_count_ = 1;
  subsets_[0].begin = 0;
  subsets_[0].count = static_cast<uint32_t>(triangles_.size());
  subsets_[0].root = Subset::kUnsplit;
}

/// Each piece of the numbers is listed where it would stand if every triangle could be hit.
void KeptPartition::List(ListFunction list, TaskPool& tasks) {
  constexpr std::size_t kPiece = 65536;  // half a millisecond
  const std::size_t most = triangles_.size();
  std::vector<ListedTriangles> pieces((most + kPiece - 1) / kPiece);
  tasks.ForEach(pieces.size(), [&](std::size_t i) {
    const std::size_t begin = i * kPiece;
    pieces[i] = list(meshes_, begin, std::min(begin + kPiece, most), triangles_.data() + begin);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].count == 0) continue;
    if (kept < i * kPiece) {
      std::copy_n(triangles_.data() + i * kPiece, pieces[i].count, triangles_.data() + kept);
    }
    kept += pieces[i].count;
    bounds_.Extend(pieces[i].bounds.lower);
    bounds_.Extend(pieces[i].bounds.upper);
    centers_.Extend(pieces[i].centers.lower);
    centers_.Extend(pieces[i].centers.upper);
  }
  triangles_ = triangles_.first(kept);
}

bool KeptPartition::Allocate(std::size_t node_count, std::size_t subset_count, uint32_t& first_node,
                             uint32_t& first_subset) {
  // If only one of the two can be had, what was taken is lost; the budget is at its end then.
  return Take(node_count_, node_count, nodes_.size(), first_node) &&
         Take(subset_count_, subset_count, subsets_.size(), first_subset);
}

std::size_t KeptPartition::BytesUsed() const {
  return triangles_.size_bytes() + node_count_ * sizeof(WideNode) + subset_count_ * sizeof(Subset);
}

}  // namespace dacrt

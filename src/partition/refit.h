// Refit: where only vertices have moved since the last commit, the old partition gets new bounds.
//
// A commit renews the volumes of nodes, and only of those in subsets that hold a mesh which
// changed; the copies that leaves have are renewed when rays come to them (trace/give_leaves.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/box.h"
#include "geometry/mesh_table.h"
#include "partition/kept_partition.h"
#include "runtime/tasks.h"

namespace dacrt {

namespace refit {

/// How much larger than when they were made the surfaces of volumes may get, relative to the whole,
/// before what they divide is split anew: they are what rays cost, by the surface area heuristic.
inline constexpr float kMostDecay = 1.6f;

}  // namespace refit

/// What is known of a subset after its vertices have moved.
struct RefittedSubset {
  Box bounds = Box::Empty();
  uint64_t mesh_bits = 0;
  bool is_unit = false;      ///< has no subsets in it
  bool is_stale = false;     ///< holds triangles that changed
  bool has_decayed = false;  ///< is to be split anew
};

/// The nodes of the stale ones among some subsets, one after the other.
struct RefitPiece {
  std::vector<WideNode> nodes;
  std::vector<Box> leaves;  ///< of one subset, meanwhile
};

/// What a refit will do. To make it changes nothing; to carry it out cannot fail.
struct RefitPlan {
  /// Subsets of a piece: a few thousand triangles.
  static constexpr std::size_t kPiece = 8;

  std::vector<RefittedSubset> subsets;
  std::vector<RefitPiece> pieces;
  std::vector<Box> node_bounds;  ///< room for those of any row of nodes
  Box bounds;
  bool always;  ///< however much subsets have decayed
};

/// Whether two tables describe the same items in the same order, with the same indices, so that
/// nothing but coordinates may differ.
bool HaveSameItems(const MeshTable& before, const MeshTable& now);

/// Which meshes of `now` may differ from what they were before, where they have the same items.
std::vector<bool> ChangedMeshes(const MeshTable& before, const MeshTable& now);

/// Plans the refit of `kept` to the meshes `now`, which have the same items, and of which those
/// that `changed` tells have moved. False if the partition must be made anew: other items than
/// before can be hit, or, unless `always`, its subsets have decayed. Throws std::bad_alloc.
using PlanRefitFunction = bool (*)(const KeptPartition& kept, const MeshTable& now,
                                   const std::vector<bool>& changed, bool always, TaskPool& tasks,
                                   RefitPlan& plan);

/// Carries it out. Nobody may trace meanwhile.
using RefitFunction = void (*)(KeptPartition& kept, const MeshTable& now, RefitPlan& plan);

}  // namespace dacrt

// Refit: where only vertices have moved since the last commit, the old partition gets new bounds.
//
// A commit renews the volumes of nodes and the copies that leaves have, and only of those in
// subsets that hold a geometry which changed. Where a copy is not as easily renewed, that waits for
// rays (trace/give_leaves.h). To wait with whole subsets does not pay: in halls, Sponza and the
// dragon a thousand rays come to nearly all of them, and their bounds want a look at every triangle
// before.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/box.h"
#include "geometry/geometry_table.h"
#include "partition/kept_partition.h"
#include "runtime/tasks.h"

namespace dacrt {

namespace refit {

/// How much larger than when they were made the surfaces of volumes may get, relative to the whole,
/// before what they divide is split anew: they are what rays cost, by the surface area heuristic.
inline constexpr float kMostDecay = 1.6f;

}  // namespace refit

/// What a refit will do. To make it changes nothing; to carry it out cannot fail.
struct RefitPlan {
  std::vector<bool> changed;  ///< which geometries have moved
  bool always;                ///< however much subsets have decayed
};

/// Whether a table describes the items of another one in the same order, with the same indices, so
/// that nothing but coordinates may differ, and perhaps others behind them.
bool BeginsWithSameItems(const GeometryTable& before, const GeometryTable& now);

/// Whether a geometry may differ from what it was before.
bool IsChanged(const Geometry& before, const Geometry& now);

/// Which geometries of `now` may differ from what they were before; not those that are new.
std::vector<bool> ChangedGeometries(const GeometryTable& before, const GeometryTable& now);

/// Whether `kept` can be refitted to the geometries `now`, which begin with the same items, as
/// `plan` says. False if the partition must be made anew: other items than before can be hit, or,
/// unless the plan says always, its subsets have decayed.
using CanRefitFunction = bool (*)(const KeptPartition& kept, const GeometryTable& now,
                                  const RefitPlan& plan, TaskPool& tasks);

/// Does it. A subset of items that have come (see growth.h) gets its place. Nobody may trace
/// meanwhile.
using RefitFunction = void (*)(KeptPartition& kept, const GeometryTable& now, const RefitPlan& plan,
                               TaskPool& tasks) noexcept;

}  // namespace dacrt

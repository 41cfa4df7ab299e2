// What a committed scene consists of, for those who trace it: the scene itself, and instances.
#pragma once

#include <cstddef>
#include <memory>

#include "geometry/box.h"
#include "geometry/geometry_table.h"
#include "partition/kept_partition.h"

namespace dacrt {

/// What rays ask of a scene that they enter is in its first cache line (see GeometryTable).
struct alignas(64) SceneParts {
  GeometryTable geometries;
  Box bounds = Box::Empty();
  std::size_t triangle_count = 0;                 ///< items that can be hit, of any shape
  std::unique_ptr<KeptPartition> kept = nullptr;  ///< null if nothing is kept
  bool has_callbacks = false;  ///< the scene itself, or one that it has an instance of
  bool has_instances = false;
  bool has_motion = false;  ///< of itself: what an instance shows is not looked at
  /// Whether filter functions may be asked last about closest hits (see trace/ask_last-inl.h):
  /// there are such, nobody else is called, so that nobody sees that a ray begins anew, and hits
  /// tell by their IDs whose function is to be asked.
  bool closest_filters_may_wait = false;
  bool prepares_leaves = true;  ///< if it is small enough, see policy::kPreparedScene
  bool is_small = false;        ///< neither it nor a scene it has instances of is above kSmallScene

  PartitionView partition() const { return kept ? kept->view() : PartitionView{}; }
};

}  // namespace dacrt

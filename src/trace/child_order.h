// In which order the children of a node are visited by rays that look for any hit.
//
// The order decides how soon a blocked ray is done, and no rule knows it beforehand: for shadows
// the nearest child holds the surface that the rays come from, the farthest what stands around the
// light, and each order takes twice the time of another one in some scene. So it is learnt, from
// groups or pieces of rays.
//
// What any-hit rays find does not depend on it.
#pragma once

#include <cstdint>

#include "trace/learnt_best.h"

namespace dacrt {

/// As stored: see SortChildren in partition/choose_nodes-inl.h. Single rays always go so: distances
/// would have to be stored.
enum class ChildOrder : uint8_t { kAsStored, kNearestFirst, kFarthestFirst };

class LearntOrder : public LearntBest<3> {
 public:
  using LearntBest::LearntBest;

  ChildOrder best() const { return static_cast<ChildOrder>(LearntBest::best()); }
  ChildOrder Next() const { return static_cast<ChildOrder>(LearntBest::Next()); }
};

}  // namespace dacrt

// What random worlds may hold, so that a run can be restricted to what is to be tested.
#pragma once

#include <bitset>
#include <span>
#include <string_view>

namespace dacrt::tests {

enum class Feature : unsigned {
  kTriangles,
  kQuads,
  kGrids,
  kSpheres,
  kDiscs,
  kOrientedDiscs,
  kUser,
  kInstances,
  kMotion,          ///< 2 to 129 time steps, time ranges
  kQuaternions,     ///< instances whose transforms are given in parts
  kFilters,         ///< filter functions of geometries
  kContextFilters,  ///< filter functions of calls
  kMasks,
  kLayouts,  ///< strides, offsets, and who owns the memory
  kRobust,
  kFlags,    ///< compact and dynamic scenes, build qualities
  kChanges,  ///< commits after changes
  kConfigs,  ///< instruction sets, threads, budgets and methods of the drop-in
  kHostile,  ///< vertices that are no numbers, infinite or huge; negative radii
  kScales,   ///< worlds from 1e-30 to 1e18 across, and small ones far from the origin
};
inline constexpr unsigned kFeatureCount = 20;

using Features = std::bitset<kFeatureCount>;

inline bool Has(const Features& features, Feature feature) {
  return features[static_cast<unsigned>(feature)];
}

const char* Name(Feature feature);

/// All features, or those of a list such as "triangles,quads,motion"; "-NAME" takes one away from
/// what stands before it, and from all if it stands first.
/// Throws std::invalid_argument for a name that is not known.
Features ParseFeatures(std::string_view list);

}  // namespace dacrt::tests

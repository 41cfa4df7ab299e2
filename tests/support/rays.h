// Rays of every kind that a renderer sends, and of those that find faults.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "embree_scene.h"
#include "scenes.h"

namespace dacrt::tests {

enum class RayKind {
  kCamera,            ///< a picture, row by row
  kAmbientOcclusion,  ///< short, from what the camera sees
  kDiffuse,           ///< one to three bounces from what the camera sees
  kRandomLines,       ///< between random points in and around the bounds
  kAxisAligned,       ///< along an axis, zeros of either sign, often through vertices
  kZeroComponents,    ///< in a plane of two axes
  kEdges,             ///< aimed exactly at vertices and middles of edges, and along edges
  kSurface,           ///< from a hit point exactly, in any direction
  kShort,             ///< ends before, after and at the origin
  kTfarAtHit,         ///< ends exactly at a hit, or one float before or after it
  kTnearAtHit,        ///< begins there
  kNegativeTnear,     ///< begins behind the origin
  kMasks,             ///< masks with no, some and all bits
  kUnnormalised,      ///< directions from very short to very long
  kHostile,           ///< inactive, zero, infinite and not-a-number rays among ordinary ones
};

std::vector<RayKind> AllRayKinds();

const char* Name(RayKind kind);

/// Finds the closest hits of rays.
using TraceRays = std::function<void(std::span<RTCRayHit>)>;

/// Makes rays for one scene. What they need to know of hits they ask of a library's scene.
class RayGenerator {
 public:
  /// `scene` must outlive the generator.
  RayGenerator(const TestScene& scene, TraceRays trace);

  /// Both must outlive the generator.
  RayGenerator(const TestScene& scene, const EmbreeScene& traced_scene);

  /// `count` rays, the same ones for the same seed. Components that do not matter to a query hold
  /// random bits; geomID is RTC_INVALID_GEOMETRY_ID, as Embree demands.
  std::vector<RTCRayHit> Make(RayKind kind, std::size_t count, uint64_t seed) const;

 private:
  class Batch;
  const TestScene& scene_;
  TraceRays trace_;
  TestScene::Corners bounds_;
};

}  // namespace dacrt::tests

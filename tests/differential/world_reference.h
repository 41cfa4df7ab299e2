// Brute force over all primitives of a world's top scene, in double precision with bounds of what
// single precision can make of it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "shape_tests.h"
#include "slab_test.h"
#include "world.h"

namespace dacrt::tests {

/// What a hit is known by.
struct HitName {
  uint32_t instance_id = RTC_INVALID_GEOMETRY_ID;
  uint32_t geometry_id = 0;
  uint32_t primitive_id = 0;

  auto operator<=>(const HitName&) const = default;
};

inline HitName NameOf(const RTCHit& hit) { return {hit.instID[0], hit.geomID, hit.primID}; }

/// A primitive, or one of the triangles of a quad or grid; with its instance, if it is in one.
struct Part {
  HitName name;
  const WorldScene* scene;
  const WorldGeometry* geometry;
  const WorldGeometry* instance;  ///< null: it stands in the top scene itself
  std::array<uint32_t, 3> vertex;
  bool is_second = false;          ///< the triangle (2, 3, 1) of a quad
  uint32_t column = 0, row = 0;    ///< of a grid's quad
  uint32_t columns = 1, rows = 1;  ///< of its grid
};

/// A hit that single precision may find.
struct PossibleHit {
  const Part* part;
  ShapeAnswer answer;
};

class WorldReference {
 public:
  /// `scenes` must outlive the reference and stay as they are.
  explicit WorldReference(const std::vector<WorldScene>& scenes);

  /// Every hit that single precision may find, masks and times considered, filter functions not.
  /// In the first form those of parts whose bounding spheres the ray's line passes at less than two
  /// radii; it has all that single precision must find. The second form is slow.
  std::vector<PossibleHit> NearHits(const RTCRay& ray) const { return Hits(ray, true, nullptr); }
  std::vector<PossibleHit> AllHits(const RTCRay& ray) const { return Hits(ray, false, nullptr); }

  /// The hits of one primitive.
  std::vector<PossibleHit> HitsOf(const RTCRay& ray, const HitName& name) const {
    return Hits(ray, false, &name);
  }

  /// Whether the ray's time is at or beyond an end of the range of something that moves.
  bool IsAtEndOfTimes(const RTCRay& ray) const;

  /// Whether the real library's slab tests, in single precision, may lose hits of a part: it does
  /// not widen its boxes where scenes are not robust. `tfar` is where the ray ends, or the nearest
  /// hit found before; `company` are rays that it may test together.
  bool SlabTestMayMiss(const RTCRay& ray, float tfar, const Part& part,
                       const Company& company) const;

 private:
  struct Sphere {
    Double3 center;
    double radius = 0;
  };
  /// Parts that share everything but vertices.
  struct Group {
    const WorldGeometry* geometry;
    const WorldGeometry* instance;
    std::size_t first, end;  ///< in parts_
    Sphere sphere;
    bool may_be_left_out;  ///< an instance whose bounds may be beyond those that Embree takes
  };
  struct Box;

  std::vector<PossibleHit> Hits(const RTCRay& ray, bool near_only, const HitName* name) const;
  bool MayBeLeftOut(const WorldGeometry& instance) const;
  void AddScene(const WorldScene& scene, const WorldGeometry* instance);
  void AddGeometry(const WorldScene& scene, const WorldGeometry& geometry,
                   const WorldGeometry* instance);
  static Sphere BoundingSphere(const Part& part);
  static bool IsNear(const ApproximateRay& ray, const Sphere& sphere);
  static void Test(const ApproximateRay& ray, const Part& part, const Moment& moment,
                   std::vector<PossibleHit>& hits);
  static Box BoxOf(const Part& part, float time);
  /// No box around points that stand in one hierarchy with these is longer.
  Box LongestBoxWith(const Part& points) const;
  Box BoxOfInstance(const WorldGeometry& instance, const ApproximateTransform& to_world) const;

  const std::vector<WorldScene>& scenes_;
  std::vector<Part> parts_;
  std::vector<Sphere> spheres_;  ///< about each part at all times, in its own space
  std::vector<Group> groups_;
  /// Something moves in times other than [0, 1]: then the real library's boxes of all that moves
  /// lose single hits, one of some five million rays.
  bool has_time_ranges_ = false;
};

}  // namespace dacrt::tests

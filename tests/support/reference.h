// What is true of a ray and a triangle, and what single precision may make of it.
//
// Embree and dacrt decide a hit by the signs of a few polynomials of the ray and the triangle
// (Moeller, Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997), computed in single
// precision. Here they are computed in double precision, each with a bound of the error that single
// precision can make in it. A polynomial further from zero than its bound has the same sign in both
// libraries; one that is nearer may have either. Nothing is ever explained by a tolerance.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "scenes.h"
#include "vec3.h"

namespace dacrt::tests {

/// Reasons why single precision may decide either way; bits of a set.
enum Doubt : uint32_t {
  kNoDoubt = 0,
  kDoubtEdge = 1,      ///< the ray passes an edge within rounding
  kDoubtInterval = 2,  ///< the hit is at tnear or tfar within rounding
  kDoubtParallel = 4,  ///< the ray is parallel to the plane within rounding, or there is no plane
  kDoubtRange = 8,     ///< a product is beyond the range of single precision
};

/// A value and how far from it single precision can be.
struct Bounded {
  double value = 0;
  double error = 0;

  bool Admits(double other) const { return other >= value - error && other <= value + error; }
};

/// Embree's reciprocals of direction components stay below this, also those of zeros.
inline constexpr double kLargestReciprocal = 1e18;
double EmbreeReciprocal(double direction);

/// Whether a packet of Embree's counts the ray as one of its own.
bool IsTraced(const RTCRay& ray);

struct TriangleAnswer {
  bool is_hit = false;         ///< by exact arithmetic, up to double rounding
  uint32_t doubts = kNoDoubt;  ///< none: single precision decides the same
  Bounded t, u, v;             ///< infinite error if the ray may be parallel
  Bounded normal[3];

  bool MayHit() const { return is_hit || doubts != kNoDoubt; }
  bool MustHit() const { return is_hit && doubts == kNoDoubt; }
};

struct Corners {
  Float3 v0, v1, v2;
};

/// The ray's interval is (tnear, tfar] as in the record. Its ends may be infinite, nothing else.
TriangleAnswer TestTriangle(const RTCRay& ray, const Corners& corners);

/// Whether single-precision slab tests may lose a hit on the triangle with these corners: whether
/// the ray misses its bounding box if each distance is off by its rounding error. `tfar` is where
/// the ray ends, or the nearest hit found before.
///
/// A box that holds the triangle's, as those of a hierarchy do, is lost only if this one may be:
/// the float distance to a plane is monotone in the plane.
///
/// `packet` are the rays, this one included, that may be tested together, by the intervals of their
/// origins and reciprocal directions: then the largest of them make the error. Alone if it is
/// empty.
bool SlabTestMayMiss(const RTCRay& ray, float tfar, const Corners& corners,
                     std::span<const RTCRayHit> packet);

struct ReferenceHit {
  uint32_t geometry_id;
  uint32_t primitive_id;
  Corners corners;
  TriangleAnswer answer;
};

/// Brute force over all triangles of a scene.
class Reference {
 public:
  /// `scene` must outlive the reference.
  explicit Reference(const TestScene& scene);

  /// A triangle that a ray with this mask can hit; null for ids that do not name one.
  const Corners* Find(uint32_t geometry_id, uint32_t primitive_id, uint32_t ray_mask) const;

  /// Every triangle that any correct single-precision computation hits; those farther than `limit`
  /// may be left out.
  std::vector<ReferenceHit> MustHits(const RTCRay& ray, double limit) const;

  /// A triangle that some correct single-precision computation hits; if there are several, rather
  /// one that exact arithmetic hits. Slow if there is none.
  std::optional<ReferenceHit> MayHit(const RTCRay& ray) const;

  /// Every triangle that some correct single-precision computation hits. Slow.
  std::vector<ReferenceHit> MayHits(const RTCRay& ray) const;

 private:
  struct Item {
    uint32_t geometry_id;
    uint32_t primitive_id;
    uint32_t mask;
    Corners corners;
  };
  struct Sphere {
    Double3 center;
    double radius;
  };

  /// What of a ray a sphere may have a part in, in the units of the scene.
  struct Line {
    Line(const RTCRay& ray, double limit);

    Double3 origin, direction;  ///< of length 1
    double near, far;
  };

  static bool IsNear(const Line& line, const Sphere& sphere, double scale);

  /// A sphere about those of `below` from `first` to before `end`.
  static Sphere Around(const std::vector<Sphere>& below, std::size_t first, std::size_t end);

  /// Calls `visit(hit)` for the triangles that may be hit among those whose bounding spheres,
  /// enlarged by `scale`, the ray meets before `limit`.
  template <typename Visit>
  void ForEachNear(const RTCRay& ray, double limit, double scale, const Visit& visit) const;

  /// The same for those in sphere number `index` of a level.
  template <typename Visit>
  void ForEachNearIn(std::size_t level, std::size_t index, const Line& line, double scale,
                     const Visit& visit) const;

  /// The triangles that rays can hit, neighbours in space near each other.
  std::vector<Item> items_;

  /// Spheres about each triangle, and then, level by level, about kGroup spheres of the level
  /// below, until one holds all.
  static constexpr std::size_t kGroup = 8;
  std::vector<std::vector<Sphere>> levels_;

  /// For each geometry, which item a triangle became; kNoItem if rays cannot hit it.
  static constexpr uint32_t kNoItem = UINT32_MAX;
  std::unordered_map<uint32_t, std::vector<uint32_t>> geometries_;
};

}  // namespace dacrt::tests

// Finding the primitives near a point.
#pragma once

#include <cstdint>

#include "dacrt/transform.h"

namespace dacrt {

/// The space of an instanced scene, as a point query sees it.
struct InstanceSpace {
  uint32_t instance_id;  ///< the instance's geometry_id
  AffineTransform to_instance;
  AffineTransform from_instance;
  float similarity_scale;  ///< SimilarityScale(to_instance)
};

/// A primitive near the point of a query.
struct PointCandidate {
  uint32_t geometry_id;
  uint32_t primitive_id;
  const InstanceSpace* instance;  ///< in which the primitive is seen; null outside of instances
  float radius;                   ///< of the query as it goes on now
  void* call;                     ///< PointQuery::call
};

/// A function of the program's that point queries call for the primitives of a geometry, and the
/// data that it is called with. None if `function` is null.
///
/// It returns the radius to go on with: the candidate's, or a smaller one. It may trace rays and
/// make point queries itself.
struct PointCallback {
  float (*function)(void* data, const PointCandidate& candidate) = nullptr;
  void* data = nullptr;

  explicit operator bool() const { return function != nullptr; }
  float operator()(const PointCandidate& candidate) const { return function(data, candidate); }
};

/// A point, and how far around it primitives are looked for.
struct PointQuery {
  float point[3];
  float radius;  ///< not negative; infinity for all primitives
  float time = 0;

  /// For programs that keep instances themselves: the way from the space of point and radius to the
  /// scene's, null if they are the same. Instances in the scene are left out then: there is one
  /// level.
  const AffineTransform* to_scene = nullptr;

  void* call = nullptr;  ///< handed on to callbacks
};

}  // namespace dacrt

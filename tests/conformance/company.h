// The rays that the real library may trace together with one: what these are decides what its
// bounding boxes may do to that one.
#pragma once

#include <cstddef>
#include <span>

#include "reference.h"
#include "streams.h"

namespace dacrt::tests {

struct Company {
  /// Those whose intervals of origins and reciprocal directions may be tested against a box in its
  /// place, itself included; none if it is alone.
  std::span<const RTCRayHit> packet;
  /// Those that it may take the order of a box's planes from.
  std::span<const RTCRayHit> guides;
  /// A hit of one of the packet has no number for its distance: then there is none that the ends of
  /// all of them are before, either, and what has not been found by then is lost.
  bool loses_its_end = false;
};

/// Of ray `i` of a call.
Company CompanyOf(const Form& form, Query query, std::span<const RTCRayHit> rays, std::size_t i);

/// The same where answers are known that the real library gave.
Company CompanyOf(const Form& form, Query query, std::span<const RTCRayHit> rays,
                  std::span<const RTCRayHit> answers, std::size_t i);

/// Whether the real library may take near planes for far ones. Where rays whose directions have the
/// same signs go together, it takes the order of the planes from others' reciprocals, and those of
/// components above -1e-18 have lost their sign.
bool PlanesMayBeSwapped(const RTCRay& ray, std::span<const RTCRayHit> guides);

}  // namespace dacrt::tests

// Affine transforms of instances, and how they move.
#pragma once

#include <cstdint>
#include <span>

#include "dacrt/export.h"

namespace dacrt {

/// Maps a point p to p.x * column[0] + p.y * column[1] + p.z * column[2] + column[3].
struct AffineTransform {
  float column[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
};

/// A transform taken apart, so that a rotation can be interpolated as one: the matrix is
/// translation * rotation * (scale, skew and shift), the last of which maps p to
///   (scale.x p.x + skew_xy p.y + skew_xz p.z + shift.x,
///                  scale.y p.y + skew_yz p.z + shift.y,
///                                  scale.z p.z + shift.z).
struct TransformParts {
  float scale[3] = {1, 1, 1};
  float skew_xy = 0, skew_xz = 0, skew_yz = 0;
  float shift[3] = {0, 0, 0};
  float quaternion[4] = {1, 0, 0, 0};  ///< r, i, j, k; need not be of length 1
  float translation[3] = {0, 0, 0};
};

/// A transform at one time step: a matrix, which is interpolated number by number, or parts, whose
/// quaternion is interpolated along the sphere. Between a matrix and parts the matrices are
/// interpolated.
struct TransformStep {
  AffineTransform matrix;
  TransformParts parts;
  bool in_parts = false;  ///< `parts` counts, else `matrix`
};

/// The times at which a moving geometry is given: its time steps lie evenly spaced from begin to
/// end. A geometry with several steps is there for rays whose time lies in this range, and for no
/// others; one with a single step always.
struct TimeRange {
  float begin = 0;
  float end = 1;
};

/// The transform at `time`. `steps` must not be empty. Outside of the range the first or last
/// segment goes on; a single step has no range.
DACRT_API AffineTransform TransformAt(std::span<const TransformStep> steps, TimeRange range,
                                      float time);

/// The inverse. A transform that is not invertible gives numbers that are not finite.
DACRT_API AffineTransform Inverse(const AffineTransform& transform);

/// The number by which a transform multiplies distances; 0 if that depends on the direction: if
/// their squares differ by more than a hundred-thousandth.
DACRT_API float SimilarityScale(const AffineTransform& transform);

}  // namespace dacrt

#include "dacrt/transform.h"

#include <algorithm>
#include <cmath>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace dacrt {
namespace {

float Interpolate(float a, float b, float fraction) {
  return std::fma(1.0f - fraction, a, fraction * b);
}

/// a * b.
AffineTransform Multiply(const AffineTransform& a, const AffineTransform& b) {
  AffineTransform out;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      float value = column == 3 ? a.column[3][row] : 0.0f;
      for (int i = 0; i < 3; ++i) value += a.column[i][row] * b.column[column][i];
      out.column[column][row] = value;
    }
  }
  return out;
}

float Dot(const float* a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/// 1 / sqrt(value) as Embree takes it: the processor's estimate, and one step of Newton's method.
float InverseSquareRoot(float value) {
#ifdef __SSE__
  const float guess = _mm_cvtss_f32(_mm_rsqrt_ss(_mm_set_ss(value)));
  return 1.5f * guess - 0.5f * value * guess * (guess * guess);
#else
  return 1 / std::sqrt(value);
#endif
}

/// `out` may be `quaternion`.
void Normalize(const float* quaternion, float* out) {
  const float scale = InverseSquareRoot(Dot(quaternion, quaternion));
  for (int i = 0; i < 4; ++i) out[i] = quaternion[i] * scale;
}

AffineTransform Compose(const TransformParts& parts) {
  AffineTransform shape;
  shape.column[0][0] = parts.scale[0];
  shape.column[1][0] = parts.skew_xy;
  shape.column[1][1] = parts.scale[1];
  shape.column[2][0] = parts.skew_xz;
  shape.column[2][1] = parts.skew_yz;
  shape.column[2][2] = parts.scale[2];
  std::copy_n(parts.shift, 3, shape.column[3]);

  float q[4];
  Normalize(parts.quaternion, q);
  const float r = q[0], i = q[1], j = q[2], k = q[3];
  AffineTransform placed;
  const float rotation[3][3] = {
      {r * r + i * i - j * j - k * k, 2 * (i * j + r * k), 2 * (i * k - r * j)},
      {2 * (i * j - r * k), r * r - i * i + j * j - k * k, 2 * (j * k + r * i)},
      {2 * (i * k + r * j), 2 * (j * k - r * i), r * r - i * i - j * j + k * k}};
  for (int column = 0; column < 3; ++column) {
    std::copy_n(rotation[column], 3, placed.column[column]);
  }
  std::copy_n(parts.translation, 3, placed.column[3]);
  return Multiply(placed, shape);
}

/// From `a` to `b`, which have length 1, along the shorter arc of the sphere: by an angle that is
/// in proportion to `fraction`. In the order of Embree's operations, since near 1 the cosine's
/// rounding shows in the angle.
void InterpolateRotation(const float* a, const float* b, float fraction, float* out) {
  float cosine = Dot(a, b);
  const float sign = cosine < 0 ? -1.0f : 1.0f;
  cosine *= sign;
  constexpr float kNearlyEqual = 0.9995f;
  if (cosine > kNearlyEqual) {
    for (int i = 0; i < 4; ++i) out[i] = (1 - fraction) * a[i] + fraction * sign * b[i];
    return;
  }
  float perpendicular[4];
  for (int i = 0; i < 4; ++i) perpendicular[i] = sign * b[i] - cosine * a[i];
  Normalize(perpendicular, perpendicular);
  const float angle = fraction * std::acos(cosine);
  for (int i = 0; i < 4; ++i) {
    out[i] = std::cos(angle) * a[i] + std::sin(angle) * perpendicular[i];
  }
}

TransformParts Interpolate(const TransformParts& a, const TransformParts& b, float fraction) {
  TransformParts out;
  for (int i = 0; i < 3; ++i) {
    out.scale[i] = Interpolate(a.scale[i], b.scale[i], fraction);
    out.shift[i] = Interpolate(a.shift[i], b.shift[i], fraction);
    out.translation[i] = Interpolate(a.translation[i], b.translation[i], fraction);
  }
  out.skew_xy = Interpolate(a.skew_xy, b.skew_xy, fraction);
  out.skew_xz = Interpolate(a.skew_xz, b.skew_xz, fraction);
  out.skew_yz = Interpolate(a.skew_yz, b.skew_yz, fraction);
  float from[4], to[4];
  Normalize(a.quaternion, from);
  Normalize(b.quaternion, to);
  InterpolateRotation(from, to, fraction, out.quaternion);
  return out;
}

}  // namespace

AffineTransform TransformAt(std::span<const TransformStep> steps, TimeRange range, float time) {
  std::size_t step = 0;
  float fraction = 0;
  if (steps.size() > 1) {
    const float segments = static_cast<float>(steps.size() - 1);
    const float place = (time - range.begin) / (range.end - range.begin) * segments;
    // Also for a place that is not a number.
    const float floor = place >= 1 ? std::min(std::floor(place), segments - 1) : 0.0f;
    step = static_cast<std::size_t>(floor);
    fraction = place - floor;
  }
  const TransformStep& a = steps[step];
  if (steps.size() == 1) return a.in_parts ? Compose(a.parts) : a.matrix;
  const TransformStep& b = steps[step + 1];
  if (a.in_parts && b.in_parts) return Compose(Interpolate(a.parts, b.parts, fraction));
  const AffineTransform from = a.in_parts ? Compose(a.parts) : a.matrix;
  const AffineTransform to = b.in_parts ? Compose(b.parts) : b.matrix;
  AffineTransform out;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      out.column[column][row] =
          Interpolate(from.column[column][row], to.column[column][row], fraction);
    }
  }
  return out;
}

AffineTransform Inverse(const AffineTransform& transform) {
  const auto& c = transform.column;
  const auto cross = [](const float* a, const float* b, float* out) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      out[i] = std::fma(a[j], b[k], -(a[k] * b[j]));
    }
  };
  const auto dot = [](const float* a, const float* b) {
    return std::fma(a[0], b[0], std::fma(a[1], b[1], a[2] * b[2]));
  };
  float row[3][3];  // of the inverse, times the determinant
  cross(c[1], c[2], row[0]);
  cross(c[2], c[0], row[1]);
  cross(c[0], c[1], row[2]);
  const float determinant = dot(c[0], row[0]);
  AffineTransform out;
  for (int i = 0; i < 3; ++i) {
    for (int column = 0; column < 3; ++column) {
      out.column[column][i] = row[i][column] / determinant;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const float inverse_row[3] = {out.column[0][i], out.column[1][i], out.column[2][i]};
    out.column[3][i] = -dot(inverse_row, c[3]);
  }
  return out;
}

float SimilarityScale(const AffineTransform& transform) {
  const auto dot = [&](int a, int b) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += double{transform.column[a][i]} * transform.column[b][i];
    return sum;
  };
  const double square = dot(0, 0);
  const double most = 1e-5 * square;
  for (int a = 0; a < 3; ++a) {
    // Negated, so that what is not a number fails as well.
    if (!(std::abs(dot(a, a) - square) <= most)) return 0;
    if (!(std::abs(dot(a, (a + 1) % 3)) <= most)) return 0;
  }
  return static_cast<float>(std::sqrt(square));
}

}  // namespace dacrt

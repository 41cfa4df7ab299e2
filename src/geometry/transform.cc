#include "dacrt/transform.h"

#include <algorithm>
#include <cmath>

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

void Normalize(const float* quaternion, float* out) {
  float square = 0;
  for (int i = 0; i < 4; ++i) square += quaternion[i] * quaternion[i];
  for (int i = 0; i < 4; ++i) out[i] = quaternion[i] / std::sqrt(square);
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

/// Along the shorter arc of the sphere.
void InterpolateRotation(const float* from, const float* to, float fraction, float* out) {
  float a[4], b[4];
  Normalize(from, a);
  Normalize(to, b);
  float cosine = 0;
  for (int i = 0; i < 4; ++i) cosine += a[i] * b[i];
  const float sign = cosine < 0 ? -1.0f : 1.0f;
  cosine = std::abs(cosine);
  float weight_a = 1 - fraction, weight_b = fraction;
  constexpr float kNearlyEqual = 0.9995f;
  if (cosine < kNearlyEqual) {
    const float angle = std::acos(cosine);
    const float sine = std::sin(angle);
    weight_a = std::sin((1 - fraction) * angle) / sine;
    weight_b = std::sin(fraction * angle) / sine;
  }
  for (int i = 0; i < 4; ++i) out[i] = weight_a * a[i] + sign * weight_b * b[i];
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
  InterpolateRotation(a.quaternion, b.quaternion, fraction, out.quaternion);
  return out;
}

}  // namespace

AffineTransform TransformAt(std::span<const TransformStep> steps, TimeRange range, float time) {
  std::size_t step = 0;
  float fraction = 0;
  if (steps.size() > 1) {
    const float segments = static_cast<float>(steps.size() - 1);
    float place = (time - range.begin) / (range.end - range.begin) * segments;
    if (!(place >= 0)) place = 0;
    place = std::min(place, segments);
    const float floor = std::min(std::floor(place), segments - 1);
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

}  // namespace dacrt

// Numbers that single precision has computed, known up to rounding.
//
// Each carries the value that exact arithmetic gives, in double precision, and a bound of how far
// from it single precision can be, whatever the order of the operations and with or without fused
// multiply-add: running error analysis (Wilkinson; Higham, "Accuracy and Stability of Numerical
// Algorithms", section 3.3).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "reference.h"

namespace dacrt::tests {

using Approximate = Bounded;
using Approximate3 = std::array<Approximate, 3>;

/// Largest relative error of one operation in single precision.
inline constexpr double kUnitRoundoff = 0x1p-24;

/// Largest absolute error of one whose result is too small for a normal float, also where such
/// results are flushed to zero.
inline constexpr double kUnderflow = 0x1p-126;

/// Embree's reciprocals are an estimate and a Newton step, good to two ulp, which is four units;
/// a quotient is one of them and a product.
inline constexpr int kQuotientOperations = 5;

/// Largest relative error of a term that went through n operations, one after the other.
constexpr double RoundingOf(int operations) {
  return operations * kUnitRoundoff / (1 - operations * kUnitRoundoff);
}

inline double Magnitude(const Approximate& a) { return std::abs(a.value) + a.error; }

/// Beyond this, single precision may have met an infinity on the way.
inline bool MayOverflow(const Approximate& a) {
  return !(Magnitude(a) <= std::numeric_limits<float>::max() / 8);
}

inline Approximate Exactly(double value) { return {value, 0}; }

inline Approximate operator-(const Approximate& a) { return {-a.value, a.error}; }

inline Approximate operator+(const Approximate& a, const Approximate& b) {
  const double value = a.value + b.value;
  // A sum with zero is not rounded; of numbers that are not normal none is.
  if (b.value == 0 && b.error == 0) return a;
  if (a.value == 0 && a.error == 0) return b;
  const double error = a.error + b.error;
  return {value, error + kUnitRoundoff * (std::abs(value) + error) + kUnderflow};
}

inline Approximate operator-(const Approximate& a, const Approximate& b) { return a + -b; }

/// The error that the factors bring into a product.
inline double InheritedError(const Approximate& a, const Approximate& b) {
  return std::abs(a.value) * b.error + std::abs(b.value) * a.error + a.error * b.error;
}

inline bool IsZero(const Approximate& a) { return a.value == 0 && a.error == 0; }

inline Approximate operator*(const Approximate& a, const Approximate& b) {
  if (IsZero(a) || IsZero(b)) return {0, 0};
  const double value = a.value * b.value, error = InheritedError(a, b);
  return {value, error + kUnitRoundoff * (std::abs(value) + error) + kUnderflow};
}

/// A sum of products, added in any order.
inline Approximate SumOfProducts(std::span<const Approximate> a, std::span<const Approximate> b) {
  Approximate sum;
  double magnitude = 0;
  int terms = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (IsZero(a[i]) || IsZero(b[i])) continue;
    ++terms;
    sum.value += a[i].value * b[i].value;
    sum.error += InheritedError(a[i], b[i]);
    magnitude += Magnitude(a[i]) * Magnitude(b[i]);
  }
  sum.error += RoundingOf(terms) * magnitude + 2 * terms * kUnderflow;
  return sum;
}

/// Not known at all if the denominator may be zero.
inline Approximate operator/(const Approximate& a, const Approximate& b) {
  const double least = std::abs(b.value) - b.error;
  if (!(least > 0)) return {0, std::numeric_limits<double>::infinity()};
  const double value = a.value / b.value;
  const double error = (a.error + std::abs(value) * b.error) / least;
  return {value, error + RoundingOf(kQuotientOperations) * (std::abs(value) + error) + kUnderflow};
}

/// Of what may be negative by rounding only.
inline Approximate SquareRoot(const Approximate& a) {
  const double value = std::sqrt(std::max(a.value, 0.0));
  const double upper = std::sqrt(std::max(a.value + a.error, 0.0));
  const double lower = std::sqrt(std::max(a.value - a.error, 0.0));
  return {value, std::max(upper - value, value - lower) + RoundingOf(3) * upper + kUnderflow};
}

inline Approximate3 operator+(const Approximate3& a, const Approximate3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Approximate3 operator-(const Approximate3& a, const Approximate3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Approximate3 operator*(const Approximate& s, const Approximate3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}

inline Approximate Dot(const Approximate3& a, const Approximate3& b) { return SumOfProducts(a, b); }

inline Approximate3 Cross(const Approximate3& a, const Approximate3& b) {
  const auto component = [&](int i, int j) {
    const Approximate left[2] = {a[i], -a[j]}, right[2] = {b[j], b[i]};
    return SumOfProducts(left, right);
  };
  return {component(1, 2), component(2, 0), component(0, 1)};
}

/// (1 - fraction) * a + fraction * b, or a + fraction * (b - a).
inline Approximate Interpolate(const Approximate& a, const Approximate& b,
                               const Approximate& fraction) {
  if (IsZero(fraction)) return a;
  const double f = fraction.value;
  const double value = a.value + f * (b.value - a.value);
  const double inherited = std::abs(1 - f) * a.error + std::abs(f) * b.error +
                           fraction.error * (Magnitude(a) + Magnitude(b));
  return {value, inherited + RoundingOf(4) * (Magnitude(a) + Magnitude(b)) + 3 * kUnderflow};
}

}  // namespace dacrt::tests

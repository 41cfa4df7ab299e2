// Points and directions of test scenes: single precision where they are given to a library, double
// where the tests compute with them.
#pragma once

#include <cmath>
#include <cstdint>

namespace dacrt::tests {

template <typename T>
struct Vec3 {
  T x = 0, y = 0, z = 0;

  template <typename U>
  explicit operator Vec3<U>() const {
    return {static_cast<U>(x), static_cast<U>(y), static_cast<U>(z)};
  }

  T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  const T& operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

using Float3 = Vec3<float>;
using Double3 = Vec3<double>;

template <typename T>
Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

template <typename T>
Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

template <typename T>
Vec3<T> operator*(T s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}

template <typename T>
T Dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename T>
Vec3<T> Cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <typename T>
T Length(const Vec3<T>& a) {
  return std::sqrt(Dot(a, a));
}

/// `a` with length one; `a` itself if it has no length.
template <typename T>
Vec3<T> Normalized(const Vec3<T>& a) {
  const T length = Length(a);
  return length > 0 ? (1 / length) * a : a;
}

template <typename T>
Vec3<T> Abs(const Vec3<T>& a) {
  return {std::abs(a.x), std::abs(a.y), std::abs(a.z)};
}

}  // namespace dacrt::tests

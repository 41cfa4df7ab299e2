// Transforms of instances, against the same in double precision.
#include "dacrt/transform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace dacrt {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TransformStep Matrix(std::mt19937& random) {
  std::uniform_real_distribution<float> number(-2, 2);
  TransformStep step;
  for (auto& column : step.matrix.column) {
    for (float& value : column) value = number(random);
  }
  return step;
}

TransformStep Rotation(double r, double i, double j, double k) {
  TransformStep step;
  step.in_parts = true;
  const double values[] = {r, i, j, k};
  std::copy(values, values + 4, step.parts.quaternion);
  return step;
}

void ExpectNear(const AffineTransform& transform, const double (&reference)[4][3],
                double tolerance) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(transform.column[column][row], reference[column][row], tolerance)
          << "column " << column << ", row " << row;
    }
  }
}

/// The rotation by a quaternion, whose length does not matter.
void ReferenceRotation(const double* quaternion, double (&out)[4][3]) {
  double length = 0;
  for (int i = 0; i < 4; ++i) length += quaternion[i] * quaternion[i];
  // Twice the products of two components.
  const auto two = [&](int a, int b) { return 2 * quaternion[a] * quaternion[b] / length; };
  const double reference[4][3] = {
      {1 - two(2, 2) - two(3, 3), two(1, 2) + two(0, 3), two(1, 3) - two(0, 2)},
      {two(1, 2) - two(0, 3), 1 - two(1, 1) - two(3, 3), two(2, 3) + two(0, 1)},
      {two(1, 3) + two(0, 2), two(2, 3) - two(0, 1), 1 - two(1, 1) - two(2, 2)},
      {0, 0, 0}};
  std::copy(&reference[0][0], &reference[0][0] + 12, &out[0][0]);
}

TEST(Transform, MatricesAreInterpolatedNumberByNumber) {
  std::mt19937 random(1);
  for (const int count : {2, 3, 5, 129}) {
    std::vector<TransformStep> steps;
    for (int i = 0; i < count; ++i) steps.push_back(Matrix(random));
    const TimeRange range{0.25f, 0.75f};
    for (int i = 0; i <= 64; ++i) {
      const float time = 0.25f + 0.5f * static_cast<float>(i) / 64;
      const double place = i / 64.0 * (count - 1);
      const int step = std::min(static_cast<int>(place), count - 2);
      const double fraction = place - step;
      double reference[4][3];
      for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
          reference[column][row] = (1 - fraction) * steps[step].matrix.column[column][row] +
                                   fraction * steps[step + 1].matrix.column[column][row];
        }
      }
      ExpectNear(TransformAt(steps, range, time), reference, 1e-4);
    }
  }
}

TEST(Transform, ASingleStepKnowsNoTime) {
  std::mt19937 random(1);
  const TransformStep step = Matrix(random);
  for (const float time : {-1.0f, 0.0f, 0.5f, 7.0f, kNan}) {
    const AffineTransform transform = TransformAt({&step, 1}, {0, 1}, time);
    EXPECT_EQ(transform.column[2][1], step.matrix.column[2][1]) << time;
  }
}

TEST(Transform, TheFirstAndTheLastSegmentGoOnOutsideOfTheRange) {
  std::vector<TransformStep> steps(3);
  const float places[] = {0, 1, 3};
  for (int i = 0; i < 3; ++i) steps[i].matrix.column[3][0] = places[i];
  const auto at = [&](float time) { return TransformAt(steps, {0, 1}, time).column[3][0]; };
  EXPECT_EQ(at(-0.5f), -1);
  EXPECT_EQ(at(0.5f), 1);
  EXPECT_EQ(at(0.75f), 2);
  EXPECT_EQ(at(1.5f), 5);
  EXPECT_TRUE(std::isnan(at(kNan)));
}

TEST(Transform, PartsAreScaledSkewedShiftedRotatedAndTranslatedInThisOrder) {
  TransformStep step = Rotation(1, 0, 0, 1);  // x to y
  step.parts = {{2, 3, 4}, 5, 6, 7, {8, 9, 10}, {1, 0, 0, 1}, {100, 200, 300}};
  const AffineTransform transform = TransformAt({&step, 1}, {}, 0);
  const double reference[4][3] = {{0, 2, 0}, {-3, 5, 0}, {-7, 6, 4}, {100 - 9, 200 + 8, 300 + 10}};
  ExpectNear(transform, reference, 1e-4);
}

TEST(Transform, RotationsTurnAtAnEvenSpeedTheShorterWay) {
  std::mt19937 random(2);
  std::normal_distribution<double> number;
  for (int i = 0; i < 2000; ++i) {
    double a[4], b[4], length_a = 0, length_b = 0;
    // From any angle to nearly none.
    const double distance = std::pow(10.0, -4.0 * (i % 50) / 50);
    for (int k = 0; k < 4; ++k) a[k] = number(random);
    for (int k = 0; k < 4; ++k) b[k] = i % 2 ? number(random) : a[k] + distance * number(random);
    for (int k = 0; k < 4; ++k) {
      length_a += a[k] * a[k];
      length_b += b[k] * b[k];
    }
    const double side = i % 3 == 0 ? -1 : 1;
    const std::vector<TransformStep> steps = {
        Rotation(a[0], a[1], a[2], a[3]),
        Rotation(side * b[0], side * b[1], side * b[2], side * b[3])};
    double cosine = 0;
    for (int k = 0; k < 4; ++k) {
      a[k] /= std::sqrt(length_a);
      b[k] /= std::sqrt(length_b);
      cosine += a[k] * b[k];
    }
    const double angle = std::acos(std::min(std::abs(cosine), 1.0));
    for (const float time : {0.0f, 0.25f, 0.5f, 0.875f, 1.0f}) {
      double between[4], reference[4][3];
      for (int k = 0; k < 4; ++k) {
        between[k] = angle < 1e-6 ? a[k]
                                  : (std::sin((1 - time) * angle) * a[k] +
                                     std::copysign(std::sin(time * angle), cosine) * b[k]) /
                                        std::sin(angle);
      }
      ReferenceRotation(between, reference);
      // What the last bit of the cosine is worth.
      ExpectNear(TransformAt(steps, {0, 1}, time), reference, 2e-5);
    }
  }
}

TEST(Transform, BetweenAMatrixAndPartsTheMatricesAreInterpolated) {
  const std::vector<TransformStep> steps = {Rotation(1, 0, 0, 1), {}};
  const double reference[4][3] = {{0.5, 0.5, 0}, {-0.5, 0.5, 0}, {0, 0, 1}, {0, 0, 0}};
  ExpectNear(TransformAt(steps, {0, 1}, 0.5f), reference, 1e-6);
}

TEST(Transform, NoQuaternionIsNoRotation) {
  const TransformStep step = Rotation(0, 0, 0, 0);
  EXPECT_TRUE(std::isnan(TransformAt({&step, 1}, {}, 0).column[0][0]));
}

TEST(Transform, TheInverseLeadsBack) {
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    AffineTransform transform = Matrix(random).matrix;
    for (int axis = 0; axis < 3; ++axis) transform.column[axis][axis] += 8;  // far from singular
    const AffineTransform inverse = Inverse(transform);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row) {
        double value = column == 3 ? inverse.column[3][row] : 0;
        for (int k = 0; k < 3; ++k) {
          value += double{inverse.column[k][row]} * transform.column[column][k];
        }
        EXPECT_NEAR(value, column == row, 1e-6);
      }
    }
  }
}

TEST(Transform, WhatIsFlatHasNoWayBack) {
  AffineTransform flat;
  flat.column[2][2] = 0;
  EXPECT_FALSE(std::isfinite(Inverse(flat).column[2][2]));
}

}  // namespace
}  // namespace dacrt

#include "wave.h"

#include <cmath>
#include <numbers>

#include "bench_scene.h"

namespace dacrt::bench {
namespace {

// Shares of the diagonal: enough that every box changes, and that the view stays what it is.
constexpr float kHeight = 0.005f;
constexpr float kLength = 0.25f;

}  // namespace

Wave::Wave(const scenes::Mesh& rest) : rest_(rest) {
  const float diagonal = Bounds(rest).size().length();
  height_ = kHeight * diagonal;
  length_ = kLength * diagonal;
}

void Wave::Apply(float turns, std::size_t first, std::span<float> positions) const {
  constexpr float kTurn = 2 * std::numbers::pi_v<float>;
  for (std::size_t i = 0; i + 3 <= positions.size(); i += 3) {
    const float* const from = &rest_.positions[3 * first + i];
    positions[i] = from[0];
    positions[i + 1] = from[1] + height_ * std::sin(kTurn * (from[0] / length_ + turns));
    positions[i + 2] = from[2];
  }
}

}  // namespace dacrt::bench

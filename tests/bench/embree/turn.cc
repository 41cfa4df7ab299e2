#include "turn.h"

#include <cmath>
#include <numbers>

namespace dacrt::bench {

Transform TurnAbout(const Imath::V3f& middle, float degrees) {
  const float angle = degrees * std::numbers::pi_v<float> / 180;
  const float c = std::cos(angle), s = std::sin(angle);
  const float x = middle.x - c * middle.x - s * middle.z;
  const float z = middle.z + s * middle.x - c * middle.z;
  return {c, 0, -s, 0, 1, 0, s, 0, c, x, 0, z};
}

}  // namespace dacrt::bench

#include "asked_bounds.h"

#include <cstddef>
#include <utility>

namespace dacrt::compat {

void AskedBounds::Ask(const dacrt::Geometry& geometry) {
  const BoundsCallback& function = geometry.bounds;
  if (!function.function) return;
  Answers answers{geometry.user_time_steps, {}};
  answers.bounds.reserve(geometry.primitive_count * answers.time_steps);
  for (std::size_t primitive = 0; primitive < geometry.primitive_count; ++primitive) {
    for (uint32_t step = 0; step < answers.time_steps; ++step) {
      function.function(function.data, static_cast<uint32_t>(primitive), step,
                        answers.bounds.emplace_back());
    }
  }
  answers_.insert_or_assign(function.data, std::move(answers));
}

void AskedBounds::Answer(dacrt::Geometry& geometry) {
  const auto asked = answers_.find(geometry.bounds.data);
  if (asked == answers_.end()) return;
  Answers& answers = asked->second;
  if (answers.time_steps != geometry.user_time_steps ||
      answers.bounds.size() != geometry.primitive_count * answers.time_steps) {
    return;
  }
  geometry.bounds = {&Read, &answers};
}

void AskedBounds::Read(void* answers, uint32_t primitive, uint32_t time_step, Bounds& bounds) {
  const auto& known = *static_cast<const Answers*>(answers);
  bounds = known.bounds[std::size_t{primitive} * known.time_steps + time_step];
}

}  // namespace dacrt::compat

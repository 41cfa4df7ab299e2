#include "feature_set.h"

#include <stdexcept>
#include <string>

namespace dacrt::tests {
namespace {

unsigned Find(std::string_view name) {
  for (unsigned i = 0; i < kFeatureCount; ++i) {
    if (name == Name(static_cast<Feature>(i))) return i;
  }
  throw std::invalid_argument("there is no feature " + std::string(name));
}

}  // namespace

const char* Name(Feature feature) {
  constexpr const char* kNames[kFeatureCount] = {
      "triangles", "quads",     "grids",  "spheres",     "discs",   "oriented_discs",
      "user",      "instances", "motion", "quaternions", "filters", "context_filters",
      "masks",     "layouts",   "robust", "flags",       "changes", "configs",
      "hostile",   "scales"};
  return kNames[static_cast<unsigned>(feature)];
}

Features ParseFeatures(std::string_view list) {
  Features features;
  if (list.empty() || list.front() == '-') features.set();
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    std::string_view name = list.substr(0, comma);
    const bool is_taken_away = name.starts_with('-');
    if (is_taken_away) name.remove_prefix(1);
    features[Find(name)] = !is_taken_away;
    list = comma == std::string_view::npos ? "" : list.substr(comma + 1);
  }
  return features;
}

}  // namespace dacrt::tests

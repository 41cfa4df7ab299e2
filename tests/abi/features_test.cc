// Device properties, embree-config.cmake and the README say the same of the drop-in's features.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

struct Feature {
  bool is_there;
  std::string property;  ///< "-" for none
  std::string variable;  ///< "-" for none
};

std::string Contents(const char* path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<Feature> ListedFeatures() {
  std::vector<Feature> features;
  std::istringstream list(Contents(DACRT_FEATURE_LIST));
  for (std::string line; std::getline(list, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    Feature feature;
    words >> feature.is_there >> feature.property >> feature.variable;
    EXPECT_TRUE(words) << line;
    features.push_back(feature);
  }
  return features;
}

/// The variables that an embree-config.cmake sets, and to what.
std::map<std::string, std::string> VariablesSet(const char* path) {
  std::map<std::string, std::string> variables;
  const std::string text = Contents(path);
  const std::regex statement(R"(\b(?:set|SET)\((EMBREE_\w+) +([^ )]+))");
  for (std::sregex_iterator i(text.begin(), text.end(), statement), end; i != end; ++i) {
    variables[(*i)[1]] = (*i)[2];
  }
  return variables;
}

/// The row of the README's table of features that begins with `state`.
std::string ReadmeRow(const std::string& state) {
  const std::string readme = Contents(DACRT_README);
  const std::size_t row = readme.find("\n| " + state + " | `RTC_DEVICE_PROPERTY_");
  EXPECT_NE(row, std::string::npos) << state;
  return row == std::string::npos ? "" : readme.substr(row, readme.find('\n', row + 1) - row);
}

/// The properties of Embree's header, but for the version.
const std::vector<std::pair<std::string, RTCDeviceProperty>> kProperties = {
#define PROPERTY(name) \
  { #name, RTC_DEVICE_PROPERTY_##name }
    PROPERTY(NATIVE_RAY4_SUPPORTED),
    PROPERTY(NATIVE_RAY8_SUPPORTED),
    PROPERTY(NATIVE_RAY16_SUPPORTED),
    PROPERTY(RAY_STREAM_SUPPORTED),
    PROPERTY(BACKFACE_CULLING_CURVES_ENABLED),
    PROPERTY(RAY_MASK_SUPPORTED),
    PROPERTY(BACKFACE_CULLING_ENABLED),
    PROPERTY(FILTER_FUNCTION_SUPPORTED),
    PROPERTY(IGNORE_INVALID_RAYS_ENABLED),
    PROPERTY(COMPACT_POLYS_ENABLED),
    PROPERTY(TRIANGLE_GEOMETRY_SUPPORTED),
    PROPERTY(QUAD_GEOMETRY_SUPPORTED),
    PROPERTY(SUBDIVISION_GEOMETRY_SUPPORTED),
    PROPERTY(CURVE_GEOMETRY_SUPPORTED),
    PROPERTY(USER_GEOMETRY_SUPPORTED),
    PROPERTY(POINT_GEOMETRY_SUPPORTED),
    PROPERTY(TASKING_SYSTEM),
    PROPERTY(JOIN_COMMIT_SUPPORTED),
    PROPERTY(PARALLEL_COMMIT_SUPPORTED),
#undef PROPERTY
};

TEST(Features, DevicePropertiesAreTheListed) {
  Session s(DropIn());
  std::map<std::string, bool> listed;
  for (const Feature& feature : ListedFeatures()) listed[feature.property] = feature.is_there;
  for (const auto& [name, property] : kProperties) {
    ASSERT_TRUE(listed.contains(name)) << name;
    EXPECT_EQ(s.api.rtcGetDeviceProperty(s.device, property), listed[name]) << name;
  }
  EXPECT_EQ(listed.size(), kProperties.size() + 1);  // "-"
}

// Filter functions, quads, points and user geometries were announced as missing.
TEST(Features, CMakePackageSaysTheListed) {
  const std::map<std::string, std::string> set = VariablesSet(DACRT_CMAKE_CONFIG);
  for (const Feature& feature : ListedFeatures()) {
    if (feature.variable == "-") continue;
    ASSERT_TRUE(set.contains(feature.variable)) << feature.variable;
    EXPECT_EQ(set.at(feature.variable), feature.is_there ? "ON" : "OFF") << feature.variable;
  }
}

TEST(Features, CMakePackageSetsWhatTheRealOneSets) {
  const std::map<std::string, std::string> set = VariablesSet(DACRT_CMAKE_CONFIG);
  // Of a build that dacrt does not have, and of the width of curves.
  const std::set<std::string> others = {"EMBREE_BUILD_TYPE", "EMBREE_ISA_NEON",
                                        "EMBREE_CURVE_SELF_INTERSECTION_AVOIDANCE_FACTOR"};
  for (const auto& [name, value] : VariablesSet(DACRT_REAL_CMAKE_CONFIG)) {
    EXPECT_TRUE(set.contains(name) || others.contains(name)) << name;
  }
}

TEST(Features, ReadmeSaysTheListed) {
  const std::string present = ReadmeRow("yes"), missing = ReadmeRow("no");
  for (const Feature& feature : ListedFeatures()) {
    for (std::string name : {"RTC_DEVICE_PROPERTY_" + feature.property, feature.variable}) {
      if (name.ends_with("-")) continue;
      name = "`" + name + "`";
      EXPECT_EQ(present.find(name) != std::string::npos, feature.is_there) << name;
      EXPECT_EQ(missing.find(name) != std::string::npos, !feature.is_there) << name;
    }
  }
}

}  // namespace
}  // namespace dacrt::tests

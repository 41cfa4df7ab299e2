#include "dacrt/settings.h"

#include <charconv>
#include <stdexcept>

namespace dacrt {
namespace {

struct NumberSetting {
  std::string_view name;
  uint32_t Settings::* member;
  uint32_t least;
  uint32_t most;
};

constexpr NumberSetting kNumbers[] = {
    {"bins", &Settings::bins, 2, 32},
    {"sample_rays", &Settings::sample_rays, 1, 1024},
    {"sample_threshold", &Settings::sample_threshold, 1, UINT32_MAX},
    {"leaf_triangles", &Settings::leaf_triangles, 1, 64},
    {"leaf_rays", &Settings::leaf_rays, 1, 1024},
    {"piece_rays", &Settings::piece_rays, 64, 1u << 30},
};

constexpr std::string_view kInstructionSetName = "instruction_set";

struct InstructionSetName {
  std::string_view name;
  InstructionSet instruction_set;
};

constexpr InstructionSetName kInstructionSets[] = {
    {"scalar", InstructionSet::kScalar}, {"ssse3", InstructionSet::kSsse3},
    {"sse4", InstructionSet::kSse4},     {"avx2", InstructionSet::kAvx2},
    {"avx512", InstructionSet::kAvx512}, {"best", InstructionSet::kBest},
};

[[noreturn]] void Refuse(std::string_view name, std::string_view value, const std::string& legal) {
  throw std::invalid_argument("setting " + std::string(name) + ": \"" + std::string(value) +
                              "\" is not legal; " + legal);
}

std::string Range(const NumberSetting& number) {
  return "it takes a whole number from " + std::to_string(number.least) + " to " +
         std::to_string(number.most);
}

void CheckRange(const NumberSetting& number, uint32_t value, std::string_view text) {
  if (value < number.least || value > number.most) Refuse(number.name, text, Range(number));
}

}  // namespace

std::string_view Name(InstructionSet instruction_set) {
  for (const auto& entry : kInstructionSets) {
    if (entry.instruction_set == instruction_set) return entry.name;
  }
  return "unknown";
}

void SetByName(Settings& settings, std::string_view name, std::string_view value) {
  for (const NumberSetting& number : kNumbers) {
    if (number.name != name) continue;
    uint32_t parsed = 0;
    const char* end = value.data() + value.size();
    const auto result = std::from_chars(value.data(), end, parsed);
    if (result.ec != std::errc() || result.ptr != end) Refuse(name, value, Range(number));
    CheckRange(number, parsed, value);
    settings.*number.member = parsed;
    return;
  }
  std::string legal = "it takes one of";
  for (const auto& entry : kInstructionSets) {
    if (name == kInstructionSetName && entry.name == value) {
      settings.instruction_set = entry.instruction_set;
      return;
    }
    legal += " " + std::string(entry.name);
  }
  if (name == kInstructionSetName) Refuse(name, value, legal);

  std::string names = std::string(kInstructionSetName);
  for (const NumberSetting& number : kNumbers) names += " " + std::string(number.name);
  throw std::invalid_argument("there is no setting \"" + std::string(name) +
                              "\"; the settings are " + names);
}

void Validate(const Settings& settings) {
  for (const NumberSetting& number : kNumbers) {
    const uint32_t value = settings.*number.member;
    CheckRange(number, value, std::to_string(value));
  }
  if (Name(settings.instruction_set) == "unknown") {
    throw std::invalid_argument("setting instruction_set is not one of the enumeration's values");
  }
}

}  // namespace dacrt

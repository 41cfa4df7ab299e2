#include "dacrt/settings.h"

#include <charconv>

#include "dacrt/error.h"

namespace dacrt {
namespace {

struct NumberSetting {
  std::string_view name;
  uint32_t Settings::*member;
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
    {"threads", &Settings::threads, 0, 1024},
};

struct SwitchSetting {
  std::string_view name;
  bool Settings::*member;
};

constexpr SwitchSetting kSwitches[] = {
    {"sampled_cost", &Settings::sampled_cost},
    {"sampled_order", &Settings::sampled_order},
    {"skip_filtering", &Settings::skip_filtering},
};

template <class Enum>
struct ChoiceName {
  std::string_view name;
  Enum value;
};

constexpr ChoiceName<InstructionSet> kInstructionSets[] = {
    {"scalar", InstructionSet::kScalar}, {"neon", InstructionSet::kNeon},
    {"sse4", InstructionSet::kSse4},     {"avx2", InstructionSet::kAvx2},
    {"avx512", InstructionSet::kAvx512}, {"best", InstructionSet::kBest},
};

constexpr ChoiceName<Algorithm> kAlgorithms[] = {
    {"nabata2013", Algorithm::kNabata2013},
    {"afra2012", Algorithm::kAfra2012},
    {"mora2011", Algorithm::kMora2011},
};

std::string Quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

[[noreturn]] void Refuse(std::string_view name, std::string_view value, const std::string& legal) {
  throw Error(Error::Kind::kArgument, "Settings", std::string(name), Quoted(value), legal);
}

std::string Range(const NumberSetting& number) {
  return "it takes a whole number from " + std::to_string(number.least) + " to " +
         std::to_string(number.most);
}

void CheckRange(const NumberSetting& number, uint32_t value, std::string_view text) {
  if (value < number.least || value > number.most) Refuse(number.name, text, Range(number));
}

template <class Enum, std::size_t kCount>
std::string_view NameIn(const ChoiceName<Enum> (&choices)[kCount], Enum value) {
  for (const auto& choice : choices) {
    if (choice.value == value) return choice.name;
  }
  return {};
}

template <class Enum, std::size_t kCount>
Enum ParseChoice(const ChoiceName<Enum> (&choices)[kCount], std::string_view name,
                 std::string_view value) {
  std::string legal = "it takes one of";
  for (const auto& choice : choices) {
    if (choice.name == value) return choice.value;
    legal.append(" ").append(choice.name);
  }
  Refuse(name, value, legal);
}

uint32_t ParseNumber(const NumberSetting& number, std::string_view value) {
  uint32_t parsed = 0;
  const char* end = value.data() + value.size();
  const auto result = std::from_chars(value.data(), end, parsed);
  if (result.ec != std::errc() || result.ptr != end) Refuse(number.name, value, Range(number));
  CheckRange(number, parsed, value);
  return parsed;
}

uint64_t ParseBudget(std::string_view value) {
  if (value == "default") return kDefaultBudget;
  if (value == "unlimited") return kUnlimitedBudget;
  uint64_t parsed = 0;
  const char* end = value.data() + value.size();
  const auto result = std::from_chars(value.data(), end, parsed);
  if (result.ec != std::errc() || result.ptr != end) {
    Refuse("budget", value, "it takes a number of bytes, default, or unlimited");
  }
  return parsed;
}

bool ParseSwitch(std::string_view name, std::string_view value) {
  if (value != "0" && value != "1") Refuse(name, value, "it takes 0 or 1");
  return value == "1";
}

}  // namespace

std::string_view Name(InstructionSet instruction_set) {
  return NameIn(kInstructionSets, instruction_set);
}

std::string_view Name(Algorithm algorithm) { return NameIn(kAlgorithms, algorithm); }

void SetByName(Settings& settings, std::string_view name, std::string_view value) {
  std::string names = "algorithm instruction_set budget";
  if (name == "algorithm") {
    settings.algorithm = ParseChoice(kAlgorithms, name, value);
    return;
  }
  if (name == "instruction_set") {
    settings.instruction_set = ParseChoice(kInstructionSets, name, value);
    return;
  }
  if (name == "budget") {
    settings.budget = ParseBudget(value);
    return;
  }
  for (const SwitchSetting& entry : kSwitches) {
    if (entry.name == name) {
      settings.*entry.member = ParseSwitch(name, value);
      return;
    }
    names.append(" ").append(entry.name);
  }
  for (const NumberSetting& entry : kNumbers) {
    if (entry.name == name) {
      settings.*entry.member = ParseNumber(entry, value);
      return;
    }
    names.append(" ").append(entry.name);
  }
  throw Error(Error::Kind::kArgument, "Settings", "name", Quoted(name),
              "there is no such setting; the settings are " + names);
}

void Validate(const Settings& settings) {
  for (const NumberSetting& number : kNumbers) {
    const uint32_t value = settings.*number.member;
    CheckRange(number, value, std::to_string(value));
  }
  // A value outside its enumeration has no name; ParseChoice then says what is legal.
  const auto check = [](const auto& choices, std::string_view name, auto value) {
    if (NameIn(choices, value).empty()) {
      ParseChoice(choices, name, std::to_string(static_cast<int>(value)));
    }
  };
  check(kInstructionSets, "instruction_set", settings.instruction_set);
  check(kAlgorithms, "algorithm", settings.algorithm);
}

}  // namespace dacrt

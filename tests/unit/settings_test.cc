#include "dacrt/settings.h"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dacrt/dacrt.h"

namespace dacrt {
namespace {

using testing::AssertionResult;

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

AssertionResult Contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << '"' << text << "\" does not contain \"" << part << '"';
}

struct Number {
  std::string name;
  uint32_t Settings::*member;
  uint32_t least;
  uint32_t most;
};

const std::vector<Number> kNumbers = {
    {"bins", &Settings::bins, 2, 32},
    {"sample_rays", &Settings::sample_rays, 1, 1024},
    {"sample_threshold", &Settings::sample_threshold, 1, UINT32_MAX},
    {"leaf_triangles", &Settings::leaf_triangles, 1, 64},
    {"leaf_rays", &Settings::leaf_rays, 1, 1024},
    {"piece_rays", &Settings::piece_rays, 64, 1u << 30},
    {"threads", &Settings::threads, 0, 1024},
};

TEST(SettingsTest, DefaultsAreLegal) { EXPECT_NO_THROW(Validate(Settings())); }

TEST(SettingsTest, NumbersTakeBothEndsOfTheirRange) {
  for (const Number& number : kNumbers) {
    for (const uint32_t value : {number.least, number.most}) {
      Settings settings;
      SetByName(settings, number.name, std::to_string(value));
      EXPECT_EQ(settings.*number.member, value);
      EXPECT_NO_THROW(Validate(settings));
    }
  }
}

TEST(SettingsTest, WhatIsNoNumberOfTheRangeIsRefusedByNameValueAndRange) {
  for (const Number& number : kNumbers) {
    std::vector<std::string> bad = {"",   " ",   "-1", "+8",  " 8",         "8 ",
                                    "8x", "0x8", "8.", "1e3", "4294967296", "99999999999999999999"};
    if (number.least > 0) bad.push_back(std::to_string(number.least - 1));
    if (number.most != UINT32_MAX) bad.push_back(std::to_string(number.most + 1));
    for (const std::string& value : bad) {
      Settings settings;
      const std::string message = MessageOf([&] { SetByName(settings, number.name, value); });
      EXPECT_TRUE(Contains(message, number.name));
      EXPECT_TRUE(Contains(message, '"' + value + '"'));
      EXPECT_TRUE(Contains(message, std::to_string(number.least)));
      EXPECT_TRUE(Contains(message, std::to_string(number.most)));
      EXPECT_EQ(settings.*number.member, Settings().*number.member) << "changed by " << value;
    }
  }
}

TEST(SettingsTest, ValidateNamesMemberValueAndRange) {
  for (const Number& number : kNumbers) {
    std::vector<uint32_t> bad;
    if (number.least > 0) bad.push_back(number.least - 1);
    if (number.most != UINT32_MAX) bad.push_back(number.most + 1);
    for (const uint32_t value : bad) {
      Settings settings;
      settings.*number.member = value;
      const std::string message = MessageOf([&] { Validate(settings); });
      EXPECT_TRUE(Contains(message, number.name));
      EXPECT_TRUE(Contains(message, '"' + std::to_string(value) + '"'));
      EXPECT_TRUE(Contains(message, std::to_string(number.most)));
      EXPECT_EQ(MessageOf([&] { const Device device(settings); }), message);
    }
  }
}

TEST(SettingsTest, ValidateRefusesNumbersThatAreNoEnumerator) {
  Settings settings;
  settings.instruction_set = static_cast<InstructionSet>(99);
  EXPECT_TRUE(Contains(MessageOf([&] { Validate(settings); }), "instruction_set"));
  settings = {};
  settings.algorithm = static_cast<Algorithm>(99);
  EXPECT_TRUE(Contains(MessageOf([&] { Validate(settings); }), "algorithm"));
}

TEST(SettingsTest, TheBudgetIsANumberOfBytesOrAName) {
  const std::vector<std::pair<std::string, uint64_t>> legal = {{"0", 0},
                                                               {"123", 123},
                                                               {"8000000000", 8000000000},
                                                               {"default", kDefaultBudget},
                                                               {"unlimited", kUnlimitedBudget}};
  for (const auto& [value, budget] : legal) {
    Settings settings;
    settings.budget = 77;
    SetByName(settings, "budget", value);
    EXPECT_EQ(settings.budget, budget) << value;
    EXPECT_NO_THROW(Validate(settings));
  }
  for (const std::string value : {"", " ", "-1", "+8", " 8", "8 ", "1e3", "0x8", "8.5", "4k",
                                  "Default", "unlimited ", "99999999999999999999999"}) {
    Settings settings;
    const std::string message = MessageOf([&] { SetByName(settings, "budget", value); });
    for (const std::string& part :
         {std::string("budget"), '"' + value + '"', std::string("number of bytes"),
          std::string("default"), std::string("unlimited")}) {
      EXPECT_TRUE(Contains(message, part));
    }
    EXPECT_EQ(settings.budget, kDefaultBudget) << "changed by " << value;
  }
}

TEST(SettingsTest, SwitchesTakeZeroAndOne) {
  const std::vector<std::pair<std::string, bool Settings::*>> switches = {
      {"sampled_cost", &Settings::sampled_cost},
      {"sampled_order", &Settings::sampled_order},
      {"skip_filtering", &Settings::skip_filtering}};
  for (const auto& [name, member] : switches) {
    Settings settings;
    SetByName(settings, name, "0");
    EXPECT_FALSE(settings.*member);
    SetByName(settings, name, "1");
    EXPECT_TRUE(settings.*member);
    for (const std::string value : {"", "2", "true", "01", " 1"}) {
      const std::string message =
          MessageOf([&, &name = name] { SetByName(settings, name, value); });
      EXPECT_TRUE(Contains(message, name));
      EXPECT_TRUE(Contains(message, '"' + value + '"'));
      EXPECT_TRUE(Contains(message, "0 or 1"));
      EXPECT_TRUE(settings.*member);
    }
  }
}

TEST(SettingsTest, NamesGoBothWays) {
  for (const auto value : {InstructionSet::kScalar, InstructionSet::kNeon, InstructionSet::kSse4,
                           InstructionSet::kAvx2, InstructionSet::kAvx512, InstructionSet::kBest}) {
    Settings settings;
    SetByName(settings, "instruction_set", Name(value));
    EXPECT_EQ(settings.instruction_set, value);
  }
  for (const auto value : {Algorithm::kNabata2013, Algorithm::kAfra2012, Algorithm::kMora2011}) {
    Settings settings;
    SetByName(settings, "algorithm", Name(value));
    EXPECT_EQ(settings.algorithm, value);
  }
}

TEST(SettingsTest, UnknownNamesOfChoicesAreRefusedWithTheLegalOnes) {
  Settings settings;
  std::string message = MessageOf([&] { SetByName(settings, "instruction_set", "avx9000"); });
  for (const char* part :
       {"instruction_set", "\"avx9000\"", "scalar", "sse4", "avx2", "avx512", "best"}) {
    EXPECT_TRUE(Contains(message, part));
  }
  message = MessageOf([&] { SetByName(settings, "algorithm", "Nabata2013"); });
  for (const char* part : {"algorithm", "\"Nabata2013\"", "nabata2013", "afra2012", "mora2011"}) {
    EXPECT_TRUE(Contains(message, part));
  }
}

TEST(SettingsTest, UnknownSettingsAreRefusedWithTheKnownOnes) {
  for (const std::string name : {"", "bin", "bins ", "Bins", "thread"}) {
    Settings settings;
    const std::string message = MessageOf([&] { SetByName(settings, name, "8"); });
    EXPECT_TRUE(Contains(message, '"' + name + '"'));
    for (const Number& number : kNumbers) EXPECT_TRUE(Contains(message, number.name));
    for (const char* part : {"algorithm", "instruction_set", "sampled_cost", "sampled_order",
                             "skip_filtering", "budget"}) {
      EXPECT_TRUE(Contains(message, part));
    }
  }
}

TEST(SettingsTest, InstructionSetsAreSortedAndTheDeviceTakesTheLimit) {
  const std::vector<InstructionSet> available = AvailableInstructionSets();
  ASSERT_FALSE(available.empty());
  for (std::size_t i = 0; i < available.size(); ++i) {
    EXPECT_NE(available[i], InstructionSet::kBest);
    EXPECT_TRUE(ProcessorHas(available[i]));
    if (i > 0) {
      EXPECT_LT(available[i - 1], available[i]);
    }
    Settings settings;
    settings.instruction_set = available[i];
    EXPECT_EQ(Device(settings).instruction_set(), available[i]);
  }
  EXPECT_EQ(Device().instruction_set(), available.back());
}

}  // namespace
}  // namespace dacrt

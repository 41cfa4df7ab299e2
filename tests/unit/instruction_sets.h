// Tests of what chooses its instruction set at run time, on each that the machine has.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "dacrt/dacrt.h"

namespace dacrt::unit {

class OnEachInstructionSet : public testing::TestWithParam<InstructionSet> {
 protected:
  Settings WithInstructionSet(Settings settings = {}) const {
    settings.instruction_set = GetParam();
    return settings;
  }
};

#define INSTANTIATE_ON_EACH_INSTRUCTION_SET(suite)                                                \
  INSTANTIATE_TEST_SUITE_P(InstructionSets, suite, testing::ValuesIn(AvailableInstructionSets()), \
                           [](const auto& info) { return std::string(Name(info.param)); })

}  // namespace dacrt::unit

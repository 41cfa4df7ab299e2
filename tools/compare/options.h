// The command line of dacrt-compare.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dacrt::compare {

struct Options {
  std::string embree, drop_in;  ///< the libraries
  std::string config;           ///< DACRT_CONFIG for dacrt
  std::string json;             ///< file for all figures; empty: none
  int repeat = 3;

  // Of meshes.
  int threads;
  std::string isa;
  std::vector<std::string> kinds, sizes;

  std::string mesh;                  ///< empty for a program
  std::vector<std::string> command;  ///< the program and its arguments
};

/// Nothing if only help was asked for, which has then been printed. Throws bench::UsageError, and
/// ProgramError if there is neither a mesh nor a program of that name. Throws bench::OutputError.
std::optional<Options> ParseOptions(int argc, char** argv);

}  // namespace dacrt::compare

// What the command lines of benchmarks share that go through a matrix of cells.
#pragma once

#include <string>
#include <vector>

#include "command_line.h"
#include "outputs.h"

namespace dacrt::bench {

struct MatrixOptions {
  std::string folder = DACRT_SCENES_DIR;  ///< of the PLY scenes
  bool is_full = false;
  std::vector<std::string> scenes;
  std::vector<int> threads = OneAndAllThreads();
  int repeat = 3;
  Outputs outputs;
};

/// --full, --scene, --scenes-dir, --threads, --repeat, --json, --markdown, --resume. `repeated`
/// says what is repeated.
void AddMatrixOptions(CLI::App& app, MatrixOptions& options, const std::string& repeated);

/// If the options have named something, that in all combinations, with the rest as in the first
/// block; else the blocks as they are. `lists` are the members that can be named; threads go with
/// them.
template <class Block, class... Lists>
std::vector<Block> NamedOr(const std::vector<Block>& blocks, const Block& named, Lists... lists) {
  Block all = blocks.front();
  all.threads = named.threads;
  bool is_named = false;
  const auto take = [&](auto list) {
    if ((named.*list).empty()) return;
    all.*list = named.*list;
    is_named = true;
  };
  (take(lists), ...);
  return is_named ? std::vector{all} : blocks;
}

}  // namespace dacrt::bench

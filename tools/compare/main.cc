// dacrt-compare: whether to switch from Embree to dacrt, on one's own mesh or program: see --help.
#include <cstdio>
#include <cstring>

#include "errors.h"
#include "exit_codes.h"
#include "libraries.h"
#include "memory_child.h"
#include "mesh_comparison.h"
#include "options.h"
#include "program_comparison.h"

namespace dacrt::compare {
namespace {

/// How it starts itself to measure the memory of one library.
bool IsMemoryChild(int argc, char** argv) {
  return argc == 5 && std::strcmp(argv[1], "--memory-child") == 0;
}

int Main(int argc, char** argv) {
  if (IsMemoryChild(argc, argv)) {
    bench::AnswerMemory(argv[2], argv[3], argv[4]);
    return bench::kSuccess;
  }
  std::optional<Options> options = ParseOptions(argc, argv);
  if (!options) return bench::kSuccess;
  if (options->mesh.empty()) return CompareProgram(*options);
  if (options->embree.empty()) options->embree = FindEmbree(options->drop_in);
  return CompareMesh(*options);
}

}  // namespace
}  // namespace dacrt::compare

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("dacrt-compare", [=] {
    try {
      return dacrt::compare::Main(argc, argv);
    } catch (const dacrt::compare::ProgramError& error) {
      std::fprintf(stderr, "dacrt-compare: %s\n", error.what());
      return dacrt::compare::kProgramFailed;
    }
  });
}

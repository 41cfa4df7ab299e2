// The child process of embree_bench that measures the memory of one library: embree_memory LIBRARY
// CONFIG GEOMETRY, with the mesh and the rays on the standard input. Not for use by hand.
#include "errors.h"
#include "memory_child.h"

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("embree_memory", [=]() -> int {
    if (argc != 4) throw dacrt::bench::UsageError("it is started by embree_bench");
    dacrt::bench::AnswerMemory(argv[1], argv[2], argv[3]);
    return dacrt::bench::kSuccess;
  });
}

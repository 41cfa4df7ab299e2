// What dacrt-run makes of all ranks but the one that runs the program.
#include <mpi.h>

#include <cstdio>
#include <exception>

#include "dacrt/mpi.h"

int main() {
  using dacrt::mpi::Ending;
  int level;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
  try {
    if (dacrt::mpi::Serve(MPI_COMM_WORLD) == Ending::kFinalise) MPI_Finalize();
    return 0;
  } catch (const std::exception& error) {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    std::fprintf(stderr, "dacrt-worker: rank %d: %s\n", rank, error.what());
    return 1;
  }
}

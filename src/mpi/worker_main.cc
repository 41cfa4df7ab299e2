// What dacrt-run makes of all ranks but the one that runs the program.
#include <mpi.h>

#include <cstdio>
#include <exception>

#include "dacrt/mpi.h"

int main() {
  int level;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
  int code = 0;
  try {
    dacrt::mpi::Serve(MPI_COMM_WORLD);
  } catch (const std::exception& error) {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    std::fprintf(stderr, "dacrt-worker: rank %d: %s\n", rank, error.what());
    code = 1;
  }
  MPI_Finalize();
  return code;
}

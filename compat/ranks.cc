#include "ranks.h"

#include <dlfcn.h>

#include <cstdio>
#include <string>

#include "boundary.h"

namespace dacrt::compat {
namespace {

/// The folder of the library that this function is in, with a slash at its end.
std::string OwnFolder() {
  Dl_info info;
  if (dladdr(reinterpret_cast<const void*>(&OpenRanks), &info) == 0) return {};
  const std::string path = info.dli_fname;
  return path.substr(0, path.rfind('/') + 1);
}

mpi::OpenFunction* LoadModule() {
  const std::string path = OwnFolder() + mpi::kModuleName;
  // Global, because MPI loads parts of its own, which look for its functions. Never unloaded: MPI
  // lives as long as the process.
  void* const module = dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL | RTLD_NODELETE);
  void* const open = module ? dlsym(module, mpi::kOpenName) : nullptr;
  if (!open) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "config: dacrt_mpi needs ", mpi::kModuleName,
                   ", which cannot be loaded: ", dlerror());
  }
  return reinterpret_cast<mpi::OpenFunction*>(open);
}

}  // namespace

std::shared_ptr<mpi::Group> OpenRanks(const Config& config) {
  if (!config.mpi_mode) return nullptr;
  std::shared_ptr<mpi::Group> ranks;
  LoadModule()(ranks, *config.mpi_mode, config.mpi_options);
  return ranks;
}

void NoteRanks(const mpi::Group& ranks) {
  const std::string shared =
      ranks.least_rays() == SIZE_MAX
          ? "no calls are shared"
          : "calls of " + std::to_string(ranks.least_rays()) + " rays and more are shared";
  // The whole line at once: the launcher puts the ranks' outputs together as the pieces come.
  std::fprintf(stderr, "dacrt: rank %d of %d, %s\n", ranks.rank(), ranks.size(), shared.c_str());
}

}  // namespace dacrt::compat

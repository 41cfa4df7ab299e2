// Several processes that work together: the module that knows MPI, loaded when it is asked for.
#pragma once

#include <memory>

#include "config.h"
#include "dacrt/mpi.h"

namespace dacrt::compat {

/// The ranks that `config` asks for; null if it asks for none. Throws RTC_ERROR_INVALID_OPERATION
/// if the module, which stands beside this library, cannot be loaded.
std::shared_ptr<mpi::Group> OpenRanks(const Config& config);

/// Says on the standard error output how many there are.
void NoteRanks(const mpi::Group& ranks);

}  // namespace dacrt::compat

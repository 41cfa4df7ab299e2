// What ranks say of themselves before they work together.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

#include "dacrt/mpi.h"

namespace dacrt::mpi {

/// What a rank does in its group.
enum class Role : uint32_t { kProgram, kWorker, kMember };

/// As it is on the wire, so that it says in which way bytes are written.
struct Greeting {
  char name[8];         ///< "dacrt"; the same in every byte order
  uint32_t byte_order;  ///< 0x01020304
  uint32_t role;
  char version[48];  ///< of dacrt, and sizes of what travels as it lies in memory
  char host[64];     ///< where the rank is, as far as process numbers have a meaning
  int64_t process;
};

Greeting MakeGreeting(Role role);

/// Why the rank that says `own` cannot work with `rank`, which says `other` and should have
/// `role`. Empty if it can.
std::string Refusal(const Greeting& own, const Greeting& other, Role role, int rank);

/// Whether the process behind `greeting` has certainly ended. Only known on the same machine.
bool HasEnded(const Greeting& own, const Greeting& greeting);

/// Ends the process behind `greeting`. False if it is not on the same machine.
bool Kill(const Greeting& own, const Greeting& greeting);

}  // namespace dacrt::mpi

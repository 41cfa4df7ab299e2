#include "greeting.h"

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "wire.h"

namespace dacrt::mpi {
namespace {

constexpr uint32_t kByteOrder = 0x01020304;
constexpr char kName[8] = "dacrt";

/// In containers processes have numbers of their own.
unsigned long long ProcessNamespace() {
  struct stat status {};
  return stat("/proc/self/ns/pid", &status) == 0 ? status.st_ino : 0;
}

std::string_view TextIn(const char* text, std::size_t size) { return {text, strnlen(text, size)}; }

bool AreOnOneMachine(const Greeting& a, const Greeting& b) {
  return TextIn(a.host, sizeof(a.host)) == TextIn(b.host, sizeof(b.host));
}

std::string RankName(int rank) { return "rank " + std::to_string(rank); }

}  // namespace

Greeting MakeGreeting(Role role) {
  Greeting greeting{};
  std::memcpy(greeting.name, kName, sizeof(kName));
  greeting.byte_order = kByteOrder;
  greeting.role = static_cast<uint32_t>(role);
  std::snprintf(greeting.version, sizeof(greeting.version), "%s, wire %u.%zu",
                std::string(Version()).c_str(), kWireVersion, sizeof(Settings));
  char host[32] = "";
  gethostname(host, sizeof(host) - 1);
  std::snprintf(greeting.host, sizeof(greeting.host), "%s %llu", host, ProcessNamespace());
  greeting.process = getpid();
  return greeting;
}

std::string Refusal(const Greeting& own, const Greeting& other, Role role, int rank) {
  if (std::memcmp(own.name, other.name, sizeof(own.name)) != 0) {
    return RankName(rank) + " does not run dacrt";
  }
  if (own.byte_order != other.byte_order) {
    return RankName(rank) + " has another byte order: all ranks need the same";
  }
  const std::string_view version = TextIn(own.version, sizeof(own.version));
  const std::string_view other_version = TextIn(other.version, sizeof(other.version));
  if (version != other_version) {
    return RankName(rank) + " runs dacrt " + std::string(other_version) + ", this one dacrt " +
           std::string(version) + ": all ranks need the same";
  }
  if (other.role != static_cast<uint32_t>(role)) {
    return RankName(rank) + " does not run what it should: is dacrt_mpi the same on all ranks?";
  }
  return {};
}

bool HasEnded(const Greeting& own, const Greeting& greeting) {
  return AreOnOneMachine(own, greeting) && kill(static_cast<pid_t>(greeting.process), 0) != 0 &&
         errno == ESRCH;
}

bool Kill(const Greeting& own, const Greeting& greeting) {
  if (!AreOnOneMachine(own, greeting)) return false;
  kill(static_cast<pid_t>(greeting.process), SIGKILL);
  return true;
}

}  // namespace dacrt::mpi

#include "link_speed.h"

#include <algorithm>
#include <limits>

#include "wire.h"

namespace dacrt::mpi {
namespace {

constexpr int kRepetitions = 8;
constexpr uint64_t kShort = 16, kLong = 1u << 20;  // bytes

/// What a rank traces in a second, in round numbers: a scene of average size, one thread. A call
/// does not know its own rate before it is over.
constexpr double kRaysPerSecond = 4e6;

/// A closest hit's way out and back, at most: 40 and 36 bytes.
constexpr double kBytesPerRay = 76;

/// Seconds until a message of `bytes` comes back; negative if the worker was lost.
double Echo(Crew& crew, int rank, uint64_t bytes) {
  Message message;
  message.Put(Command::kEcho);
  message.Put(bytes);
  std::fill_n(message.Extend(bytes), bytes, std::byte{0});
  const Clock::time_point start = Clock::now();
  crew.SetOwing(rank, true);
  crew.Send(rank, std::move(message));
  Idle idle;
  for (;;) {
    if (const auto arrival = crew.Receive(); arrival && arrival->from == rank) {
      crew.SetOwing(rank, false);
      return SecondsSince(start);
    }
    crew.LoseSilent();
    if (!crew.IsThere(rank)) return -1;
    idle.Pause();
  }
}

}  // namespace

LinkSpeed MeasureLink(Crew& crew) {
  LinkSpeed slowest{0, std::numeric_limits<double>::infinity()};
  for (const int rank : std::vector<int>(crew.workers())) {
    // Others may have the processor meanwhile: the best of several says what the link can do.
    double short_seconds = std::numeric_limits<double>::infinity(), long_seconds = short_seconds;
    for (int i = 0; i < kRepetitions; ++i) {
      const double there = Echo(crew, rank, kShort);
      if (there < 0) break;
      short_seconds = std::min(short_seconds, there);
      long_seconds = std::min(long_seconds, std::max(Echo(crew, rank, kLong), 1e-9));
    }
    slowest.round_trip_seconds = std::max(slowest.round_trip_seconds, short_seconds);
    slowest.bytes_per_second = std::min(slowest.bytes_per_second,
                                        2 * kLong / std::max(long_seconds - short_seconds, 1e-9));
  }
  return slowest;
}

std::size_t LeastRays(const LinkSpeed& speed, std::size_t ranks) {
  if (ranks < 2) return SIZE_MAX;
  // Sharing should save twice of what it costs: a round trip for the first pieces and one for the
  // last.
  constexpr double kGain = 2, kRoundTrips = 2;
  constexpr double kFewest = 1024;  // a smaller piece is not traced at full speed
  const double saved = 1 / kRaysPerSecond - kBytesPerRay / speed.bytes_per_second;
  if (!(saved > 0)) return SIZE_MAX;
  const double share = 1 - 1 / static_cast<double>(ranks);
  const double rays = kGain * kRoundTrips * speed.round_trip_seconds / (share * saved);
  return static_cast<std::size_t>(std::clamp(rays, kFewest, 1e9));
}

}  // namespace dacrt::mpi

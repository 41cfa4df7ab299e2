// What messages begin with. Everything is written as it lies in memory: ranks of different versions
// or byte orders refuse each other (greeting.h).
#pragma once

#include <cstdint>

namespace dacrt::mpi {

/// Grows with every change of what is sent.
inline constexpr uint32_t kWireVersion = 1;

/// Tags. Answers are apart from commands because both go to rank 0 in a group of workers.
enum Tag : int {
  kTagGreeting = 1,  ///< a Greeting, from workers to rank 0
  kTagVerdict = 2,   ///< text, from rank 0 to workers: empty, or why they are refused
  kTagCommand = 3,   ///< from rank 0 to workers; begins with a Command
  kTagAnswer = 4,    ///< from workers to rank 0; begins with an Answer
  kTagGather = 9,    ///< between members: a value that all get
  kTagBarrier = 10,  ///< between members: two numbers, of the call and of the barrier's round
  kTagAlive = 5,     ///< nothing, between members of a divided group: one that is in a call
  kTagEnd = 6,       ///< text, between members: why the group cannot go on
  kTagRays = 7,      ///< rays and answers between members, in calls with even numbers
  kTagRaysOdd = 8,   ///< in odd ones: the next call may begin before all have seen the end of one
};

enum class Command : uint32_t {
  kEcho,    ///< answered with as many bytes as it asks for: how the link is measured
  kArray,   ///< a part of an array that scenes refer to
  kScene,   ///< a scene, after its arrays
  kForget,  ///< a scene that is not needed any more
  kPiece,   ///< rays to trace
  kStop,
};

enum class Answer : uint32_t {
  kEcho,
  kHits,
  kFailure,  ///< text: the worker cannot go on
};

}  // namespace dacrt::mpi

// Scenes and calls that several processes share over MPI. Optional: only programs that include this
// header and link dacrt_mpi, and those that load its module, know of MPI.
//
//   Replicate  one rank has the program; the others hold copies of its scenes and trace pieces of
//              its calls.
//   Divide     every rank has its part of the scene and its own rays; rays go where they may hit
//              something, and come home with the closest hit of all parts. After Wald, Jaros,
//              Zellmann, "Data parallel multi-GPU path tracing using ray queue cycling", CGF 2023;
//              here rays skip ranks whose bounds they miss, and meet the others nearest first.
//
// The answers are those of one process that holds everything, bit for bit.
//
// To pass a communicator, include <mpi.h> before this header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>

#include "dacrt/dacrt.h"

namespace dacrt::mpi {

enum class Mode { kReplicate, kDivide };

struct Options {
  /// A rank that owes an answer and is not heard from for this long is lost. To be longer than a
  /// rank takes for a commit, and in Mode::kDivide longer than ranks come late to a call.
  double timeout_seconds = 120;

  /// Mode::kReplicate: calls of fewer rays stay on rank 0. kMeasured: found out at the start, from
  /// the time that messages take.
  static constexpr std::size_t kMeasured = SIZE_MAX;
  std::size_t least_rays = kMeasured;

  /// Rays that travel in one message, at most: 1 to 2^20. The memory for messages grows with it.
  std::size_t piece_rays = 65536;
};

/// Thrown by calls of a group in which a rank is lost: it died, it hung, what it sent was cut, or
/// it cannot work with the others. The message names the rank and the reason.
class Fault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What went between ranks, counted by one of them since its group began.
struct Traffic {
  uint64_t calls = 0;          ///< Trace of all of the group's scenes
  uint64_t calls_shared = 0;   ///< of these, calls that left the rank
  uint64_t rays_out = 0;       ///< rays sent to another rank, counted each time
  uint64_t rays_traced = 0;    ///< rays traced here in shared calls, counted each time
  uint64_t messages_sent = 0;  ///< in calls and outside of them
  uint64_t messages_received = 0;
  uint64_t bytes_sent = 0;
  uint64_t bytes_received = 0;
  double seconds_tracing = 0;  ///< in shared calls: with the rank's own engine
  double seconds_moving = 0;   ///< in shared calls: packing, sending, receiving, unpacking
  double seconds_waiting = 0;  ///< in shared calls: with nothing to do
};

/// One rank's engine, as a group sees it. The group calls it, and nothing else of the engine.
struct LocalScene {
  const Scene* scene = nullptr;  ///< says which scene an instance means; not called
  std::function<void(Query, const RayView&, const CallOptions&)> trace;
  Bounds bounds;
  Settings settings;
  InstructionSet instruction_set = InstructionSet::kScalar;
};

/// `scene`, which `device` made. Both must outlive what is made from it.
inline LocalScene Local(const Device& device, const Scene& scene) {
  return {&scene,
          [&scene](Query query, const RayView& rays, CallOptions options) {
            options.progress = {};  // what one rank has done of its part says nothing of the call
            scene.Trace(query, rays, options);
          },
          scene.bounds(), device.settings(), device.instruction_set()};
}

/// A committed scene of a group.
class GroupScene {
 public:
  virtual ~GroupScene() = default;

  /// As dacrt::Scene::Trace, except that CallOptions::progress is not called.
  ///
  /// Mode::kReplicate: called by rank 0, from any number of threads; one of them shares its call,
  /// the others trace with the local engine meanwhile. Throws Fault after a rank was lost, in that
  /// call and all later ones; the rays are all answered then, by the ranks that are left.
  ///
  /// Mode::kDivide: collective, one call of a group at a time; each rank has its own rays, any
  /// number, and the same `query`. Callbacks run on the rank that has their geometry, with that
  /// rank's options. Throws Fault in all ranks that can still be reached, in that call and all
  /// later ones; no ray has changed then.
  virtual void Trace(Query query, const RayView& rays, const CallOptions& options = {}) = 0;

  /// Whether calls can leave the rank. Mode::kReplicate: false for scenes with callbacks, which are
  /// traced on rank 0.
  virtual bool is_shared() const = 0;
};

/// How the processes of a group can end; the larger, the worse.
enum class Ending {
  kFinalise,  ///< with MPI_Finalize
  kLeave,     ///< without, because a rank has ended before: MPI_Finalize might wait for it for ever
  kAbort,     ///< with MPI_Abort, because a rank that nobody hears from may still be running
};

/// Ranks that work together. Keeps the communicator until its end.
class Group {
 public:
  virtual ~Group() = default;

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// A scene of the group. `local` is made of the same geometries and options.
  ///
  /// Mode::kReplicate: called by rank 0. What the others do not hold yet travels to them; arrays
  /// are told apart by their contents, so that unchanged ones do not. What is written into an array
  /// later is not seen by the other ranks. Throws nothing for a lost rank: the next Trace does.
  ///
  /// Mode::kDivide: collective; every rank with its own geometries, or with none. Geometry IDs are
  /// the caller's, and should differ between ranks. Throws Fault, and Error if ranks use different
  /// instruction sets.
  virtual std::unique_ptr<GroupScene> Commit(const LocalScene& local,
                                             std::span<const Geometry> geometries,
                                             const SceneOptions& options) = 0;

  virtual Traffic traffic() const = 0;

  /// Lets the workers of Mode::kReplicate go, as the destructor does. Later calls are answered by
  /// this rank alone. Kills workers on this machine that hang.
  virtual Ending End() = 0;

  /// Calls of fewer rays than this stay on the rank.
  virtual std::size_t least_rays() const = 0;
};

#ifdef MPI_VERSION

// MPI must be initialised, for calls from different threads (MPI_THREAD_SERIALIZED) where the
// program's calls come from several. The communicator is the group's alone while the group exists.

/// Called by rank 0 while all others call Serve. Throws Fault, and refuses the others, if a rank
/// has another version of dacrt or another byte order.
std::shared_ptr<Group> Replicate(MPI_Comm communicator, const Options& options = {});

/// Works for rank 0 until its group ends. Throws Fault if rank 0 refuses this rank or is gone.
/// Never kAbort.
Ending Serve(MPI_Comm communicator, const Options& options = {});

/// Called by all ranks. Throws Fault, on all of them, if ranks have different versions of dacrt or
/// different byte orders.
std::shared_ptr<Group> Divide(MPI_Comm communicator, const Options& options = {});

#endif

/// The entry of the module, for those who load it with dlopen: makes `group` that of all ranks of
/// the process's job. Initialises MPI where the program has not, and then ends it with the process.
/// Throws Fault and std::runtime_error. In Mode::kDivide called by all ranks.
using OpenFunction = void(std::shared_ptr<Group>& group, Mode mode, const Options& options);
inline constexpr char kModuleName[] = "libdacrt_mpi.so";
inline constexpr char kOpenName[] = "dacrt_mpi_open";

}  // namespace dacrt::mpi

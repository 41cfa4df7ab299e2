// dacrt: batches of rays against triangles, without an acceleration structure built beforehand.
//
// Method: Nabata, Iwasaki, Dobashi, Nishita, "Efficient Divide-And-Conquer Ray Tracing using Ray
// Sampling", HPG 2013.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "dacrt/callback.h"
#include "dacrt/geometry.h"
#include "dacrt/point_query.h"
#include "dacrt/ray_view.h"
#include "dacrt/settings.h"
#include "dacrt/statistics.h"

namespace dacrt {

/// Told of the memory that a device and its scenes take: before they take `bytes`, which it may
/// refuse by returning false, and, with negative `bytes`, after they gave some back, when what it
/// returns has no meaning. That is workspaces; what a scene keeps, Scene::KeptBytes tells. Any
/// thread may call it.
using MemoryMonitor = std::function<bool(std::ptrdiff_t bytes)>;

/// Owns what calls share: the settings, the choice of instruction set, and the workspaces, which
/// are kept between calls.
///
/// Threads: any number may use a device at once.
class Device {
 public:
  /// Throws std::invalid_argument for illegal settings (see Validate).
  explicit Device(const Settings& settings = {}, MemoryMonitor monitor = nullptr);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const Settings& settings() const;

  /// The instruction set that is used, never kBest.
  InstructionSet instruction_set() const;

  /// Bytes that a call needs beyond the caller's memory, what the scene keeps, and the stack.
  /// With a piece of R rays for each of W threads that work on the call (src/engine/call_plan.h)
  ///     bytes = W * (a number of bytes a ray * R + a constant) + some for each triangle
  /// and with a kept partition at least those of one thread with a piece of 1,024 rays, which are
  /// reserved when a scene is made. Calls of up to 256 rays over a kept partition, packets and
  /// single rays need none but, while subsets are split, that constant; their stack is 80 KiB.
  /// The constants are stated in src/runtime/workspace.h, and for the triangles in
  /// src/partition/grid.h where a partition is kept: they are then needed only by the first calls,
  /// while large subsets are split. The device keeps as many workspaces as threads worked at once,
  /// each as large as the largest piece that it served.
  std::size_t WorkspaceBytes(std::size_t triangle_count, std::size_t ray_count) const;

  /// Bytes of all workspaces that the device holds now, those in use included.
  std::size_t WorkspaceBytesHeld() const;

  /// Gives the memory of workspaces that no call is using back to the system.
  void ReleaseIdleWorkspaces();

 private:
  friend class Scene;
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// How much of the partition of its triangles a scene keeps between calls.
enum class Keep {
  kByBudget,  ///< as Settings::budget says
  kLittle,    ///< at most eight bytes a triangle; nothing with a budget of 0
};

struct SceneOptions {
  Keep keep = Keep::kByBudget;

  /// No ray passes between two triangles that share an edge, by the test of edges in Woop, Benthin,
  /// Wald, "Watertight ray/triangle intersection", JCGT 2013, section 2. Costs time.
  bool robust = false;

  /// Whether a partition is taken over whenever it can be (see Scene::TakeOver), however badly it
  /// fits by now.
  bool always_refit = false;
};

/// A committed, immutable set of geometries.
///
/// Primitives with an index outside the vertices, or with a coordinate that is not finite or beyond
/// 1.8e18 in magnitude at any time step, are left out: no ray hits them, and they do not enter the
/// bounds.
///
/// Threads: any number may trace one scene at once. Callbacks are called by the thread that calls,
/// which does all the work of a call on a scene with callbacks: programs let them write to what
/// belongs to the call, CallOptions::call, without a lock.
class Scene {
 public:
  /// Reads every mesh once. Of two meshes with equal geometry_id the later one counts as larger
  /// where distances are equal.
  /// Throws std::invalid_argument if a pointer is null while its count is not zero, or if an
  /// address or stride is not a multiple of four; std::length_error if there are 2^31 - 1
  /// triangles or more; std::bad_alloc if the memory of what is kept, or of the least workspace,
  /// cannot be had.
  Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes,
        Keep keep = Keep::kByBudget);

  /// The same for geometries of every shape. Throws std::invalid_argument too if an instance has no
  /// scene or one of another device, or if counts of time steps are out of range or differ.
  Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
        const SceneOptions& options);

  /// The same for a scene that comes in the place of `previous`, for the next frame of an
  /// animation: where both have the same geometries but for vertices, transforms and bounds, with
  /// as many primitives and the same indices, what `previous` keeps can be taken over, and only
  /// what rays come to is renewed. If so, takes_over() is true, and before anything else is done
  /// with the new scene TakeOver must be called. Where coordinates have changed so much that the
  /// old partition would be slow, or other primitives can be hit than before, takes_over() is
  /// false.
  ///
  /// The caller's duty: indices and the arrays of `previous` need not be in place any more, but
  /// nobody may trace `previous` meanwhile.
  Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
        const SceneOptions& options, const Scene& previous);
  bool takes_over() const;

  /// Takes over what `previous` keeps, the scene that was given to the constructor. From then on
  /// nothing must be done with that but to destroy it. Does nothing if takes_over() is false.
  void TakeOver(Scene& previous) noexcept;
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Bounds of what can be hit at any time; empty if there is nothing.
  Bounds bounds() const;

  /// The same at the ends of the time from 0 to 1. Reads every mesh.
  LinearBounds linear_bounds() const;

  /// Number of primitives that can be hit; of grids, of their quads.
  std::size_t triangle_count() const;

  /// Bytes that the scene may come to keep between calls, beside the meshes' description: 0 if
  /// nothing is kept. Reserved when the scene is made, taken from the system as the partition
  /// grows.
  std::size_t KeptBytes() const;

  /// Of these, the bytes in use now.
  std::size_t KeptBytesUsed() const;

  /// Bytes that Trace needs for `ray_count` rays; see Device::WorkspaceBytes.
  std::size_t WorkspaceBytes(std::size_t ray_count) const;

  /// Answers `query` for every active ray of `rays`; see RayView for what is read and written.
  ///
  /// Hits: closest hits are exact to single-precision rounding of the Moeller-Trumbore test; of
  /// hits at the same distance the one with the smaller (geometry_id, primitive_id) is reported.
  /// The same rays get the same bits whatever the settings, the pieces and the other rays in the
  /// batch. Not promised: the same bits on two different instruction sets; watertight edges, but in
  /// robust scenes.
  ///
  /// Memory: where the workspace cannot be had, the call makes do with fewer threads and smaller
  /// pieces, down to what was reserved when a scene was made. So a call fails for want of memory
  /// only if other calls have all that there is.
  ///
  /// Returns what was counted; nothing for calls of up to 256 rays over a kept partition, which
  /// take a shorter way.
  ///
  /// Throws std::invalid_argument if a component that must be present is absent or lanes is 0, and
  /// std::bad_alloc if not even the least workspace can be had; no ray has changed then.
  Statistics Trace(Query query, const RayView& rays, const CallOptions& options = {}) const;

  /// The same for a packet or a single ray, by the shortest way: on the stack and the thread of the
  /// caller, without counting.
  ///
  /// Throws std::invalid_argument if lanes is not 1 to 16. Where nothing is kept, as Trace.
  void Trace(Query query, const RayPacket& packet, const CallOptions& options = {}) const;

  /// Calls the point callbacks of the geometries for the primitives within the radius of a point,
  /// each once, in instances once an instance. A primitive is within the radius if its bounds at
  /// the query's time are; a moving geometry is passed by at times at which it is not there.
  /// Through an instance that is not a similarity (see SimilarityScale), the box that holds what
  /// the ball of the radius becomes stands for it.
  ///
  /// Where a partition is kept, nearer subsets are looked at first, and those beyond a radius that
  /// shrinks are not looked at. Otherwise a query looks at the bounds of every primitive.
  ///
  /// The callbacks are called by the thread that calls. A point or a radius that is not a number
  /// finds nothing. Throws std::bad_alloc if there is no memory to split a subset of the partition.
  void QueryPoint(const PointQuery& query) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace dacrt

// dacrt: batches of rays against triangles, without an acceleration structure built beforehand.
//
// Method: Nabata, Iwasaki, Dobashi, Nishita, "Efficient Divide-And-Conquer Ray Tracing using Ray
// Sampling", HPG 2013. A scene may keep what it finds out about its triangles while rays are traced
// (Settings::budget): a bounding volume hierarchy, eight wide, that is built where rays come.
//
//   std::vector<float> vertices = {0, 0, 0, 4, 0, 0, 0, 4, 0};
//   std::vector<uint32_t> triangles = {0, 1, 2};
//   dacrt::Scene scene(std::make_shared<dacrt::Device>(), dacrt::Triangles(vertices, triangles));
//   std::vector<dacrt::RayHit> rays(1);
//   rays[0].ray = {.org = {1, 1, 2}, .dir = {0, 0, -1}};
//   scene.ClosestHits(rays);
//   if (rays[0].hit) std::printf("hit at t = %g\n", rays[0].ray.tfar);
//
// This header includes all of the API but callback_of.h (callbacks from lambdas) and mpi.h (several
// processes). Lengths and times are in units of the program's choice. Errors are reported by
// exceptions: see error.h.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "dacrt/arrays.h"
#include "dacrt/callback.h"
#include "dacrt/error.h"
#include "dacrt/export.h"
#include "dacrt/geometry.h"
#include "dacrt/point_query.h"
#include "dacrt/ray.h"
#include "dacrt/ray_layout.h"
#include "dacrt/ray_view.h"
#include "dacrt/settings.h"
#include "dacrt/statistics.h"
#include "dacrt/version.h"

namespace dacrt {

/// Told of the memory that a device and its scenes take: before they take `bytes`, which it may
/// refuse by returning false, and, with negative `bytes`, after they gave some back, when what it
/// returns is ignored. Counted are workspaces, what scenes keep between calls, and what splitting a
/// large scene takes while it lasts. Any thread may call it. It must neither throw nor trace rays.
using MemoryMonitor = std::function<bool(std::ptrdiff_t bytes)>;

/// Owns what calls share: the settings, the choice of instruction set, the threads, and the
/// workspaces, which are kept between calls.
///
/// A program needs one. Several are for parts of a program that want settings, budgets, threads or
/// a memory monitor of their own; their scenes cannot be instances of each other.
///
/// Threads: any number may use a device at once.
class DACRT_API Device {
 public:
  /// Throws Error for illegal settings (see Validate).
  explicit Device(const Settings& settings = {}, MemoryMonitor monitor = nullptr);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const Settings& settings() const;

  /// The instruction set that is used, never kBest.
  InstructionSet instruction_set() const;

  /// Bytes that a call needs beyond the caller's memory, what the scene keeps, and the stack. For T
  /// triangles and N rays, of which W of the device's D threads trace pieces of R = min(N, 65,536),
  /// or fewer where threads would otherwise have none, they are about
  ///     with a kept partition  W (152 R + 0.9 million)
  ///                            + 6 T + 4.5 million + 1.2 million min(D, T / 32,768)
  ///     where nothing is kept  32 T + 84.25 min(N, Settings::piece_rays) + 0.9 million
  /// The second line is needed only by the first calls, while large subsets are split. With a kept
  /// partition one of the threads has at least what a piece of 1,024 rays needs, which is reserved
  /// when a scene is made. Calls of up to 256 rays over a kept partition, packets and single rays
  /// need only the second line, and only while subsets are split; their stack is 80 KiB. The device
  /// keeps as many workspaces as threads worked at once, each as large as the largest piece that it
  /// served.
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

  /// Whether so many rays are expected, before triangles come or go, that it pays to split them
  /// with care: a call whose rays come to triangles for the first time takes half as long again to
  /// two and a half times as long, and most calls after that up to a quarter less. Hits are the
  /// same.
  bool splits_with_care = false;
};

/// A Geometry, or a contiguous range of them.
template <class T>
concept OneOrMoreGeometries =
    std::same_as<T, Geometry> || std::convertible_to<const T&, std::span<const Geometry>>;

/// A committed set of geometries, which nothing changes but Update.
///
/// Change: to show what has moved, come or gone, make another scene of the same device over the
/// same arrays; the old one may be destroyed before or after. Where only vertices, transforms and
/// bounds have changed, the new scene can take over what the old one has found out (see TakeOver);
/// otherwise that is found out anew where rays come. Where few of many geometries have, Update
/// changes the scene itself. What stays still while others move belongs in a scene of its own, of
/// which the one that is made anew has an instance (InstanceOf): it keeps what it has, and what
/// moves without changing its shape is an instance with another transform.
///
/// Primitives with an index outside the vertices, or with a coordinate that is not finite or beyond
/// 1.8e18 in magnitude at any time step, are left out: no ray hits them, and they do not enter the
/// bounds.
///
/// Threads: any number may trace one scene at once. Callbacks are called by the thread that calls,
/// which does all the work of a call on a scene with callbacks: programs let them write to what
/// belongs to the call, CallOptions::call, without a lock.
class DACRT_API Scene {
 public:
  /// Reads every mesh once. Of two meshes with equal geometry_id the later one counts as larger
  /// where distances are equal.
  /// Throws Error if the device is null, if a pointer is null while its count is not zero, if an
  /// address or stride is not a multiple of four, or if there are 2^31 - 1 triangles or more
  /// (Error::Kind::kTooLarge); std::bad_alloc if there is no memory for what is kept or for the
  /// least workspace.
  Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes,
        Keep keep = Keep::kByBudget);

  /// The same for geometries of every shape. Throws Error too if an instance has no scene or one of
  /// another device, or if counts of time steps are out of range or differ.
  Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
        const SceneOptions& options);

  /// The same for one geometry, or for a std::vector or an array of them.
  template <OneOrMoreGeometries Geometries>
  Scene(std::shared_ptr<Device> device, const Geometries& geometries,
        const SceneOptions& options = {})
      : Scene(std::move(device), AsSpan(geometries), options) {}

  /// The same for a scene that replaces `previous` in the next frame of an animation: where both
  /// have the same geometries but for vertices, transforms and bounds, with as many primitives and
  /// the same indices, what `previous` keeps can be taken over, and only what rays come to is
  /// renewed. The new scene may have others with larger IDs besides. If so, takes_over() is true,
  /// and TakeOver must be called before anything else is done with the new scene.
  /// Where coordinates have changed so much that the old partition would be slow, where other
  /// primitives can be hit than before, or where half as many have come as it was made of,
  /// takes_over() is false.
  ///
  /// The caller's duty: nobody may trace `previous` meanwhile. Its indices and arrays need not be
  /// in place any more.
  Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
        const SceneOptions& options, const Scene& previous);
  bool takes_over() const;

  /// Takes over what `previous`, the scene that was given to the constructor, keeps. From then on
  /// `previous` may only be destroyed. Does nothing if takes_over() is false.
  void TakeOver(Scene& previous) noexcept;

  /// The same, but `previous` stays as it is, for scenes that have an instance of it: what it keeps
  /// is copied. Throws std::bad_alloc; this scene may only be destroyed then.
  void TakeCopy(const Scene& previous);

  /// The same without another scene, for a few geometries of many: those with the IDs of `changed`
  /// are from now on as described there. What it costs follows them and not the scene.
  ///
  /// Those that are hidden (Geometry::hidden) are looked at no more, and their arrays, callbacks
  /// and instanced scenes may go; they count in triangle_count() still, and come back by another
  /// Update, or others do with their IDs and counts. Instances may show other scenes than before.
  ///
  /// False, and nothing has changed, if that needs another scene: where TakeOver would not do, or
  /// no or several geometries have such an ID, or one gets or loses a filter function, or is the
  /// first to show a scene with callbacks. Bounds functions may have been called then. Throws as
  /// the constructors do; nothing has changed then.
  ///
  /// The caller's duty: nobody may trace the scene, or one that has an instance of it, meanwhile;
  /// nor later the latter, because their bounds are those of before.
  bool Update(std::vector<Geometry> changed, bool always_refit = false);

  /// The same, and the instances `placed`, each of which is there once and not in `changed`, stand
  /// somewhere else from now on and are what they were in all else: what costs least where many of
  /// them move. False too if one of them is not an instance, is hidden, or has another number of
  /// time steps.
  bool Update(std::vector<Geometry> changed, std::span<const Placement> placed,
              bool always_refit = false);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Bounds of what can be hit at any time; empty if there is nothing.
  Bounds bounds() const;

  /// The same at the ends of the time from 0 to 1. Reads every mesh.
  LinearBounds linear_bounds() const;

  /// Number of primitives that can be hit; of grids, of their quads.
  std::size_t triangle_count() const;

  /// Bytes that the scene may come to keep between calls, besides the meshes' description: 0 if
  /// nothing is kept. Reserved when the scene is made, taken from the system as the partition
  /// grows.
  std::size_t KeptBytes() const;

  /// Of these, the bytes in use now.
  std::size_t KeptBytesUsed() const;

  /// Bytes that Trace needs for `ray_count` rays; see Device::WorkspaceBytes. With functions of the
  /// program's each of W threads takes 8 R more, with instances 102 min(R, 4,096) more.
  std::size_t WorkspaceBytes(std::size_t ray_count) const;

  /// Answers `query` for every active ray of `rays`; see RayView for what is read and written.
  ///
  /// Hits: closest hits are exact to single-precision rounding of the Moeller-Trumbore test; of
  /// hits at the same distance the one with the smaller (geometry_id, primitive_id) is reported.
  /// The same rays get the same bits whatever the settings, the pieces and the other rays in the
  /// batch. Not promised: the same bits on two different instruction sets; watertight edges, except
  /// in robust scenes.
  ///
  /// Memory: where the workspace does not fit, the call makes do with fewer threads and smaller
  /// pieces, down to what was reserved when a scene was made. So a call fails for want of memory
  /// only if other calls have all that there is.
  ///
  /// Returns what was counted; nothing for calls of up to 256 rays over a kept partition, which
  /// take a shorter way.
  ///
  /// Throws Error if a component that must be present is absent or lanes is 0, and std::bad_alloc
  /// if there is no memory for even the least workspace; no ray has changed then.
  Statistics Trace(Query query, const RayView& rays, const CallOptions& options = {}) const;

  /// The same for a packet or a single ray, by the shortest way: on the stack and the thread of the
  /// caller, without counting.
  ///
  /// Throws Error if lanes is not 1 to 16. Where nothing is kept, as Trace.
  void Trace(Query query, const RayPacket& packet, const CallOptions& options = {}) const;

  /// Finds the closest hit of every ray: Trace with Query::kClosest over these records. Where a ray
  /// hits, its tfar and its hit are written; a ray that misses stays as it was.
  Statistics ClosestHits(std::span<RayHit> rays, const CallOptions& options = {}) const {
    return Trace(Query::kClosest, ViewOf(rays), options);
  }

  /// Finds out whether there is anything along every ray, for shadows and lines of sight: Trace
  /// with Query::kAny. Ray::IsOccluded gives the answer afterwards.
  Statistics AnyHits(std::span<Ray> rays, const CallOptions& options = {}) const {
    return Trace(Query::kAny, ViewOf(rays), options);
  }

  /// The same for a single ray, by the shortest way. Returns whether it hits. In a batch a ray
  /// costs less.
  bool ClosestHit(RayHit& ray, const CallOptions& options = {}) const {
    ray.hit = {};
    Trace(Query::kClosest, RayPacket{&ray}, options);
    return static_cast<bool>(ray.hit);
  }
  bool AnyHit(Ray ray, const CallOptions& options = {}) const {
    Trace(Query::kAny, RayPacket{&ray}, options);
    return ray.IsOccluded();
  }

  /// Calls the point callbacks of the geometries for the primitives within the radius of a point,
  /// each once, and in instances once per instance. A primitive is within the radius if its bounds
  /// at the query's time are; a moving geometry is skipped at times at which it is not there.
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
  static std::span<const Geometry> AsSpan(const Geometry& geometry) { return {&geometry, 1}; }
  static std::span<const Geometry> AsSpan(std::span<const Geometry> geometries) {
    return geometries;
  }

  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace dacrt

// dacrt: batches of rays against triangles, without an acceleration structure built beforehand.
//
// Method: Nabata, Iwasaki, Dobashi, Nishita, "Efficient Divide-And-Conquer Ray Tracing using Ray
// Sampling", HPG 2013.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "dacrt/ray_view.h"
#include "dacrt/settings.h"
#include "dacrt/statistics.h"

namespace dacrt {

/// An axis-aligned box. An empty one has lower = +infinity and upper = -infinity.
struct Bounds {
  float lower[3];
  float upper[3];
};

/// An indexed triangle mesh in the caller's memory, which is read during Scene's constructor and
/// during each Trace, and never copied: it must stay in place and unchanged while a scene that was
/// made from it exists.
struct TriangleMesh {
  /// Three floats a vertex, `vertex_stride` bytes apart. Four-byte aligned.
  const void* vertices = nullptr;
  std::size_t vertex_stride = 12;
  std::size_t vertex_count = 0;

  /// Three uint32_t a triangle, `triangle_stride` bytes apart. Four-byte aligned.
  const void* triangles = nullptr;
  std::size_t triangle_stride = 12;
  std::size_t triangle_count = 0;

  /// What a hit reports. Also the first key by which equal distances are decided.
  uint32_t geometry_id = 0;

  /// A ray meets this mesh only if (ray mask & mesh mask) != 0.
  uint32_t mask = UINT32_MAX;
};

/// Owns what calls share: the settings, the choice of instruction set, and the workspaces, which
/// are kept between calls.
///
/// Threads: any number may use a device at once.
class Device {
 public:
  /// Throws std::invalid_argument for illegal settings (see Validate).
  explicit Device(const Settings& settings = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const Settings& settings() const;

  /// The instruction set that is used, never kBest.
  InstructionSet instruction_set() const;

  /// Bytes that a call needs beyond the caller's memory, what the scene keeps, and the stack.
  /// With a piece of R rays for each of W threads that work on the call (src/engine/call_plan.h)
  ///     bytes = W * (kRayBytes * R + a constant) + kTriangleBytes * triangle_count
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

/// Whether a scene keeps the partition of its triangles between calls.
enum class Keep {
  kByBudget,  ///< as Settings::budget says
  kNothing,   ///< as with a budget of 0
};

/// A committed, immutable set of meshes.
///
/// Triangles with an index outside the vertices, or with a vertex that is not finite or beyond
/// 1.8e18 in magnitude, are left out: no ray hits them, and they do not enter the bounds.
///
/// Threads: any number may trace one scene at once.
class Scene {
 public:
  /// Reads every mesh once. Of two meshes with equal geometry_id the later one counts as larger
  /// where distances are equal.
  /// Throws std::invalid_argument if a pointer is null while its count is not zero, or if an
  /// address or stride is not a multiple of four; std::length_error if there are 2^32 - 1
  /// triangles or more; std::bad_alloc if the memory of what is kept cannot be had.
  Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes,
        Keep keep = Keep::kByBudget);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Bounds of the triangles that can be hit; empty if there are none.
  Bounds bounds() const;

  /// Number of triangles that can be hit.
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
  /// batch. Not promised: the same bits on two different instruction sets; watertight edges.
  ///
  /// Throws std::invalid_argument if a component that must be present is absent or lanes is 0, and
  /// std::bad_alloc if the workspace cannot be had, not even for smaller pieces on one thread; no
  /// ray has changed then.
  Statistics Trace(Query query, const RayView& rays) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace dacrt

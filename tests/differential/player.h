// A world as one library holds it.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "callbacks.h"
#include "embree_scene.h"
#include "world.h"

namespace dacrt::tests {

class PlayedWorld {
 public:
  /// Makes and commits all scenes as they are before the first stage. `device` must outlive this.
  /// Throws std::runtime_error if the library reports an error.
  PlayedWorld(const EmbreeDevice& device, const std::vector<WorldScene>& scenes);
  ~PlayedWorld();
  PlayedWorld(const PlayedWorld&) = delete;
  PlayedWorld& operator=(const PlayedWorld&) = delete;

  /// Makes the changes and commits what they touch. Throws as the constructor does.
  void Commit(std::span<const Change> changes);

  /// Traces a copy of `rays` as `batch` says, in calls of at most batch.rays_per_call.
  std::vector<RTCRayHit> Trace(const Batch& batch, std::span<const RTCRayHit> rays,
                               CallContext& call) const;

  RTCBounds Bounds() const;

 private:
  /// Where the vertices of a geometry stand, in memory that the library has seen.
  struct Array {
    std::byte* first = nullptr;
    std::size_t stride = 0;
  };
  struct Geometry {
    RTCGeometry handle = nullptr;
    GeometryData data;
    std::vector<Array> vertices;  ///< of each time step
  };
  struct Scene {
    RTCScene handle = nullptr;
    std::vector<Geometry> geometries;
    RTCBuffer common_buffer = nullptr;
    std::size_t common_capacity = 0, common_size = 0;  ///< bytes there are, and bytes given out
  };

  const EmbreeApi& api() const { return device_.api(); }
  void MakeScene(std::size_t scene);
  void MakeGeometry(Scene& scene, const WorldGeometry& description, Geometry& geometry);
  void SetArrays(Scene& scene, const WorldGeometry& description, Geometry& geometry);
  void SetFilters(const WorldGeometry& description, RTCGeometry geometry);
  void SetInstance(const WorldGeometry& description, const Geometry& geometry);
  void SetPlacements(const WorldGeometry& description, RTCGeometry geometry);
  Array SetArray(Scene& scene, const ArrayLayout& layout, RTCGeometry geometry, RTCBufferType type,
                 uint32_t slot, RTCFormat format, std::span<const std::byte> items,
                 std::size_t item_size);
  /// Null where the library was refused memory.
  std::byte* DataOf(RTCBuffer buffer, std::size_t offset) const;
  void WriteVertices(const WorldGeometry& description, Geometry& geometry);
  void Play(const Change& change);
  void Release();

  const EmbreeDevice& device_;
  std::vector<WorldScene> descriptions_;
  std::vector<Scene> scenes_;
  std::vector<std::unique_ptr<std::byte[]>> shared_;  ///< memory that the library was lent
  std::vector<RTCBuffer> buffers_;
};

}  // namespace dacrt::tests

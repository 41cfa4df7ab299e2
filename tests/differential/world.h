// What a differential test is about, as plain data: scenes of every geometry type, what is changed
// between commits, and the batches of rays that are traced after each.
#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "streams.h"
#include "vec3.h"

namespace dacrt::tests {

enum class Shape : uint32_t {
  kTriangles,
  kQuads,
  kGrids,
  kSpheres,
  kDiscs,
  kOrientedDiscs,
  kUser,  ///< spheres behind callbacks
  kInstance,
};
inline constexpr uint32_t kShapeCount = 8;

const char* Name(Shape shape);

bool HasPoints(Shape shape);  ///< one vertex a primitive: centre and radius
bool HasFacets(Shape shape);  ///< indexed vertices

/// What a filter function does with a hit. `kRejectSome` decides by the ray's id and the
/// primitive's name (see Rejects), so that the answer does not depend on the order of the hits.
/// `kChange` accepts it with other values for u and v.
enum class FilterKind : uint32_t { kNone, kAccept, kRejectSome, kRejectAll, kChange };
inline constexpr float kChangedU = 0.375f, kChangedV = 2.5f;

const char* Name(FilterKind kind);

/// Who owns the memory of a geometry's arrays.
enum class Memory : uint32_t {
  kShared,       ///< rtcSetSharedGeometryBuffer
  kNew,          ///< rtcSetNewGeometryBuffer
  kBuffer,       ///< an RTCBuffer of its own
  kSceneBuffer,  ///< one RTCBuffer with all other geometries of the scene that say so
};

struct ArrayLayout {
  Memory memory = Memory::kShared;
  uint32_t offset = 0;  ///< bytes before the first item; not with kNew
  uint32_t gap = 0;     ///< bytes between items; a multiple of four
};

struct Vertex {
  float x = 0, y = 0, z = 0, radius = 0;
};

/// Where an instance stands at a time step.
struct Placement {
  std::array<float, 12> matrix{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};  ///< columns
  std::array<float, 16> parts{};  ///< the members of RTCQuaternionDecomposition in their order
};

struct WorldGeometry {
  Shape shape = Shape::kTriangles;
  uint32_t id = 0;
  uint32_t mask = UINT32_MAX;
  bool enabled = true;
  bool attached = true;
  RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
  FilterKind closest_filter = FilterKind::kNone;
  FilterKind any_filter = FilterKind::kNone;
  float time_begin = 0, time_end = 1;
  ArrayLayout layout;

  std::vector<std::vector<Vertex>> vertices;        ///< of each time step
  std::vector<std::vector<Float3>> normals;         ///< of each time step: oriented discs
  std::vector<std::array<uint32_t, 4>> primitives;  ///< indices; grids: first vertex, vertices
                                                    ///< from row to row, width, height
  bool traces_again = false;                        ///< user functions trace in instanced_scene
  uint32_t instanced_scene = 0;                     ///< in World::scenes
  bool in_parts = false;                            ///< placements are given as parts
  RTCFormat transform_format = RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR;
  std::vector<Placement> placements;  ///< at each time step: instances

  uint32_t StepCount() const;
  uint32_t PrimitiveCount() const;
};

struct WorldScene {
  RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
  RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
  std::vector<WorldGeometry> geometries;

  bool IsRobust() const { return (flags & RTC_SCENE_FLAG_ROBUST) != 0; }
};

/// Something that a program does to a geometry between two commits.
struct Change {
  enum class Kind : uint32_t {
    kEnable,
    kDisable,
    kDetach,
    kAttach,
    kShift,  ///< moves the vertices, or the instance
    kMask,
    kFilters,     ///< other filter functions
    kPrimitives,  ///< the first half of the primitives is left, in other memory
    kBend,        ///< moves the vertices, neighbours nearly alike
    kScatter,     ///< moves each vertex by itself
    kSpoil,       ///< some vertices are no numbers any more; those that were none are numbers again
    kReplace,     ///< another one, described alike, comes in its place, and this is released
  };
  Kind kind = Kind::kEnable;
  uint32_t scene = 0, geometry = 0;  ///< places, not ids
  Float3 shift;
  uint32_t mask = 0;
  FilterKind closest_filter = FilterKind::kNone, any_filter = FilterKind::kNone;
};
inline constexpr uint32_t kChangeKindCount = 12;

struct Batch {
  Form form{Form::Call::kRecords};
  Query query = Query::kClosest;
  FilterKind context_filter = FilterKind::kNone;
  uint32_t rays_per_call = UINT32_MAX;
  std::string ray_kind;
  std::vector<RTCRayHit> rays;
};

/// What happens between one commit and the next.
struct Stage {
  std::vector<Change> changes;  ///< before the commit
  std::vector<Batch> batches;   ///< after it
};

struct World {
  std::string real_config;         ///< of the real library's device
  std::string drop_in_config;      ///< of the drop-in's, if the run does not say otherwise
  std::vector<WorldScene> scenes;  ///< the last one is traced, the others are for its instances
  std::vector<Stage> stages;

  const WorldScene& Top() const { return scenes.back(); }
};

/// Does to the description what the player does to a library's scenes.
void Apply(const Change& change, std::vector<WorldScene>& scenes);

/// Whether a filter function of this kind rejects the hit of this ray.
bool Rejects(FilterKind kind, uint32_t ray_id, const RTCHit& hit);

}  // namespace dacrt::tests

// A scene with filter functions on geometries of every type.
#pragma once

#include <limits>
#include <vector>

#include "callbacks.h"
#include "model.h"

namespace dacrt::tests {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The types whose hits the library finds itself. Of an instance, the geometry in it has filters.
inline constexpr RTCGeometryType kTypes[] = {
    RTC_GEOMETRY_TYPE_TRIANGLE,   RTC_GEOMETRY_TYPE_QUAD,
    RTC_GEOMETRY_TYPE_GRID,       RTC_GEOMETRY_TYPE_SPHERE_POINT,
    RTC_GEOMETRY_TYPE_DISC_POINT, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT,
    RTC_GEOMETRY_TYPE_INSTANCE,
};
inline constexpr unsigned int kFirstId = 10;
inline constexpr unsigned int kInstanceId = kFirstId + 6;
inline constexpr unsigned int kInnerId = 3;

inline bool IsReal(const Api& api) { return &api == &RealEmbree(); }

/// One geometry of each type, four apart along the rays, all with filter functions. The real
/// library's code for AVX-512 hangs or fails in occlusion calls for 16 coherent rays and instances.
class Tower {
 public:
  explicit Tower(const Api& api, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE,
                 const char* config = nullptr)
      : s(api, IsReal(api) ? "isa=avx2" : config), scene(s.NewScene()), flags_(flags) {
    s.api.rtcSetSceneFlags(scene, flags);
    float z = 0;
    unsigned int id = kFirstId;
    for (const RTCGeometryType& type : kTypes) {
      s.api.rtcAttachGeometryByID(scene, Floor(type, z), id++);
      z += 4;
    }
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  }

  /// Gives the geometries filter functions for `query` and none for the other.
  void SetFilters(Query query) {
    for (const RTCGeometry geometry : filtered_) {
      const bool is_closest = query == Query::kClosest;
      s.api.rtcSetGeometryIntersectFilterFunction(geometry,
                                                  is_closest ? FilterOfGeometry : nullptr);
      s.api.rtcSetGeometryOccludedFilterFunction(geometry, is_closest ? nullptr : FilterOfGeometry);
    }
  }

  void Commit() {
    for (const RTCGeometry geometry : filtered_) s.api.rtcCommitGeometry(geometry);
    for (const RTCScene changed : {inner_, scene}) s.api.rtcCommitScene(changed);
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  }

  RTCScene SceneOfInstance() const { return inner_; }

  Session s;
  RTCScene scene;

 private:
  RTCGeometry Floor(const RTCGeometryType& type, float z) {
    if (type == RTC_GEOMETRY_TYPE_INSTANCE) return InstanceFloor(z);
    const RTCGeometry geometry = s.Own(s.api.rtcNewGeometry(s.device, type));
    SetVertices(s, geometry, type, 0, z, IsPoint(type) ? 1 : 4);
    SetPrimitives(s, geometry, type);
    s.api.rtcSetGeometryIntersectFilterFunction(geometry, FilterOfGeometry);
    s.api.rtcSetGeometryOccludedFilterFunction(geometry, FilterOfGeometry);
    s.api.rtcSetGeometryUserData(geometry, const_cast<RTCGeometryType*>(&type));
    s.api.rtcCommitGeometry(geometry);
    filtered_.push_back(geometry);
    return geometry;
  }

  RTCGeometry InstanceFloor(float z) {
    inner_ = s.NewScene();
    s.api.rtcSetSceneFlags(inner_, flags_);
    s.api.rtcAttachGeometryByID(inner_, Floor(kTypes[0], 0), kInnerId);
    s.api.rtcCommitScene(inner_);
    const RTCGeometry instance = Instance(s, inner_, z);
    s.api.rtcCommitGeometry(instance);
    return instance;
  }

  const RTCSceneFlags flags_;
  RTCScene inner_ = nullptr;
  std::vector<RTCGeometry> filtered_;
};

inline Outcome TraceTower(Tower& tower, const Form& form, Query query, const Judge& geometry,
                          const Judge& context = nullptr) {
  Outcome outcome = TraceRow(tower.s, tower.scene, form, query, geometry, context);
  EXPECT_EQ(outcome.idle_calls, 0);
  return outcome;
}

/// The scene in both libraries.
class FilterTest : public testing::Test {
 protected:
  Tower real{RealEmbree()};
  Tower ours{DropIn()};
};

}  // namespace dacrt::tests

// A program that makes calls of many kinds, step by step; tests take its memory away meanwhile.
#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace dacrt::tests {

/// Triangles, one in each unit square of a plane: enough of them for a grid.
inline constexpr unsigned int kSide = 80;
inline constexpr unsigned int kTriangles = kSide * kSide;

inline RTCRayHit RayAt(unsigned int triangle) {
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(triangle % kSide) + 0.2f;
  ray.ray.org_y = static_cast<float>(triangle / kSide % kSide) + 0.2f;
  ray.ray.org_z = -1;
  ray.ray.dir_z = 1;
  ray.ray.tfar = 10;
  ray.ray.mask = 0xFFFFFFFF;
  ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

struct Vertex {
  float x, y, z;
};

/// What a program makes. Each step is one call, or a few, and says whether it did what it should.
class StepProgram {
 public:
  using Step = std::function<bool()>;

  explicit StepProgram(const char* config) : config_(config) {
    for (unsigned int y = 0; y <= kSide; ++y) {
      for (unsigned int x = 0; x <= kSide; ++x) {
        vertices_.push_back({static_cast<float>(x), static_cast<float>(y), 0});
      }
    }
    for (unsigned int i = 0; i < kTriangles; ++i) {
      const unsigned int corner = i / kSide * (kSide + 1) + i % kSide;
      for (const unsigned int index : {corner, corner + 1, corner + kSide + 1}) {
        indices_.push_back(index);
      }
    }
  }

  std::vector<Step> Steps() {
    std::vector<Step> steps;
    steps.push_back([this] { return (device_ = rtcNewDevice(config_)) != nullptr; });
    steps.push_back([this] {
      rtcSetDeviceErrorFunction(
          device_, [](void*, RTCError, const char*) {}, nullptr);
      return true;
    });
    steps.push_back([this] { return (buffer_ = rtcNewBuffer(device_, 1000)) != nullptr; });
    steps.push_back([this] { return (mesh_ = New(RTC_GEOMETRY_TYPE_TRIANGLE)) != nullptr; });
    steps.push_back([this] {
      rtcSetSharedGeometryBuffer(mesh_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                 vertices_.data(), 0, sizeof(Vertex), vertices_.size());
      return true;
    });
    steps.push_back([this] {
      auto* const indices = static_cast<unsigned int*>(rtcSetNewGeometryBuffer(
          mesh_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, kTriangles));
      if (indices) std::copy(indices_.begin(), indices_.end(), indices);
      return indices != nullptr;
    });
    steps.push_back([this] {
      rtcSetGeometryVertexAttributeCount(mesh_, 2);
      return true;
    });
    steps.push_back([this] {
      rtcCommitGeometry(mesh_);
      return true;
    });
    steps.push_back([this] { return (inner_ = rtcNewScene(device_)) != nullptr; });
    steps.push_back([this] { return Attach(inner_, mesh_); });
    steps.push_back([this] { return Commit(inner_); });
    // Several of each: the first ones split.
    for (int i = 0; i < 2; ++i) {
      steps.push_back([this] { return Trace1(inner_); });
      steps.push_back([this] { return TraceM(inner_, 100); });
    }
    steps.push_back([this] { return QueryPoint(inner_); });

    steps.push_back([this] { return (instance_ = New(RTC_GEOMETRY_TYPE_INSTANCE)) != nullptr; });
    steps.push_back([this] {
      rtcSetGeometryInstancedScene(instance_, inner_);
      return true;
    });
    steps.push_back([this] {
      rtcSetGeometryTimeStepCount(instance_, 2);
      return true;
    });
    steps.push_back([this] {
      rtcCommitGeometry(instance_);
      return true;
    });
    steps.push_back([this] { return (outer_ = rtcNewScene(device_)) != nullptr; });
    steps.push_back([this] { return Attach(outer_, instance_); });
    steps.push_back([this] { return Commit(outer_); });
    steps.push_back([this] { return TraceM(outer_, 3000); });
    steps.push_back([this] { return TraceOccluded(outer_, 3000); });
    steps.push_back([this] { return Trace16(outer_); });
    steps.push_back([this] { return QueryPoint(outer_); });

    steps.push_back([this] { return (points_ = New(RTC_GEOMETRY_TYPE_USER)) != nullptr; });
    steps.push_back([this] {
      rtcSetGeometryUserPrimitiveCount(points_, 100);
      rtcSetGeometryBoundsFunction(points_, Bound, nullptr);
      rtcCommitGeometry(points_);
      return true;
    });
    steps.push_back([this] { return (mixed_ = rtcNewScene(device_)) != nullptr; });
    steps.push_back([this] { return Attach(mixed_, mesh_); });
    steps.push_back([this] { return Attach(mixed_, points_); });
    steps.push_back([this] { return Commit(mixed_); });
    steps.push_back([this] { return TraceM(mixed_, 3000); });
    // A scene that keeps little, and its next commit.
    steps.push_back([this] {
      rtcSetSceneFlags(inner_, RTC_SCENE_FLAG_COMPACT);
      return Commit(inner_);
    });
    steps.push_back([this] { return TraceM(inner_, 3000); });
    steps.push_back([this] {
      rtcDetachGeometry(mixed_, 1);
      return true;
    });
    steps.push_back([this] { return Commit(mixed_); });
    return steps;
  }

  /// Takes the error, that of no device before there is one.
  RTCError TakeError() const { return rtcGetDeviceError(device_); }

  /// A call that is wrong, whatever memory there is.
  void MakeArgumentError() { rtcSetGeometryTimeStepCount(mesh_, 100000); }

  void Release() {
    for (const RTCScene scene : {inner_, outer_, mixed_}) rtcReleaseScene(scene);
    for (const RTCGeometry geometry : {mesh_, instance_, points_}) rtcReleaseGeometry(geometry);
    rtcReleaseBuffer(buffer_);
    rtcReleaseDevice(device_);
  }

 private:
  RTCGeometry New(RTCGeometryType type) { return rtcNewGeometry(device_, type); }

  static bool Attach(RTCScene scene, RTCGeometry geometry) {
    return rtcAttachGeometry(scene, geometry) != RTC_INVALID_GEOMETRY_ID;
  }

  static bool Commit(RTCScene scene) {
    rtcCommitScene(scene);
    return true;
  }

  static void Bound(const RTCBoundsFunctionArguments* args) {
    const float at = static_cast<float>(args->primID);
    *args->bounds_o = {at, 0, 50, 0, at + 1, 1, 51, 0};
  }

  bool TraceM(RTCScene scene, unsigned int count) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (unsigned int i = 0; i < count; ++i) rays_[i] = RayAt(7 * i % kTriangles);
    rtcIntersect1M(scene, &context, rays_, count, sizeof(RTCRayHit));
    bool all = true;
    for (unsigned int i = 0; i < count; ++i) all &= rays_[i].hit.primID == 7 * i % kTriangles;
    return all;
  }

  bool TraceOccluded(RTCScene scene, unsigned int count) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (unsigned int i = 0; i < count; ++i) rays_[i] = RayAt(5 * i % kTriangles);
    rtcOccluded1M(scene, &context, &rays_[0].ray, count, sizeof(RTCRayHit));
    bool all = true;
    for (unsigned int i = 0; i < count; ++i) all &= rays_[i].ray.tfar < 0;
    return all;
  }

  static bool Trace1(RTCScene scene) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray = RayAt(4321);
    rtcIntersect1(scene, &context, &ray);
    return ray.hit.primID == 4321;
  }

  static bool Trace16(RTCScene scene) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    alignas(64) int valid[16];
    alignas(64) RTCRayHit16 rays{};
    for (unsigned int i = 0; i < 16; ++i) {
      const RTCRayHit ray = RayAt(100 * i);
      valid[i] = -1;
      rays.ray.org_x[i] = ray.ray.org_x;
      rays.ray.org_y[i] = ray.ray.org_y;
      rays.ray.org_z[i] = ray.ray.org_z;
      rays.ray.dir_z[i] = ray.ray.dir_z;
      rays.ray.tfar[i] = ray.ray.tfar;
      rays.ray.mask[i] = ray.ray.mask;
      rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene, &context, &rays);
    bool all = true;
    for (unsigned int i = 0; i < 16; ++i) all &= rays.hit.primID[i] == 100 * i;
    return all;
  }

  static bool QueryPoint(RTCScene scene) {
    RTCPointQuery query{};
    query.x = query.y = 40.5f;
    query.radius = 3;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    std::size_t calls = 0;
    rtcPointQuery(
        scene, &query, &context,
        [](RTCPointQueryFunctionArguments* args) {
          ++*static_cast<std::size_t*>(args->userPtr);
          return false;
        },
        &calls);
    return calls > 20;
  }

  const char* const config_;
  std::vector<Vertex> vertices_;
  std::vector<unsigned int> indices_;
  RTCRayHit rays_[3000];
  RTCDevice device_ = nullptr;
  RTCBuffer buffer_ = nullptr;
  RTCGeometry mesh_ = nullptr, instance_ = nullptr, points_ = nullptr;
  RTCScene inner_ = nullptr, outer_ = nullptr, mixed_ = nullptr;
};

}  // namespace dacrt::tests

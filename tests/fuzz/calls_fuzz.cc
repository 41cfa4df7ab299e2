// Sequences of calls, with arguments from everywhere. Handles may be null or long gone, counts,
// strides, slots and enumerators are any; what the manual asks of a program and no library can
// check is kept: memory that is shared is there, and queries and interpolation, which do not look
// handles up, get such as are alive.
#include <embree3/rtcore.h>

#include <cstdlib>
#include <vector>

#include "input.h"

namespace dacrt::fuzz {
namespace {

constexpr std::size_t kSharedBytes = 1 << 14;
constexpr unsigned int kNumbers[] = {0,   1,   2,   3,     4,          16,
                                     100, 129, 130, 65536, 0x7FFFFFFF, UINT32_MAX};
constexpr std::size_t kSizes[] = {0,  1,  2,    3,          4,          12,           16,
                                  20, 64, 4096, UINT32_MAX, 1ull << 33, SIZE_MAX - 3, SIZE_MAX};

void Filter(const RTCFilterFunctionNArguments* args) {
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == -1 && RTCHitN_primID(args->hit, args->N, i) % 2 == 1) args->valid[i] = 0;
  }
}

void Bound(const RTCBoundsFunctionArguments* args) {
  const float at = static_cast<float>(args->primID);
  *args->bounds_o = {at, 0, 0, 0, at + 1, 1, 1, 0};
}

void Intersect(const RTCIntersectFunctionNArguments* args) {
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    RTCRayN* const ray = RTCRayHitN_RayN(args->rayhit, args->N);
    RTCHitN* const hit = RTCRayHitN_HitN(args->rayhit, args->N);
    RTCRayN_tfar(ray, args->N, i) *= 0.5f;
    RTCHitN_geomID(hit, args->N, i) = args->geomID;
    RTCHitN_primID(hit, args->N, i) = args->primID;
  }
}

void Occlude(const RTCOccludedFunctionNArguments* args) {
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == -1) RTCRayN_tfar(args->ray, args->N, i) = -1;
  }
}

bool Point(RTCPointQueryFunctionArguments* args) {
  args->query->radius *= 0.75f;
  return args->primID % 2 == 0;
}

class Program {
 public:
  explicit Program(Input input) : input_(input), device_(rtcNewDevice("threads=1")) {
    shared_.resize(kSharedBytes / sizeof(float));
    for (std::size_t i = 0; i < shared_.size(); ++i) shared_[i] = static_cast<float>(i * 7 % 11);
    for (RTCScene& scene : scenes_) scene = rtcNewScene(device_);
  }

  ~Program() {
    for (const RTCScene scene : scenes_) rtcReleaseScene(scene);
    for (std::size_t i = 0; i < kEach; ++i) {
      if (geometries_[i] && !geometry_gone_[i]) rtcReleaseGeometry(geometries_[i]);
      if (buffers_[i]) rtcReleaseBuffer(buffers_[i]);
    }
    rtcReleaseDevice(device_);
  }

  void Run() {
    while (!input_.IsEmpty()) Step();
  }

 private:
  static constexpr std::size_t kEach = 5;

  void Step() {
    const std::size_t g = input_.Below(kEach);
    const RTCGeometry geometry = geometries_[g];
    const RTCScene scene = scenes_[input_.Below(kScenes)];
    switch (input_.Below(30)) {
      case 0:
        if (!geometries_[g] || geometry_gone_[g]) {
          geometries_[g] = rtcNewGeometry(device_, TakeType());
          geometry_gone_[g] = false;
        }
        return;
      case 1:
        // The handle stays in use: a scene may keep it alive, or it is gone.
        if (geometry && !geometry_gone_[g]) {
          rtcReleaseGeometry(geometry);
          geometry_gone_[g] = true;
        }
        return;
      case 2:
        if (!buffers_[g]) buffers_[g] = rtcNewBuffer(device_, input_.OneOf(kSizes));
        return;
      case 3:
        return rtcSetGeometryBuffer(geometry, TakeBuffer(), TakeNumber(), TakeFormat(), buffers_[g],
                                    input_.OneOf(kSizes), input_.OneOf(kSizes),
                                    input_.OneOf(kSizes));
      case 4:
        return SetShared(geometry);
      case 5:
        return SetNew(geometry);
      case 6:
        rtcGetGeometryBufferData(geometry, TakeBuffer(), TakeNumber());
        return;
      case 7:
        return rtcUpdateGeometryBuffer(geometry, TakeBuffer(), TakeNumber());
      case 8:
        return rtcSetGeometryVertexAttributeCount(geometry, TakeNumber() % 200);
      case 9:
        return rtcSetGeometryTimeStepCount(geometry, TakeNumber());
      case 10:
        return rtcSetGeometryTimeRange(geometry, input_.Take<float>(), input_.Take<float>());
      case 11:
        return rtcSetGeometryMask(geometry, TakeNumber());
      case 12:
        return rtcSetGeometryBuildQuality(geometry, static_cast<RTCBuildQuality>(TakeNumber()));
      case 13:
        rtcSetGeometryUserPrimitiveCount(geometry, TakeNumber() % 300);
        rtcSetGeometryBoundsFunction(geometry, input_.Below(4) ? Bound : nullptr, nullptr);
        rtcSetGeometryIntersectFunction(geometry, input_.Below(4) ? Intersect : nullptr);
        return rtcSetGeometryOccludedFunction(geometry, input_.Below(4) ? Occlude : nullptr);
      case 14:
        rtcSetGeometryIntersectFilterFunction(geometry, input_.Below(2) ? Filter : nullptr);
        return rtcSetGeometryOccludedFilterFunction(geometry, input_.Below(2) ? Filter : nullptr);
      case 15:
        return rtcSetGeometryInstancedScene(geometry, scenes_[input_.Below(kScenes)]);
      case 16:
        return SetTransform(geometry);
      case 17:
      case 18:
        return rtcCommitGeometry(geometry);
      case 19:
        return input_.Below(2) ? rtcEnableGeometry(geometry) : rtcDisableGeometry(geometry);
      case 20:
        rtcAttachGeometry(scene, geometry);
        return;
      case 21:
        return rtcAttachGeometryByID(scene, geometry, TakeNumber());
      case 22:
        return rtcDetachGeometry(scene, input_.Below(4) ? input_.Below(8) : TakeNumber());
      case 23:
        return rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(input_.Take<uint8_t>() & 31));
      case 24:
        return rtcSetSceneBuildQuality(scene, static_cast<RTCBuildQuality>(TakeNumber()));
      case 25:
        rtcCommitScene(scene);
        return CheckBounds(scene);
      case 26:
        return Interpolate(geometry_gone_[g] ? nullptr : geometry);
      case 27:
        rtcGetDeviceProperty(device_, static_cast<RTCDeviceProperty>(TakeNumber()));
        rtcGetDeviceError(device_);
        return;
      case 28:
        return QueryPoint(scene);
      default:
        return Trace(scene);
    }
  }

  unsigned int TakeNumber() {
    return input_.Below(2) ? input_.OneOf(kNumbers) : input_.Take<uint8_t>();
  }

  RTCGeometryType TakeType() {
    static constexpr RTCGeometryType kTypes[] = {RTC_GEOMETRY_TYPE_TRIANGLE,
                                                 RTC_GEOMETRY_TYPE_QUAD,
                                                 RTC_GEOMETRY_TYPE_GRID,
                                                 RTC_GEOMETRY_TYPE_SPHERE_POINT,
                                                 RTC_GEOMETRY_TYPE_DISC_POINT,
                                                 RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT,
                                                 RTC_GEOMETRY_TYPE_USER,
                                                 RTC_GEOMETRY_TYPE_INSTANCE,
                                                 RTC_GEOMETRY_TYPE_SUBDIVISION,
                                                 static_cast<RTCGeometryType>(77),
                                                 RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE};
    return input_.OneOf(kTypes);
  }

  RTCBufferType TakeBuffer() {
    static constexpr RTCBufferType kTypes[] = {
        RTC_BUFFER_TYPE_INDEX,          RTC_BUFFER_TYPE_VERTEX, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE,
        RTC_BUFFER_TYPE_NORMAL,         RTC_BUFFER_TYPE_GRID,   RTC_BUFFER_TYPE_FLAGS,
        static_cast<RTCBufferType>(200)};
    return input_.OneOf(kTypes);
  }

  RTCFormat TakeFormat() {
    static constexpr RTCFormat kFormats[] = {
        RTC_FORMAT_UINT3,   RTC_FORMAT_UINT4,         RTC_FORMAT_FLOAT3, RTC_FORMAT_FLOAT4,
        RTC_FORMAT_GRID,    RTC_FORMAT_FLOAT,         RTC_FORMAT_UINT,   RTC_FORMAT_FLOAT2,
        RTC_FORMAT_FLOAT16, static_cast<RTCFormat>(0)};
    return input_.OneOf(kFormats);
  }

  /// Memory that is there, or null.
  void SetShared(RTCGeometry geometry) {
    const RTCBufferType type = TakeBuffer();
    const RTCFormat format = TakeFormat();
    const unsigned int slot = TakeNumber();
    const std::size_t stride = input_.Below(80);
    constexpr std::size_t kLastItem = 64;
    const std::size_t most = stride ? (kSharedBytes - kLastItem) / stride : 200;
    const std::size_t count = std::min<std::size_t>(input_.Take<uint8_t>(), most);
    void* const data = input_.Below(8) ? shared_.data() : nullptr;
    rtcSetSharedGeometryBuffer(geometry, type, slot, format, data, 0, stride, count);
  }

  void SetNew(RTCGeometry geometry) {
    const RTCBufferType type = TakeBuffer();
    const RTCFormat format = TakeFormat();
    const unsigned int slot = TakeNumber();
    const std::size_t stride = input_.OneOf(kSizes);
    const std::size_t count = input_.Below(4) ? input_.Take<uint8_t>() : input_.OneOf(kSizes);
    void* const data = rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count);
    // Any bytes; what is not written is zero, as it may be anything.
    if (!data || stride * count > kSharedBytes) return;
    auto* const bytes = static_cast<uint8_t*>(data);
    for (std::size_t i = 0; i < stride * count; ++i) {
      bytes[i] = i % 4 == 0 || input_.Below(8) == 0 ? input_.Take<uint8_t>() : 0;
    }
    // Rows of a grid may be the same vertices: then a few bytes ask for a billion cells.
    for (std::size_t i = 0; type == RTC_BUFFER_TYPE_GRID && i < count && stride >= 12; ++i) {
      bytes[i * stride + 9] = bytes[i * stride + 11] = 0;
    }
  }

  void SetTransform(RTCGeometry geometry) {
    float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    matrix[input_.Below(16)] = input_.Take<float>();
    RTCQuaternionDecomposition parts;
    rtcInitQuaternionDecomposition(&parts);
    parts.quaternion_i = input_.Take<float>();
    const unsigned int step = TakeNumber();
    if (input_.Below(2)) return rtcSetGeometryTransformQuaternion(geometry, step, &parts);
    static constexpr RTCFormat kFormats[] = {RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                                             RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                             RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, RTC_FORMAT_FLOAT};
    rtcSetGeometryTransform(geometry, step, input_.OneOf(kFormats), matrix);
    rtcGetGeometryTransform(geometry, input_.Take<float>(), RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                            matrix);
  }

  void Interpolate(RTCGeometry geometry) {
    float p[16], du[16], dv[16];
    RTCInterpolateArguments args{};
    args.geometry = geometry;
    args.primID = TakeNumber();
    args.u = input_.Take<float>();
    args.v = input_.Take<float>();
    args.bufferType = TakeBuffer();
    args.bufferSlot = TakeNumber();
    args.P = p;
    args.dPdu = input_.Below(2) ? du : nullptr;
    args.dPdv = args.dPdu ? dv : nullptr;
    args.valueCount = input_.Below(17);
    rtcInterpolate(&args);
  }

  void CheckBounds(RTCScene scene) {
    RTCBounds bounds;
    RTCLinearBounds linear;
    rtcGetSceneBounds(scene, &bounds);
    rtcGetSceneLinearBounds(scene, &linear);
  }

  void QueryPoint(RTCScene scene) {
    RTCPointQuery query{};
    query.x = input_.Take<float>();
    query.radius = input_.Take<float>();
    query.time = input_.Take<float>();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, Point, nullptr);
  }

  void Trace(RTCScene scene) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = static_cast<RTCIntersectContextFlags>(input_.Below(4));
    if (input_.Below(4) == 0) context.filter = Filter;
    const unsigned int count = input_.Below(40);
    std::vector<RTCRayHit> rays(count + 1);  // The last one is a canary.
    for (RTCRayHit& ray : rays) {
      ray = {};
      ray.ray.org_x = static_cast<float>(input_.Below(16)) * 0.5f;
      ray.ray.org_y = 0.3f;
      ray.ray.org_z = -5;
      ray.ray.dir_x = 0.01f * static_cast<float>(input_.Below(8));
      ray.ray.dir_z = 1;
      ray.ray.tfar = 100;
      ray.ray.time = 0.125f * static_cast<float>(input_.Below(9));
      ray.ray.mask = UINT32_MAX;
      ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    const RTCRayHit canary = rays.back();
    if (count == 1) {
      rtcIntersect1(scene, &context, rays.data());
    } else {
      rtcIntersect1M(scene, &context, rays.data(), count, sizeof(RTCRayHit));
    }
    rtcOccluded1M(scene, &context, &rays[0].ray, count, sizeof(RTCRayHit));
    if (std::memcmp(&canary, &rays.back(), sizeof(canary)) != 0) std::abort();
  }

  static constexpr std::size_t kScenes = 3;
  Input input_;
  const RTCDevice device_;
  RTCScene scenes_[kScenes] = {};
  RTCGeometry geometries_[kEach] = {};
  bool geometry_gone_[kEach] = {};
  RTCBuffer buffers_[kEach] = {};
  std::vector<float> shared_;
};

}  // namespace
}  // namespace dacrt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, std::size_t count) {
  dacrt::fuzz::Program(dacrt::fuzz::Input(bytes, count)).Run();
  return 0;
}

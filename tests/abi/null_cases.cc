#include "error_cases.h"

namespace dacrt::tests {

std::vector<Case> NullHandles() {
  static RTCBounds bounds;
  static RTCLinearBounds linear_bounds;
  static float floats[16];
  return {
      OnThread("rtcRetainDevice", "null", [](auto& s) { s.api.rtcRetainDevice(nullptr); }),
      OnThread("rtcReleaseDevice", "null", [](auto& s) { s.api.rtcReleaseDevice(nullptr); }),
      OnThread("rtcGetDeviceProperty", "null",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcGetDeviceProperty(nullptr, RTC_DEVICE_PROPERTY_VERSION), 0);
               }),
      OnThread(
          "rtcSetDeviceProperty", "null",
          [](auto& s) { s.api.rtcSetDeviceProperty(nullptr, RTC_DEVICE_PROPERTY_VERSION, 1); }),
      OnThread("rtcSetDeviceErrorFunction", "null",
               [](auto& s) { s.api.rtcSetDeviceErrorFunction(nullptr, nullptr, nullptr); }),
      OnThread(
          "rtcSetDeviceMemoryMonitorFunction", "null",
          [](auto& s) { s.api.rtcSetDeviceMemoryMonitorFunction(nullptr, nullptr, nullptr); },
          Real::kCrashes),
      OnThread("rtcNewBuffer", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewBuffer(nullptr, 16), nullptr); }),
      OnThread("rtcNewSharedBuffer", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewSharedBuffer(nullptr, floats, 16), nullptr); }),
      OnThread("rtcGetBufferData", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetBufferData(nullptr), nullptr); }),
      OnThread("rtcRetainBuffer", "null", [](auto& s) { s.api.rtcRetainBuffer(nullptr); }),
      OnThread("rtcReleaseBuffer", "null", [](auto& s) { s.api.rtcReleaseBuffer(nullptr); }),
      OnThread("rtcNewGeometry", "null device",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcNewGeometry(nullptr, RTC_GEOMETRY_TYPE_TRIANGLE), nullptr);
               }),
      OnThread("rtcRetainGeometry", "null", [](auto& s) { s.api.rtcRetainGeometry(nullptr); }),
      OnThread("rtcReleaseGeometry", "null", [](auto& s) { s.api.rtcReleaseGeometry(nullptr); }),
      OnThread("rtcCommitGeometry", "null", [](auto& s) { s.api.rtcCommitGeometry(nullptr); }),
      OnThread("rtcEnableGeometry", "null", [](auto& s) { s.api.rtcEnableGeometry(nullptr); }),
      OnThread("rtcDisableGeometry", "null", [](auto& s) { s.api.rtcDisableGeometry(nullptr); }),
      OnThread("rtcSetGeometryTimeStepCount", "null",
               [](auto& s) { s.api.rtcSetGeometryTimeStepCount(nullptr, 1); }),
      OnThread("rtcSetGeometryTimeRange", "null",
               [](auto& s) { s.api.rtcSetGeometryTimeRange(nullptr, 0, 1); }),
      OnThread("rtcSetGeometryVertexAttributeCount", "null",
               [](auto& s) { s.api.rtcSetGeometryVertexAttributeCount(nullptr, 1); }),
      OnThread("rtcSetGeometryMask", "null", [](auto& s) { s.api.rtcSetGeometryMask(nullptr, 1); }),
      OnThread("rtcSetGeometryBuildQuality", "null",
               [](auto& s) { s.api.rtcSetGeometryBuildQuality(nullptr, RTC_BUILD_QUALITY_LOW); }),
      OnThread("rtcSetGeometryMaxRadiusScale", "null",
               [](auto& s) { s.api.rtcSetGeometryMaxRadiusScale(nullptr, 1); }),
      OnThread("rtcSetGeometryBuffer", "null geometry",
               [](auto& s) {
                 s.api.rtcSetGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            s.NewBuffer(64), 0, 12, 4);
               }),
      OnThread("rtcSetSharedGeometryBuffer", "null geometry",
               [](auto& s) {
                 s.api.rtcSetSharedGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0,
                                                  RTC_FORMAT_FLOAT3, floats, 0, 12, 4);
               }),
      OnThread("rtcSetNewGeometryBuffer", "null geometry",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcSetNewGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0,
                                                         RTC_FORMAT_FLOAT3, 12, 4),
                           nullptr);
               }),
      OnThread("rtcGetGeometryBufferData", "null geometry",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcGetGeometryBufferData(nullptr, RTC_BUFFER_TYPE_VERTEX, 0),
                           nullptr);
               }),
      OnThread("rtcUpdateGeometryBuffer", "null geometry",
               [](auto& s) { s.api.rtcUpdateGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0); }),
      OnThread("rtcSetGeometryIntersectFilterFunction", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryIntersectFilterFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryOccludedFilterFunction", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryOccludedFilterFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryPointQueryFunction", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryPointQueryFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryUserData", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryUserData(nullptr, floats); }),
      OnThread("rtcGetGeometryUserData", "null geometry",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometryUserData(nullptr), nullptr); }),
      OnThread("rtcNewScene", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewScene(nullptr), nullptr); }),
      OnThread("rtcGetSceneDevice", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetSceneDevice(nullptr), nullptr); }),
      OnThread("rtcRetainScene", "null", [](auto& s) { s.api.rtcRetainScene(nullptr); }),
      OnThread("rtcReleaseScene", "null", [](auto& s) { s.api.rtcReleaseScene(nullptr); }),
      OnThread("rtcAttachGeometry", "null scene",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcAttachGeometry(nullptr, s.Triangle()), RTC_INVALID_GEOMETRY_ID);
               }),
      OnThread("rtcAttachGeometryByID", "null scene",
               [](auto& s) { s.api.rtcAttachGeometryByID(nullptr, s.Triangle(), 0); }),
      OnThread("rtcDetachGeometry", "null scene",
               [](auto& s) { s.api.rtcDetachGeometry(nullptr, 0); }),
      OnThread(
          "rtcGetGeometry", "null scene",
          [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometry(nullptr, 0), nullptr); }, Real::kCrashes),
      OnThread(
          "rtcGetGeometryThreadSafe", "null scene",
          [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometryThreadSafe(nullptr, 0), nullptr); },
          Real::kCrashes),
      OnThread("rtcCommitScene", "null", [](auto& s) { s.api.rtcCommitScene(nullptr); }),
      OnThread("rtcJoinCommitScene", "null", [](auto& s) { s.api.rtcJoinCommitScene(nullptr); }),
      OnThread(
          "rtcSetSceneProgressMonitorFunction", "null",
          [](auto& s) { s.api.rtcSetSceneProgressMonitorFunction(nullptr, nullptr, nullptr); }),
      OnThread("rtcSetSceneBuildQuality", "null",
               [](auto& s) { s.api.rtcSetSceneBuildQuality(nullptr, RTC_BUILD_QUALITY_LOW); }),
      OnThread("rtcSetSceneFlags", "null",
               [](auto& s) { s.api.rtcSetSceneFlags(nullptr, RTC_SCENE_FLAG_NONE); }),
      OnThread("rtcGetSceneFlags", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetSceneFlags(nullptr), RTC_SCENE_FLAG_NONE); }),
      OnThread("rtcGetSceneBounds", "null",
               [](auto& s) { s.api.rtcGetSceneBounds(nullptr, &bounds); }),
      OnThread("rtcGetSceneLinearBounds", "null",
               [](auto& s) { s.api.rtcGetSceneLinearBounds(nullptr, &linear_bounds); }),
      OnDevice("rtcSetGeometryBuffer", "null buffer", kArgument,
               [](auto& s) {
                 s.api.rtcSetGeometryBuffer(s.Triangle(), RTC_BUFFER_TYPE_VERTEX, 0,
                                            RTC_FORMAT_FLOAT3, nullptr, 0, 12, 4);
               }),
      OnDevice("rtcAttachGeometry", "null geometry", kArgument,
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcAttachGeometry(s.NewScene(), nullptr), RTC_INVALID_GEOMETRY_ID);
               }),
      OnDevice("rtcAttachGeometryByID", "null geometry", kArgument,
               [](auto& s) { s.api.rtcAttachGeometryByID(s.NewScene(), nullptr, 0); }),
  };
}

std::vector<Case> NullGeometries() {
  static float matrix[16];
  static RTCQuaternionDecomposition quaternion;
  return {
      OnThread("rtcSetGeometryUserPrimitiveCount", "null",
               [](auto& s) { s.api.rtcSetGeometryUserPrimitiveCount(nullptr, 1); }),
      OnThread("rtcSetGeometryBoundsFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryBoundsFunction(nullptr, nullptr, nullptr); }),
      OnThread("rtcSetGeometryIntersectFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryIntersectFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryOccludedFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryOccludedFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryInstancedScene", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryInstancedScene(nullptr, s.NewScene()); }),
      OnThread("rtcSetGeometryTransform", "null geometry",
               [](auto& s) {
                 s.api.rtcSetGeometryTransform(nullptr, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
               }),
      OnThread("rtcSetGeometryTransformQuaternion", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryTransformQuaternion(nullptr, 0, &quaternion); }),
      OnlyOurs("rtcGetGeometryTransform", "null geometry",
               [](auto& s) {
                 s.api.rtcGetGeometryTransform(nullptr, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
               }),
      OnDevice(
          "rtcGetGeometryTransform", "null matrix of an instance", kArgument,
          [](auto& s) {
            s.api.rtcGetGeometryTransform(Model(s, RTC_GEOMETRY_TYPE_INSTANCE), 0,
                                          RTC_FORMAT_FLOAT3X4_ROW_MAJOR, nullptr);
          },
          Real::kCrashes),
      OnThread("rtcSetGeometryTessellationRate", "null",
               [](auto& s) { s.api.rtcSetGeometryTessellationRate(nullptr, 1); }),
      OnThread("rtcSetGeometryTopologyCount", "null",
               [](auto& s) { s.api.rtcSetGeometryTopologyCount(nullptr, 1); }),
      OnThread("rtcSetGeometrySubdivisionMode", "null",
               [](auto& s) {
                 s.api.rtcSetGeometrySubdivisionMode(nullptr, 0, RTC_SUBDIVISION_MODE_PIN_ALL);
               }),
      OnThread("rtcSetGeometryVertexAttributeTopology", "null",
               [](auto& s) { s.api.rtcSetGeometryVertexAttributeTopology(nullptr, 0, 0); }),
      OnThread("rtcSetGeometryDisplacementFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryDisplacementFunction(nullptr, nullptr); }),
      OnlyOurs("rtcGetGeometryFirstHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryFirstHalfEdge(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryFace", "null", [](auto& s) { s.api.rtcGetGeometryFace(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryNextHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryNextHalfEdge(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryPreviousHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryPreviousHalfEdge(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryOppositeHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryOppositeHalfEdge(nullptr, 0, 0); }),
  };
}

std::vector<Case> NullPointers() {
  static RTCInterpolateArguments interpolate{};
  static RTCInterpolateNArguments interpolate_n{};
  static RTCIntersectFunctionNArguments intersect_args{};
  static RTCOccludedFunctionNArguments occluded_args{};
  return {
      OnlyOurs("rtcFilterIntersection", "null",
               [](auto& s) { s.api.rtcFilterIntersection(nullptr, nullptr); }),
      OnlyOurs("rtcFilterIntersection", "null filter arguments",
               [](auto& s) { s.api.rtcFilterIntersection(&intersect_args, nullptr); }),
      OnlyOurs("rtcFilterOcclusion", "null",
               [](auto& s) { s.api.rtcFilterOcclusion(nullptr, nullptr); }),
      OnlyOurs("rtcFilterOcclusion", "null filter arguments",
               [](auto& s) { s.api.rtcFilterOcclusion(&occluded_args, nullptr); }),
      OnlyOurs("rtcInterpolate", "null", [](auto& s) { s.api.rtcInterpolate(nullptr); }),
      OnlyOurs("rtcInterpolate", "null geometry",
               [](auto& s) { s.api.rtcInterpolate(&interpolate); }),
      OnlyOurs("rtcInterpolateN", "null", [](auto& s) { s.api.rtcInterpolateN(nullptr); }),
      OnlyOurs("rtcInterpolateN", "null geometry",
               [](auto& s) { s.api.rtcInterpolateN(&interpolate_n); }),
      OnlyOurs("rtcPointQuery", "null",
               [](auto& s) { s.api.rtcPointQuery(nullptr, nullptr, nullptr, nullptr, nullptr); }),
      OnlyOurs("rtcPointQuery4", "null",
               [](auto& s) {
                 s.api.rtcPointQuery4(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
               }),
      OnlyOurs("rtcPointQuery8", "null",
               [](auto& s) {
                 s.api.rtcPointQuery8(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
               }),
      OnlyOurs("rtcPointQuery16", "null",
               [](auto& s) {
                 s.api.rtcPointQuery16(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
               }),
      OnlyOurs("rtcCollide", "null",
               [](auto& s) { s.api.rtcCollide(nullptr, nullptr, nullptr, nullptr); }),
      OnThread("rtcNewBVH", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewBVH(nullptr), nullptr); }),
      OnlyOurs("rtcBuildBVH", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcBuildBVH(nullptr), nullptr); }),
      OnlyOurs("rtcThreadLocalAlloc", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcThreadLocalAlloc(nullptr, 8, 8), nullptr); }),
      OnThread("rtcRetainBVH", "null", [](auto& s) { s.api.rtcRetainBVH(nullptr); }),
      OnThread("rtcReleaseBVH", "null", [](auto& s) { s.api.rtcReleaseBVH(nullptr); }),
      OnlyOurs("rtcMakeStaticBVH", "null", [](auto& s) { s.api.rtcMakeStaticBVH(nullptr); }),
  };
}

}  // namespace dacrt::tests

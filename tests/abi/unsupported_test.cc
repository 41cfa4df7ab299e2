// What the drop-in does not do: every such function is there, says so, and crashes on nothing.
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

/// The only error that the session's device was told of, which it no longer has.
void ExpectRefusal(Session& s, const std::string& function, const std::string& what = "") {
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION) << function;
  ASSERT_EQ(s.reports.size(), 1u) << function;
  EXPECT_TRUE(s.reports[0].message.starts_with(function + ": ")) << s.reports[0].message;
  EXPECT_NE(s.reports[0].message.find(what), std::string::npos) << s.reports[0].message;
  s.reports.clear();
}

TEST(Unsupported, GeometryTypesAreNamed) {
  Session s(DropIn());
  const std::pair<RTCGeometryType, const char*> types[] = {
      {RTC_GEOMETRY_TYPE_SUBDIVISION, "subdivision surface"},
      {RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE, "linear curve"},
      {RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE, "Bezier curve"},
      {RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE, "B-spline curve"},
      {RTC_GEOMETRY_TYPE_ROUND_HERMITE_CURVE, "Hermite curve"},
      {RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE, "Catmull-Rom curve"}};
  for (const auto& [type, name] : types) {
    EXPECT_EQ(s.api.rtcNewGeometry(s.device, type), nullptr);
    ExpectRefusal(s, "rtcNewGeometry", name);
  }
}

TEST(Unsupported, PropertiesTellTheTruth) {
  Session s(DropIn());
  for (const RTCDeviceProperty property : {RTC_DEVICE_PROPERTY_SUBDIVISION_GEOMETRY_SUPPORTED,
                                           RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED}) {
    EXPECT_EQ(s.api.rtcGetDeviceProperty(s.device, property), 0) << property;
  }
}

TEST(Unsupported, FunctionsOfAGeometryOrSceneNameThemselves) {
  Session s(DropIn());
  const Api& api = s.api;
  const RTCGeometry g = s.Triangle();
  const RTCScene scene = s.SceneOf(g);
  constexpr unsigned int kNoHalfEdge = ~0u;

  const std::pair<const char*, std::function<void()>> calls[] = {
      {"rtcSetGeometryMaxRadiusScale", [&] { api.rtcSetGeometryMaxRadiusScale(g, 1); }},
      {"rtcSetGeometryTessellationRate", [&] { api.rtcSetGeometryTessellationRate(g, 1); }},
      {"rtcSetGeometryTopologyCount", [&] { api.rtcSetGeometryTopologyCount(g, 1); }},
      {"rtcSetGeometrySubdivisionMode",
       [&] { api.rtcSetGeometrySubdivisionMode(g, 0, RTC_SUBDIVISION_MODE_PIN_ALL); }},
      {"rtcSetGeometryVertexAttributeTopology",
       [&] { api.rtcSetGeometryVertexAttributeTopology(g, 0, 0); }},
      {"rtcSetGeometryDisplacementFunction",
       [&] { api.rtcSetGeometryDisplacementFunction(g, nullptr); }},
      {"rtcGetGeometryFirstHalfEdge",
       [&] { EXPECT_EQ(api.rtcGetGeometryFirstHalfEdge(g, 0), kNoHalfEdge); }},
      {"rtcGetGeometryFace", [&] { EXPECT_EQ(api.rtcGetGeometryFace(g, 0), kNoHalfEdge); }},
      {"rtcGetGeometryNextHalfEdge",
       [&] { EXPECT_EQ(api.rtcGetGeometryNextHalfEdge(g, 0), kNoHalfEdge); }},
      {"rtcGetGeometryPreviousHalfEdge",
       [&] { EXPECT_EQ(api.rtcGetGeometryPreviousHalfEdge(g, 0), kNoHalfEdge); }},
      {"rtcGetGeometryOppositeHalfEdge",
       [&] { EXPECT_EQ(api.rtcGetGeometryOppositeHalfEdge(g, 0, 0), kNoHalfEdge); }},
      {"rtcCollide", [&] { api.rtcCollide(scene, scene, nullptr, nullptr); }},
      {"rtcNewBVH", [&] { EXPECT_EQ(api.rtcNewBVH(s.device), nullptr); }},
  };
  for (const auto& [function, call] : calls) {
    call();
    ExpectRefusal(s, function, "dacrt does not support ");
  }
}

TEST(Unsupported, FunctionsWithoutAHandleReportToTheThread) {
  const Api& api = DropIn();
  RTCBuildArguments build = rtcDefaultBuildArguments();
  char memory[8];
  const auto bvh = reinterpret_cast<RTCBVH>(memory);
  const std::function<void()> calls[] = {
      [&] { EXPECT_EQ(api.rtcBuildBVH(&build), nullptr); },
      [&] {
        const auto allocator = reinterpret_cast<RTCThreadLocalAllocator>(memory);
        EXPECT_EQ(api.rtcThreadLocalAlloc(allocator, 8, 8), nullptr);
      },
      [&] { api.rtcRetainBVH(bvh); },
      [&] { api.rtcReleaseBVH(bvh); },
      [&] { api.rtcMakeStaticBVH(bvh); },
  };
  for (const auto& call : calls) {
    call();
    EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_OPERATION);
  }
}

}  // namespace
}  // namespace dacrt::tests

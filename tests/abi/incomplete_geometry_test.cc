// Geometries that are committed before they have all that they need: what is found and what is said
// is the real library's; what it crashes with is an error of the drop-in's.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "model.h"

namespace dacrt::tests {
namespace {

/// What a geometry is made of before it is committed for the first time.
struct Part {
  std::string name;
  std::function<void(Session&, RTCGeometry, RTCGeometryType)> make;
};

std::vector<Part> Parts() {
  const auto steps = [](unsigned int count) {
    return [=](Session& s, RTCGeometry g) { s.api.rtcSetGeometryTimeStepCount(g, count); };
  };
  return {
      {"nothing", [](auto&, auto, auto) {}},
      {"no vertices", [](auto& s, auto g, auto t) { SetPrimitives(s, g, t); }},
      {"no primitives", [](auto& s, auto g, auto t) { SetVertices(s, g, t, 0); }},
      {"nothing of two steps", [=](auto& s, auto g, auto) { steps(2)(s, g); }},
      {"no vertices of two steps",
       [=](auto& s, auto g, auto t) {
         steps(2)(s, g);
         SetPrimitives(s, g, t);
       }},
      {"the first of two steps",
       [=](auto& s, auto g, auto t) {
         steps(2)(s, g);
         SetVertices(s, g, t, 0);
         SetPrimitives(s, g, t);
       }},
      {"the last of 129 steps",
       [=](auto& s, auto g, auto t) {
         steps(129)(s, g);
         SetVertices(s, g, t, 128);
         SetPrimitives(s, g, t);
       }},
      {"two strides",
       [=](auto& s, auto g, auto t) {
         steps(2)(s, g);
         SetVertices(s, g, t, 0, 0, 4, 4);
         SetVertices(s, g, t, 1, 0, 4, 8);
         SetPrimitives(s, g, t);
       }},
      {"more vertices in the second step",
       [=](auto& s, auto g, auto t) {
         steps(2)(s, g);
         SetVertices(s, g, t, 0, 0, 4);
         SetVertices(s, g, t, 1, 0, 6);
         SetPrimitives(s, g, t);
       }},
      {"attributes that are not set",
       [=](auto& s, auto g, auto t) {
         SetVertices(s, g, t, 0);
         SetPrimitives(s, g, t);
         s.api.rtcSetGeometryVertexAttributeCount(g, 2);
       }},
      {"two steps, then one",
       [=](auto& s, auto g, auto t) {
         SetVertices(s, g, t, 0);
         SetPrimitives(s, g, t);
         steps(2)(s, g);
         steps(1)(s, g);
       }},
  };
}

std::vector<RTCGeometryType> TypesWithBuffers() {
  std::vector<RTCGeometryType> types;
  std::copy_if(std::begin(kSupportedTypes), std::end(kSupportedTypes), std::back_inserter(types),
               HasBuffers);
  return types;
}

class IncompleteGeometry : public testing::TestWithParam<RTCGeometryType> {};
INSTANTIATE_TEST_SUITE_P(, IncompleteGeometry, testing::ValuesIn(TypesWithBuffers()),
                         [](const auto& info) { return NameOf(info.param); });

TEST_P(IncompleteGeometry, IsCommitted) {
  for (const Part& part : Parts()) {
    RTCError codes[2][2];
    unsigned int hits[2];
    for (const Api* const api : {&RealEmbree(), &DropIn()}) {
      const bool is_ours = api == &DropIn();
      Session s(*api);
      const RTCGeometry geometry = s.Own(api->rtcNewGeometry(s.device, GetParam()));
      part.make(s, geometry, GetParam());
      ASSERT_EQ(s.TakeError(), RTC_ERROR_NONE) << part.name;
      api->rtcCommitGeometry(geometry);
      codes[is_ours][0] = s.TakeError();
      const RTCScene scene = s.SceneOf(geometry);
      codes[is_ours][1] = s.TakeError();
      hits[is_ours] = s.HitGeometry(scene);
    }
    EXPECT_EQ(codes[1][0], codes[0][0]) << part.name;
    EXPECT_EQ(codes[1][1], codes[0][1]) << part.name;
    EXPECT_EQ(hits[1], hits[0]) << part.name;
  }
}

// The real library crashes with these.

/// The message of the only error, which is RTC_ERROR_INVALID_OPERATION.
std::string TakeMessage(Session& s) {
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION);
  if (s.reports.size() != 1) return "there are " + std::to_string(s.reports.size()) + " errors";
  const std::string message = s.reports[0].message;
  s.reports.clear();
  return message;
}

TEST(DropInGeometry, NoTimeStepsAreRefused) {
  for (const RTCGeometryType type : kSupportedTypes) {
    Session s(DropIn());
    const RTCGeometry geometry = UncommittedModel(s, type);
    s.api.rtcSetGeometryTimeStepCount(geometry, 0);
    s.api.rtcCommitGeometry(geometry);
    EXPECT_EQ(TakeMessage(s), "rtcCommitGeometry: geometry has no time steps") << NameOf(type);
  }
}

TEST(DropInGeometry, MissingNormalsAreRefused) {
  Session s(DropIn());
  const RTCGeometryType type = RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT;
  const RTCGeometry geometry = UncommittedModel(s, type);
  s.api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3, 12, 3);
  s.api.rtcCommitGeometry(geometry);
  EXPECT_EQ(TakeMessage(s),
            "rtcCommitGeometry: the NORMAL buffer in slot 0 has 3 items for 4 vertices");
}

TEST(DropInGeometry, AUserGeometryNeedsABoundsFunction) {
  Session s(DropIn());
  const RTCGeometry geometry = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryBoundsFunction(geometry, nullptr, nullptr);
  s.api.rtcCommitGeometry(geometry);
  s.SceneOf(geometry);
  EXPECT_EQ(TakeMessage(s), "rtcCommitScene: the geometry with geomID = 0 has no bounds function");
}

TEST(DropInGeometry, AnInstanceNeedsAScene) {
  Session s(DropIn());
  const RTCGeometry instance = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE));
  s.api.rtcCommitGeometry(instance);
  s.SceneOf(instance);
  EXPECT_EQ(TakeMessage(s), "rtcCommitScene: the geometry with geomID = 0 has no instanced scene");
}

}  // namespace
}  // namespace dacrt::tests

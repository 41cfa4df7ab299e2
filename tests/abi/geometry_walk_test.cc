// Every function of a geometry with every type of one, and with bad arguments: the drop-in's codes
// are the real library's, also those of a commit that follows.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "model.h"

namespace dacrt::tests {
namespace {

class GeometryWalk : public testing::TestWithParam<RTCGeometryType> {};
INSTANTIATE_TEST_SUITE_P(, GeometryWalk, testing::ValuesIn(kSupportedTypes),
                         [](const auto& info) { return NameOf(info.param); });

constexpr RTCFormat kMatrix = RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR;
constexpr auto kLast = std::numeric_limits<unsigned int>::max();

/// Arguments that can be wrong in many ways at once.
struct Setting {
  int type;
  unsigned int slot;
  int format;
  std::size_t offset, stride, count;

  std::string Text() const {
    return "type " + std::to_string(type) + ", slot " + std::to_string(slot) + ", format " +
           std::to_string(format) + ", offset " + std::to_string(offset) + ", stride " +
           std::to_string(stride) + ", count " + std::to_string(count);
  }
};

constexpr int kBufferTypes[] = {-1,
                                RTC_BUFFER_TYPE_INDEX,
                                RTC_BUFFER_TYPE_VERTEX,
                                RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE,
                                RTC_BUFFER_TYPE_NORMAL,
                                RTC_BUFFER_TYPE_TANGENT,
                                RTC_BUFFER_TYPE_NORMAL_DERIVATIVE,
                                RTC_BUFFER_TYPE_GRID,
                                RTC_BUFFER_TYPE_FACE,
                                RTC_BUFFER_TYPE_LEVEL,
                                RTC_BUFFER_TYPE_EDGE_CREASE_INDEX,
                                RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT,
                                RTC_BUFFER_TYPE_HOLE,
                                RTC_BUFFER_TYPE_FLAGS,
                                99};

constexpr int kFormats[] = {RTC_FORMAT_UNDEFINED,
                            RTC_FORMAT_UCHAR,
                            RTC_FORMAT_UINT,
                            RTC_FORMAT_UINT3,
                            RTC_FORMAT_UINT4,
                            RTC_FORMAT_FLOAT,
                            RTC_FORMAT_FLOAT2,
                            RTC_FORMAT_FLOAT3,
                            RTC_FORMAT_FLOAT4,
                            RTC_FORMAT_FLOAT16,
                            RTC_FORMAT_GRID,
                            RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                            -1};

std::vector<Setting> Settings() {
  constexpr std::size_t kTooMany = std::size_t{1} << 32;
  std::vector<Setting> settings;
  for (const int type : kBufferTypes) {
    for (const int format : kFormats) {
      for (const unsigned int slot : {0u, 1u, 2u, kLast}) {
        settings.push_back({type, slot, format, 0, 64, 4});
      }
      for (const std::size_t offset : {1, 2}) settings.push_back({type, 0, format, offset, 64, 4});
      for (const std::size_t stride : {0, 4, 12, 65, 66}) {
        settings.push_back({type, 0, format, 0, stride, 4});
      }
      settings.push_back({type, 0, format, 0, 64, kTooMany});
      settings.push_back({type, kLast, format, 2, 66, kTooMany});
      settings.push_back({type, 0, format, 0, 64, 0});
    }
  }
  return settings;
}

/// Embree's quads take whatever lies behind vertex attributes for them. The drop-in refuses it.
bool IsTakenByMistake(RTCGeometryType geometry, int buffer) {
  return geometry == RTC_GEOMETRY_TYPE_QUAD && buffer > RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE;
}

TEST_P(GeometryWalk, BuffersOfEveryTypeFormatAndSlot) {
  using Set = std::function<void(Session&, RTCGeometry, const Setting&)>;
  alignas(16) static char memory[1024];
  const std::pair<const char*, Set> ways[] = {
      {"rtcSetGeometryBuffer",
       [](Session& s, RTCGeometry geometry, const Setting& set) {
         s.api.rtcSetGeometryBuffer(geometry, RTCBufferType(set.type), set.slot,
                                    RTCFormat(set.format), s.NewBuffer(sizeof(memory)), set.offset,
                                    set.stride, set.count);
       }},
      {"rtcSetSharedGeometryBuffer",
       [](Session& s, RTCGeometry geometry, const Setting& set) {
         s.api.rtcSetSharedGeometryBuffer(geometry, RTCBufferType(set.type), set.slot,
                                          RTCFormat(set.format), memory, set.offset, set.stride,
                                          set.count);
       }},
      {"rtcSetNewGeometryBuffer",
       [](Session& s, RTCGeometry geometry, const Setting& set) {
         s.api.rtcSetNewGeometryBuffer(geometry, RTCBufferType(set.type), set.slot,
                                       RTCFormat(set.format), set.stride, set.count);
       }},
  };
  Session real(RealEmbree());
  Session ours(DropIn());
  for (const auto& [function, set] : ways) {
    for (const Setting& setting : Settings()) {
      RTCError codes[2];
      for (Session* const s : {&real, &ours}) {
        const RTCGeometry geometry = s->api.rtcNewGeometry(s->device, GetParam());
        s->api.rtcSetGeometryVertexAttributeCount(geometry, 2);
        s->TakeError();
        s->reports.clear();
        set(*s, geometry, setting);
        codes[s == &ours] = s->TakeError();
        s->api.rtcReleaseGeometry(geometry);
      }
      if (codes[0] == RTC_ERROR_NONE && IsTakenByMistake(GetParam(), setting.type)) {
        codes[0] = RTC_ERROR_INVALID_OPERATION;
      }
      ASSERT_EQ(codes[1], codes[0]) << function << ": " << setting.Text();
      ASSERT_EQ(ours.reports.size(), codes[1] == RTC_ERROR_NONE ? 0u : 1u);
      for (const ErrorReport& report : ours.reports) {
        EXPECT_TRUE(report.message.starts_with(std::string(function) + ": ")) << report.message;
      }
    }
  }
}

/// A call with its function's name first.
struct Call {
  std::string name;
  std::function<void(Session&, RTCGeometry)> make;
};
using Calls = std::vector<Call>;

std::string Text(auto value) { return std::to_string(value); }

Calls BufferCalls(RTCGeometryType type) {
  Calls calls;
  for (const int buffer : kBufferTypes) {
    for (const unsigned int slot : {0u, 1u, kLast}) {
      const std::string what = " buffer " + Text(buffer) + ", slot " + Text(slot);
      calls.push_back({"rtcGetGeometryBufferData" + what, [=](Session& s, RTCGeometry g) {
                         s.api.rtcGetGeometryBufferData(g, RTCBufferType(buffer), slot);
                       }});
      calls.push_back({"rtcUpdateGeometryBuffer" + what, [=](Session& s, RTCGeometry g) {
                         s.api.rtcUpdateGeometryBuffer(g, RTCBufferType(buffer), slot);
                       }});
    }
  }
  if (!HasBuffers(type)) return calls;
  for (const std::size_t count : {4, 5}) {
    calls.push_back({"rtcSetNewGeometryBuffer vertices " + Text(count),
                     [=](Session& s, RTCGeometry g) { SetVertices(s, g, type, 0, 0, count); }});
  }
  for (const std::size_t count : {1, 2}) {
    calls.push_back({"rtcSetNewGeometryBuffer primitives " + Text(count),
                     [=](Session& s, RTCGeometry g) { SetPrimitives(s, g, type, count); }});
  }
  return calls;
}

Calls PropertyCalls() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Calls calls;
  for (const unsigned int count : {0u, 1u, 2u, 129u, 130u, kLast}) {
    calls.push_back({"rtcSetGeometryTimeStepCount " + Text(count), [=](Session& s, RTCGeometry g) {
                       s.api.rtcSetGeometryTimeStepCount(g, count);
                     }});
  }
  for (const auto& range : {std::pair{0.0f, 1.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {kNan, 1.0f}}) {
    calls.push_back({"rtcSetGeometryTimeRange " + Text(range.first) + " " + Text(range.second),
                     [=](Session& s, RTCGeometry g) {
                       s.api.rtcSetGeometryTimeRange(g, range.first, range.second);
                     }});
  }
  for (const unsigned int count : {0u, 1u, 16u}) {
    calls.push_back(
        {"rtcSetGeometryVertexAttributeCount " + Text(count),
         [=](Session& s, RTCGeometry g) { s.api.rtcSetGeometryVertexAttributeCount(g, count); }});
  }
  for (const unsigned int mask : {1u, ~0u}) {
    calls.push_back({"rtcSetGeometryMask " + Text(mask),
                     [=](Session& s, RTCGeometry g) { s.api.rtcSetGeometryMask(g, mask); }});
  }
  for (const int quality : {-1, 0, 1, 2, 3, 4}) {
    calls.push_back({"rtcSetGeometryBuildQuality " + Text(quality), [=](Session& s, RTCGeometry g) {
                       s.api.rtcSetGeometryBuildQuality(g, RTCBuildQuality(quality));
                     }});
  }
  for (const unsigned int count : {0u, 1u, 2u}) {
    calls.push_back(
        {"rtcSetGeometryUserPrimitiveCount " + Text(count),
         [=](Session& s, RTCGeometry g) { s.api.rtcSetGeometryUserPrimitiveCount(g, count); }});
  }
  calls.push_back({"rtcSetGeometryUserData",
                   [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryUserData(g, &s); }});
  return calls;
}

Calls StateCalls() {
  const auto disable = [](Session& s, RTCGeometry g) { s.api.rtcDisableGeometry(g); };
  return {
      {"rtcDisableGeometry", disable},
      {"rtcEnableGeometry", [](Session& s, RTCGeometry g) { s.api.rtcEnableGeometry(g); }},
      {"rtcCommitGeometry", [](Session& s, RTCGeometry g) { s.api.rtcCommitGeometry(g); }},
      {"rtcSetGeometryMask of a disabled geometry",
       [=](Session& s, RTCGeometry g) {
         disable(s, g);
         s.api.rtcSetGeometryMask(g, 1);
       }},
      {"rtcCommitGeometry after a mask",
       [](Session& s, RTCGeometry g) {
         s.api.rtcSetGeometryMask(g, 1);
         s.api.rtcCommitGeometry(g);
       }},
  };
}

/// Functions that take a callback, with none and with one.
Calls CallbackCalls() {
  Calls calls;
  const auto add = [&](std::string name, auto set, auto function) {
    calls.push_back({name + " null", [=](Session& s, RTCGeometry g) {
                       set(s.api, g, decltype(function){nullptr});
                     }});
    calls.push_back(
        {name + " function", [=](Session& s, RTCGeometry g) { set(s.api, g, function); }});
  };
  const RTCFilterFunctionN filter = [](const RTCFilterFunctionNArguments*) {};
  const RTCPointQueryFunction query = [](RTCPointQueryFunctionArguments*) { return false; };
  add(
      "rtcSetGeometryIntersectFilterFunction",
      [](const Api& api, auto g, auto f) { api.rtcSetGeometryIntersectFilterFunction(g, f); },
      filter);
  add(
      "rtcSetGeometryOccludedFilterFunction",
      [](const Api& api, auto g, auto f) { api.rtcSetGeometryOccludedFilterFunction(g, f); },
      filter);
  add(
      "rtcSetGeometryPointQueryFunction",
      [](const Api& api, auto g, auto f) { api.rtcSetGeometryPointQueryFunction(g, f); }, query);
  add(
      "rtcSetGeometryBoundsFunction",
      [](const Api& api, auto g, auto f) { api.rtcSetGeometryBoundsFunction(g, f, nullptr); },
      &BoundUnitBox);
  add(
      "rtcSetGeometryIntersectFunction",
      [](const Api& api, auto g, auto f) { api.rtcSetGeometryIntersectFunction(g, f); },
      &IntersectPlane);
  add(
      "rtcSetGeometryOccludedFunction",
      [](const Api& api, auto g, auto f) { api.rtcSetGeometryOccludedFunction(g, f); },
      &OccludePlane);
  return calls;
}

/// Quaternions and matrices, at steps that are there and not, with pointers and without.
Calls SetTransformCalls() {
  static const float matrix[16] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  static RTCQuaternionDecomposition quaternion;
  rtcInitQuaternionDecomposition(&quaternion);
  Calls calls;
  for (const unsigned int step : {0u, 1u, kLast}) {
    for (const bool null : {true, false}) {
      const std::string what = " step " + Text(step) + (null ? ", null" : "");
      for (const RTCFormat format :
           {kMatrix, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
            RTC_FORMAT_UNDEFINED, RTC_FORMAT_FLOAT12, RTC_FORMAT_FLOAT3X3_ROW_MAJOR,
            RTC_FORMAT_FLOAT4X4_ROW_MAJOR}) {
        calls.push_back({"rtcSetGeometryTransform" + what + ", format " + Text(format),
                         [=](Session& s, RTCGeometry g) {
                           s.api.rtcSetGeometryTransform(g, step, format, null ? nullptr : matrix);
                         }});
      }
      calls.push_back({"rtcSetGeometryTransformQuaternion" + what, [=](Session& s, RTCGeometry g) {
                         s.api.rtcSetGeometryTransformQuaternion(g, step,
                                                                 null ? nullptr : &quaternion);
                       }});
    }
  }
  return calls;
}

Calls InstanceCalls(RTCGeometryType type) {
  static float matrix[16];
  Calls calls = {
      {"rtcSetGeometryInstancedScene null",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryInstancedScene(g, nullptr); }},
      {"rtcSetGeometryInstancedScene",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryInstancedScene(g, s.NewScene()); }},
  };
  for (const RTCFormat format :
       {kMatrix, RTC_FORMAT_UNDEFINED, RTC_FORMAT_FLOAT12, RTC_FORMAT_FLOAT4X4_ROW_MAJOR}) {
    calls.push_back(
        {"rtcGetGeometryTransform format " + Text(format),
         [=](Session& s, RTCGeometry g) { s.api.rtcGetGeometryTransform(g, 0, format, matrix); }});
  }
  // Of an instance the real library writes to the null pointer.
  if (type != RTC_GEOMETRY_TYPE_INSTANCE) {
    calls.push_back({"rtcGetGeometryTransform null", [](Session& s, RTCGeometry g) {
                       s.api.rtcGetGeometryTransform(g, 0, kMatrix, nullptr);
                     }});
  }
  return calls;
}

/// Functions of types that the drop-in does not support.
Calls OtherTypesCalls() {
  return {
      {"rtcSetGeometryMaxRadiusScale",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryMaxRadiusScale(g, 2); }},
      {"rtcSetGeometryTessellationRate",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryTessellationRate(g, 1); }},
      {"rtcSetGeometryTopologyCount",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryTopologyCount(g, 1); }},
      {"rtcSetGeometrySubdivisionMode",
       [](Session& s, RTCGeometry g) {
         s.api.rtcSetGeometrySubdivisionMode(g, 0, RTC_SUBDIVISION_MODE_PIN_ALL);
       }},
      {"rtcSetGeometryVertexAttributeTopology",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryVertexAttributeTopology(g, 0, 0); }},
      {"rtcSetGeometryDisplacementFunction",
       [](Session& s, RTCGeometry g) { s.api.rtcSetGeometryDisplacementFunction(g, nullptr); }},
      {"rtcGetGeometryFirstHalfEdge",
       [](Session& s, RTCGeometry g) { s.api.rtcGetGeometryFirstHalfEdge(g, 0); }},
      {"rtcGetGeometryFace", [](Session& s, RTCGeometry g) { s.api.rtcGetGeometryFace(g, 0); }},
      {"rtcGetGeometryNextHalfEdge",
       [](Session& s, RTCGeometry g) { s.api.rtcGetGeometryNextHalfEdge(g, 0); }},
      {"rtcGetGeometryPreviousHalfEdge",
       [](Session& s, RTCGeometry g) { s.api.rtcGetGeometryPreviousHalfEdge(g, 0); }},
      {"rtcGetGeometryOppositeHalfEdge",
       [](Session& s, RTCGeometry g) { s.api.rtcGetGeometryOppositeHalfEdge(g, 0, 0); }},
  };
}

Calls AllCalls(RTCGeometryType type) {
  Calls all;
  for (const Calls& calls : {BufferCalls(type), PropertyCalls(), StateCalls(), CallbackCalls(),
                             SetTransformCalls(), InstanceCalls(type), OtherTypesCalls()}) {
    all.insert(all.end(), calls.begin(), calls.end());
  }
  return all;
}

/// The codes of a call, and of the scene's commit behind it.
using Codes = std::pair<RTCError, RTCError>;

Codes CodesOf(const Api& api, RTCGeometryType type, const Call& call) {
  Session s(api);
  const RTCGeometry geometry = Model(s, type);
  const RTCScene scene = s.SceneOf(geometry);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  call.make(s, geometry);
  const RTCError code = s.TakeError();
  if (&api == &DropIn() && code != RTC_ERROR_NONE) {
    const std::string function = call.name.substr(0, call.name.find(' '));
    EXPECT_EQ(s.reports.size(), 1u) << call.name;
    EXPECT_TRUE(s.reports[0].message.starts_with(function + ": ")) << s.reports[0].message;
  }
  api.rtcCommitScene(scene);
  EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_NONE) << call.name;
  return {code, s.TakeError()};
}

TEST_P(GeometryWalk, CallsAndTheCommitBehindThem) {
  for (const Call& call : AllCalls(GetParam())) {
    EXPECT_EQ(CodesOf(DropIn(), GetParam(), call), CodesOf(RealEmbree(), GetParam(), call))
        << call.name;
  }
}

}  // namespace
}  // namespace dacrt::tests

// Point queries: what a program's functions are called with, and what they may do.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "point_query.h"

namespace dacrt::tests {
namespace {

class PointQueryCalls : public PointQueryTest {};

INSTANTIATE_ON_BOTH_LIBRARIES(PointQueryCalls);

/// A function's calls, in order. There is one test at a time.
struct CallRecord {
  char function;
  RTCPointQueryFunctionArguments args;
  float radius;
};
std::vector<CallRecord> calls;

template <char kName, bool kAnswer>
bool Record(RTCPointQueryFunctionArguments* args) {
  calls.push_back({kName, *args, args->query->radius});
  return kAnswer;
}

std::string NamesOfCalls() {
  std::string names;
  for (const CallRecord& call : calls) names += call.function;
  calls.clear();
  return names;
}

TEST_P(PointQueryCalls, CallTheirOwnFunctionAndThenTheGeometrys) {
  const Api& api = s_.api;
  const RTCGeometry geometry = s_.Triangle();
  const RTCScene scene = s_.SceneOf(geometry);
  int user_value = 0;
  RTCPointQuery query = QueryAt({0.2, 0.2, 0}, 1);
  const auto run = [&](RTCPointQueryFunction function) {
    calls.clear();
    return Query(api, scene, query, function, &user_value);
  };
  EXPECT_FALSE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "");
  EXPECT_TRUE(run(Record<'q', true>));
  EXPECT_EQ(NamesOfCalls(), "q");
  // A function counts at once, without another commit.
  api.rtcSetGeometryPointQueryFunction(geometry, Record<'g', false>);
  api.rtcCommitScene(scene);
  EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
  EXPECT_FALSE(run(Record<'q', false>));
  for (const CallRecord& call : calls) {
    EXPECT_EQ(call.args.userPtr, &user_value);
    EXPECT_EQ(call.args.query, &query);
    EXPECT_EQ(call.args.geomID, 0u);
    EXPECT_EQ(call.args.primID, 0u);
    EXPECT_EQ(call.args.similarityScale, 1);
  }
  EXPECT_EQ(NamesOfCalls(), "qg");
  EXPECT_TRUE(run(Record<'q', true>));
  EXPECT_EQ(NamesOfCalls(), "qg");
  EXPECT_FALSE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "g");
  EXPECT_FALSE(run(Record<'g', false>));
  EXPECT_EQ(NamesOfCalls(), "gg");
  api.rtcSetGeometryPointQueryFunction(geometry, Record<'h', true>);
  EXPECT_TRUE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "h");
  api.rtcSetGeometryPointQueryFunction(geometry, nullptr);
  EXPECT_FALSE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "");
}

TEST_P(PointQueryCalls, InAnInstanceCallTheFunctionsOfItsGeometries) {
  const Api& api = s_.api;
  const RTCGeometry geometry = s_.Triangle();
  const RTCScene inner = s_.SceneOf(geometry);
  const RTCGeometry instance = s_.Own(api.rtcNewGeometry(s_.device, RTC_GEOMETRY_TYPE_INSTANCE));
  const Matrix moved{1, 0, 0, 0, 1, 0, 0, 0, 1, 10, 0, 0};
  api.rtcSetGeometryInstancedScene(instance, inner);
  api.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, moved.data());
  api.rtcCommitGeometry(instance);
  api.rtcSetGeometryPointQueryFunction(geometry, Record<'g', false>);
  api.rtcSetGeometryPointQueryFunction(instance, Record<'i', false>);
  EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
  const RTCScene scene = s_.SceneOf(instance);
  RTCPointQuery query = QueryAt({10.2, 0.2, 0}, 1);
  calls.clear();
  Query(api, scene, query, Record<'q', false>, nullptr);
  for (const CallRecord& call : calls) EXPECT_EQ(call.args.query->x, 10.2f);
  EXPECT_EQ(NamesOfCalls(), "qg");
}

/// Shrinks the radius without saying so.
bool ShrinkInSilence(RTCPointQueryFunctionArguments* args) {
  ++*static_cast<int*>(args->userPtr);
  args->query->radius = 0.5f;
  return false;
}

TEST_P(PointQueryCalls, ARadiusThatShrinksInSilenceDoesNotCount) {
  const RTCScene scene = s_.NewScene();
  for (const float z : {0.0f, 5.0f}) s_.api.rtcAttachGeometry(scene, s_.Triangle(z));
  s_.api.rtcCommitScene(scene);
  RTCPointQuery query = QueryAt({0.2, 0.2, 0}, 100);
  int count = 0;
  EXPECT_FALSE(Query(s_.api, scene, query, ShrinkInSilence, &count));
  EXPECT_EQ(count, 2);
  EXPECT_EQ(query.radius, 0.5f);
}

struct Reentrance {
  const Api& api;
  RTCScene scene;
  int depth = 0;
  int inner_calls = 0;
};

/// Traces a ray and asks once more.
bool Reenter(RTCPointQueryFunctionArguments* args) {
  auto& state = *static_cast<Reentrance*>(args->userPtr);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = RayAt(0.2f);
  state.api.rtcIntersect1(state.scene, &context, &ray);
  EXPECT_EQ(ray.hit.geomID, 0u);
  if (state.depth > 0) {
    ++state.inner_calls;
    return false;
  }
  ++state.depth;
  RTCPointQuery query = QueryAt({0, 0, 0}, 100);
  Query(state.api, state.scene, query, Reenter, &state);
  --state.depth;
  return false;
}

TEST_P(PointQueryCalls, FunctionsMayQueryAndTraceThemselves) {
  const RTCScene scene = s_.NewScene();
  for (const float z : {0.0f, 5.0f}) s_.api.rtcAttachGeometry(scene, s_.Triangle(z));
  s_.api.rtcCommitScene(scene);
  Reentrance state{s_.api, scene};
  RTCPointQuery query = QueryAt({0.2, 0.2, 0}, 100);
  Query(s_.api, scene, query, Reenter, &state);
  EXPECT_EQ(state.inner_calls, 4);
}

// Programs that keep instances themselves put them on the stack, and the query comes to the scene
// through the topmost one.
TEST_P(PointQueryCalls, GoThroughTheStackThatTheyAreCalledWith) {
  const Api& api = s_.api;
  const RTCScene scene = s_.NewScene();
  for (const float z : {0.0f, 5.0f}) api.rtcAttachGeometry(scene, s_.Triangle(z));
  api.rtcCommitScene(scene);
  struct {
    Matrix world2inst;
    float scale;
  } const stacks[] = {{{0.5f, 0, 0, 0, 0.5f, 0, 0, 0, 0.5f, -5, -5, -5}, 0.5f},
                      {{0.5f, 0, 0, 0, 1, 0, 0, 0, 0.5f, -5, -10, -5}, 0}};
  for (const auto& stack : stacks) {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const float kIgnored = 9;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row) {
        context.world2inst[0][4 * column + row] = stack.world2inst[3 * column + row];
      }
      context.world2inst[0][4 * column + 3] = kIgnored;
    }
    context.instStackSize = 1;
    context.instID[0] = 7;
    // Around (0.1, 0.1, 0) in the scene; the other triangle is 5 away there, and 10 here.
    RTCPointQuery query = QueryAt({10.2, 10.1, 10}, 12);
    calls.clear();
    api.rtcPointQuery(scene, &query, &context, Record<'q', false>, nullptr);
    ASSERT_EQ(calls.size(), 2u);
    for (const CallRecord& call : calls) {
      EXPECT_EQ(call.args.similarityScale, stack.scale);
      EXPECT_EQ(call.args.context->instStackSize, 1u);
      EXPECT_EQ(call.args.context->instID[0], 7u);
      EXPECT_EQ(call.args.query->x, 10.2f);
    }
    EXPECT_EQ(context.instStackSize, 1u);
    EXPECT_EQ(context.world2inst[0][3], kIgnored);
    if (!IsOurs()) continue;  // The real library offers all of a leaf.
    query.radius = 9;
    calls.clear();
    api.rtcPointQuery(scene, &query, &context, Record<'q', false>, nullptr);
    ASSERT_EQ(calls.size(), 1u);
    EXPECT_EQ(calls[0].args.geomID, 0u);
  }
}

TEST_P(PointQueryCalls, TakeFunctionsForGeometriesOfEveryType) {
  for (const RTCGeometryType type :
       {RTC_GEOMETRY_TYPE_TRIANGLE, RTC_GEOMETRY_TYPE_QUAD, RTC_GEOMETRY_TYPE_GRID,
        RTC_GEOMETRY_TYPE_SPHERE_POINT, RTC_GEOMETRY_TYPE_DISC_POINT,
        RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT, RTC_GEOMETRY_TYPE_USER,
        RTC_GEOMETRY_TYPE_INSTANCE}) {
    const RTCGeometry geometry = s_.Own(s_.api.rtcNewGeometry(s_.device, type));
    s_.api.rtcSetGeometryPointQueryFunction(geometry, Record<'g', false>);
    s_.api.rtcSetGeometryPointQueryFunction(geometry, nullptr);
    EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE) << type;
  }
}

TEST_P(PointQueryCalls, FindNothingWithoutAPlace) {
  const RTCScene scene = s_.SceneOf(s_.Triangle());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  if (IsOurs()) {  // The real library offers all of a leaf.
    for (RTCPointQuery query : {QueryAt({nan, 0, 0}, 1), QueryAt({0, 0, 0}, nan)}) {
      calls.clear();
      EXPECT_FALSE(Query(s_.api, scene, query, Record<'q', true>, nullptr));
      EXPECT_EQ(NamesOfCalls(), "");
    }
  }
  const RTCScene empty = s_.NewScene();
  s_.api.rtcCommitScene(empty);
  RTCPointQuery query = QueryAt({0, 0, 0}, 1);
  calls.clear();
  EXPECT_FALSE(Query(s_.api, empty, query, Record<'q', true>, nullptr));
  EXPECT_EQ(NamesOfCalls(), "");
  EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
}

// The real library checks nothing, and crashes on each of these.
TEST(PointQueryErrors, AreReported) {
  Session s(DropIn());
  const Api& api = s.api;
  const RTCScene scene = s.SceneOf(s.Triangle());
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query = QueryAt({0, 0, 0}, 1);
  alignas(64) RTCPointQuery16 packet{};
  alignas(64) const int valid[16] = {-1};
  const RTCPointQueryFunction function = Record<'q', true>;
  calls.clear();

  EXPECT_FALSE(api.rtcPointQuery(s.NewScene(), &query, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_FALSE(api.rtcPointQuery(scene, nullptr, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery(scene, &query, nullptr, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery16(nullptr, scene, &packet, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery16(valid, scene, nullptr, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  context.instStackSize = 2;
  EXPECT_FALSE(api.rtcPointQuery(scene, &query, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery(nullptr, &query, &context, function, nullptr));
  EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(NamesOfCalls(), "");
  for (const ErrorReport& report : s.reports) {
    EXPECT_TRUE(report.message.starts_with("rtcPointQuery")) << report.message;
  }
}

}  // namespace
}  // namespace dacrt::tests

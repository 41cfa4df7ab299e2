// Instances: how transforms are given and given back, what is hit through them, and what is
// refused, beside the real library.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "forms.h"
#include "model.h"

namespace dacrt::tests {
namespace {

constexpr RTCFormat kFormats[] = {RTC_FORMAT_FLOAT3X4_ROW_MAJOR, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                  RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR};

/// A transform by columns: three axes and where the origin goes.
using Matrix = std::array<std::array<float, 3>, 4>;

/// `matrix` as a program writes it in `format`.
std::array<float, 16> InFormat(const Matrix& matrix, RTCFormat format) {
  std::array<float, 16> values{};
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      const int place = format == RTC_FORMAT_FLOAT3X4_ROW_MAJOR      ? 4 * row + column
                        : format == RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR ? 3 * column + row
                                                                     : 4 * column + row;
      values[place] = matrix[column][row];
    }
  }
  if (format == RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR) values[15] = 1;
  return values;
}

/// Turned, scaled, skewed and moved at random, though not by much.
Matrix RandomMatrix(std::mt19937& random) {
  std::uniform_real_distribution<float> around_zero(-0.5f, 0.5f);
  Matrix matrix;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) matrix[column][row] = around_zero(random) + (column == row);
  }
  return matrix;
}

RTCQuaternionDecomposition RandomDecomposition(std::mt19937& random) {
  std::uniform_real_distribution<float> around_zero(-0.5f, 0.5f);
  const auto any = [&] { return around_zero(random); };
  RTCQuaternionDecomposition parts;
  rtcInitQuaternionDecomposition(&parts);
  rtcQuaternionDecompositionSetQuaternion(&parts, 1 + any(), any(), any(), any());
  rtcQuaternionDecompositionSetScale(&parts, 1 + any(), 1 + any(), 1 + any());
  rtcQuaternionDecompositionSetSkew(&parts, any(), any(), any());
  rtcQuaternionDecompositionSetShift(&parts, any(), any(), any());
  rtcQuaternionDecompositionSetTranslation(&parts, any(), any(), any());
  return parts;
}

RTCGeometry NewInstance(Session& s, RTCScene scene, unsigned int steps = 1) {
  const RTCGeometry instance = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE));
  s.api.rtcSetGeometryInstancedScene(instance, scene);
  s.api.rtcSetGeometryTimeStepCount(instance, steps);
  return instance;
}

void SetMatrix(Session& s, RTCGeometry instance, unsigned int step, const Matrix& matrix,
               RTCFormat format = kFormats[0]) {
  s.api.rtcSetGeometryTransform(instance, step, format, InFormat(matrix, format).data());
}

std::array<float, 16> GetTransform(Session& s, RTCGeometry instance, float time, RTCFormat format) {
  std::array<float, 16> values{};
  s.api.rtcGetGeometryTransform(instance, time, format, values.data());
  return values;
}

/// The real library's code for AVX-512 hangs in occlusion calls for 16 coherent rays and instances.
class Instances : public testing::Test {
 protected:
  Session real{RealEmbree(), "isa=avx2"};
  Session ours{DropIn()};
};

TEST_F(Instances, TransformsComeBackInEveryFormat) {
  std::mt19937 random(1);
  for (Session* const s : {&real, &ours}) {
    const RTCGeometry instance = NewInstance(*s, s->SceneOf(s->Triangle()));
    for (const RTCFormat set : kFormats) {
      const Matrix matrix = RandomMatrix(random);
      SetMatrix(*s, instance, 0, matrix, set);
      for (const RTCFormat get : kFormats) {
        EXPECT_EQ(GetTransform(*s, instance, 0, get), InFormat(matrix, get))
            << s->api.name << ", set as " << set << ", got as " << get;
      }
    }
    EXPECT_EQ(s->TakeError(), RTC_ERROR_NONE);
  }
}

TEST_F(Instances, ANewOneStandsWhereItsSceneDoes) {
  const Matrix identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
  for (Session* const s : {&real, &ours}) {
    const RTCGeometry instance = NewInstance(*s, s->SceneOf(s->Triangle()));
    EXPECT_EQ(GetTransform(*s, instance, 0, kFormats[0]), InFormat(identity, kFormats[0]));
  }
}

/// Sets all steps of both libraries' instances to the same at random. Embree does not tell what
/// becomes of matrices and parts in one geometry.
void SetTransforms(std::mt19937& random, bool in_parts, unsigned int steps, Session& real,
                   RTCGeometry real_instance, Session& ours, RTCGeometry our_instance) {
  for (unsigned int step = 0; step < steps; ++step) {
    if (in_parts) {
      const RTCQuaternionDecomposition parts = RandomDecomposition(random);
      real.api.rtcSetGeometryTransformQuaternion(real_instance, step, &parts);
      ours.api.rtcSetGeometryTransformQuaternion(our_instance, step, &parts);
    } else {
      const Matrix matrix = RandomMatrix(random);
      SetMatrix(real, real_instance, step, matrix);
      SetMatrix(ours, our_instance, step, matrix);
    }
  }
}

/// When and how often a geometry has a transform.
struct Motion {
  unsigned int steps;
  float begin, end;

  /// By how many segments `time` lies outside.
  float SegmentsOutside(float time) const {
    const float outside = std::max({begin - time, time - end, 0.0f});
    return outside / (end - begin) * static_cast<float>(steps - 1);
  }
};

constexpr Motion kMotions[] = {{1, 0, 1},         {2, 0, 1},           {3, 0, 1}, {129, 0, 1},
                               {2, 0.25f, 0.75f}, {129, 0.25f, 0.75f}, {3, -1, 2}};

/// The last segments go on outside of the range. There rounding grows with the distance, and that
/// of an angle without limit, so rotations are followed for a few segments only.
void ExpectSameTransforms(Session& real, RTCGeometry real_instance, Session& ours,
                          RTCGeometry our_instance, const Motion& motion, bool in_parts) {
  for (const float time :
       {-1.0f, -0.01f, 0.0f, 0.1f, 0.25f, 0.3f, 0.5f, 0.7f, 0.75f, 0.99f, 1.0f, 1.01f, 3.0f}) {
    if (in_parts && motion.SegmentsOutside(time) > 2) continue;
    const auto expected = GetTransform(real, real_instance, time, kFormats[0]);
    const auto actual = GetTransform(ours, our_instance, time, kFormats[0]);
    const float ulps = in_parts ? 16 : 2;
    const float tolerance =
        ulps * std::numeric_limits<float>::epsilon() * (1 + motion.SegmentsOutside(time));
    for (int i = 0; i < 12; ++i) {
      EXPECT_NEAR(actual[i], expected[i], tolerance) << "at " << time << ", number " << i;
    }
  }
}

TEST_F(Instances, TransformsAreInterpolated) {
  std::mt19937 random(2);
  for (const bool in_parts : {false, true}) {
    for (const Motion& motion : kMotions) {
      SCOPED_TRACE((in_parts ? "parts, " : "matrices, ") + std::to_string(motion.steps) +
                   " steps from " + std::to_string(motion.begin));
      const RTCGeometry real_instance = NewInstance(real, real.NewScene(), motion.steps);
      const RTCGeometry our_instance = NewInstance(ours, ours.NewScene(), motion.steps);
      SetTransforms(random, in_parts, motion.steps, real, real_instance, ours, our_instance);
      real.api.rtcSetGeometryTimeRange(real_instance, motion.begin, motion.end);
      ours.api.rtcSetGeometryTimeRange(our_instance, motion.begin, motion.end);
      ExpectSameTransforms(real, real_instance, ours, our_instance, motion, in_parts);
    }
  }
}

std::vector<RTCRayHit> TraceRays(Session& s, RTCScene scene, std::vector<RTCRayHit> rays,
                                 Query query = Query::kClosest) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return Trace(s.api, scene, context, {Form::Call::kRecords}, query, rays);
}

/// A committed scene of triangles at random places.
RTCScene Soup(Session& s) {
  const RTCGeometry soup = UncommittedSoup(s, 3, 50, 0.5f);
  s.api.rtcCommitGeometry(soup);
  return s.SceneOf(soup);
}

/// A committed scene of the square of a model.
RTCScene Square(Session& s) { return s.SceneOf(Model(s, RTC_GEOMETRY_TYPE_QUAD)); }

/// Traces random rays in instances of what `make_scene` makes, and calls `compare(ours, real)` with
/// them, for many transforms.
template <class MakeScene, class Compare>
void TraceTransformed(Session& real, Session& ours, MakeScene make_scene, const Compare& compare) {
  std::mt19937 random(4);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const RTCGeometry real_instance = NewInstance(real, make_scene(real));
    const RTCGeometry our_instance = NewInstance(ours, make_scene(ours));
    SetTransforms(random, repeat % 2 == 0, 1, real, real_instance, ours, our_instance);
    real.api.rtcCommitGeometry(real_instance);
    ours.api.rtcCommitGeometry(our_instance);
    const std::vector<RTCRayHit> rays = RandomRays(repeat, 300);
    SCOPED_TRACE(repeat);
    compare(TraceRays(ours, ours.SceneOf(our_instance), rays),
            TraceRays(real, real.SceneOf(real_instance), rays));
  }
}

TEST_F(Instances, ShowTheSameTrianglesAsTheRealLibrarys) {
  std::size_t hits = 0;
  TraceTransformed(real, ours, Soup, [&](const auto& our_rays, const auto& real_rays) {
    for (std::size_t i = 0; i < our_rays.size(); ++i) {
      EXPECT_EQ(our_rays[i].hit.primID, real_rays[i].hit.primID);
      EXPECT_EQ(our_rays[i].hit.geomID, real_rays[i].hit.geomID);
      EXPECT_EQ(our_rays[i].hit.instID[0], real_rays[i].hit.instID[0]);
      hits += our_rays[i].hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
  });
  EXPECT_GT(hits, 500u);
}

TEST_F(Instances, AreHitWhereTheRealLibrarysAre) {
  TraceTransformed(real, ours, Square, [](const auto& our_rays, const auto& real_rays) {
    ExpectSameRays(our_rays, real_rays);
  });
}

/// A scene of `count` instances of one, side by side across the row of rays: each is the square
/// narrowed to a tenth. Their IDs are 20, 21 and so on, that of the square is 3.
RTCScene SideBySide(Session& s, unsigned int count) {
  const RTCScene inner = s.NewScene();
  s.api.rtcAttachGeometryByID(inner, Model(s, RTC_GEOMETRY_TYPE_QUAD), 3);
  s.api.rtcCommitScene(inner);
  const RTCScene scene = s.NewScene();
  for (unsigned int i = 0; i < count; ++i) {
    const RTCGeometry instance = NewInstance(s, inner);
    const float x = 0.295f + 0.1f * static_cast<float>(i);
    SetMatrix(s, instance, 0, {{{0.1f, 0, 0}, {0, 1, 0}, {0, 0, 1}, {x, 0, 0}}});
    s.api.rtcCommitGeometry(instance);
    s.api.rtcAttachGeometryByID(scene, instance, 20 + i);
  }
  s.api.rtcCommitScene(scene);
  return scene;
}

TEST_F(Instances, OfOneSceneAreToldApart) {
  const RTCScene real_scene = SideBySide(real, 4), our_scene = SideBySide(ours, 4);
  ForEachCall([&](const Form& form, Query query) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const std::vector<RTCRayHit> row = RowOfRays(form);
    const auto expected = Trace(real.api, real_scene, context, form, query, row);
    const auto actual = Trace(ours.api, our_scene, context, form, query, row);
    ExpectSameRays(actual, expected);
    for (int i = 0; i < kRays; ++i) {
      const bool is_hit = MeetsSquare(i) && query == Query::kClosest;
      EXPECT_EQ(actual[i].hit.geomID, is_hit ? 3 : RTC_INVALID_GEOMETRY_ID);
      if (form.call == Form::Call::kRequiredArrays) continue;
      EXPECT_EQ(actual[i].hit.instID[0], is_hit ? 20 + i / 10 : RTC_INVALID_GEOMETRY_ID);
    }
  });
}

// The masks of the rays in the row have one bit of the lower half each, and one of the upper.
TEST_F(Instances, MasksOfBothLevelsCount) {
  RTCScene scenes[2];
  for (Session* const s : {&real, &ours}) {
    const RTCGeometry square = UncommittedModel(*s, RTC_GEOMETRY_TYPE_QUAD);
    s->api.rtcSetGeometryMask(square, 0x0FF0);
    s->api.rtcCommitGeometry(square);
    const RTCGeometry instance = Instance(*s, s->SceneOf(square));
    s->api.rtcSetGeometryMask(instance, 0xF0FF00);
    s->api.rtcCommitGeometry(instance);
    scenes[s == &ours] = s->SceneOf(instance);
  }
  ForEachCall([&](const Form& form, Query query) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const std::vector<RTCRayHit> row = RowOfRays(form);
    const auto expected = Trace(real.api, scenes[0], context, form, query, row);
    const auto actual = Trace(ours.api, scenes[1], context, form, query, row);
    for (int i = 0; i < kRays; ++i) {
      const unsigned int mask = row[i].ray.mask;
      const bool is_hit = MeetsSquare(i) && (mask & 0x0FF0) != 0 && (mask & 0xF0FF00) != 0;
      EXPECT_EQ(actual[i].ray.tfar != row[i].ray.tfar, is_hit) << "ray " << i;
      EXPECT_EQ(expected[i].ray.tfar != row[i].ray.tfar, is_hit) << "ray " << i;
    }
  });
}

// Ours are wider by what rays lose to rounding on their way into an instance.
TEST_F(Instances, BoundsAreThoseOfTheTransformedScene) {
  constexpr float kWider = 8 * 0x1p-20f;  // for what reaches to 8 at most
  std::mt19937 random(5);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const RTCGeometry real_instance = NewInstance(real, Soup(real));
    const RTCGeometry our_instance = NewInstance(ours, Soup(ours));
    SetTransforms(random, repeat % 2 == 0, 1, real, real_instance, ours, our_instance);
    real.api.rtcCommitGeometry(real_instance);
    ours.api.rtcCommitGeometry(our_instance);
    RTCBounds expected, actual;
    real.api.rtcGetSceneBounds(real.SceneOf(real_instance), &expected);
    ours.api.rtcGetSceneBounds(ours.SceneOf(our_instance), &actual);
    for (int axis = 0; axis < 3; ++axis) {
      const float lower = (&expected.lower_x)[axis], upper = (&expected.upper_x)[axis];
      EXPECT_LE((&actual.lower_x)[axis], lower);
      EXPECT_GE((&actual.lower_x)[axis], lower - kWider);
      EXPECT_GE((&actual.upper_x)[axis], upper);
      EXPECT_LE((&actual.upper_x)[axis], upper + kWider);
    }
  }
}

class OneInstance : public OnBothLibraries {
 protected:
  OneInstance() : s(GetParam()()) {}

  /// The distance of what the ray of RayAt(0.2) hits.
  float Distance(RTCScene scene) {
    return WholeDistance(s.api, TraceRays(s, scene, {RayAt(0.2f)})[0].ray.tfar);
  }

  Session s;
};
INSTANTIATE_ON_BOTH_LIBRARIES(OneInstance);

TEST_P(OneInstance, KeepsItsSceneAlive) {
  const RTCScene inner = s.api.rtcNewScene(s.device);
  s.api.rtcAttachGeometry(inner, s.Triangle(2));
  s.api.rtcCommitScene(inner);
  const RTCGeometry instance = Instance(s, inner);
  s.api.rtcReleaseScene(inner);
  s.api.rtcCommitGeometry(instance);
  EXPECT_EQ(Distance(s.SceneOf(instance)), 12);
}

TEST_P(OneInstance, MovesOnceItAndItsSceneAreCommitted) {
  const RTCGeometry instance = Instance(s, s.SceneOf(s.Triangle()), 2);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(instance);
  EXPECT_EQ(Distance(scene), 12);
  SetMatrix(s, instance, 0, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 7}}});
  EXPECT_EQ(Distance(scene), 12);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(Distance(scene), 12);
  s.api.rtcCommitGeometry(instance);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(Distance(scene), 17);
}

TEST_P(OneInstance, MovesBesideOthersThatChange) {
  const RTCGeometry triangle = s.Triangle(1);
  const RTCScene inner = s.SceneOf(triangle);
  const RTCGeometry one = Instance(s, inner, 2), other = Instance(s, inner, 4);
  for (const RTCGeometry instance : {one, other}) s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(one);
  s.api.rtcAttachGeometry(scene, other);
  s.api.rtcAttachGeometry(scene, s.Triangle(30));
  const auto place = [&](RTCGeometry instance, float z) {
    SetMatrix(s, instance, 0, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, z}}});
    s.api.rtcCommitGeometry(instance);
  };
  const auto expect = [&](float distance, const char* when) {
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(Distance(scene), distance) << when;
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE) << when;
  };
  const auto mask = [&](unsigned value) {
    s.api.rtcSetGeometryMask(other, value);
    s.api.rtcCommitGeometry(other);
  };
  expect(13, "at first");
  place(one, 3);
  expect(14, "one has moved");
  place(one, 8);
  mask(0);
  expect(19, "the other one cannot be met");
  mask(UINT32_MAX);
  place(one, 9);
  place(other, 10);
  expect(20, "both have moved");
  place(one, 11);
  place(other, 7);
  s.api.rtcDisableGeometry(other);
  expect(22, "the other one has moved while it goes");
  place(one, 12);
  s.api.rtcEnableGeometry(other);
  expect(18, "it comes back");
  s.api.rtcSetGeometryTimeStepCount(one, 2);
  place(one, 5);
  SetMatrix(s, one, 1, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 20}}});
  s.api.rtcCommitGeometry(one);
  expect(16, "one is at two places");
  s.api.rtcAttachGeometry(inner, s.Triangle(-1));
  s.api.rtcCommitScene(inner);
  place(other, 4);
  s.api.rtcCommitGeometry(one);
  expect(13, "their scene is another");
  place(one, 2);
  expect(11, "the next move");
}

TEST_P(OneInstance, ShowsAChangedSceneOnceBothScenesAreCommitted) {
  const RTCScene inner = s.SceneOf(s.Triangle(3));
  const RTCGeometry instance = Instance(s, inner);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(instance);
  s.api.rtcAttachGeometry(inner, s.Triangle(2));
  EXPECT_EQ(Distance(scene), 13);
  s.api.rtcCommitScene(inner);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(Distance(scene), 12);
}

TEST_P(OneInstance, GoesOnWhereOnlyItsSceneIsCommittedAnew) {
  const RTCGeometry triangle = s.Triangle(3);
  const RTCScene inner = s.SceneOf(triangle);
  const RTCGeometry instance = Instance(s, inner);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(instance);
  EXPECT_EQ(Distance(scene), 13);
  s.api.rtcSetGeometryMask(triangle, 3);
  s.api.rtcCommitGeometry(triangle);
  s.api.rtcCommitScene(inner);
  EXPECT_EQ(Distance(scene), 13);
  EXPECT_EQ(Distance(inner), 13);
}

TEST_P(OneInstance, OfAnEmptySceneIsNotHit) {
  const RTCScene empty = s.NewScene();
  s.api.rtcCommitScene(empty);
  for (const RTCScene inner : {empty, s.NewScene()}) {
    const RTCGeometry instance = Instance(s, inner);
    s.api.rtcCommitGeometry(instance);
    EXPECT_EQ(Distance(s.SceneOf(instance)), 1000);
  }
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

TEST_P(OneInstance, OfAnUncommittedSceneIsNotHit) {
  const RTCScene inner = s.NewScene();
  s.api.rtcAttachGeometry(inner, s.Triangle());
  const RTCGeometry instance = Instance(s, inner);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(instance);
  EXPECT_EQ(Distance(scene), 1000);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  s.api.rtcCommitScene(inner);
  s.api.rtcCommitGeometry(instance);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(Distance(scene), 10);
}

TEST_P(OneInstance, WithAMatrixThatIsNoneIsNotHit) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const Matrix& matrix : {Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {kNan, 0, 0}}},
                               Matrix{{{kNan, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}},
                               Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, kInfinity}}},
                               Matrix{{{1e30f, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}}}) {
    const RTCGeometry instance = NewInstance(s, s.SceneOf(s.Triangle()));
    SetMatrix(s, instance, 0, matrix);
    s.api.rtcCommitGeometry(instance);
    EXPECT_EQ(Distance(s.SceneOf(instance)), 1000);
  }
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

// The real library finds it by its new bounds, and hits it where it was.
TEST(DropInInstance, MovesWithTheNextCommitWhoeverAsksForIt) {
  Session s(DropIn());
  const RTCGeometry instance = Instance(s, s.SceneOf(s.Triangle()), 2), beside = s.Triangle(40);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(instance);
  s.api.rtcAttachGeometry(scene, beside);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(TraceRays(s, scene, {RayAt(0.2f)})[0].ray.tfar, 12);
  SetMatrix(s, instance, 0, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 7}}});
  s.api.rtcCommitGeometry(beside);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(TraceRays(s, scene, {RayAt(0.2f)})[0].ray.tfar, 17);
}

// The real library stops the program.
TEST(DropInInstance, WithoutDepthOrExtentIsNotHit) {
  Session s(DropIn());
  for (const Matrix& matrix : {Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 0}}}, Matrix{}}) {
    const RTCGeometry instance = NewInstance(s, s.SceneOf(s.Triangle()));
    SetMatrix(s, instance, 0, matrix);
    s.api.rtcCommitGeometry(instance);
    EXPECT_EQ(s.HitGeometry(s.SceneOf(instance)), RTC_INVALID_GEOMETRY_ID);
  }
}

/// The drop-in reported this and nothing else.
void ExpectError(Session& s, RTCError code, const std::string& message) {
  EXPECT_EQ(s.TakeError(), code);
  ASSERT_EQ(s.reports.size(), 1u);
  EXPECT_EQ(s.reports[0].message, message);
  s.reports.clear();
}

// The real library takes it, with two devices' memory and errors in one scene.
TEST(DropInInstance, OfAnotherDevicesSceneIsRefused) {
  Session s(DropIn());
  const RTCScene other = s.Own(s.api.rtcNewScene(s.OtherDevice()));
  s.api.rtcCommitScene(other);
  NewInstance(s, other);
  ExpectError(s, RTC_ERROR_INVALID_ARGUMENT,
              "rtcSetGeometryInstancedScene: geometry and scene are from different devices");
}

// The real library stops the program at the first ray.
TEST(DropInInstance, OfASceneWithInstancesIsRefused) {
  Session s(DropIn());
  const RTCGeometry inner = Instance(s, s.SceneOf(s.Triangle()));
  s.api.rtcCommitGeometry(inner);
  const RTCGeometry outer = Instance(s, s.SceneOf(inner));
  s.api.rtcCommitGeometry(outer);
  const RTCScene scene = s.SceneOf(outer);
  ExpectError(s, RTC_ERROR_INVALID_OPERATION,
              "rtcCommitScene: the geometry with geomID = 0 is an instance of a scene that has "
              "instances");
  EXPECT_EQ(s.HitGeometry(scene), RTC_INVALID_GEOMETRY_ID);
}

TEST(DropInInstance, OfItsOwnSceneIsRefused) {
  Session s(DropIn());
  const RTCScene scene = s.SceneOf(s.Triangle());
  const RTCGeometry instance = Instance(s, scene);
  s.api.rtcCommitGeometry(instance);
  EXPECT_EQ(s.api.rtcAttachGeometry(scene, instance), RTC_INVALID_GEOMETRY_ID);
  ExpectError(s, RTC_ERROR_INVALID_OPERATION,
              "rtcAttachGeometry: scene would be an instance in itself");
  s.api.rtcAttachGeometryByID(scene, instance, 5);
  ExpectError(s, RTC_ERROR_INVALID_OPERATION,
              "rtcAttachGeometryByID: scene would be an instance in itself");
  EXPECT_EQ(s.HitGeometry(scene), 0u);
}

TEST(DropInInstance, OfItsOwnSceneByWayOfAnotherIsRefused) {
  Session s(DropIn());
  const RTCScene first = s.NewScene(), second = s.NewScene();
  const RTCGeometry of_first = Instance(s, first), of_second = Instance(s, second);
  const RTCGeometry other = Instance(s, s.NewScene());
  s.api.rtcAttachGeometry(second, other);
  s.api.rtcAttachGeometry(first, of_second);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(s.api.rtcAttachGeometry(second, of_first), RTC_INVALID_GEOMETRY_ID);
  ExpectError(s, RTC_ERROR_INVALID_OPERATION,
              "rtcAttachGeometry: scene would be an instance in itself");
  s.api.rtcSetGeometryInstancedScene(other, first);
  ExpectError(s, RTC_ERROR_INVALID_OPERATION,
              "rtcSetGeometryInstancedScene: scene would be an instance in itself");
}

// A geometry's version was that of its own changes and of the instanced scene's commits together;
// one that went to a scene of one commit less looked as if it had not changed.
TEST_F(Instances, OneThatShowsAnotherSceneIsSeenAtTheNextCommit) {
  for (Session* const s : {&real, &ours}) {
    const RTCGeometry far = s->Triangle(0);
    const RTCScene first = s->SceneOf(far), second = s->SceneOf(s->Triangle(-1));
    s->api.rtcDetachGeometry(first, 0);
    s->api.rtcAttachGeometryByID(first, far, 3);
    s->api.rtcCommitScene(first);  // for the second time
    const RTCGeometry instance = NewInstance(*s, first);
    s->api.rtcCommitGeometry(instance);
    const RTCScene outer = s->SceneOf(instance);
    EXPECT_EQ(s->HitGeometry(outer), 3u) << s->api.name;
    s->api.rtcSetGeometryInstancedScene(instance, second);
    s->api.rtcCommitGeometry(instance);
    s->api.rtcCommitScene(outer);
    EXPECT_EQ(s->HitGeometry(outer), 0u) << s->api.name;
    EXPECT_EQ(s->TakeError(), RTC_ERROR_NONE);
  }
}

}  // namespace
}  // namespace dacrt::tests

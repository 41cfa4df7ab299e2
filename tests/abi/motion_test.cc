// Geometries with several time steps and time ranges, and rays at times inside and outside of
// these, beside the real library.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "forms.h"
#include "model.h"

namespace dacrt::tests {
namespace {

/// The steps of a geometry, and its time range.
struct Motion {
  unsigned int steps;
  float begin, end;
};

void PrintTo(const Motion& motion, std::ostream* out) {
  *out << motion.steps << " steps from " << motion.begin << " to " << motion.end;
}

constexpr Motion kMotions[] = {{2, 0, 1},           {129, 0, 1}, {2, 0.25f, 0.75f},
                               {129, 0.25f, 0.75f}, {2, -1, 2},  {5, 0.5f, 1.5f}};

/// The real library stops the program for a grid that comes or goes between 0 and 1.
bool IsTooMuchForEmbree(RTCGeometryType type, const Motion& motion) {
  return type == RTC_GEOMETRY_TYPE_GRID && (motion.begin > 0 || motion.end < 1);
}

/// Where a geometry stands at a step: it goes to and fro, and away.
float ZOf(unsigned int step, const Motion& motion) {
  return 4 * static_cast<float>(step) / static_cast<float>(motion.steps - 1) +
         (step % 2 == 0 ? 0.0f : 0.75f);
}

void SetMotion(Session& s, RTCGeometry geometry, const Motion& motion) {
  s.api.rtcSetGeometryTimeStepCount(geometry, motion.steps);
  s.api.rtcSetGeometryTimeRange(geometry, motion.begin, motion.end);
}

/// A user geometry's plane, which moves as the others do.
float PlaneAt(const Motion& motion, float time) {
  const auto segments = static_cast<float>(motion.steps - 1);
  const float place = (time - motion.begin) / (motion.end - motion.begin) * segments;
  const float segment = std::fmin(std::fmax(std::floor(place), 0.0f), segments - 1);
  const auto step = static_cast<unsigned int>(segment);
  const float fraction = place - segment;
  return (1 - fraction) * ZOf(step, motion) + fraction * ZOf(step + 1, motion);
}

void BoundMovingPlane(const RTCBoundsFunctionArguments* args) {
  const float z = ZOf(args->timeStep, *static_cast<const Motion*>(args->geometryUserPtr));
  *args->bounds_o = {0, 0, z - 0.01f, 0, 1, 1, z + 0.01f, 0};
}

/// Calls `hit(lane, ray, t)` for each ray that meets the plane.
template <class Arguments, class OnHit>
void MeetMovingPlane(const Arguments& args, RTCRayN* rays, const OnHit& hit) {
  for (unsigned int i = 0; i < args.N; ++i) {
    if (args.valid[i] == 0) continue;
    const RTCRay ray = rtcGetRayFromRayN(rays, args.N, i);
    const float z = PlaneAt(*static_cast<const Motion*>(args.geometryUserPtr), ray.time);
    const float t = z - ray.org_z;
    if (ray.tnear <= t && t <= ray.tfar && ray.org_x <= 1) hit(i, ray, t);
  }
}

void IntersectMovingPlane(const RTCIntersectFunctionNArguments* args) {
  RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, args->N);
  MeetMovingPlane(*args, rays, [&](unsigned int lane, const RTCRay& ray, float t) {
    RTCRayN_tfar(rays, args->N, lane) = t;
    const RTCHit hit{0, 0, 1, ray.org_x, 0, args->primID, args->geomID, {args->context->instID[0]}};
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &hit, args->N, lane);
  });
}

void OccludeMovingPlane(const RTCOccludedFunctionNArguments* args) {
  MeetMovingPlane(*args, args->ray, [&](unsigned int lane, const RTCRay&, float) {
    RTCRayN_tfar(args->ray, args->N, lane) = -INFINITY;
  });
}

RTCGeometry MovingUser(Session& s, const Motion& motion) {
  const RTCGeometry geometry = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryUserData(geometry, const_cast<Motion*>(&motion));
  s.api.rtcSetGeometryBoundsFunction(geometry, BoundMovingPlane, nullptr);
  s.api.rtcSetGeometryIntersectFunction(geometry, IntersectMovingPlane);
  s.api.rtcSetGeometryOccludedFunction(geometry, OccludeMovingPlane);
  return geometry;
}

RTCGeometry MovingInstance(Session& s, RTCScene scene, const Motion& motion) {
  const RTCGeometry instance = Instance(s, scene);
  SetMotion(s, instance, motion);
  for (unsigned int step = 0; step < motion.steps; ++step) {
    const float matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, ZOf(step, motion)};
    s.api.rtcSetGeometryTransform(instance, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
  }
  return instance;
}

/// The square of a model, which moves along the rays. Points are one only, for those at equal
/// distances either could be hit. Committed.
RTCGeometry MovingModel(Session& s, RTCGeometryType type, const Motion& motion) {
  RTCGeometry geometry;
  if (type == RTC_GEOMETRY_TYPE_USER) {
    geometry = MovingUser(s, motion);
  } else if (type == RTC_GEOMETRY_TYPE_INSTANCE) {
    geometry = MovingInstance(s, s.SceneOf(Model(s, RTC_GEOMETRY_TYPE_QUAD)), motion);
  } else {
    geometry = s.Own(s.api.rtcNewGeometry(s.device, type));
  }
  SetMotion(s, geometry, motion);
  for (unsigned int step = 0; step < motion.steps && HasBuffers(type); ++step) {
    SetVertices(s, geometry, type, step, ZOf(step, motion), IsPoint(type) ? 1 : 4);
  }
  SetPrimitives(s, geometry, type);
  s.api.rtcCommitGeometry(geometry);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  return geometry;
}

/// The row of rays, each at another time. Embree knows none but those from 0 to 1.
std::vector<RTCRayHit> RowInTime(const Form& form) {
  std::vector<RTCRayHit> rays = RowOfRays(form);
  for (int i = 0; i < kRays; ++i) {
    rays[i].ray.time = static_cast<float>(i) / (kRays - 1);
  }
  ReplaceAbsent(form, rays);
  return rays;
}

std::vector<RTCRayHit> TraceInTime(Session& s, RTCScene scene, const Form& form, Query query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return Trace(s.api, scene, context, form, query, RowInTime(form));
}

class Moving : public testing::TestWithParam<RTCGeometryType> {
 protected:
  /// The real library's code for AVX-512 hangs in occlusion calls for 16 coherent rays and
  /// instances.
  Session real{RealEmbree(), "isa=avx2"};
  Session ours{DropIn()};

  /// Traces rays of all times in what `make_scene` makes, in every form. Returns how many of the
  /// drop-in's hit. The real library's occlusion calls for packets let rays whose time is out of
  /// the range hit with others, so what is occluded is taken from its closest hits.
  template <class MakeScene>
  int CompareScenes(MakeScene make_scene) {
    const RTCScene real_scene = make_scene(real);
    const RTCScene our_scene = make_scene(ours);
    int hits = 0;
    ForEachCall([&](const Form& form, Query query) {
      const auto actual = TraceInTime(ours, our_scene, form, query);
      auto expected = TraceInTime(real, real_scene, form, Query::kClosest);
      if (query == Query::kAny) expected = Occluded(form, expected);
      ExpectSameRays(actual, expected);
      for (const RTCRayHit& record : actual) hits += record.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    });
    return hits;
  }

 private:
  /// What is left of an occlusion call by rays whose closest hits are `closest`.
  static std::vector<RTCRayHit> Occluded(const Form& form, const std::vector<RTCRayHit>& closest) {
    std::vector<RTCRayHit> rays = RowInTime(form);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (closest[i].hit.geomID != RTC_INVALID_GEOMETRY_ID) rays[i].ray.tfar = -INFINITY;
    }
    return rays;
  }
};

INSTANTIATE_TEST_SUITE_P(, Moving, testing::ValuesIn(kSupportedTypes),
                         [](const auto& info) { return NameOf(info.param); });

TEST_P(Moving, IsHitWhereItIsAtTheRaysTime) {
  for (const Motion& motion : kMotions) {
    if (IsTooMuchForEmbree(GetParam(), motion)) continue;
    SCOPED_TRACE(testing::PrintToString(motion));
    const int hits =
        CompareScenes([&](Session& s) { return s.SceneOf(MovingModel(s, GetParam(), motion)); });
    EXPECT_GT(hits, 0);
  }
}

TEST_P(Moving, StandsBesideWhatDoesNotMove) {
  for (const Motion& motion : kMotions) {
    if (IsTooMuchForEmbree(GetParam(), motion)) continue;
    SCOPED_TRACE(testing::PrintToString(motion));
    const int hits = CompareScenes([&](Session& s) {
      const RTCScene scene = s.NewScene();
      s.api.rtcAttachGeometry(scene, MovingModel(s, GetParam(), motion));
      s.api.rtcAttachGeometry(scene, s.Triangle(1.3f));
      s.api.rtcCommitScene(scene);
      return scene;
    });
    EXPECT_GT(hits, 0);
  }
}

// The scene's motion counts at the ray's time, too.
TEST_P(Moving, IsShownByAMovingInstance) {
  if (GetParam() == RTC_GEOMETRY_TYPE_INSTANCE) return;  // one level is all there is
  for (const Motion& motion : kMotions) {
    if (IsTooMuchForEmbree(GetParam(), motion)) continue;
    SCOPED_TRACE(testing::PrintToString(motion));
    static const Motion kInstanceMotion{3, 0.1f, 0.8f};
    const int hits = CompareScenes([&](Session& s) {
      const RTCScene inner = s.SceneOf(MovingModel(s, GetParam(), motion));
      const RTCGeometry instance = MovingInstance(s, inner, kInstanceMotion);
      s.api.rtcCommitGeometry(instance);
      return s.SceneOf(instance);
    });
    EXPECT_GT(hits, 0);
  }
}

TEST_P(Moving, MayStopAndMoveAgain) {
  static const Motion kMoving{5, 0, 1};
  RTCScene scenes[2];
  RTCGeometry geometries[2];
  for (Session* const s : {&real, &ours}) {
    const bool is_ours = s == &ours;
    geometries[is_ours] = MovingModel(*s, GetParam(), kMoving);
    scenes[is_ours] = s->SceneOf(geometries[is_ours]);
  }
  for (const unsigned int steps : {2u, 1u, 5u}) {
    SCOPED_TRACE(steps);
    for (Session* const s : {&real, &ours}) {
      const bool is_ours = s == &ours;
      s->api.rtcSetGeometryTimeStepCount(geometries[is_ours], steps);
      for (unsigned int step = 0; step < steps && HasBuffers(GetParam()); ++step) {
        SetVertices(*s, geometries[is_ours], GetParam(), step, ZOf(step, kMoving),
                    IsPoint(GetParam()) ? 1 : 4);
      }
      s->api.rtcCommitGeometry(geometries[is_ours]);
      s->api.rtcCommitScene(scenes[is_ours]);
      EXPECT_EQ(s->TakeError(), RTC_ERROR_NONE);
    }
    ForEachCall([&](const Form& form, Query query) {
      ExpectSameRays(TraceInTime(ours, scenes[1], form, query),
                     TraceInTime(real, scenes[0], form, query));
    });
  }
}

void ExpectSameBounds(const RTCBounds& ours, const RTCBounds& real) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_FLOAT_EQ((&ours.lower_x)[axis], (&real.lower_x)[axis]);
    EXPECT_FLOAT_EQ((&ours.upper_x)[axis], (&real.upper_x)[axis]);
  }
}

// An instance's are wider by rounding.
TEST_P(Moving, LinearBoundsAreTheRealLibrarysForTheUsualTimes) {
  for (const Motion& motion : kMotions) {
    if (motion.begin != 0 || motion.end != 1 || GetParam() == RTC_GEOMETRY_TYPE_INSTANCE) continue;
    SCOPED_TRACE(testing::PrintToString(motion));
    RTCLinearBounds expected, actual;
    real.api.rtcGetSceneLinearBounds(real.SceneOf(MovingModel(real, GetParam(), motion)),
                                     &expected);
    ours.api.rtcGetSceneLinearBounds(ours.SceneOf(MovingModel(ours, GetParam(), motion)), &actual);
    ExpectSameBounds(actual.bounds0, expected.bounds0);
    ExpectSameBounds(actual.bounds1, expected.bounds1);
  }
}

// Where the time range is another, the drop-in's are wider than the real library's.
TEST_P(Moving, BoundsHoldWhatMovesAtAllTimes) {
  for (const Motion& motion : kMotions) {
    SCOPED_TRACE(testing::PrintToString(motion));
    const RTCScene scene = ours.SceneOf(MovingModel(ours, GetParam(), motion));
    RTCBounds bounds;
    ours.api.rtcGetSceneBounds(scene, &bounds);
    RTCLinearBounds linear;
    ours.api.rtcGetSceneLinearBounds(scene, &linear);
    for (int i = 0; i < kRays; ++i) {
      const float time = static_cast<float>(i) / (kRays - 1);
      if (time < motion.begin || time > motion.end) continue;
      const float z = PlaneAt(motion, time);
      constexpr float kRounding = 8 * std::numeric_limits<float>::epsilon();
      EXPECT_LE(bounds.lower_z, z + kRounding);
      EXPECT_GE(bounds.upper_z, z - kRounding);
      EXPECT_LE(std::lerp(linear.bounds0.lower_z, linear.bounds1.lower_z, time), z + kRounding);
      EXPECT_GE(std::lerp(linear.bounds0.upper_z, linear.bounds1.upper_z, time), z - kRounding);
    }
  }
}

class DropInMoving : public testing::Test {
 protected:
  Session s{DropIn()};
};

TEST_F(DropInMoving, GridsComeAndGoAsQuadsDo) {
  for (const Motion& motion : kMotions) {
    SCOPED_TRACE(testing::PrintToString(motion));
    const RTCScene grid = s.SceneOf(MovingModel(s, RTC_GEOMETRY_TYPE_GRID, motion));
    const RTCScene quad = s.SceneOf(MovingModel(s, RTC_GEOMETRY_TYPE_QUAD, motion));
    ForEachCall([&](const Form& form, Query query) {
      const auto actual = TraceInTime(s, grid, form, query);
      const auto expected = TraceInTime(s, quad, form, query);
      for (int i = 0; i < kRays; ++i) {
        EXPECT_FLOAT_EQ(actual[i].ray.tfar, expected[i].ray.tfar) << "ray " << i;
      }
    });
  }
}

// The real library stops the program.
TEST_F(DropInMoving, GeometriesOfOtherTimesAreNotHit) {
  for (const RTCGeometryType type : kSupportedTypes) {
    for (const Motion& motion : {Motion{3, -2, -1}, Motion{3, 2, 3}}) {
      const RTCScene scene = s.SceneOf(MovingModel(s, type, motion));
      ForEachCall([&](const Form& form, Query query) {
        const auto rays = TraceInTime(s, scene, form, query);
        for (const RTCRayHit& record : rays) {
          EXPECT_EQ(record.hit.geomID, RTC_INVALID_GEOMETRY_ID) << NameOf(type);
        }
      });
    }
  }
}

}  // namespace
}  // namespace dacrt::tests

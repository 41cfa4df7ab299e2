#include "acts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

#include "batch_rays.h"
#include "contest.h"
#include "generator.h"
#include "random.h"
#include "watched_device.h"

namespace dacrt::tests {
namespace {

constexpr std::size_t kStandingWorlds = 6;
constexpr std::size_t kRaysOfAWorld = 1000;

/// What changes no bit of an answer. Not the instruction set, and not the threads of the machine.
const char* const kConfigs[] = {"",
                                "threads=1",
                                "threads=2",
                                "threads=2,dacrt_budget=0",
                                "threads=1,dacrt_budget=unlimited",
                                "dacrt_piece_rays=100",
                                "dacrt_budget=0,dacrt_algorithm=mora2011",
                                "threads=2,dacrt_algorithm=afra2012"};

/// A scene whose split is worth several threads.
TestScene ManyTriangles(uint64_t seed, std::size_t count) {
  Random random(seed);
  TestScene scene;
  scene.name = "many";
  TestMesh& mesh = scene.meshes.emplace_back();
  for (std::size_t i = 0; i < count; ++i) {
    const Float3 corner{random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)};
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back({corner.x + random.Uniform(-0.02f, 0.02f),
                                corner.y + random.Uniform(-0.02f, 0.02f),
                                corner.z + random.Uniform(-0.02f, 0.02f)});
    }
    const auto first = static_cast<uint32_t>(3 * i);
    mesh.triangles.push_back({{first, first + 1, first + 2}});
  }
  return scene;
}

std::vector<RTCRayHit> RaysFor(const TestScene& scene, uint64_t seed, std::size_t count) {
  const RayGenerator generator(scene, [](std::span<RTCRayHit>) {});
  return generator.Make(RayKind::kRandomLines, count, seed);
}

Form AnyForm(Random& random) {
  std::vector<Form> forms = StreamForms();
  if (random.Chance(0.3f)) forms = PacketForms();
  return forms[random.Below(static_cast<uint32_t>(forms.size()))];
}

/// As MakeRays, but none begins behind its origin: what a user function finds there depends on the
/// boxes that are entered.
void MakeRaysAhead(Batch& batch, uint64_t seed, const std::vector<WorldScene>& scenes,
                   const PlayedWorld& probe) {
  MakeRays(batch, seed, scenes, probe);
  for (RTCRayHit& record : batch.rays) {
    if (record.ray.tnear < 0) record.ray.tnear = 0;
  }
}

std::string Text(const char* act, uint64_t seed, const std::string& what) {
  return std::string(act) + ", seed " + std::to_string(seed) + ": " + what;
}

/// The distance of the nearest first vertex of the scene's triangles, by a point query.
float NearestFirstVertex(RTCScene scene, const TestScene& triangles, const Float3& point) {
  struct Search {
    const TestScene& triangles;
    Float3 point;
  } search{triangles, point};
  const auto function = [](RTCPointQueryFunctionArguments* arguments) {
    const Search& s = *static_cast<const Search*>(arguments->userPtr);
    const TestMesh& mesh = s.triangles.meshes[arguments->geomID];
    const Float3& v = mesh.positions[mesh.triangles[arguments->primID].vertex[0]];
    const float x = v.x - s.point.x, y = v.y - s.point.y, z = v.z - s.point.z;
    const float distance = std::sqrt(x * x + y * y + z * z);
    if (!(distance < arguments->query->radius)) return false;
    arguments->query->radius = distance;
    return true;
  };
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query{point.x, point.y, point.z, 0, std::numeric_limits<float>::infinity()};
  rtcPointQuery(scene, &query, &context, function, &search);
  return query.radius;
}

}  // namespace

/// A scene that stays, and the answers to its batches when one thread asked.
struct Acts::Standing {
  World world;
  std::unique_ptr<PlayedWorld> played;
  std::vector<Batch> batches;
  std::vector<std::vector<RTCRayHit>> answers;
};

Acts::Acts(uint64_t seed) : common_(DropIn(), "threads=2") {
  Features features;
  features.set();
  for (std::size_t i = 0; i < kStandingWorlds; ++i) {
    auto standing = std::make_unique<Standing>();
    standing->world = MakeWorld(SeedFor("standing", seed + i), features, kRaysOfAWorld);
    standing->played = std::make_unique<PlayedWorld>(common_, standing->world.scenes);
    for (Batch batch : standing->world.stages.front().batches) {
      MakeRaysAhead(batch, SeedFor("standing rays", seed + i), standing->world.scenes,
                    *standing->played);
      CallContext call = MakeContext(batch.context_filter);
      standing->answers.push_back(standing->played->Trace(batch, batch.rays, call));
      standing->batches.push_back(std::move(batch));
    }
    standing_.push_back(std::move(standing));
  }
  common_.CheckErrors();
}

Acts::~Acts() = default;

void Acts::Act(uint64_t seed) const {
  const auto kind = static_cast<Kind>(Random(seed).Below(kKindCount));
  ++counts_[kind];
  switch (kind) {
    case kAskStanding:
      return AskStanding(seed);
    case kPlayWorld:
      return PlayWorld(seed);
    case kSplitAnew:
      return SplitAnew(seed);
    case kRefuseMemory:
      return RefuseMemory(seed);
    default:
      return Churn(seed);
  }
}

void Acts::Compare(const char* act, uint64_t seed, std::span<const RTCRayHit> expected,
                   std::span<const RTCRayHit> answers) const {
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (std::memcmp(&expected[i], &answers[i], sizeof(RTCRayHit)) != 0) {
      throw std::runtime_error(Text(act, seed, "another answer to ray " + std::to_string(i)));
    }
  }
  rays_ += expected.size();
}

void Acts::AskStanding(uint64_t seed) const {
  Random random(SeedFor("ask", seed));
  for (int turn = 0; turn < 10; ++turn) {
    const Standing& standing = *standing_[random.Below(kStandingWorlds)];
    if (standing.batches.empty()) continue;
    const uint32_t which = random.Below(static_cast<uint32_t>(standing.batches.size()));
    Batch batch = standing.batches[which];
    batch.rays_per_call = 1 + random.Below(random.Chance(0.5f) ? 64 : 4096);
    CallContext call = MakeContext(batch.context_filter);
    Compare("ask", seed, standing.answers[which], standing.played->Trace(batch, batch.rays, call));
    common_.CheckErrors();
  }
}

void Acts::PlayWorld(uint64_t seed) const {
  Random random(SeedFor("play", seed));
  Features features;
  features.set();
  const World world = MakeWorld(SeedFor("world", seed), features, kRaysOfAWorld);
  WatchedDevice own(kConfigs[random.Below(std::size(kConfigs))]);
  {
    std::vector<WorldScene> scenes = world.scenes;
    PlayedWorld here(common_, scenes), there(own.device(), scenes);
    uint64_t number = 0;
    for (const Stage& stage : world.stages) {
      if (!stage.changes.empty()) {
        here.Commit(stage.changes);
        there.Commit(stage.changes);
        for (const Change& change : stage.changes) Apply(change, scenes);
      }
      for (Batch batch : stage.batches) {
        MakeRaysAhead(batch, SeedFor("rays", seed + number++), scenes, here);
        CallContext call = MakeContext(batch.context_filter);
        CallContext other = MakeContext(batch.context_filter);
        Compare("play", seed, here.Trace(batch, batch.rays, call),
                there.Trace(batch, batch.rays, other));
        if (!call.fault.empty()) throw std::runtime_error(Text("play", seed, call.fault));
      }
    }
    common_.CheckErrors();
    own.device().CheckErrors();
  }
}

void Acts::SplitAnew(uint64_t seed) const {
  Random random(SeedFor("split", seed));
  const TestScene triangles = ManyTriangles(seed, 60'000);
  const std::vector<RTCRayHit> rays = RaysFor(triangles, seed, 4000);
  const Form form = AnyForm(random);
  const EmbreeScene here(common_, triangles);
  std::vector<RTCRayHit> of_helper, own;
  float nearest_of_helper = 0;
  const Float3 point{random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)};
  {
    const std::jthread helper([&] {
      of_helper = Trace(here, form, Query::kClosest, rays);
      nearest_of_helper = NearestFirstVertex(here.handle(), triangles, point);
    });
    own = Trace(here, form, Query::kClosest, rays);
  }
  Compare("split", seed, own, of_helper);
  if (NearestFirstVertex(here.handle(), triangles, point) != nearest_of_helper) {
    throw std::runtime_error(Text("split", seed, "another answer to a point query"));
  }
  const EmbreeDevice alone(DropIn(), "threads=1,dacrt_budget=0");
  const EmbreeScene there(alone, triangles);
  Compare("split", seed, Trace(there, form, Query::kClosest, rays), own);
}

void Acts::RefuseMemory(uint64_t seed) const {
  Random random(SeedFor("refuse", seed));
  Features features;
  features.set();
  const World world = MakeWorld(SeedFor("world", seed), features, kRaysOfAWorld);
  WatchedDevice own(random.Chance(0.5f) ? "threads=1" : "threads=2");
  const auto out_of_memory = [&] {
    const RTCError error = DropIn().rtcGetDeviceError(own.device().handle());
    if (error == RTC_ERROR_NONE) return false;
    if (error != RTC_ERROR_OUT_OF_MEMORY) {
      throw std::runtime_error(Text("refuse", seed, "error " + std::to_string(error)));
    }
    ++refusals_;
    return true;
  };
  {
    own.RefuseEvery(1 + random.Below(6));
    try {
      const PlayedWorld in_vain(own.device(), world.scenes);
    } catch (const std::runtime_error&) {
      ++refusals_;
    }
    own.RefuseEvery(0);
    out_of_memory();
    const PlayedWorld here(own.device(), world.scenes), there(common_, world.scenes);
    for (Batch batch : world.stages.front().batches) {
      MakeRaysAhead(batch, SeedFor("rays", seed), world.scenes, there);
      CallContext call = MakeContext(batch.context_filter);
      const std::vector<RTCRayHit> expected = there.Trace(batch, batch.rays, call);
      own.RefuseEvery(1 + random.Below(4));
      CallContext refused_call = MakeContext(batch.context_filter);
      std::vector<RTCRayHit> answers = here.Trace(batch, batch.rays, refused_call);
      own.RefuseEvery(0);
      if (out_of_memory()) {
        CallContext again = MakeContext(batch.context_filter);
        answers = here.Trace(batch, batch.rays, again);
      }
      Compare("refuse", seed, expected, answers);
    }
    common_.CheckErrors();
    own.device().CheckErrors();
  }
}

void Acts::Churn(uint64_t seed) const {
  Random random(SeedFor("churn", seed));
  const RTCDevice device = common_.handle();
  const auto expect = [&](RTCError code, const char* what) {
    if (rtcGetDeviceError(device) != code) throw std::runtime_error(Text("churn", seed, what));
  };
  rtcRetainDevice(device);
  for (int turn = 0; turn < 100; ++turn) {
    const RTCScene scene = rtcNewScene(device);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const RTCBuffer buffer = rtcNewBuffer(device, 16 + random.Below(4096));
    std::memset(rtcGetBufferData(buffer), 0, 16);
    auto* const vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3));
    const float corners[9] = {0, 0, 1, 1, 0, 1, 0, 1, 1};
    std::copy_n(corners, 9, vertices);
    rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, buffer, 0, 12, 1);
    rtcCommitGeometry(geometry);
    const unsigned int id = rtcAttachGeometry(scene, geometry);
    rtcRetainScene(scene);
    rtcReleaseBuffer(buffer);
    rtcReleaseGeometry(geometry);
    expect(RTC_ERROR_NONE, "an error of a good call");
    switch (random.Below(4)) {
      case 0:
        rtcSetGeometryMask(rtcGetGeometry(scene, id + 1), 1);
        rtcGetDeviceError(device);
        break;
      case 1:
        rtcSetGeometryTimeStepCount(geometry, RTC_MAX_TIME_STEP_COUNT + 1);
        expect(RTC_ERROR_INVALID_ARGUMENT, "no error of a wrong call");
        break;
      case 2:
        rtcDetachGeometry(scene, id + 7);
        expect(RTC_ERROR_INVALID_OPERATION, "no error of a wrong call");
        break;
      default:
        rtcSetGeometryUserData(geometry, device);
        if (rtcGetGeometryUserData(rtcGetGeometryThreadSafe(scene, id)) != device) {
          throw std::runtime_error(Text("churn", seed, "another pointer"));
        }
    }
    rtcCommitScene(scene);
    float value[3] = {-1, -1, -1};
    rtcInterpolate0(geometry, 0, 0.25f, 0.25f, RTC_BUFFER_TYPE_VERTEX, 0, value, 3);
    if (value[2] != 1) throw std::runtime_error(Text("churn", seed, "another value"));
    rtcReleaseScene(scene);
    rtcReleaseScene(scene);
  }
  rtcReleaseDevice(device);
}

}  // namespace dacrt::tests

// The same queries to the real Embree and to the drop-in: every difference must have a reason that
// the double-precision reference proves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iostream>
#include <iterator>
#include <map>
#include <sstream>

#include "contest.h"
#include "random.h"

namespace dacrt::tests {
namespace {

/// Rays of the whole test program, shared between the scenes. conformance_run takes more.
constexpr std::size_t kRays = 10'000'000;

constexpr uint64_t kSeed = 1;

/// Fails for what is unexplained; prints what was counted.
void Check(const Report& report) {
  std::ostringstream text;
  if (report.Total().Count(Relation::kUnexplained)) report.PrintExamples(text);
  report.PrintTable(text);
  std::cout << text.str();
  EXPECT_EQ(report.Total().Count(Relation::kUnexplained), 0u);
}

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const SceneSource& source : AllScenes()) names.push_back(source.name);
  return names;
}

TEST(Libraries, AreTwo) {
  // They share a SONAME, so the dynamic linker could have taken one for the other.
  EXPECT_NE(RealEmbree().rtcNewDevice, DropIn().rtcNewDevice);
  EXPECT_NE(RealEmbree().rtcIntersect1M, DropIn().rtcIntersect1M);
}

class SceneTest : public testing::TestWithParam<std::string> {};

TEST_P(SceneTest, AnswersAreEmbrees) {
  const TestScene scene = MakeScene(GetParam());
  const Devices devices;
  Report report;
  Contest contest(devices, scene, report);
  EXPECT_TRUE(contest.BoundsAreEqual());
  contest.CompareEverything(kRays / SceneNames().size(), kSeed, [](const std::string&) {});
  Check(report);
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneTest, testing::ValuesIn(SceneNames()),
                         [](const auto& name) { return name.param; });

/// What changes how an answer is found: what is kept, threads, pieces, instruction sets.
class ConfigTest : public testing::TestWithParam<std::string> {};

TEST_P(ConfigTest, AnswersAreEmbrees) {
  constexpr std::size_t kRaysAScene = 60'000;
  const Devices devices(GetParam(), {"isa=avx2"});
  Report report;
  for (const char* const name : {"hall", "soup", "masks", "coincident"}) {
    const TestScene scene = MakeScene(name);
    Contest contest(devices, scene, report);
    contest.CompareEverything(kRaysAScene, kSeed, [](const std::string&) {});
  }
  Check(report);
}

std::vector<std::string> Configs() {
  std::vector<std::string> configs = {
      "dacrt_budget=0", "dacrt_budget=unlimited",  "dacrt_budget=100000", "threads=1", "threads=2",
      "threads=8",      "threads=8,dacrt_budget=0"};
  std::ranges::copy(IsaConfigs(), std::back_inserter(configs));
  return configs;
}

INSTANTIATE_TEST_SUITE_P(Configs, ConfigTest, testing::ValuesIn(Configs()), [](const auto& config) {
  std::string name = config.param;
  std::ranges::replace_if(
      name, [](char c) { return !std::isalnum(c); }, '_');
  return name;
});

std::vector<Form> AllForms() {
  std::vector<Form> forms = StreamForms();
  for (const Form& form : PacketForms()) forms.push_back(form);
  return forms;
}

class FormTest : public testing::TestWithParam<Form> {};

TEST_P(FormTest, EveryKindOfRayOfBothQueries) {
  // Forms of few rays get fewer: each of their calls costs a partition of the scene.
  const std::size_t rays_per_kind =
      GetParam().call == Form::Call::kRecord || GetParam().call == Form::Call::kPacket
          ? 100 * GetParam().lanes
          : 1'000;
  const Devices devices;
  Report report;
  for (const char* const name : {"masks", "coplanar", "single", "layouts"}) {
    const TestScene scene = MakeScene(name);
    Contest contest(devices, scene, report);
    for (const RayKind kind : AllRayKinds()) {
      for (const Query query : {Query::kClosest, Query::kAny}) {
        contest.Compare(GetParam(), query, Name(kind),
                        contest.MakeRays(kind, rays_per_kind, SeedFor(name, kSeed)));
      }
    }
  }
  Check(report);
}

TEST_P(FormTest, EveryNumberOfRays) {
  const Devices devices;
  const TestScene scene = MakeScene("single");
  Report report;
  Contest contest(devices, scene, report);
  for (std::size_t count = 0; count <= 70; ++count) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      contest.Compare(GetParam(), query, "hostile",
                      contest.MakeRays(RayKind::kHostile, count, count));
    }
  }
  Check(report);
}

INSTANTIATE_TEST_SUITE_P(Forms, FormTest, testing::ValuesIn(AllForms()),
                         [](const auto& form) { return Name(form.param); });

class LargeStreamTest : public testing::TestWithParam<Form> {};

TEST_P(LargeStreamTest, OfFourMillionRays) {
  // Small, so that the real library and brute force take little time.
  const TestScene scene = MakeScene("coplanar");
  const Devices devices("", {"isa=avx2"});
  Report report;
  Contest contest(devices, scene, report);
  const std::vector<RTCRayHit> rays = contest.MakeRays(RayKind::kDiffuse, 4u << 20, kSeed);
  contest.Compare(GetParam(), Query::kClosest, "diffuse", rays);
  contest.Compare(GetParam(), Query::kAny, "diffuse", rays);
  Check(report);
}

INSTANTIATE_TEST_SUITE_P(Forms, LargeStreamTest,
                         testing::Values(Form{Form::Call::kRecords},
                                         Form{Form::Call::kRecordPointers},
                                         Form{Form::Call::kPackets, false, 8},
                                         Form{Form::Call::kArrays}),
                         [](const auto& form) { return Name(form.param); });

/// Of triangles with the same vertices in the same order, the one with the smallest ids.
class FirstOfEqual {
 public:
  explicit FirstOfEqual(const TestScene& scene) {
    for (const TestMesh& mesh : scene.meshes) {
      for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const Ids ids{mesh.geometry_id, i};
        Ids& first = first_.try_emplace(Key(mesh, i), ids).first->second;
        first = std::min(first, ids);
      }
    }
    for (const TestMesh& mesh : scene.meshes) {
      for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        first_of_[{mesh.geometry_id, i}] = first_.at(Key(mesh, i));
      }
    }
  }

  using Ids = std::pair<uint32_t, uint32_t>;  // geometry, primitive
  Ids Of(const RTCHit& hit) const { return first_of_.at({hit.geomID, hit.primID}); }

 private:
  using Coordinates = std::array<float, 9>;
  static Coordinates Key(const TestMesh& mesh, uint32_t triangle) {
    Coordinates key;
    for (int corner = 0; corner < 3; ++corner) {
      const Float3& position = mesh.positions[mesh.triangles[triangle].vertex[corner]];
      for (int axis = 0; axis < 3; ++axis) key[3 * corner + axis] = position[axis];
    }
    return key;
  }

  std::map<Coordinates, Ids> first_;
  std::map<Ids, Ids> first_of_;
};

TEST(Ties, OfEqualTrianglesTheSmallestIdsAreReported) {
  const TestScene scene = MakeScene("coincident");
  const FirstOfEqual first_of_equal(scene);
  const Devices devices("", {"isa=avx2"});
  Report report;
  Contest contest(devices, scene, report);
  std::size_t hits = 0;
  for (const RayKind kind : {RayKind::kCamera, RayKind::kRandomLines, RayKind::kAxisAligned}) {
    for (const Form& form : {Form{Form::Call::kRecords}, Form{Form::Call::kArrays, true}}) {
      for (const RTCRayHit& record :
           Trace(contest.drop_in(), form, Query::kClosest, contest.MakeRays(kind, 20'000, kSeed))) {
        if (record.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
        ++hits;
        ASSERT_EQ(FirstOfEqual::Ids(record.hit.geomID, record.hit.primID),
                  first_of_equal.Of(record.hit));
      }
    }
  }
  EXPECT_GT(hits, 10'000u);
}

TEST(NotFiniteRays, LeaveTheirNeighboursAlone) {
  const TestScene scene = MakeScene("layouts");
  const Devices devices;
  Report report;
  Contest contest(devices, scene, report);
  const std::vector<RTCRayHit> rays = contest.MakeRays(RayKind::kHostile, 1'000, kSeed);
  std::vector<RTCRayHit> ordinary;
  const auto is_ordinary = [](const RTCRayHit& record) {
    const RTCRay& ray = record.ray;
    const float sum = ray.org_x + ray.org_y + ray.org_z + ray.dir_x + ray.dir_y + ray.dir_z;
    return std::isfinite(sum) && ray.tnear == 0 && ray.tfar > 0;
  };
  std::copy_if(rays.begin(), rays.end(), std::back_inserter(ordinary), is_ordinary);
  ASSERT_LT(ordinary.size(), rays.size());
  for (const Form& form : AllForms()) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      std::vector<RTCRayHit> together = Trace(contest.drop_in(), form, query, rays);
      const std::vector<RTCRayHit> alone = Trace(contest.drop_in(), form, query, ordinary);
      std::size_t next = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!is_ordinary(rays[i])) continue;
        ASSERT_EQ(std::memcmp(&together[i], &alone[next++], sizeof(RTCRayHit)), 0) << Name(form);
      }
    }
  }
}

}  // namespace
}  // namespace dacrt::tests

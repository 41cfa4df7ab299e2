// Under mpirun and dacrt-run, on rank 0: a device with dacrt_mpi=replicate answers as one without.
// Calls are cut into small pieces, so that every rank has some of each.
#include <gtest/gtest.h>

#include "bits.h"
#include "contest.h"
#include "random.h"
#include "worlds.h"

namespace dacrt::tests {
namespace {

constexpr char kOne[] = "threads=1,dacrt_mpi=none";
constexpr char kSeveral[] =
    "threads=1,dacrt_mpi=replicate,dacrt_mpi_least_rays=1,dacrt_mpi_piece_rays=333";

TEST(Configs, ThatMeanNothingAreRefused) {
  for (const char* const config :
       {"dacrt_mpi=yes", "dacrt_mpi", "dacrt_mpi_timeout=0", "dacrt_mpi_timeout=soon",
        "dacrt_mpi_least_rays=-1", "dacrt_mpi_piece_rays=0", "dacrt_mpi_piece_rays=1048577",
        "dacrt_mpi_geometry_ids=x", "dacrt_mpi_speed=9"}) {
    EXPECT_FALSE(DropIn().rtcNewDevice(config)) << config;
    EXPECT_EQ(DropIn().rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT) << config;
  }
}

class ReplicatedSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(ReplicatedSceneTest, HasTheBitsOfOneProcess) {
  const TestScene scene = MakeScene(GetParam());
  const EmbreeDevice one(DropIn(), kOne), several(DropIn(), kSeveral);
  const EmbreeScene one_scene(one, scene), several_scene(several, scene);
  const RayGenerator generator(scene, one_scene);
  const std::vector<RTCRayHit> rays = MixedRays(generator, 100, SeedFor(GetParam(), 1));
  for (const Query query : {Query::kClosest, Query::kAny}) {
    for (const Form& form : StreamForms()) {
      SCOPED_TRACE(Name(form));
      ExpectSame(rays, Trace(one_scene, form, query, rays),
                 Trace(several_scene, form, query, rays));
    }
  }
  several.CheckErrors();
}

INSTANTIATE_TEST_SUITE_P(Scenes, ReplicatedSceneTest, testing::ValuesIn(SceneNames()),
                         [](const auto& name) { return name.param; });

class ReplicatedWorldTest : public testing::TestWithParam<WorldShare> {};

/// Every shape, moving and changing, instances, and scenes that stay on rank 0.
TEST_P(ReplicatedWorldTest, HasTheBitsOfOneProcess) {
  const EmbreeDevice one(DropIn(), kOne), several(DropIn(), kSeveral);
  ExpectSameWorlds(one, several, GetParam(), 15, 0, 1);
}

INSTANTIATE_TEST_SUITE_P(, ReplicatedWorldTest, testing::ValuesIn(kWorldShares),
                         [](const auto& share) { return std::string(share.param.name); });

}  // namespace
}  // namespace dacrt::tests

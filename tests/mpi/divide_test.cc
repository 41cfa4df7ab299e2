// Under mpirun, on every rank: a scene of which each rank has a part is answered, for the rays of
// each rank, as one process answers that has all of it.
#include <gtest/gtest.h>
#include <mpi.h>

#include <algorithm>

#include "bits.h"
#include "contest.h"
#include "random.h"
#include "worlds.h"

namespace dacrt::tests {
namespace {

constexpr char kOne[] = "threads=1,dacrt_mpi=none";
// A test that fails on one rank only should not keep the others for long.
constexpr char kSeveral[] =
    "threads=1,dacrt_mpi=divide,dacrt_mpi_piece_rays=333,dacrt_mpi_timeout=60";

int Rank() {
  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int Ranks() {
  int ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks;
}

/// Its meshes in several: runs of triangles, whose bounds overlap less the more local the mesh is.
/// Every other scene has them in stripes instead, whose bounds all overlap.
TestScene InManyMeshes(const TestScene& scene) {
  constexpr std::size_t kMeshesEach = 5;
  const bool in_stripes = scene.name.size() % 2 == 0;
  TestScene parts{scene.name, {}, scene.cameras};
  for (const TestMesh& mesh : scene.meshes) {
    const std::size_t run = mesh.triangles.size() / kMeshesEach + 1;
    for (std::size_t part = 0; part < kMeshesEach; ++part) {
      TestMesh& piece = parts.meshes.emplace_back(mesh);
      // Backwards, so that IDs and ranks are not in the same order.
      piece.geometry_id = mesh.geometry_id * 8 + static_cast<uint32_t>(kMeshesEach - part);
      piece.triangles.clear();
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if ((in_stripes ? i % kMeshesEach : i / run) == part) {
          piece.triangles.push_back(mesh.triangles[i]);
        }
      }
    }
  }
  return parts;
}

class DividedSceneTest : public testing::TestWithParam<std::string> {};

TEST_P(DividedSceneTest, HasTheBitsOfOneProcess) {
  const TestScene whole = InManyMeshes(MakeScene(GetParam()));
  TestScene part = whole;
  part.meshes.clear();
  for (std::size_t i = 0; i < whole.meshes.size(); ++i) {
    if (static_cast<int>(i) % Ranks() == Rank()) part.meshes.push_back(whole.meshes[i]);
  }
  const EmbreeDevice one(DropIn(), kOne), several(DropIn(), kSeveral);
  for (const RTCSceneFlags flags : {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_ROBUST}) {
    const EmbreeScene one_scene(one, whole, flags), several_scene(several, part, flags);
    const RayGenerator generator(whole, one_scene);
    // Every rank its own rays, and not as many as the others.
    const auto seed = SeedFor(GetParam(), 100 + static_cast<uint64_t>(Rank()));
    const std::size_t own = static_cast<std::size_t>(Rank());
    const std::vector<RTCRayHit> many = MixedRays(generator, 80 + 37 * own, seed);
    const std::vector<RTCRayHit> few = MixedRays(generator, 20 + 3 * own, seed);
    for (const Query query : {Query::kClosest, Query::kAny}) {
      for (const Form& form : StreamForms()) {
        SCOPED_TRACE(Name(form));
        // How records lie in memory matters little: one scene is enough for most forms.
        const bool is_usual = form.call == Form::Call::kRecords && form.gap == 0;
        if (!is_usual && GetParam() != "masks") continue;
        const auto& rays = is_usual ? many : few;
        ExpectSame(rays, Trace(one_scene, form, query, rays),
                   Trace(several_scene, form, query, rays));
      }
    }
  }
  several.CheckErrors();
}

INSTANTIATE_TEST_SUITE_P(Scenes, DividedSceneTest, testing::ValuesIn(SceneNames()),
                         [](const auto& name) { return name.param; });

/// A rank without rays works on those of others.
TEST(DividedCalls, MayHaveNoRaysOnSomeRanks) {
  const TestScene whole = InManyMeshes(MakeScene("hall"));
  TestScene part = whole;
  part.meshes = {whole.meshes[static_cast<std::size_t>(Rank()) % whole.meshes.size()]};
  if (Rank() >= static_cast<int>(whole.meshes.size())) part.meshes.clear();
  if (Rank() == Ranks() - 1) {
    part.meshes.assign(whole.meshes.begin() + Rank(), whole.meshes.end());
  }
  const EmbreeDevice one(DropIn(), kOne), several(DropIn(), kSeveral);
  const EmbreeScene one_scene(one, whole), several_scene(several, part);
  const RayGenerator generator(whole, one_scene);
  std::vector<RTCRayHit> rays;
  if (Rank() == 0) rays = MixedRays(generator, 300, 5);
  for (const Query query : {Query::kClosest, Query::kAny}) {
    ExpectSame(rays, Trace(one_scene, {Form::Call::kRecords}, query, rays),
               Trace(several_scene, {Form::Call::kRecords}, query, rays));
  }
  several.CheckErrors();
}

class DividedWorldTest : public testing::TestWithParam<WorldShare> {};

/// Every shape, moving and changing, with callbacks that run where their geometry is.
TEST_P(DividedWorldTest, HasTheBitsOfOneProcess) {
  const EmbreeDevice one(DropIn(), kOne), several(DropIn(), kSeveral);
  ExpectSameWorlds(one, several, GetParam(), 10, Rank(), Ranks());
}

INSTANTIATE_TEST_SUITE_P(, DividedWorldTest, testing::ValuesIn(kWorldShares),
                         [](const auto& share) { return std::string(share.param.name); });

}  // namespace
}  // namespace dacrt::tests

int main(int argc, char** argv) {
  int level;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level);
  // One rank tells what is going on, the others only what goes wrong.
  if (dacrt::tests::Rank() > 0) GTEST_FLAG_SET(brief, true);
  testing::InitGoogleTest(&argc, argv);
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return failed;
}

#include "paper/paper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/kernels.h"
#include "geometry/triangle_refs.h"
#include "instruction_sets.h"
#include "runtime/step_clock.h"
#include "runtime/workspace.h"
#include "scene/scene_parts.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::Mesh;
using unit::Random;
using unit::Ray;

/// From one point into a narrow cone, as from a camera: space partition makes packets of them.
std::vector<Ray> ConeOfRays(Random& random, std::size_t count) {
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    ray = unit::MakeRay({0, 0, -9}, {random.Uniform(-0.1f, 0.1f), random.Uniform(-0.1f, 0.1f), 1});
  }
  return rays;
}

/// A mesh without a partition, and rays solved in a batch whose slots hold what a test wants.
class Paper {
 public:
  Paper(const Mesh& mesh, bool robust, const Settings& settings) : settings_(settings) {
    geometry_.vertices = {{mesh.vertices.data(), sizeof(unit::Float3)}};
    geometry_.vertex_count = mesh.vertices.size();
    geometry_.primitives = {mesh.triangles.data(), 3 * sizeof(uint32_t)};
    geometry_.primitive_count = mesh.triangles.size();
    const SceneParts* const no_scene = nullptr;
    scene_ = std::make_unique<SceneParts>(
        SceneParts{GeometryTable({&geometry_, 1}, {&no_scene, 1}, robust)});
  }

  /// Before the rays are loaded every slot is a copy of `junk` with a number that no ray has. There
  /// is room for the rays, and for copies of them in `spare` slots.
  std::vector<Ray> Solve(Query query, std::vector<Ray> rays, std::size_t spare, const Ray& junk) {
    const GeometryTable& geometries = scene_->geometries;
    Workspace workspace;
    workspace.Reserve(WorkspaceShape::ForPaper(geometries.triangle_count(), rays.size(),
                                               geometries.is_plain(), settings_));
    RayBatch batch = workspace.batch();
    for (std::size_t slot = 0; slot < batch.capacity; ++slot) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        batch.org[axis][slot] = junk.org[axis];
        batch.dir[axis][slot] = junk.dir[axis];
      }
      batch.tnear[slot] = junk.tnear;
      batch.tfar[slot] = junk.tfar;
      batch.index[slot] = UINT32_MAX;
    }
    const RayView view = unit::ViewOf(rays);
    const RayBlock block = LoadRays(view, 0, rays.size(), query, geometries, batch);
    batch.capacity = std::min(batch.capacity, batch.top + spare);
    const CallOptions options;
    const CallFrame frame{&view, nullptr, 0, options, UINT32_MAX};
    StepClock clock;
    statistics = {};
    const PaperTask task{
        *scene_, settings_, workspace.refs(), batch, workspace.scratch(), statistics, clock, frame};
    InstructionSet chosen;
    const PaperKernels& kernels = ChooseKernels(settings_.instruction_set, chosen).paper;
    kernels.solve(query, task, MakeTriangleRefs(geometries, workspace.refs()), block);
    kernels.store(query, view, 0, task, block);
    return rays;
  }

  Statistics statistics;

 private:
  Geometry geometry_;
  Settings settings_;
  std::unique_ptr<SceneParts> scene_;
};

class PaperTest : public unit::OnEachInstructionSet {};
INSTANTIATE_ON_EACH_INSTRUCTION_SET(PaperTest);

// A packet of rays that could not be filtered for want of room was solved as if it were full: what
// stood in the lanes behind its last ray was traced, and a hit stored under its number.
TEST_P(PaperTest, PaddedLanesAreNoRaysWhereFilteringFindsNoRoom) {
  Random random(1);
  const Mesh mesh = unit::MakeSoup(random, 1000, 1, 0.2f);
  for (const Algorithm algorithm :
       {Algorithm::kNabata2013, Algorithm::kAfra2012, Algorithm::kMora2011}) {
    Settings settings = WithInstructionSet();
    settings.algorithm = algorithm;
    settings.skip_filtering = false;
    for (const bool robust : {false, true}) {
      Paper paper(mesh, robust, settings);
      for (const std::size_t count : {1u, 9u, 17u, 63u, 65u, 100u}) {
        const std::vector<Ray> rays = ConeOfRays(random, count);
        Ray not_a_ray = rays[0];
        not_a_ray.org.fill(unit::kNaN);
        for (const Query query : {Query::kClosest, Query::kAny}) {
          const std::vector<Ray> expected = paper.Solve(query, rays, SIZE_MAX / 2, not_a_ray);
          for (const Ray& junk : {rays[0], not_a_ray}) {
            const std::vector<Ray> actual = paper.Solve(query, rays, kMaxLanes, junk);
            EXPECT_EQ(paper.statistics.filters, 0u);
            for (std::size_t i = 0; i < count; ++i) {
              ASSERT_TRUE(unit::SameBits(actual[i], expected[i]))
                  << Name(algorithm) << ", robust " << robust << ", ray " << i << " of " << count;
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace dacrt

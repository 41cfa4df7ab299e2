// Single any-hit rays learn from which end of a node to visit its children.
#include <gtest/gtest.h>

#include <vector>

#include "engine/kernels.h"
#include "instruction_sets.h"
#include "partition/kept_partition.h"
#include "runtime/memory_account.h"
#include "runtime/tasks.h"
#include "runtime/workspace.h"
#include "scene/scene_parts.h"
#include "unit_test.h"

namespace dacrt::unit {
namespace {

/// Clutter that few rays along x hit, and behind it a wall of many triangles that all of them hit,
/// which stands where x is `sign`.
Mesh MakeWallBehindClutter(float sign) {
  Random random(1);
  Mesh mesh;
  for (int i = 0; i < 2000; ++i) {
    const float x = sign * random.Uniform(-1, 0.8f), y = random.Uniform(-1, 1);
    const float z = random.Uniform(-1, 1);
    mesh.Add({x, y, z}, {x + 0.01f, y, z}, {x, y + 0.01f, z + 0.001f});
  }
  constexpr int kSide = 24;
  const auto corner = [&](int y, int z) {
    const auto place = [](int i) { return 2.2f * static_cast<float>(i) / kSide - 1.1f; };
    return Float3{sign, place(y), place(z)};
  };
  for (int y = 0; y < kSide; ++y) {
    for (int z = 0; z < kSide; ++z) {
      mesh.Add(corner(y, z), corner(y + 1, z), corner(y, z + 1));
      mesh.Add(corner(y + 1, z), corner(y + 1, z + 1), corner(y, z + 1));
    }
  }
  return mesh;
}

class LoneOrderTest : public OnEachInstructionSet {
 protected:
  /// Traces rays that the wall blocks. Returns whether they learnt to go backwards.
  bool LearnsToGoBackwards(float sign) {
    const Mesh mesh = MakeWallBehindClutter(sign);
    InstructionSet chosen;
    const Kernels kernels = ChooseKernels(GetParam(), chosen);
    SceneParts scene{GeometryTable(std::vector{mesh.View()})};
    scene.kept = std::make_unique<KeptPartition>(scene.geometries, 64 * mesh.triangles.size(),
                                                 kernels.partition.first_look, tasks_, nullptr);
    scene.bounds = scene.kept->bounds();
    scene.triangle_count = mesh.triangles.size();
    WorkspacePool pool(memory_);
    Random random(2);
    for (int i = 0; i < 30'000; ++i) {
      float record[kPacketComponents] = {
          -2 * sign, random.Uniform(-1, 1),         random.Uniform(-1, 1),         0,
          sign,      random.Uniform(-1e-3f, 1e-3f), random.Uniform(-1e-3f, 1e-3f), 0,
          10};
      const RayPacket packet{.values = record, .has_masks = false};
      kernels.trace.single[static_cast<int>(Query::kAny)](scene, packet, {}, pool);
      EXPECT_LT(record[static_cast<int>(PacketComponent::kTfar)], 0);
    }
    return scene.kept->goes_backwards();
  }

  const MemoryAccount memory_{MemoryMonitor{}};
  TaskPool tasks_{1};
};

// What is best in a scene is worst in its mirror image.
TEST_P(LoneOrderTest, TheCheaperEndComesFirst) {
  EXPECT_NE(LearnsToGoBackwards(1), LearnsToGoBackwards(-1));
}

INSTANTIATE_ON_EACH_INSTRUCTION_SET(LoneOrderTest);

}  // namespace
}  // namespace dacrt::unit

// Instances: the rays that enter one are gathered in the space of the instanced scene, and solved
// there as one batch. Its partition serves all of its instances.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/workspace.h"
#include "solve/solve_task.h"

namespace dacrt {

class InstanceRays {
 public:
  /// `geometry` is an instance of the task's scene.
  InstanceRays(const SolveTask& task, uint32_t geometry);

  /// Takes the ray in `slot`. There must be room.
  void Add(std::size_t slot);
  bool IsFull() const { return count_ == most_; }

  /// Solves the rays that were added, and gives what they hit to the task's.
  void Solve(Query query);

 private:
  const SolveTask& task_;
  const uint32_t geometry_;
  const SceneParts& scene_;
  Workspace& memory_;
  RayBatch batch_;
  std::size_t most_;
  std::size_t count_ = 0;
};

}  // namespace dacrt

// What the calls of a device share.
#pragma once

#include "dacrt/dacrt.h"
#include "runtime/tasks.h"
#include "runtime/workspace.h"
#include "solve/solve.h"

namespace dacrt {

class Device::Implementation {
 public:
  Implementation(const Settings& settings, MemoryMonitor monitor);

  /// Whether a scene of so many triangles keeps its partition, and in how many bytes.
  bool Keeps(std::size_t triangles, Keep keep) const;
  std::size_t BudgetBytes(std::size_t triangles) const;

  /// What splitting a scene of so many triangles takes beside the workspaces.
  std::size_t GridBytes(std::size_t triangles) const;

  /// See Device::WorkspaceBytes.
  std::size_t CallBytes(std::size_t triangles, std::size_t rays, bool keeps) const;

  Settings settings;
  InstructionSet instruction_set;
  const Kernels& kernels;
  MemoryAccount memory;
  WorkspacePool workspaces;
  TaskPool tasks;
};

}  // namespace dacrt

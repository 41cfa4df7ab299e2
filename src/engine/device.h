// What the calls of a device share.
#pragma once

#include "dacrt/dacrt.h"
#include "runtime/workspace.h"
#include "solve/solve.h"

namespace dacrt {

class Device::Implementation {
 public:
  explicit Implementation(const Settings& settings);

  Settings settings;
  InstructionSet instruction_set;
  const Kernels& kernels;
  WorkspacePool workspaces;
};

}  // namespace dacrt

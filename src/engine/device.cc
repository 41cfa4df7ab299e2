#include "engine/device.h"

#include <algorithm>

namespace dacrt {

Device::Implementation::Implementation(const Settings& settings)
    : settings(settings), kernels(ChooseKernels(settings.instruction_set, instruction_set)) {}

Device::Device(const Settings& settings) {
  Validate(settings);
  implementation_ = std::make_unique<Implementation>(settings);
}

Device::~Device() = default;

const Settings& Device::settings() const { return implementation_->settings; }

InstructionSet Device::instruction_set() const { return implementation_->instruction_set; }

std::size_t Device::WorkspaceBytes(std::size_t triangle_count, std::size_t ray_count) const {
  const std::size_t piece_rays = std::min<std::size_t>(ray_count, settings().piece_rays);
  return WorkspaceShape(triangle_count, piece_rays, settings()).Bytes();
}

std::size_t Device::WorkspaceBytesHeld() const { return implementation_->workspaces.BytesHeld(); }

void Device::ReleaseIdleWorkspaces() { implementation_->workspaces.ReleaseIdle(); }

}  // namespace dacrt

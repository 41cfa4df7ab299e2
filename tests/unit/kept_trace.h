// The same rays by every way into a scene: calls of any size, packets, single rays.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "forms.h"
#include "instruction_sets.h"
#include "unit_test.h"

namespace dacrt::unit {

inline constexpr Form kRecords = {1, false, false};

inline std::vector<FullRay> TraceForm(const Scene& scene, const std::vector<FullRay>& rays,
                                      Query query, const Form& form = kRecords,
                                      const CallOptions& options = {}) {
  FormedRays formed(rays, form);
  scene.Trace(query, formed.View(), options);
  EXPECT_TRUE(formed.GuardsHold());
  return formed.Rays();
}

/// In calls of `count` rays.
inline std::vector<FullRay> TraceInCalls(const Scene& scene, const std::vector<FullRay>& rays,
                                         Query query, std::size_t count) {
  std::vector<FullRay> all;
  for (std::size_t i = 0; i < rays.size(); i += count) {
    const auto end = rays.begin() + static_cast<std::ptrdiff_t>(std::min(i + count, rays.size()));
    const auto some = TraceForm(scene, {rays.begin() + static_cast<std::ptrdiff_t>(i), end}, query);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// In packets of `lanes` lanes, of which those that `valid` says take part.
inline std::vector<FullRay> TracePackets(const Scene& scene, const std::vector<FullRay>& rays,
                                         Query query, uint32_t lanes,
                                         const std::vector<int32_t>* valid, bool has_masks = true) {
  FormedRays formed(rays, {lanes, false, false});
  const RayView view = formed.View();
  for (std::size_t i = 0; i < rays.size(); i += lanes) {
    RayPacket packet;
    packet.values = reinterpret_cast<void*>(view.Address(view.org_x, i));
    packet.lanes = lanes;
    packet.has_masks = has_masks;
    std::vector<int32_t> own(lanes, 0);  // lanes behind the last ray
    for (uint32_t lane = 0; lane < lanes && i + lane < rays.size(); ++lane) {
      own[lane] = valid ? (*valid)[i + lane] : -1;
    }
    if (valid || i + lanes > rays.size()) packet.valid = own.data();
    scene.Trace(query, packet);
  }
  EXPECT_TRUE(formed.GuardsHold());
  return formed.Rays();
}

inline void ExpectSame(const std::vector<FullRay>& actual, const std::vector<FullRay>& expected,
                       const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    const auto text = [](const FullRay& ray) {
      return "t " + std::to_string(ray.Get(PacketComponent::kTfar)) + " instance " +
             std::to_string(ray.Get<uint32_t>(PacketComponent::kInstanceId)) + " geometry " +
             std::to_string(ray.Get<uint32_t>(PacketComponent::kGeometryId)) + " primitive " +
             std::to_string(ray.Get<uint32_t>(PacketComponent::kPrimitiveId)) + " u " +
             std::to_string(ray.Get(PacketComponent::kU));
    };
    ASSERT_TRUE(actual[i] == expected[i])
        << what << ": ray " << i << ": " << text(actual[i]) << ", expected " << text(expected[i]);
  }
}

class KeptTraceTest : public OnEachInstructionSet {
 protected:
  Settings WithBudget(uint64_t budget, uint32_t threads = 1) const {
    Settings settings;
    settings.budget = budget;
    settings.threads = threads;
    return WithInstructionSet(settings);
  }

  std::unique_ptr<Scene> MakeScene(const Mesh& mesh, const Settings& settings) const {
    const TriangleMesh view = mesh.View();
    return std::make_unique<Scene>(std::make_shared<Device>(settings), std::span(&view, 1));
  }
};

}  // namespace dacrt::unit

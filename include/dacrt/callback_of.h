// Callbacks from lambdas and other objects that can be called, with rays and hits instead of
// packets: the easy way to a Callback.
//
//   const auto is_leaf = [&](const RayHit& hit) { return Opacity(hit.hit.u, hit.hit.v) > 0.5f; };
//   tree.closest_filter = tree.any_filter = FilterOf(is_leaf);
//
// The object is the program's, and must live as long as what the callback was given to: a temporary
// does not compile. It must not throw, and is called from the thread that calls Scene::Trace, once
// for each ray: where that is too slow, Callback takes packets.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "dacrt/callback.h"
#include "dacrt/geometry.h"
#include "dacrt/point_query.h"
#include "dacrt/ray.h"

namespace dacrt {

/// One lane of what a callback sees.
inline RayHit ReadLane(const CallbackArguments& arguments, uint32_t lane) {
  uint32_t values[kPacketComponents];
  for (std::size_t i = 0; i < kPacketComponents; ++i) {
    const auto place = (i * arguments.width + lane) * sizeof(uint32_t);
    std::memcpy(&values[i], static_cast<const char*>(arguments.packet) + place, sizeof(uint32_t));
  }
  static_assert(sizeof(RayHit) == sizeof(values));
  return std::bit_cast<RayHit>(values);
}

/// Writes what a callback may change: tfar and the hit.
inline void WriteLane(const CallbackArguments& arguments, uint32_t lane, const RayHit& ray) {
  const auto values = std::bit_cast<std::array<uint32_t, kPacketComponents>>(ray);
  for (std::size_t i = 0; i < kPacketComponents; ++i) {
    const auto component = static_cast<PacketComponent>(i);
    if (component < PacketComponent::kNgX && component != PacketComponent::kTfar) continue;
    const auto place = (i * arguments.width + lane) * sizeof(uint32_t);
    std::memcpy(static_cast<char*>(arguments.packet) + place, &values[i], sizeof(uint32_t));
  }
}

/// A filter function. `filter` is called with a candidate hit, whose distance is the ray's tfar, as
///   bool (RayHit& candidate)   or   bool (RayHit& candidate, const CallbackArguments& arguments)
/// and returns whether it counts. It may change tfar and the hit of one that does.
template <class Filter>
Callback FilterOf(Filter& filter) {
  const auto call = [](void* data, const CallbackArguments& arguments) {
    Filter& object = *static_cast<Filter*>(data);
    for (uint32_t lane = 0; lane < arguments.width; ++lane) {
      if (!arguments.valid[lane]) continue;
      RayHit candidate = ReadLane(arguments, lane);
      bool counts;
      if constexpr (std::is_invocable_v<Filter&, RayHit&, const CallbackArguments&>) {
        counts = object(candidate, arguments);
      } else {
        counts = object(candidate);
      }
      if (counts) {
        WriteLane(arguments, lane, candidate);
      } else {
        arguments.valid[lane] = 0;
      }
    }
  };
  return {call, const_cast<std::remove_const_t<Filter>*>(&filter)};
}
template <class Filter>
Callback FilterOf(const Filter&& filter) = delete;

/// Tells rays from the primitives of a user geometry, for Geometry::intersect and for
/// Geometry::occluded. `test` is called as
///   bool (uint32_t primitive, RayHit& ray)
/// and returns whether the ray hits the primitive between tnear and tfar. If so it has set tfar,
/// and ng, u and v if it likes; the IDs are set here.
template <class Test>
Callback HitTestOf(Test& test) {
  const auto call = [](void* data, const CallbackArguments& arguments) {
    Test& object = *static_cast<Test*>(data);
    for (uint32_t lane = 0; lane < arguments.width; ++lane) {
      if (!arguments.valid[lane]) continue;
      RayHit ray = ReadLane(arguments, lane);
      if (!object(arguments.primitive_id, ray)) continue;
      if (arguments.query == Query::kAny) ray.ray.tfar = -std::numeric_limits<float>::infinity();
      ray.hit.primitive_id = arguments.primitive_id;
      ray.hit.geometry_id = arguments.geometry_id;
      ray.hit.instance_id = arguments.instance_id;
      WriteLane(arguments, lane, ray);
    }
  };
  return {call, const_cast<std::remove_const_t<Test>*>(&test)};
}
template <class Test>
Callback HitTestOf(const Test&& test) = delete;

/// The bounds of user primitives. `bounds` is called as
///   Bounds (uint32_t primitive)   or   Bounds (uint32_t primitive, uint32_t time_step)
template <class Function>
BoundsCallback BoundsOf(Function& bounds) {
  const auto call = [](void* data, uint32_t primitive, uint32_t time_step, Bounds& result) {
    Function& object = *static_cast<Function*>(data);
    if constexpr (std::is_invocable_v<Function&, uint32_t, uint32_t>) {
      result = object(primitive, time_step);
    } else {
      result = object(primitive);
    }
  };
  return {call, const_cast<std::remove_const_t<Function>*>(&bounds)};
}
template <class Function>
BoundsCallback BoundsOf(const Function&& bounds) = delete;

/// What Scene::QueryPoint calls. `visit` is called as
///   float (const PointCandidate& candidate)
/// and returns the radius to go on with.
template <class Visit>
PointCallback PointVisitOf(Visit& visit) {
  const auto call = [](void* data, const PointCandidate& candidate) -> float {
    return (*static_cast<Visit*>(data))(candidate);
  };
  return {call, const_cast<std::remove_const_t<Visit>*>(&visit)};
}
template <class Visit>
PointCallback PointVisitOf(const Visit&& visit) = delete;

/// For CallOptions::progress. `report` is called as
///   bool (std::size_t done, std::size_t rays)
template <class Report>
Progress ProgressOf(Report& report) {
  const auto call = [](void* data, std::size_t done, std::size_t rays) -> bool {
    return (*static_cast<Report*>(data))(done, rays);
  };
  return {call, const_cast<std::remove_const_t<Report>*>(&report)};
}
template <class Report>
Progress ProgressOf(const Report&& report) = delete;

}  // namespace dacrt

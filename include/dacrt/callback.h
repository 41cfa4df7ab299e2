// What the program's own functions are called with while rays are traced.
#pragma once

#include <cstddef>
#include <cstdint>

#include "dacrt/settings.h"

namespace dacrt {

/// Rays, and hits behind them, in structure of arrays: `width` values of four bytes for each
/// component, in this order.
enum class PacketComponent : uint32_t {
  kOrgX,
  kOrgY,
  kOrgZ,
  kTnear,
  kDirX,
  kDirY,
  kDirZ,
  kTime,
  kTfar,
  kMask,
  kId,
  kFlags,
  kNgX,
  kNgY,
  kNgZ,
  kU,
  kV,
  kPrimitiveId,
  kGeometryId,
  kInstanceId,
};
inline constexpr std::size_t kPacketComponents = 20;

/// What a callback sees. The arrays are the engine's, valid until the callback returns.
///
/// In an instance, rays are in the space of the instanced scene.
///
/// A filter function decides on candidate hits: the rays' tfar is the candidate's distance, the
/// hits are the candidates. It sets valid[i] to 0 to reject one, which leaves the ray as it was; it
/// may change tfar and the hit of one that it accepts.
///
/// An intersect function tests rays against one primitive. For Query::kClosest the hits are the
/// closest found so far; where the primitive is hit closer than tfar, the function sets tfar and
/// the hit, the identifiers included. For Query::kAny it sets tfar to -infinity; the hits have no
/// meaning but may be read.
struct CallbackArguments {
  Query query;
  uint32_t width;  ///< CallOptions::callback_width
  int32_t* valid;  ///< -1 for the lanes that take part, else 0
  void* packet;    ///< kPacketComponents * width values, 64-byte aligned
  uint32_t geometry_id;
  uint32_t primitive_id;  ///< of intersect functions; candidates carry their own
  uint32_t instance_id;  ///< the instance's geometry_id, or the caller's value outside of instances
  void* call;            ///< CallOptions::call
};

/// A function of the program's, and the data that it is called with. None if `function` is null.
/// A callback may trace rays itself. It must not throw. callback_of.h makes one from a lambda.
struct Callback {
  void (*function)(void* data, const CallbackArguments& arguments) = nullptr;
  void* data = nullptr;

  explicit operator bool() const { return function != nullptr; }
  void operator()(const CallbackArguments& arguments) const { function(data, arguments); }
};

/// Told how far a call of Scene::Trace has come: `done` of its `rays` have their answers. None if
/// `function` is null.
///
/// Called after each piece of the batch, of at most 65,536 rays, by one thread at a time of those
/// that work on the call. Not called by calls of up to 256 rays. It must not throw.
///
/// Returns whether to go on. If not, the call returns as soon as the pieces that threads are
/// working on are done: all rays of a piece have their answers then, or none has changed. The
/// caller knows what its own function has said; nothing is thrown.
struct Progress {
  bool (*function)(void* data, std::size_t done, std::size_t rays) = nullptr;
  void* data = nullptr;

  explicit operator bool() const { return function != nullptr; }
  bool operator()(std::size_t done, std::size_t rays) const { return function(data, done, rays); }
};

/// What one call of Scene::Trace hands to callbacks.
struct CallOptions {
  uint32_t callback_width = 16;  ///< lanes of the packets that callbacks see: 1 to 16
  void* call = nullptr;          ///< handed on to callbacks
  Progress progress = {};
};

}  // namespace dacrt

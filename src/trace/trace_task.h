// Some rays against one scene, or against an instance in it: what the recursion works on.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "dacrt/dacrt.h"
#include "rays/ray_lists.h"
#include "rays/ray_record.h"
#include "runtime/split_memory.h"
#include "scene/scene_parts.h"
#include "trace/child_order.h"
#include "trace/filter_answers.h"

namespace dacrt {

/// What hits and callbacks need to know of the call. Its rays come from a view or from a packet.
struct CallFrame {
  /// Values of a caller's ray that are not in its record, or what stands for absent ones.
  RayTag Tag(uint32_t ray) const {
    return {Read(PacketComponent::kId, &RayView::id, ray, UINT32_MAX),
            Read(PacketComponent::kFlags, &RayView::flags, ray, UINT32_MAX)};
  }
  float Time(uint32_t ray) const { return Read(PacketComponent::kTime, &RayView::time, ray, 0.0f); }

  std::size_t ray_count() const { return packet ? packet->lanes : view->count; }

  const RayView* view;      ///< null with a packet
  const RayPacket* packet;  ///< null with a view
  std::size_t first;        ///< ray of the view with which the piece begins
  const CallOptions& options;
  uint32_t no_instance;  ///< what hits outside of instances get

 private:
  template <class T>
  T Read(PacketComponent component, RayView::Component RayView::*of_view, uint32_t ray,
         T absent) const {
    T value = absent;
    if (packet) {
      std::memcpy(&value,
                  static_cast<const float*>(packet->values) +
                      static_cast<std::size_t>(component) * packet->lanes + ray,
                  sizeof(value));
    } else if (view->*of_view != RayView::kAbsent) {
      std::memcpy(&value, reinterpret_cast<const void*>(view->Address(view->*of_view, first + ray)),
                  sizeof(value));
    }
    return value;
  }
};

struct TraceTask;

/// The hit of a ray that is known by leaf and lane, and the geometry that was hit.
using FinishHitFunction = FullHit (*)(const TraceTask& task, RayNumber ray, uint32_t& geometry);

struct TraceTask {
  const SceneParts& scene;
  PartitionView partition;
  RayRecord* rays;
  FullHit* hits;  ///< by ray number; closest-hit queries only
  bool checks_masks;
  /// Whether hits of facets are kept by leaf and lane: not where the partition is soon forgotten.
  bool keeps_leaf_hits;
  const CallFrame& frame;
  SplitMemory& split_memory;
  InstanceMemory instance_memory;
  Statistics* statistics;  ///< null on the short way
  FinishHitFunction finish_hit;
  uint32_t instance_id;                   ///< what hits get
  const uint32_t* callers = nullptr;      ///< numbers of the caller's rays; null: as outside
  const TraceTask* outer = nullptr;       ///< whose rays these are, in an instance or a part of it
  const RayNumber* outer_rays = nullptr;  ///< their numbers there; null: the same
  ChildOrder any_hit_order = ChildOrder::kAsStored;
  /// By ray number, or null: where many rays are sorted, those of the next one that is asked for
  /// are in no cache.
  const RayTag* tags = nullptr;
  /// Whether closest hits that are known by leaf and lane are asked last whether the ray enters the
  /// triangle's own box (see trace_view-inl.h).
  bool asks_boxes_last = false;
  /// Whether filter functions are asked last about closest hits (see ask_last-inl.h).
  bool asks_filters_last = false;
  const FullHit* asked = nullptr;  ///< that has been asked about, and is not offered again
  FilterAnswers* filter_answers = nullptr;  ///< null where it does not matter what they are

  /// Whether filter functions are asked about hits where these are found.
  bool AsksFilters(Query query) const {
    return scene.geometries.shapes().has_filters(query) && !asks_filters_last;
  }

  /// A filter function has been shown hits, and has accepted some, a bit each.
  void CountAnswers(uint64_t accepted, std::size_t shown) const {
    if (filter_answers) {
      filter_answers->Count(shown, static_cast<std::size_t>(std::popcount(accepted)));
    }
  }

  /// The number of a ray outside.
  RayNumber OuterOf(RayNumber ray) const { return outer_rays ? outer_rays[ray] : ray; }

  uint32_t CallerOf(RayNumber ray) const {
    if (callers) return callers[ray];
    return outer ? outer->CallerOf(OuterOf(ray)) : ray;
  }

  RayTag TagOf(RayNumber ray) const {
    if (tags) return tags[ray];
    return outer ? outer->TagOf(OuterOf(ray)) : frame.Tag(CallerOf(ray));
  }

  /// The hit of a ray in that state that is not known by leaf and lane.
  const FullHit& FullHitOf(RayNumber ray, uint32_t state) const {
    if (!(state & RayRecord::kOfOuter)) return hits[ray];
    const TraceTask* instance = this;
    while (!instance->outer_rays) instance = instance->outer;
    return instance->outer->hits[instance->outer_rays[ray]];
  }

  /// The hit that a ray has.
  FullHit HitOf(RayNumber ray, uint32_t& geometry) const {
    if (!(rays[ray].state & RayRecord::kInLeaf)) {
      geometry = rays[ray].hit;
      return FullHitOf(ray, rays[ray].state);
    }
    const bool is_own = keeps_leaf_hits && !(rays[ray].state & RayRecord::kOfOuter);
    if (!outer || is_own) return finish_hit(*this, ray, geometry);
    return outer->HitOf(OuterOf(ray), geometry);
  }

  /// The same task over another partition of some of the scene's triangles.
  TraceTask Within(PartitionView part) const {
    TraceTask task = *this;
    task.partition = part;
    task.keeps_leaf_hits = false;
    task.outer = this;
    task.outer_rays = nullptr;
    return task;
  }
};

}  // namespace dacrt

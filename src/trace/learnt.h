// What a thread has learnt about how rays are best traced in a scene. None of it changes a hit.
#pragma once

#include <cstddef>

#include "dacrt/settings.h"
#include "trace/child_order.h"
#include "trace/learnt_way.h"
#include "trace/walk_choice.h"

namespace dacrt {

struct Learnt {
  static constexpr LearntWay WayOfPieces(uint32_t run) { return LearntWay{run, 1 << 16, 1 << 22}; }

  /// About the rays of a query.
  struct OfQuery {
    WalkChoice walk;  ///< of those that run close together
    /// Of those that have next to nothing in common: alone they live on what the processor has
    /// learnt about the way, too, which takes it long. With runs of 512 rays, calls of 64 ambient
    /// ones went together in the kitchen, and took 1.2 times as long as alone.
    LearntWay apart{4096};
    /// Of the same in pieces of larger calls, by their size, see ApartInPiece. Of a large piece
    /// both ways get parts in turn.
    LearntWay apart_in_pieces[3] = {WayOfPieces(4096), WayOfPieces(16384), WayOfPieces(2048)};
    LearntWay close{512};  ///< of those that run close together, in short calls
  };

  /// How rays of a piece of `rays` go that have next to nothing in common: as lists, which are the
  /// quicker the more rays they begin with, or as groups. As groups, calls of 64K ambient rays took
  /// 0.68 times the time of lists in a scene of 871,000 triangles, and 1.3 times in Sponza.
  LearntWay& ApartInPiece(Query query, std::size_t rays) {
    return Of(query).apart_in_pieces[(rays > 2048) + (rays > 16384)];
  }

  LearntOrder order_of_groups{8, 2048};         ///< costs are visits
  LearntOrder order_of_packets{32, 8192};       ///< the same
  LearntOrder order_of_rays{1 << 15, 1 << 22};  ///< of those in lists; costs are ticks
  OfQuery of_closest, of_any;

  OfQuery& Of(Query query) { return query == Query::kAny ? of_any : of_closest; }
};

/// What the calling thread has learnt about a scene that it asks for by an address: calls are often
/// smaller than what it takes to learn. It begins with what one that has ended knew. It may forget,
/// and may confuse scenes.
Learnt& LearntAbout(const void* scene);

}  // namespace dacrt

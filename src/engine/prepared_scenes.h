// How much of the caches the prepared leaves of small scenes may take together (see
// policy::kPreparedScene). Prepared triangles are quickly tested where they are at hand, and are
// four times as many cache lines where they are not: of a thousand small scenes that a larger one
// has instances of nothing is at hand.
#pragma once

#include <atomic>
#include <cstddef>

#include "trace/policy.h"

namespace dacrt {

/// The small scenes of a device. Any number of threads may make and end scenes.
class PreparedScenes {
 public:
  /// A scene of so many triangles (see GeometryTable::shares), as long as this lives.
  class Part {
   public:
    Part(PreparedScenes& all, std::size_t triangles)
        : all_(all), triangles_(triangles <= policy::kPreparedScene ? triangles : 0) {
      has_room_ = all_.triangles_.fetch_add(triangles_) + triangles_ <= policy::kPreparedTogether;
    }
    ~Part() { all_.triangles_ -= triangles_; }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    /// Whether its leaves are to be prepared.
    bool has_room() const { return has_room_; }

   private:
    PreparedScenes& all_;
    const std::size_t triangles_;  ///< 0 if the scene is not small
    bool has_room_;
  };

 private:
  std::atomic<std::size_t> triangles_{0};
};

}  // namespace dacrt

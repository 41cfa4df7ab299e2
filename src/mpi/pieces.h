// A piece of a call on its way to a worker, and its hits on their way back.
#pragma once

#include <cstdint>
#include <vector>

#include "dacrt/mpi.h"
#include "message.h"

namespace dacrt::mpi {

/// What Command::kPiece is followed by, before the rays' columns.
struct PieceHead {
  uint64_t scene;
  uint64_t number;  ///< of the piece; its answer repeats it
  uint32_t query;
  uint32_t count;
  uint32_t instance_value;
  uint32_t common_columns;
};

/// What Answer::kHits is followed by, before a bit for each ray that says whether it has a hit, and
/// for Query::kClosest the hits' columns.
struct HitsHead {
  uint64_t number;
  uint32_t count;
  uint32_t hits;
  uint32_t common_columns;
  uint32_t unused;
};

/// The message for `rays`, a piece: 8 to 40 bytes a ray, as few of its columns are all the same.
Message PackPiece(uint64_t scene, uint64_t number, Query query, const RayView& rays);

/// The rays of a piece, with room for their hits.
class UnpackedPiece {
 public:
  /// `reader` stands behind the command. Throws CutMessage.
  explicit UnpackedPiece(Reader& reader);

  uint64_t scene() const { return head_.scene; }
  Query query() const { return static_cast<Query>(head_.query); }
  RayView view();

  /// The answer, after the rays were traced: a bit a ray, and up to 36 bytes a closest hit.
  Message PackHits() const;

 private:
  static constexpr std::size_t kRayColumns = 10, kHitColumns = 8;

  uint32_t* Column(std::size_t column) { return values_.data() + column * head_.count; }
  const uint32_t* Column(std::size_t column) const { return values_.data() + column * head_.count; }

  PieceHead head_;
  std::vector<uint32_t> values_;
};

/// The number of the piece that an answer is for. `reader` stands behind Answer::kHits.
uint64_t PieceOf(Reader reader);

/// Writes the hits of an answer for `rays`, the same piece: records of rays without a hit stay as
/// they are. Throws CutMessage, before anything was written, if the answer is not one for `rays`.
void UnpackHits(Reader& reader, Query query, const RayView& rays);

}  // namespace dacrt::mpi

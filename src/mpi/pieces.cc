#include "pieces.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "columns.h"
#include "view_piece.h"
#include "wire.h"

namespace dacrt::mpi {
namespace {

constexpr uint32_t kNoPrimitive = UINT32_MAX;
constexpr uint32_t kOccluded = std::bit_cast<uint32_t>(-std::numeric_limits<float>::infinity());

std::size_t WordsOfBits(std::size_t count) { return (count + 31) / 32; }

// The columns of a piece, in their order. The hits' stand behind the rays'.
enum Column : std::size_t {
  kOrgX,
  kOrgY,
  kOrgZ,
  kDirX,
  kDirY,
  kDirZ,
  kTnear,
  kTfar,
  kMask,
  kTime,
  kNgX,
  kNgY,
  kNgZ,
  kU,
  kV,
  kPrimitive,
  kGeometry,
  kInstance,
};

}  // namespace

Message PackPiece(uint64_t scene, uint64_t number, Query query, const RayView& rays) {
  Message message;
  message.Extend(sizeof(Command) + sizeof(PieceHead) + 40 * rays.count);
  message.Shrink(0);
  message.Put(Command::kPiece);
  const std::size_t head_place = message.size();
  message.Extend(sizeof(PieceHead));
  ColumnWriter columns(message, rays.count);
  const auto put = [&](RayView::Component component, uint32_t absent) {
    if (component == RayView::kAbsent) return columns.Common(absent);
    columns.Column([&](std::size_t i) { return ReadBits(rays, component, i); });
  };
  for (const RayView::Component component : {rays.org_x, rays.org_y, rays.org_z, rays.dir_x,
                                             rays.dir_y, rays.dir_z, rays.tnear, rays.tfar}) {
    put(component, 0);
  }
  put(rays.mask, UINT32_MAX);
  put(rays.time, 0);
  const PieceHead head{scene,
                       number,
                       static_cast<uint32_t>(query),
                       static_cast<uint32_t>(rays.count),
                       rays.instance_value,
                       columns.is_common()};
  std::memcpy(message.data() + head_place, &head, sizeof(head));
  return message;
}

UnpackedPiece::UnpackedPiece(Reader& reader) : head_(reader.Take<PieceHead>()) {
  const bool is_closest = query() == Query::kClosest;
  values_.resize((kRayColumns + (is_closest ? kHitColumns : 0)) * std::size_t{head_.count});
  ColumnReader columns(reader, head_.count, head_.common_columns);
  for (std::size_t column = 0; column < kRayColumns; ++column) {
    const ColumnReader::Column from = columns.Next();
    uint32_t* const to = Column(column);
    for (std::size_t i = 0; i < head_.count; ++i) to[i] = from[i];
  }
  reader.ExpectEnd();
  if (is_closest) std::fill_n(Column(kPrimitive), head_.count, kNoPrimitive);
}

RayView UnpackedPiece::view() {
  RayView view;
  view.count = head_.count;
  view.packet_stride = 4;
  view.instance_value = head_.instance_value;
  const auto at = [&](std::size_t column) {
    return reinterpret_cast<RayView::Component>(Column(column));
  };
  view.org_x = at(kOrgX), view.org_y = at(kOrgY), view.org_z = at(kOrgZ);
  view.dir_x = at(kDirX), view.dir_y = at(kDirY), view.dir_z = at(kDirZ);
  view.tnear = at(kTnear), view.tfar = at(kTfar);
  view.mask = at(kMask), view.time = at(kTime);
  if (query() == Query::kAny) return view;
  view.ng_x = at(kNgX), view.ng_y = at(kNgY), view.ng_z = at(kNgZ);
  view.u = at(kU), view.v = at(kV);
  view.primitive_id = at(kPrimitive);
  view.geometry_id = at(kGeometry);
  view.instance_id = at(kInstance);
  return view;
}

Message UnpackedPiece::PackHits() const {
  const bool is_closest = query() == Query::kClosest;
  // Rays that were -infinity before are inactive, and writing the same again changes nothing.
  const uint32_t* const tfar = Column(kTfar);
  const uint32_t* const primitive = is_closest ? Column(kPrimitive) : nullptr;
  const auto has_hit = [&](std::size_t i) {
    return is_closest ? primitive[i] != kNoPrimitive : tfar[i] == kOccluded;
  };
  Message message;
  message.Put(Answer::kHits);
  const std::size_t head_place = message.size();
  message.Extend(sizeof(HitsHead));
  auto* const bits = reinterpret_cast<uint32_t*>(message.Extend(4 * WordsOfBits(head_.count)));
  std::fill_n(bits, WordsOfBits(head_.count), 0);
  std::vector<uint32_t> hits;
  for (uint32_t i = 0; i < head_.count; ++i) {
    if (!has_hit(i)) continue;
    bits[i / 32] |= 1u << (i % 32);
    hits.push_back(i);
  }
  HitsHead head{head_.number, head_.count, static_cast<uint32_t>(hits.size()), 0, 0};
  if (is_closest && !hits.empty()) {
    ColumnWriter columns(message, hits.size());
    for (const std::size_t column :
         {kTfar, kNgX, kNgY, kNgZ, kU, kV, kPrimitive, kGeometry, kInstance}) {
      const uint32_t* const values = Column(column);
      columns.Column([&](std::size_t i) { return values[hits[i]]; });
    }
    head.common_columns = columns.is_common();
  }
  std::memcpy(message.data() + head_place, &head, sizeof(head));
  return message;
}

uint64_t PieceOf(Reader reader) { return reader.Take<HitsHead>().number; }

void UnpackHits(Reader& reader, Query query, const RayView& rays) {
  const auto head = reader.Take<HitsHead>();
  if (head.count != rays.count) throw CutMessage();
  const std::size_t words = WordsOfBits(rays.count);
  const auto* const bits = reinterpret_cast<const uint32_t*>(reader.Take(4 * words));
  const std::size_t rest = rays.count % 32;
  if (rest != 0 && bits[words - 1] >> rest != 0) throw CutMessage();
  std::size_t hits = 0;
  for (std::size_t word = 0; word < words; ++word) {
    hits += static_cast<std::size_t>(std::popcount(bits[word]));
  }
  if (hits != head.hits) throw CutMessage();
  ColumnReader::Column columns[9]{};
  if (query == Query::kClosest && hits > 0) {
    ColumnReader reader_of_columns(reader, hits, head.common_columns);
    for (auto& column : columns) column = reader_of_columns.Next();
  }
  reader.ExpectEnd();

  std::size_t hit = 0;
  for (std::size_t word = 0; word < words; ++word) {
    for (uint32_t left = bits[word]; left != 0; left &= left - 1, ++hit) {
      const std::size_t i = word * 32 + static_cast<std::size_t>(std::countr_zero(left));
      if (query == Query::kAny) {
        WriteOccluded(rays, i);
        continue;
      }
      const auto real = [&](std::size_t column) {
        return std::bit_cast<float>(columns[column][hit]);
      };
      WriteHit(rays, i,
               {real(0),
                {real(1), real(2), real(3)},
                real(4),
                real(5),
                columns[6][hit],
                columns[7][hit],
                columns[8][hit]});
    }
  }
}

}  // namespace dacrt::mpi

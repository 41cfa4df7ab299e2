#include "ray_buffer.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace dacrt::bench {

RayBuffer::RayBuffer(std::size_t capacity)
    : records_(static_cast<RayRecord*>(
          ::operator new (capacity * sizeof(RayRecord), std::align_val_t{kAlignment}))) {}

void RayBuffer::Begin(float tfar) {
  size_ = 0;
  tfar_ = tfar;
}

void RayBuffer::Append(const float (&org)[3], const float (&dir)[3], uint32_t id) {
  RayRecord& record = records_[size_++];
  record = {};
  std::memcpy(record.org, org, sizeof(org));
  std::memcpy(record.dir, dir, sizeof(dir));
  record.tfar = tfar_;
  record.mask = UINT32_MAX;
  record.id = id;
  record.primitive_id = kNoGeometry;
  record.geometry_id = kNoGeometry;
  record.instance_id = kNoGeometry;
}

void RayBuffer::Rearm() {
  for (RayRecord& record : rays()) {
    record.tfar = tfar_;
    record.geometry_id = kNoGeometry;
  }
}

RayBuffer RayBuffer::Part(std::size_t first, std::size_t count) const {
  RayBuffer part(count);
  part.Begin(tfar_);
  std::ranges::copy(rays().subspan(first, count), part.records_.get());
  part.size_ = count;
  part.Rearm();
  return part;
}

RayView RayBuffer::View() {
  RayRecord* const first = records_.get();
  const auto at = [](const void* component) {
    return std::bit_cast<RayView::Component>(component);
  };
  return {.count = size_,
          .packet_stride = sizeof(RayRecord),
          .org_x = at(&first->org[0]),
          .org_y = at(&first->org[1]),
          .org_z = at(&first->org[2]),
          .dir_x = at(&first->dir[0]),
          .dir_y = at(&first->dir[1]),
          .dir_z = at(&first->dir[2]),
          .tnear = at(&first->tnear),
          .tfar = at(&first->tfar),
          .mask = at(&first->mask),
          .ng_x = at(&first->ng[0]),
          .ng_y = at(&first->ng[1]),
          .ng_z = at(&first->ng[2]),
          .u = at(&first->u),
          .v = at(&first->v),
          .primitive_id = at(&first->primitive_id),
          .geometry_id = at(&first->geometry_id),
          .instance_id = at(&first->instance_id)};
}

uint64_t Fingerprint(Query query, const RayRecord& record) {
  if (query == Query::kAny) return std::bit_cast<uint32_t>(record.tfar);
  if (record.geometry_id == kNoGeometry) return 0;
  // FNV-1a over whole words, with a rotation that carries the upper half down again.
  uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&hash](uint32_t word) { hash = std::rotl((hash ^ word) * 0x100000001b3u, 27); };
  mix(std::bit_cast<uint32_t>(record.tfar));
  for (const float component : record.ng) mix(std::bit_cast<uint32_t>(component));
  mix(std::bit_cast<uint32_t>(record.u));
  mix(std::bit_cast<uint32_t>(record.v));
  mix(record.primitive_id);
  mix(record.geometry_id);
  return hash;
}

}  // namespace dacrt::bench

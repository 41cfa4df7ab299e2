// After Wald, Jaros, Zellmann, "Data parallel multi-GPU path tracing using ray queue cycling", CGF
// 2023: the queues, without the cycle. What is left of it is the order of ranks where several are
// entered at the same distance.
#include "divided_call.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "hit_key.h"
#include "view_piece.h"
#include "wire.h"

namespace dacrt::mpi {
namespace {

/// Hits that come home are kept in blocks of this many: one array would be copied as it grows.
constexpr std::size_t kHitsTogether = 8192;
constexpr HitRecord kNoHit{0, {0, 0, 0}, 0, 0, UINT32_MAX, UINT32_MAX, UINT32_MAX};

/// Which optional parts the record of a ray needs.
RecordKind KindOf(const TravellingRay& ray, bool for_callbacks) {
  return {ray.mask != UINT32_MAX, std::bit_cast<uint32_t>(ray.time) != 0, for_callbacks, false};
}

}  // namespace

DividedCall::DividedCall(Members& members, const LocalScene& local, const DividedParts& parts,
                         uint64_t call, std::size_t bundle_rays, Query query, const RayView& rays,
                         const CallOptions& options, Traffic& traffic)
    : members_(members),
      link_(members.link()),
      local_(local),
      parts_(parts),
      call_(call),
      bundle_rays_(bundle_rays),
      query_(query),
      rays_(rays),
      options_(options),
      traffic_(traffic),
      tag_(call % 2 ? kTagRaysOdd : kTagRays),
      route_(parts.boxes),
      buckets_(parts.boxes.size() * RecordKind::kKinds) {}

void DividedCall::Run() {
  Idle idle;
  for (bool is_waiting_for_all = false;;) {
    const Clock::time_point start = Clock::now();
    const double traced_before = traffic_.seconds_tracing;
    members_.Watch();
    const bool took = TakeMessages();
    if (Work() || took) {
      idle.Reset();
      traffic_.seconds_moving += SecondsSince(start) - (traffic_.seconds_tracing - traced_before);
      continue;
    }
    FlushAll();
    if (is_waiting_for_all) {
      // What is still on its way would wait for this rank's next call.
      if (members_.IsBarrierDone() && link_.HasSentAll()) return;
    } else if (ended_ == rays_.count) {
      members_.StartBarrier(call_);
      is_waiting_for_all = true;
    }
    idle.Pause();
    traffic_.seconds_waiting += SecondsSince(start);
  }
}

void DividedCall::Store() const {
  for (const auto& some : own_hits_) {
    for (const auto& [index, hit] : some) StoreOne(index, hit);
  }
}

void DividedCall::StoreOne(uint32_t index, HitRecord hit) const {
  if (query_ == Query::kAny) return WriteOccluded(rays_, index);
  if (hit.instance_id == UINT32_MAX) hit.instance_id = rays_.instance_value;
  WriteHit(rays_, index, hit);
}

void DividedCall::KeepHit(uint32_t index, const HitRecord& hit) {
  if (own_hits_.empty() || own_hits_.back().size() == kHitsTogether) {
    own_hits_.emplace_back().reserve(kHitsTogether);
  }
  own_hits_.back().emplace_back(index, hit);
}

bool DividedCall::TakeMessages() {
  bool took = false;
  // Rays that wait here have taken their sender's memory off it; a few are enough to go on.
  constexpr std::size_t kMostWaiting = 8;
  while (work_.size() < kMostWaiting) {
    auto arrival = link_.Receive(tag_);
    if (!arrival) break;
    took = true;
    members_.Hear(arrival->from);
    try {
      Reader reader(arrival->message);
      const auto head = reader.Take<BundleHead>();
      if (head.call != call_ || head.scene != parts_.number ||
          head.query != static_cast<uint32_t>(query_)) {
        throw Fault("rank " + std::to_string(arrival->from) +
                    " makes another call than this one: all ranks have to make the same");
      }
      if (head.is_answer) {
        TakeAnswers(reader, head);
        continue;
      }
      reader.Take(std::size_t{head.count} * RecordKind::FromBits(head.kind).bytes());
      reader.ExpectEnd();
    } catch (const CutMessage&) {
      throw Fault("rank " + std::to_string(arrival->from) + " has sent a message that was cut");
    }
    work_.push_back(std::move(arrival->message));
  }
  return took;
}

void DividedCall::TakeAnswers(Reader& reader, const BundleHead& head) {
  for (uint32_t i = 0; i < head.count; ++i) {
    const auto index = reader.Take<uint32_t>();
    if (index >= rays_.count) throw CutMessage();
    KeepHit(index, query_ == Query::kClosest ? reader.Take<HitRecord>() : kNoHit);
  }
  reader.ExpectEnd();
  ended_ += head.done;
}

bool DividedCall::Work() {
  if (!work_.empty()) {
    const Message bundle = std::move(work_.front());
    work_.pop_front();
    TraceBundle(bundle);
    return true;
  }
  if (next_own_ == rays_.count) return false;
  SendOwnRays();
  return true;
}

void DividedCall::SendOwnRays() {
  const std::size_t end = std::min(rays_.count, next_own_ + bundle_rays_);
  for (; next_own_ < end; ++next_own_) {
    const TravellingRay ray = FromView(rays_, next_own_, static_cast<uint32_t>(link_.rank()));
    const RouteRay route = ray.route();
    route_.Set(route, link_.rank());
    Dispatch(ray, KindOf(ray, parts_.has_callbacks), route_.Next(route.limit, kNew));
  }
}

void DividedCall::TraceBundle(const Message& bundle) {
  Reader reader(bundle);
  const auto head = reader.Take<BundleHead>();
  RecordKind kind = RecordKind::FromBits(head.kind);
  const std::byte* const records = reader.Take(head.count * kind.bytes());
  if (visitors_.size() < head.count) visitors_.resize(head.count);
  const std::span<Visitor> visitors(visitors_.data(), head.count);
  for (std::size_t i = 0; i < visitors.size(); ++i) {
    Visitor& visitor = visitors[i];
    visitor.ray = GetRay(records + i * kind.bytes(), kind);
    visitor.found_primitive = visitor.found_geometry = visitor.found_instance = UINT32_MAX;
    visitor.ends_here = false;
    visitor.found_t = std::exchange(visitor.ray.tfar, visitor.ray.FindableTo());
  }
  Trace(visitors);
  for (Visitor& visitor : visitors) {
    TravellingRay& ray = visitor.ray;
    const int next = NextOf(visitor);
    if (visitor.has_found() &&
        (visitor.found_key < ray.key ||
         (visitor.found_key == ray.key && NameOf(visitor.found()) < NameOf(ray.hit)))) {
      ray.hit = visitor.found();
      ray.key = visitor.found_key;
    }
    kind.has_hit = ray.has_hit();
    Dispatch(ray, kind, next);
  }
}

int DividedCall::NextOf(const Visitor& visitor) {
  if (visitor.ends_here) return kNowhere;
  RouteRay route = visitor.ray.route();
  if (visitor.has_found()) {
    // One that is occluded goes home.
    if (query_ == Query::kAny) return kNowhere;
    route.limit = std::min(route.limit, visitor.found_key);
  }
  route_.Set(route, static_cast<int>(visitor.ray.home));
  return route_.Next(route.limit, link_.rank());
}

void DividedCall::Trace(std::span<Visitor> visitors) {
  const Clock::time_point start = Clock::now();
  Visitor& first = visitors[0];
  const auto at = [](auto& value) { return reinterpret_cast<RayView::Component>(&value); };
  RayView view;
  view.count = visitors.size();
  view.packet_stride = sizeof(Visitor);
  TravellingRay& ray = first.ray;
  view.org_x = at(ray.org[0]), view.org_y = at(ray.org[1]), view.org_z = at(ray.org[2]);
  view.dir_x = at(ray.dir[0]), view.dir_y = at(ray.dir[1]), view.dir_z = at(ray.dir[2]);
  view.tnear = at(ray.tnear), view.mask = at(ray.mask), view.time = at(ray.time);
  view.id = at(ray.id), view.flags = at(ray.flags);
  view.tfar = at(ray.tfar);
  if (query_ == Query::kClosest) {
    view.ng_x = at(first.found_ng[0]), view.ng_y = at(first.found_ng[1]);
    view.ng_z = at(first.found_ng[2]);
    view.u = at(first.found_u), view.v = at(first.found_v);
    view.primitive_id = at(first.found_primitive);
    view.geometry_id = at(first.found_geometry);
    view.instance_id = at(first.found_instance);
  }
  local_.trace(query_, view, options_);
  if (query_ == Query::kClosest) {
    FindKeysOf(visitors);
  } else {
    for (Visitor& visitor : visitors) {
      std::swap(visitor.ray.tfar, visitor.found_t);
      if (visitor.found_t == -kInfinity) visitor.found_primitive = 0;
    }
  }
  traffic_.rays_traced += visitors.size();
  traffic_.seconds_tracing += SecondsSince(start);
}

bool DividedCall::GoesNoFarther(const Visitor& visitor) {
  const RouteRay route = visitor.ray.route();
  route_.Set(route, static_cast<int>(visitor.ray.home));
  const auto is_last = [&](float limit) { return route_.Next(limit, link_.rank()) == kNowhere; };
  return is_last(route.limit) ||
         is_last(std::min(route.limit, parts_.key_bounds.MostOf(visitor.ray, visitor.found())));
}

void DividedCall::FindKeysOf(std::span<Visitor> visitors) {
  std::vector<FoundHit> hits;
  std::vector<Visitor*> owners;
  for (Visitor& visitor : visitors) {
    std::swap(visitor.ray.tfar, visitor.found_t);
    if (!visitor.has_found()) continue;
    visitor.found_key = visitor.found_t;
    // Callbacks see each candidate once.
    if (parts_.has_callbacks) continue;
    const TravellingRay& ray = visitor.ray;
    // Nobody else has a say in the hit of a ray that carries none and goes no farther.
    visitor.ends_here = !ray.has_hit() && GoesNoFarther(visitor);
    if (visitor.ends_here) continue;
    hits.push_back({&ray, ray.FindableTo(), visitor.found_t, 0});
    owners.push_back(&visitor);
  }
  FindKeys(local_, hits);
  for (std::size_t i = 0; i < hits.size(); ++i) owners[i]->found_key = hits[i].key;
}

void DividedCall::Dispatch(const TravellingRay& ray, RecordKind kind, int next) {
  if (next == kNowhere) return End(ray);
  const std::size_t number = static_cast<std::size_t>(next) * RecordKind::kKinds + kind.Bits();
  Bucket& bucket = buckets_[number];
  if (bucket.count == 0) {
    bucket.message.Extend(sizeof(BundleHead) + bundle_rays_ * kind.bytes());
    bucket.message.Shrink(sizeof(BundleHead));
  }
  PutRay(ray, kind, bucket.message.Extend(kind.bytes()));
  if (++bucket.count == bundle_rays_) Flush(number, bucket);
}

void DividedCall::End(const TravellingRay& ray) {
  const int home = static_cast<int>(ray.home);
  if (home == link_.rank()) {
    ++ended_;
    if (ray.has_hit()) KeepHit(ray.index, ray.hit);
    return;
  }
  Answers& answers = answers_[home];
  ++answers.done;
  if (ray.has_hit()) answers.hits.emplace_back(ray.index, ray.hit);
  if (answers.hits.size() == bundle_rays_) SendAnswers(home, answers);
}

BundleHead DividedCall::Head() const {
  BundleHead head{};
  head.query = static_cast<uint32_t>(query_);
  head.scene = parts_.number;
  head.call = call_;
  return head;
}

void DividedCall::Flush(std::size_t number, Bucket& bucket) {
  if (bucket.count == 0) return;
  const int to = static_cast<int>(number / RecordKind::kKinds);
  BundleHead head = Head();
  head.kind = static_cast<uint32_t>(number % RecordKind::kKinds);
  head.count = std::exchange(bucket.count, 0);
  std::memcpy(bucket.message.data(), &head, sizeof(head));
  Message message = std::exchange(bucket.message, Message());
  if (to == link_.rank()) {
    work_.push_back(std::move(message));
    return;
  }
  traffic_.rays_out += head.count;
  link_.Send(to, tag_, std::move(message));
}

void DividedCall::FlushAll() {
  for (std::size_t number = 0; number < buckets_.size(); ++number) {
    Flush(number, buckets_[number]);
  }
  for (auto& [home, answers] : answers_) SendAnswers(home, answers);
}

void DividedCall::SendAnswers(int home, Answers& answers) {
  if (answers.done == 0) return;
  BundleHead head = Head();
  head.is_answer = 1;
  head.count = static_cast<uint32_t>(answers.hits.size());
  head.done = answers.done;
  Message message;
  message.Put(head);
  const std::size_t bytes_a_hit = 4 + (query_ == Query::kClosest ? sizeof(HitRecord) : 0);
  std::byte* to = message.Extend(answers.hits.size() * bytes_a_hit);
  for (const auto& [index, hit] : answers.hits) {
    std::memcpy(to, &index, 4);
    if (query_ == Query::kClosest) std::memcpy(to + 4, &hit, sizeof(hit));
    to += bytes_a_hit;
  }
  answers = {};
  link_.Send(home, tag_, std::move(message));
}

}  // namespace dacrt::mpi

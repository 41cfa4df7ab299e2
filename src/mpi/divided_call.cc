// After Wald, Jaros, Zellmann, "Data parallel multi-GPU path tracing using ray queue cycling", CGF
// 2023: the queues, without the cycle. What is left of it is the order of ranks where several are
// entered at the same distance.
#include "divided_call.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "hit_key.h"
#include "view_piece.h"
#include "wire.h"

namespace dacrt::mpi {

DividedCall::DividedCall(Members& members, const LocalScene& local, const DividedParts& parts,
                         uint64_t call, std::size_t bundle_rays, Bundle& room, Query query,
                         const RayView& rays, const CallOptions& options, Traffic& traffic)
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
      routes_(parts.boxes),
      bundle_(room),
      rays_out_(parts.boxes.size() * RayKind::kKinds),
      answers_out_(parts.boxes.size()) {}

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
    SendAll();
    if (is_waiting_for_all) {
      // What is still on its way would wait for this rank's next call.
      if (members_.IsBarrierDone() && link_.HasSentAll()) break;
    } else if (ended_ == rays_.count) {
      members_.StartBarrier(call_);
      is_waiting_for_all = true;
    }
    idle.Pause();
    traffic_.seconds_waiting += SecondsSince(start);
  }
  SendAnswers(link_.rank(), answers_out_[static_cast<std::size_t>(link_.rank())]);
}

void DividedCall::Store() {
  for (Message& message : own_hits_) {
    Reader reader(message);
    const auto head = reader.Take<BundleHead>();
    for (uint32_t i = 0; i < head.count; ++i) {
      const auto index = reader.Take<uint32_t>();
      if (query_ == Query::kAny) {
        WriteOccluded(rays_, index);
        continue;
      }
      auto hit = reader.Take<HitRecord>();
      if (hit.instance_id == UINT32_MAX) hit.instance_id = rays_.instance_value;
      WriteHit(rays_, index, hit);
    }
    link_.KeepRoom(std::move(message));
  }
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
        TakeAnswers(std::move(arrival->message), head);
        continue;
      }
      reader.Take(std::size_t{head.count} * RayKind::FromBits(head.kind).bytes());
      reader.ExpectEnd();
    } catch (const CutMessage&) {
      throw Fault("rank " + std::to_string(arrival->from) + " has sent a message that was cut");
    }
    work_.push_back(std::move(*arrival));
  }
  return took;
}

void DividedCall::TakeAnswers(Message message, const BundleHead& head) {
  Reader reader(message);
  reader.Take(sizeof(head));
  for (uint32_t i = 0; i < head.count; ++i) {
    if (reader.Take<uint32_t>() >= rays_.count) throw CutMessage();
    reader.Take(BytesOfHit() - sizeof(uint32_t));
  }
  reader.ExpectEnd();
  ended_ += head.done;
  if (head.count > 0) own_hits_.push_back(std::move(message));
}

bool DividedCall::Work() {
  if (!work_.empty()) {
    TakeBundle(work_.front());
    link_.KeepRoom(std::move(work_.front().message));
    work_.pop_front();
  } else if (next_own_ < rays_.count) {
    TakeOwnRays();
  } else {
    return false;
  }
  TraceBundle();
  return true;
}

void DividedCall::TakeOwnRays() {
  // Those that begin elsewhere leave at once.
  bundle_.Resize(0);
  while (next_own_ < rays_.count && bundle_.size() < bundle_rays_) {
    const std::size_t first = bundle_.size();
    const std::size_t end =
        std::min({first + Routes::kMost, first + rays_.count - next_own_, bundle_rays_});
    bundle_.Resize(end);
    for (std::size_t i = first; i < end; ++i, ++next_own_) {
      GetRay(rays_, next_own_, static_cast<uint32_t>(link_.rank()), bundle_.record(i),
             bundle_.luggage(i));
    }
    SetRoutes(first, end);
    std::size_t staying = first;
    for (std::size_t i = first; i < end; ++i) {
      const int next = routes_.Next(i - first, kNew).RankWithin(bundle_.luggage(i).limit());
      if (next != link_.rank()) {
        Dispatch(i, next);
      } else {
        bundle_.Copy(i, staying++);
      }
    }
    bundle_.Resize(staying);
  }
}

void DividedCall::TakeBundle(const Link::Arrival& arrival) {
  Reader reader(arrival.message);
  const auto head = reader.Take<BundleHead>();
  const RayKind kind = RayKind::FromBits(head.kind);
  const std::byte* const rays = reader.Take(head.count * kind.bytes());
  bundle_.Resize(head.count);
  for (std::size_t i = 0; i < head.count; ++i) {
    Luggage& luggage = bundle_.luggage(i);
    GetRay(rays + i * kind.bytes(), kind, bundle_.record(i), luggage);
    if (luggage.home >= answers_out_.size()) {
      throw Fault("rank " + std::to_string(arrival.from) + " has sent a ray of rank " +
                  std::to_string(luggage.home) + ", which there is not");
    }
  }
}

void DividedCall::TraceBundle() {
  if (bundle_.size() == 0) return;
  TraceHere();
  unsure_.clear();
  for (std::size_t first = 0; first < bundle_.size(); first += Routes::kMost) {
    SendOn(first, std::min(first + Routes::kMost, bundle_.size()));
  }
  SendOnWithKeys();
}

void DividedCall::TraceHere() {
  const Clock::time_point start = Clock::now();
  local_.trace(query_, bundle_.View(query_), options_);
  traffic_.rays_traced += bundle_.size();
  traffic_.seconds_tracing += SecondsSince(start);
}

void DividedCall::SetRoutes(std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i) routes_.Add(bundle_.route(i));
  routes_.Find();
}

void DividedCall::SendOn(std::size_t first, std::size_t end) {
  SetRoutes(first, end);
  static_assert(Routes::kMost <= KeyBounds::kMost);
  KeyBounds::Asked asked[Routes::kMost];
  Stop stops[Routes::kMost];
  std::size_t numbers[Routes::kMost];
  std::size_t asked_count = 0;
  for (std::size_t i = first; i < end; ++i) {
    const RayRecord& ray = bundle_.record(i);
    const Luggage& luggage = bundle_.luggage(i);
    const Stop next = routes_.Next(i - first, link_.rank());
    if (query_ == Query::kAny && ray.tfar == -kInfinity) {
      End(i, true, {});
    } else if (query_ == Query::kAny || ray.primitive_id == UINT32_MAX) {
      Dispatch(i, next.RankWithin(luggage.limit()));
    } else if (parts_.has_callbacks) {
      // They see each candidate once, so that nothing can be asked again.
      Merge(i, ray.tfar);
      Dispatch(i, next.RankWithin(luggage.limit()));
    } else if (!luggage.has_hit() && !next.IsWithin(luggage.tfar)) {
      // Nobody else has a say in it.
      End(i, true, ray.found());
    } else if (!luggage.has_hit() && !next.IsWithin(ray.tfar)) {
      // Nor here, unless the key is much larger than t.
      stops[asked_count] = next;
      numbers[asked_count] = i;
      asked[asked_count++] = {&ray};
    } else {
      unsure_.push_back({&ray, i, luggage.FindableTo()});
    }
  }
  parts_.key_bounds.Find({asked, asked_count});
  for (std::size_t k = 0; k < asked_count; ++k) {
    const std::size_t i = numbers[k];
    if (stops[k].IsWithin(asked[k].most)) {
      unsure_.push_back({asked[k].ray, i, bundle_.luggage(i).FindableTo()});
    } else {
      End(i, true, asked[k].ray->found());
    }
  }
}

void DividedCall::SendOnWithKeys() {
  if (unsure_.empty()) return;
  const Clock::time_point start = Clock::now();
  FindKeys(local_, unsure_);
  traffic_.seconds_tracing += SecondsSince(start);
  for (std::size_t first = 0; first < unsure_.size(); first += Routes::kMost) {
    const std::span<const FoundHit> some =
        std::span(unsure_).subspan(first, std::min(Routes::kMost, unsure_.size() - first));
    for (const FoundHit& hit : some) routes_.Add(bundle_.route(hit.number));
    routes_.Find();
    for (std::size_t k = 0; k < some.size(); ++k) {
      const std::size_t i = some[k].number;
      Merge(i, some[k].key);
      Dispatch(i, routes_.Next(k, link_.rank()).RankWithin(bundle_.luggage(i).limit()));
    }
  }
}

void DividedCall::Merge(std::size_t i, float key) {
  Luggage& luggage = bundle_.luggage(i);
  const HitRecord found = bundle_.record(i).found();
  if (key > luggage.key || (key == luggage.key && NameOf(luggage.hit) < NameOf(found))) return;
  luggage.hit = found;
  luggage.key = key;
}

void DividedCall::Dispatch(std::size_t i, int next) {
  const Luggage& luggage = bundle_.luggage(i);
  if (next == kNowhere) return End(i, luggage.has_hit(), luggage.hit);
  const RayRecord& ray = bundle_.record(i);
  const RayKind kind = KindOf(ray, luggage, parts_.has_callbacks);
  const std::size_t number = static_cast<std::size_t>(next) * RayKind::kKinds + kind.Bits();
  Outgoing& outgoing = rays_out_[number];
  PutRay(ray, luggage, kind, Append(outgoing, kind.bytes()));
  if (outgoing.count == bundle_rays_) SendRays(number, outgoing);
}

void DividedCall::End(std::size_t i, bool has_hit, const HitRecord& hit) {
  const Luggage& luggage = bundle_.luggage(i);
  Outgoing& outgoing = answers_out_[luggage.home];
  if (static_cast<int>(luggage.home) == link_.rank()) {
    ++ended_;
  } else {
    ++outgoing.done;
  }
  if (!has_hit) return;
  std::byte* const to = Append(outgoing, BytesOfHit());
  std::memcpy(to, &luggage.index, 4);
  if (query_ == Query::kClosest) std::memcpy(to + 4, &hit, sizeof(hit));
  if (outgoing.count == bundle_rays_) SendAnswers(static_cast<int>(luggage.home), outgoing);
}

std::size_t DividedCall::BytesOfHit() const {
  return sizeof(uint32_t) + (query_ == Query::kClosest ? sizeof(HitRecord) : 0);
}

std::byte* DividedCall::Append(Outgoing& outgoing, std::size_t bytes) {
  if (outgoing.count++ == 0) {
    outgoing.message = link_.Room(sizeof(BundleHead) + bundle_rays_ * bytes);
    outgoing.message.Extend(sizeof(BundleHead));
  }
  return outgoing.message.Extend(bytes);
}

Message DividedCall::Finish(Outgoing& outgoing, BundleHead head) {
  head.query = static_cast<uint32_t>(query_);
  head.scene = parts_.number;
  head.call = call_;
  head.count = outgoing.count;
  head.done = outgoing.done;
  if (outgoing.count == 0) outgoing.message.Extend(sizeof(head));
  std::memcpy(outgoing.message.data(), &head, sizeof(head));
  return std::exchange(outgoing, {}).message;
}

void DividedCall::SendRays(std::size_t number, Outgoing& outgoing) {
  if (outgoing.count == 0) return;
  traffic_.rays_out += outgoing.count;
  BundleHead head{};
  head.kind = static_cast<uint32_t>(number % RayKind::kKinds);
  link_.Send(static_cast<int>(number / RayKind::kKinds), tag_, Finish(outgoing, head));
}

void DividedCall::SendAnswers(int home, Outgoing& outgoing) {
  if (outgoing.done == 0 && outgoing.count == 0) return;
  BundleHead head{};
  head.is_answer = 1;
  if (home == link_.rank()) {
    own_hits_.push_back(Finish(outgoing, head));
  } else {
    link_.Send(home, tag_, Finish(outgoing, head));
  }
}

void DividedCall::SendAll() {
  for (std::size_t number = 0; number < rays_out_.size(); ++number) {
    SendRays(number, rays_out_[number]);
  }
  for (int home = 0; home < link_.size(); ++home) {
    // Those of this rank go nowhere.
    if (home != link_.rank()) SendAnswers(home, answers_out_[static_cast<std::size_t>(home)]);
  }
}

}  // namespace dacrt::mpi

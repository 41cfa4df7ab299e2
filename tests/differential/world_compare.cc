#include "world_compare.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>

#include "answer.h"

namespace dacrt::tests {
namespace {

/// Also where the bound is not a number because nothing is known.
bool Admits(const Bounded& bound, double value) {
  return !(std::abs(value - bound.value) > bound.error);
}

bool ValuesFit(const RTCHit& hit, float t, const ShapeAnswer& truth) {
  return Admits(truth.t, t) && Admits(truth.u, hit.u) && Admits(truth.v, hit.v) &&
         Admits(truth.normal[0], hit.Ng_x) && Admits(truth.normal[1], hit.Ng_y) &&
         Admits(truth.normal[2], hit.Ng_z);
}

/// The names that a form without arrays for the normal and the instance leaves out.
RTCHit Complete(const RTCRayHit& before, RTCHit hit, const PossibleHit& possible) {
  if (std::memcmp(&hit.Ng_x, &before.hit.Ng_x, 3 * sizeof(float)) == 0) {
    hit.Ng_x = static_cast<float>(possible.answer.normal[0].value);
    hit.Ng_y = static_cast<float>(possible.answer.normal[1].value);
    hit.Ng_z = static_cast<float>(possible.answer.normal[2].value);
  }
  return hit;
}

/// A negative tnear counts as zero for the boxes that a ray enters, and as itself for what stands
/// in them. So what lies behind the origin may be found or not.
bool IsOptional(const RTCRay& ray, const ShapeAnswer& answer) {
  return ray.tnear < 0 && answer.t.value - answer.t.error <= 0;
}

RTCHit HitNamed(const HitName& name) {
  return {0, 0, 0, 0, 0, name.primitive_id, name.geometry_id, {name.instance_id}};
}

std::string Text(const HitName& name) {
  std::ostringstream text;
  text << "geometry " << name.geometry_id << ", primitive " << name.primitive_id;
  if (name.instance_id != RTC_INVALID_GEOMETRY_ID) text << ", instance " << name.instance_id;
  return text.str();
}

using Judgement = JudgementBy<ShapeAnswer>;

/// Judges answers to one ray. What all primitives must answer is found once.
class Judge {
 public:
  Judge(const std::vector<WorldScene>& scenes, const WorldReference& reference, const Batch& batch,
        const RTCRayHit& before, const Company& company)
      : scenes_(scenes),
        reference_(reference),
        batch_(batch),
        before_(before),
        company_(company),
        near_hits_(reference.NearHits(before.ray)) {}

  Judgement Of(const Answer& answer, Library library) const {
    if (!answer.is_legal) return {"changed what no hit changes"};
    if (!answer.is_hit) return WithoutNearer(before_.ray.tfar, kInfinity, library);
    return batch_.query == Query::kClosest ? OfClosest(answer, library) : OfOccluded();
  }

  std::string OfferFault(const Answer& answer, Library library,
                         std::span<const Offer> offers) const {
    for (const Offer& offer : offers) {
      if (std::string fault = FaultOf(offer, library, offers); !fault.empty()) return fault;
    }
    const bool ends_early = batch_.query == Query::kAny && answer.is_hit;
    return ends_early ? "" : MissingOffer(answer, library, offers);
  }

 private:
  bool ContextFilterRuns() const {
    return batch_.context_filter != FilterKind::kNone &&
           (scenes_.back().flags & RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) != 0;
  }

  FilterKind FilterOf(const WorldGeometry& geometry) const {
    return batch_.query == Query::kClosest ? geometry.closest_filter : geometry.any_filter;
  }

  bool RejectedByGeometry(const Part& part) const {
    return Rejects(FilterOf(*part.geometry), before_.ray.id, HitNamed(part.name));
  }

  bool IsRejected(const Part& part) const {
    return RejectedByGeometry(part) ||
           (ContextFilterRuns() &&
            Rejects(batch_.context_filter, before_.ray.id, HitNamed(part.name)));
  }

  bool IsChangedByGeometry(const Part& part) const {
    return FilterOf(*part.geometry) == FilterKind::kChange;
  }

  /// What a hit that was accepted says.
  ShapeAnswer Accepted(const PossibleHit& hit) const {
    const bool by_context = ContextFilterRuns() && batch_.context_filter == FilterKind::kChange;
    return by_context ? Changed(hit.answer) : ShownToContext(hit);
  }

  ShapeAnswer ShownToContext(const PossibleHit& hit) const {
    return IsChangedByGeometry(*hit.part) ? Changed(hit.answer) : hit.answer;
  }

  static ShapeAnswer Changed(ShapeAnswer answer) {
    answer.u = Exactly(kChangedU);
    answer.v = Exactly(kChangedV);
    return answer;
  }

  bool Fits(const Offer& offer, const PossibleHit& hit) const {
    return ValuesFit(offer.hit, offer.t, offer.by_context ? ShownToContext(hit) : hit.answer);
  }

  /// The name in a record; forms without instID leave it as it was.
  std::vector<PossibleHit> HitsNamed(const RTCRay& ray, const RTCHit& hit) const {
    std::vector<PossibleHit> hits = reference_.HitsOf(ray, NameOf(hit));
    if (!hits.empty() || batch_.form.call != Form::Call::kRequiredArrays) return hits;
    std::vector<PossibleHit> all = reference_.AllHits(ray);
    std::erase_if(all, [&](const PossibleHit& possible) {
      return possible.part->name.geometry_id != hit.geomID ||
             possible.part->name.primitive_id != hit.primID;
    });
    return all;
  }

  std::vector<PossibleHit> HitsBeyondTheEnd(const RTCHit& hit) const {
    const auto ray = RayBeyondTheEnd(before_.ray, reference_.AllHits(before_.ray));
    if (!ray) return {};
    std::vector<PossibleHit> hits = HitsNamed(*ray, hit);
    for (PossibleHit& possible : hits) possible.answer.doubts |= kDoubtRange;
    return hits;
  }

  Judgement OfClosest(const Answer& answer, Library library) const {
    const float t = answer.record.ray.tfar;
    std::vector<PossibleHit> hits = HitsNamed(before_.ray, answer.record.hit);
    if (hits.empty() && library == Library::kReal) hits = HitsBeyondTheEnd(answer.record.hit);
    if (hits.empty()) return {"hits a primitive that the ray misses"};
    std::erase_if(hits, [&](const PossibleHit& hit) { return IsRejected(*hit.part); });
    if (hits.empty()) return {"has a hit that a filter function rejects"};
    const auto fits = std::find_if(hits.begin(), hits.end(), [&](const PossibleHit& hit) {
      return ValuesFit(Complete(before_, answer.record.hit, hit), t, Accepted(hit));
    });
    if (fits == hits.end()) return {"has values beyond rounding"};
    Judgement judgement = WithoutNearer(t, KeepsNearer(t, *fits, library) ? t : 0, library);
    judgement.truth = fits->answer;
    return judgement;
  }

  /// Where its products overflow the real library finds an infinite distance, for which it gives up
  /// a nearer hit.
  static bool KeepsNearer(float t, const PossibleHit& hit, Library library) {
    return library == Library::kDropIn || !std::isinf(t) || !(hit.answer.doubts & kDoubtRange);
  }

  Judgement OfOccluded() const {
    const auto find = [&](const std::vector<PossibleHit>& hits) -> const PossibleHit* {
      const PossibleHit* found = nullptr;
      for (const PossibleHit& hit : hits) {
        if (IsRejected(*hit.part)) continue;
        if (!found || (hit.answer.is_hit && !found->answer.is_hit)) found = &hit;
      }
      return found;
    };
    Judgement judgement;
    if (const PossibleHit* const hit = find(near_hits_)) {
      judgement.truth = hit->answer;
      return judgement;
    }
    const std::vector<PossibleHit> all = reference_.AllHits(before_.ray);
    const PossibleHit* const hit = find(all);
    if (!hit) return {"is occluded where there is nothing"};
    judgement.truth = hit->answer;
    return judgement;
  }

  /// Faults if there is a hit that is certain, and certainly before `limit`. `tfar` is what ends
  /// the box tests.
  Judgement WithoutNearer(float tfar, double limit, Library library) const {
    Judgement judgement;
    for (const PossibleHit& hit : near_hits_) {
      if (!IsCertainBefore(hit, limit) || IsRejected(*hit.part)) continue;
      if (!MayLose(hit, tfar, library)) {
        return {"lacks the hit on " + Text(hit.part->name) + " at " +
                std::to_string(hit.answer.t.value)};
      }
      judgement.needs_slab_test = true;
    }
    return judgement;
  }

  bool IsCertainBefore(const PossibleHit& hit, double limit) const {
    return hit.answer.MustHit() && !IsOptional(before_.ray, hit.answer) &&
           hit.answer.t.value + hit.answer.t.error < limit;
  }

  bool MayLose(const PossibleHit& hit, float tfar, Library library) const {
    return library == Library::kReal &&
           (company_.loses_its_end ||
            reference_.SlabTestMayMiss(before_.ray, tfar, *hit.part, company_));
  }

  static bool IsSame(const Offer& a, const Offer& b) {
    return a.by_context == b.by_context && NameOf(a.hit) == NameOf(b.hit);
  }

  /// The real library promises that nothing is shown twice for closest hits only, and not where it
  /// splits primitives.
  bool MayRepeat(Library library) const {
    if (library == Library::kDropIn) return false;
    return batch_.query == Query::kAny ||
           std::any_of(scenes_.begin(), scenes_.end(), [](const WorldScene& scene) {
             return scene.quality == RTC_BUILD_QUALITY_HIGH;
           });
  }

  std::string FaultOf(const Offer& offer, Library library, std::span<const Offer> offers) const {
    std::vector<PossibleHit> hits = reference_.HitsOf(before_.ray, NameOf(offer.hit));
    if (hits.empty() && library == Library::kReal) hits = HitsBeyondTheEnd(offer.hit);
    const std::string what = Text(NameOf(offer.hit)) + " at " + std::to_string(offer.t);
    const bool fits = std::any_of(hits.begin(), hits.end(),
                                  [&](const PossibleHit& hit) { return Fits(offer, hit); });
    if (!fits) return "shows a filter function a hit that is none: " + what;
    if (offer.by_context && RejectedByGeometry(*hits.front().part)) {
      return "shows the context a hit that the geometry's filter function rejects: " + what;
    }
    const auto shown = static_cast<std::size_t>(std::count_if(
        offers.begin(), offers.end(), [&](const Offer& other) { return IsSame(offer, other); }));
    if (shown > hits.size() && !MayRepeat(library))
      return "shows a filter function a hit twice: " + what;
    return "";
  }

  /// The real library shows an occlusion filter function one of the hits that a ray has on
  /// neighbouring quads of a grid, and may leave out the others.
  bool IsOfferOptional(const Part& part, Library library) const {
    return library == Library::kReal && batch_.query == Query::kAny &&
           part.geometry->shape == Shape::kGrids;
  }

  bool IsShownToAny(const Part& part) const {
    return FilterOf(*part.geometry) != FilterKind::kNone || ContextFilterRuns();
  }

  /// Where at the nearest the ray may have ended for a while: at a hit that was shown and accepted,
  /// or at one that is shown to nobody.
  double NearestEnd(std::span<const Offer> offers) const {
    double nearest = kInfinity;
    for (const Offer& offer : offers) {
      const std::vector<PossibleHit> hits = reference_.HitsOf(before_.ray, NameOf(offer.hit));
      if (hits.empty() || IsRejected(*hits.front().part)) continue;
      nearest = std::min<double>(nearest, offer.t);
    }
    for (const PossibleHit& hit : reference_.AllHits(before_.ray)) {
      if (IsShownToAny(*hit.part)) continue;
      nearest = std::min(nearest, hit.answer.t.value - hit.answer.t.error);
    }
    return nearest;
  }

  /// What is nearer than this must have been shown.
  double EndOfOffers(const Answer& answer, Library library, std::span<const Offer> offers) const {
    if (!answer.is_hit) return kInfinity;
    const float t = answer.record.ray.tfar;
    const std::vector<PossibleHit> hits = HitsNamed(before_.ray, answer.record.hit);
    const bool gave_up_nearer = std::any_of(hits.begin(), hits.end(), [&](const PossibleHit& hit) {
      return !KeepsNearer(t, hit, library);
    });
    return gave_up_nearer ? NearestEnd(offers) : t;
  }

  std::string MissingOffer(const Answer& answer, Library library,
                           std::span<const Offer> offers) const {
    const float tfar = answer.is_hit ? answer.record.ray.tfar : before_.ray.tfar;
    const double end = EndOfOffers(answer, library, offers);
    for (const bool by_context : {false, true}) {
      for (const PossibleHit& hit : near_hits_) {
        const Part& part = *hit.part;
        if (!IsCertainBefore(hit, end)) continue;
        const bool expected = by_context ? ContextFilterRuns() && !RejectedByGeometry(part)
                                         : FilterOf(*part.geometry) != FilterKind::kNone;
        if (!expected || IsOfferOptional(part, library)) continue;
        const bool shown = std::any_of(offers.begin(), offers.end(), [&](const Offer& offer) {
          return offer.by_context == by_context && NameOf(offer.hit) == part.name &&
                 Fits(offer, hit);
        });
        if (shown || MayLose(hit, tfar, library)) continue;
        return std::string("does not show the ") + (by_context ? "context's" : "geometry's") +
               " filter function the hit on " + Text(part.name) + " at " +
               std::to_string(hit.answer.t.value);
      }
    }
    return "";
  }

  const std::vector<WorldScene>& scenes_;
  const WorldReference& reference_;
  const Batch& batch_;
  const RTCRayHit& before_;
  Company company_;
  std::vector<PossibleHit> near_hits_;
};

/// Values within the tolerance: t relative to itself, u and v to 1, the normal to its length.
bool IsRounding(const RTCRayHit& a, const RTCRayHit& b) {
  const auto is_near = [](float x, float y, double scale) {
    return std::memcmp(&x, &y, sizeof(x)) == 0 ||
           std::abs(static_cast<double>(x) - y) <= kTolerance * scale;
  };
  const double normal = Length(Double3{a.hit.Ng_x, a.hit.Ng_y, a.hit.Ng_z});
  return is_near(a.ray.tfar, b.ray.tfar, std::abs(a.ray.tfar)) && is_near(a.hit.u, b.hit.u, 1) &&
         is_near(a.hit.v, b.hit.v, 1) && is_near(a.hit.Ng_x, b.hit.Ng_x, normal) &&
         is_near(a.hit.Ng_y, b.hit.Ng_y, normal) && is_near(a.hit.Ng_z, b.hit.Ng_z, normal);
}

bool AreWithinUlps(float a, float b, int ulps) {
  for (int i = 0; i < ulps && a != b; ++i) a = std::nextafter(a, b);
  return a == b;
}

/// Whether a ray that finds nothing is as it was. Packets of the real library that meet instances
/// or user geometries take a negative tfar for a ray that is occluded already, and say so again.
bool LeavesAlone(Query query, Library library, const RTCRayHit& before, const RTCRayHit& after) {
  if (SameBits(before, after)) return true;
  if (library != Library::kReal || query != Query::kAny || !(before.ray.tfar < 0)) return false;
  const Answer answer = Read(query, before, after);
  return answer.is_legal;
}

}  // namespace

const char* Name(Library library) {
  return library == Library::kReal ? "the real library" : "the drop-in";
}

Comparison WorldComparer::Compare(const Batch& batch, Library judged, const RTCRayHit& before,
                                  const RTCRayHit& real, const RTCRayHit& drop_in,
                                  const Company& company) const {
  if (FindsNothing(before.ray)) {
    if (!LeavesAlone(batch.query, judged, before, drop_in)) {
      return Unexplained("the drop-in changed an inactive ray");
    }
    if (!LeavesAlone(batch.query, Library::kReal, before, real)) {
      return Unexplained("the real library changed an inactive ray");
    }
    return {};
  }
  if (SameBits(real, drop_in)) return {};

  const Answer real_answer = Read(batch.query, before, real);
  const Answer drop_in_answer = Read(batch.query, before, drop_in);
  const bool both_hit = real_answer.is_hit && drop_in_answer.is_hit;
  const bool both_name_one =
      batch.query == Query::kClosest && both_hit && NameOf(real.hit) == NameOf(drop_in.hit);
  if (both_name_one && real_answer.is_legal && drop_in_answer.is_legal &&
      IsRounding(real, drop_in)) {
    return {Relation::kRounding, Side::kBoth, {}};
  }

  const Judge judge(scenes_, reference_, batch, before, company);
  const Judgement of_drop_in = judge.Of(drop_in_answer, judged);
  if (!of_drop_in.fault.empty() && !IsExcused(judged, before)) {
    return Unexplained("the drop-in " + of_drop_in.fault);
  }
  const Judgement of_real = judge.Of(real_answer, Library::kReal);
  if (!of_real.fault.empty()) {
    if (IsExcused(Library::kReal, before)) return {Relation::kWithheld, Side::kDropIn, {}};
    return Unexplained("the real library " + of_real.fault);
  }

  const Side right = SideOfExact(real_answer, of_real, drop_in_answer, of_drop_in);
  if (of_real.needs_slab_test || of_drop_in.needs_slab_test)
    return {Relation::kSlabTest, right, {}};
  if (both_hit && AreWithinUlps(real.ray.tfar, drop_in.ray.tfar, 2) && !both_name_one) {
    return {Relation::kTie, right, {}};
  }
  return {RelationOfDoubts({&of_real, &of_drop_in}), right, {}};
}

std::optional<std::string> WorldComparer::FindFault(const Batch& batch, Library library,
                                                    const RTCRayHit& before, const RTCRayHit& after,
                                                    const Company& company) const {
  if (FindsNothing(before.ray)) {
    if (LeavesAlone(batch.query, library, before, after)) return std::nullopt;
    return "changed an inactive ray";
  }
  const Judge judge(scenes_, reference_, batch, before, company);
  std::string fault = judge.Of(Read(batch.query, before, after), library).fault;
  if (fault.empty() || IsExcused(library, before)) return std::nullopt;
  return fault;
}

std::optional<std::string> WorldComparer::FindOfferFault(const Batch& batch, Library library,
                                                         const RTCRayHit& before,
                                                         const RTCRayHit& after,
                                                         std::span<const Offer> offers,
                                                         const Company& company) const {
  if (FindsNothing(before.ray)) {
    if (offers.empty()) return std::nullopt;
    return "shows a filter function a hit of an inactive ray";
  }
  const Judge judge(scenes_, reference_, batch, before, company);
  std::string fault = judge.OfferFault(Read(batch.query, before, after), library, offers);
  if (fault.empty() || IsExcused(library, before)) return std::nullopt;
  return fault;
}

bool WorldComparer::IsExcused(Library library, const RTCRayHit& before) const {
  return library == Library::kReal && reference_.IsAtEndOfTimes(before.ray);
}

std::string WorldComparer::Describe(const Batch& batch, const RTCRayHit& before,
                                    const RTCRayHit& real, const RTCRayHit& drop_in) const {
  std::ostringstream text;
  const RTCRay& ray = before.ray;
  text << std::setprecision(9) << "  ray " << ray.id << " org {" << ray.org_x << ", " << ray.org_y
       << ", " << ray.org_z << "} dir {" << ray.dir_x << ", " << ray.dir_y << ", " << ray.dir_z
       << "} tnear " << ray.tnear << " tfar " << ray.tfar << " time " << ray.time << " mask 0x"
       << std::hex << ray.mask << std::dec << '\n';
  for (const auto& [name, record] : {std::pair("real", &real), std::pair("drop-in", &drop_in)}) {
    text << "  " << std::setw(8) << std::left << name << ' ';
    if (SameBits(before, *record)) {
      text << "miss\n";
    } else if (batch.query == Query::kAny) {
      text << "t " << record->ray.tfar << '\n';
    } else {
      const RTCHit& hit = record->hit;
      text << "t " << record->ray.tfar << " u " << hit.u << " v " << hit.v << " Ng {" << hit.Ng_x
           << ", " << hit.Ng_y << ", " << hit.Ng_z << "} " << Text(NameOf(hit)) << '\n';
    }
  }
  if (FindsNothing(ray)) return text.str();
  std::vector<PossibleHit> hits = reference_.AllHits(ray);
  std::sort(hits.begin(), hits.end(), [](const PossibleHit& a, const PossibleHit& b) {
    return a.answer.t.value < b.answer.t.value;
  });
  constexpr std::size_t kShown = 8;
  text << "  reference: " << hits.size() << " possible hits, filter functions not considered\n";
  for (const PossibleHit& hit : std::span(hits).first(std::min(kShown, hits.size()))) {
    const ShapeAnswer& truth = hit.answer;
    text << "    " << tests::Name(hit.part->geometry->shape) << ", " << Text(hit.part->name)
         << (truth.is_hit ? ": hit" : ": miss") << (truth.doubts ? ", in doubt by" : ", certain");
    if (truth.doubts & kDoubtEdge) text << " edge";
    if (truth.doubts & kDoubtInterval) text << " interval";
    if (truth.doubts & kDoubtParallel) text << " parallel";
    if (truth.doubts & kDoubtRange) text << " range";
    const auto show = [&](const char* name, const Bounded& value) {
      text << ' ' << name << ' ' << std::setprecision(9) << value.value << " +- "
           << std::setprecision(3) << value.error;
    };
    show("t", truth.t);
    show("u", truth.u);
    show("v", truth.v);
    show("Ng", truth.normal[0]);
    show("", truth.normal[1]);
    show("", truth.normal[2]);
    text << '\n';
  }
  return text.str();
}

}  // namespace dacrt::tests

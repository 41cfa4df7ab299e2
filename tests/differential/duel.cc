#include "duel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

#include "batch_rays.h"
#include "contest.h"

namespace dacrt::tests {
namespace {

/// What the real library gets in place of a ray that it aborts on.
constexpr RTCRayHit kInactive{{0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0}, {}};

/// Answers of both libraries that are checked by brute force in each batch, whether they are equal
/// or not.
constexpr std::size_t kAuditsPerBatch = 8;

/// More than this many findings of a batch are more of the same.
constexpr std::size_t kMostFindings = 3;

/// Offers of one batch in the order of rays, of a ray in an order that does not depend on when
/// they were made.
void Sort(std::vector<Offer>& offers) {
  const auto key = [](const Offer& offer) {
    return std::tuple(offer.ray_id, offer.by_context, NameOf(offer.hit), offer.t, offer.hit.u,
                      offer.hit.v);
  };
  std::stable_sort(offers.begin(), offers.end(),
                   [&](const Offer& a, const Offer& b) { return key(a) < key(b); });
}

bool AreAlike(const Offer& a, const Offer& b) {
  constexpr double kTolerance = 16 * 0x1p-23;
  return a.by_context == b.by_context && NameOf(a.hit) == NameOf(b.hit) &&
         std::abs(a.t - b.t) <= kTolerance * std::abs(a.t) &&
         std::abs(a.hit.u - b.hit.u) <= kTolerance && std::abs(a.hit.v - b.hit.v) <= kTolerance;
}

/// Whether two libraries made the same offers, none twice. `a` and `b` are sorted.
bool AreAlike(std::span<const Offer> a, std::span<const Offer> b) {
  for (std::size_t i = 1; i < a.size(); ++i) {
    if (AreAlike(a[i - 1], a[i])) return false;
  }
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Offer& x, const Offer& y) { return AreAlike(x, y); });
}

/// The offers of one ray, from the front of what is left.
std::span<const Offer> TakeOffers(std::span<const Offer>& rest, uint32_t ray_id) {
  std::size_t count = 0;
  while (count < rest.size() && rest[count].ray_id == ray_id) ++count;
  const std::span<const Offer> taken = rest.first(count);
  rest = rest.subspan(count);
  return taken;
}

}  // namespace

Arena::Arena(const std::string& config) : Arena(tests::DropIn(), config, Library::kDropIn) {}

Arena Arena::OfRealAlone(const std::string& config) {
  return Arena(RealEmbree(), config, Library::kReal);
}

const EmbreeDevice& Arena::Real(const World& world) {
  return Device(RealEmbree(), world.real_config);
}

const EmbreeDevice& Arena::DropIn(const World& world) {
  return Device(drop_in_, config_.empty() ? world.drop_in_config : config_);
}

const EmbreeDevice& Arena::Device(const EmbreeApi& api, const std::string& config) {
  auto& device = devices_[{&api, config}];
  if (!device) device = std::make_unique<EmbreeDevice>(api, config);
  return *device;
}

/// One batch before and after, in both libraries.
struct Duel::Trial {
  std::vector<RTCRayHit> before;  ///< with what a form cannot carry replaced
  std::vector<RTCRayHit> real, drop_in;
  CallContext real_call, drop_in_call;
};

Duel::Duel(Arena& arena, const World& world)
    : judged_(arena.Judged()), progress_(arena.progress()), scenes_(world.scenes) {
  progress_.in_real_library = true;
  real_ = std::make_unique<PlayedWorld>(arena.Real(world), world.scenes);
  progress_.in_real_library = false;
  drop_in_ = std::make_unique<PlayedWorld>(arena.DropIn(world), world.scenes);
  Describe();
}

Duel::~Duel() = default;

void Duel::Describe() { comparer_ = std::make_unique<WorldComparer>(scenes_); }

PlayedWorld& Duel::Real() const {
  progress_.in_real_library = true;
  return *real_;
}

PlayedWorld& Duel::DropIn() const {
  progress_.in_real_library = false;
  return *drop_in_;
}

void Duel::Commit(std::span<const Change> changes) {
  if (changes.empty()) return;
  Real().Commit(changes);
  DropIn().Commit(changes);
  for (const Change& change : changes) Apply(change, scenes_);
  Describe();
}

void Duel::MakeRays(Batch& batch, uint64_t seed) const {
  tests::MakeRays(batch, seed, scenes_, Real());
}

std::vector<Finding> Duel::Run(const Batch& batch, Tally& tally) const {
  Trial trial;
  trial.before = batch.rays;
  ReplaceAbsent(batch.form, trial.before);
  std::vector<RTCRayHit> accepted = trial.before;
  for (RTCRayHit& record : accepted) {
    if (!RealLibraryAborts(record.ray)) continue;
    const uint32_t id = record.ray.id;
    record = kInactive;
    record.ray.id = id;
  }
  trial.real_call = MakeContext(batch.context_filter);
  trial.drop_in_call = MakeContext(batch.context_filter);
  trial.real = Real().Trace(batch, accepted, trial.real_call);
  trial.drop_in = DropIn().Trace(batch, judged_ == Library::kReal ? accepted : trial.before,
                                 trial.drop_in_call);

  std::vector<Finding> findings;
  CheckCall(batch, trial.real_call, Library::kReal, findings);
  CheckCall(batch, trial.drop_in_call, judged_, findings);
  tally.rays += trial.before.size();
  for (std::size_t i = 0; i < trial.before.size(); ++i) {
    ++tally.comparisons;
    const RTCRayHit& before = trial.before[i];
    const Company company = CompanyOf(batch, trial, i);
    Comparison comparison{Relation::kWithheld, Side::kDropIn, {}};
    if (!RealLibraryAborts(before.ray)) {
      comparison =
          comparer_->Compare(batch, judged_, before, trial.real[i], trial.drop_in[i], company);
    }
    const auto relation = static_cast<std::size_t>(comparison.relation);
    ++tally.relations[relation];
    ++tally.sides[relation][static_cast<std::size_t>(comparison.right)];
    if (comparison.relation != Relation::kUnexplained || findings.size() >= kMostFindings) continue;
    findings.push_back({comparison.reason,
                        comparer_->Describe(batch, before, trial.real[i], trial.drop_in[i]), i});
  }
  CompareOffers(batch, trial, findings);
  Audit(batch, trial, tally, findings);
  return findings;
}

Company Duel::CompanyOf(const Batch& batch, const Trial& trial, std::size_t i) const {
  const auto with = [&](const std::vector<RTCRayHit>& answers) {
    return tests::CompanyOf(batch.form, batch.query, trial.before, answers, i);
  };
  Company company = with(trial.real);
  if (judged_ == Library::kReal && with(trial.drop_in).loses_its_end) company.loses_its_end = true;
  return company;
}

void Duel::CheckCall(const Batch& batch, const CallContext& call, Library library,
                     std::vector<Finding>& findings) const {
  if (!call.fault.empty()) {
    findings.push_back({std::string(Name(library)) + ": " + call.fault, "", 0});
  }
  // The real library itself calls with N = 1 in coherent streams and in streams of one ray.
  if (library == Library::kDropIn && IsStream(batch.form) && call.fewest_lanes == 1) {
    findings.push_back(
        {std::string(Name(library)) + " calls a filter function with N = 1 from a stream call", "",
         0});
  }
}

void Duel::CompareOffers(const Batch& batch, const Trial& trial,
                         std::vector<Finding>& findings) const {
  // Without an array of ids nothing says whose hit was shown.
  if (batch.form.call == Form::Call::kRequiredArrays) return;
  std::vector<Offer> real = trial.real_call.offers, drop_in = trial.drop_in_call.offers;
  Sort(real);
  Sort(drop_in);
  std::vector<std::size_t> order(trial.before.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return trial.before[a].ray.id < trial.before[b].ray.id;
  });
  std::span<const Offer> real_rest = real, drop_in_rest = drop_in;
  for (const std::size_t i : order) {
    if (findings.size() >= kMostFindings) return;
    const RTCRayHit& before = trial.before[i];
    const auto of_real = TakeOffers(real_rest, before.ray.id);
    const auto of_drop_in = TakeOffers(drop_in_rest, before.ray.id);
    if (AreAlike(of_real, of_drop_in)) continue;
    const Company company = CompanyOf(batch, trial, i);
    const auto check = [&](Library library, const RTCRayHit& after, std::span<const Offer> offers) {
      const std::optional<std::string> fault =
          comparer_->FindOfferFault(batch, library, before, after, offers, company);
      if (!fault) return;
      findings.push_back({std::string(Name(library)) + ' ' + *fault,
                          comparer_->Describe(batch, before, trial.real[i], trial.drop_in[i]), i});
    };
    check(judged_, trial.drop_in[i], of_drop_in);
    if (!RealLibraryAborts(before.ray)) check(Library::kReal, trial.real[i], of_real);
  }
  if (!real_rest.empty() || !drop_in_rest.empty()) {
    findings.push_back({std::string(Name(real_rest.empty() ? judged_ : Library::kReal)) +
                            " shows a filter function a hit of no ray",
                        "", 0});
  }
}

void Duel::Audit(const Batch& batch, const Trial& trial, Tally& tally,
                 std::vector<Finding>& findings) const {
  const std::size_t step = trial.before.size() / kAuditsPerBatch + 1;
  for (std::size_t i = 0; i < trial.before.size(); i += step) {
    ++tally.audits;
    const RTCRayHit& before = trial.before[i];
    const Company company = CompanyOf(batch, trial, i);
    const auto check = [&](Library library, const RTCRayHit& after) {
      const std::optional<std::string> fault =
          comparer_->FindFault(batch, library, before, after, company);
      if (!fault || findings.size() >= kMostFindings) return;
      ++tally.relations[static_cast<std::size_t>(Relation::kUnexplained)];
      findings.push_back({"audited: " + std::string(Name(library)) + ' ' + *fault,
                          comparer_->Describe(batch, before, trial.real[i], trial.drop_in[i]), i});
    };
    const bool is_withheld = RealLibraryAborts(before.ray);
    if (!is_withheld) check(Library::kReal, trial.real[i]);
    if (!is_withheld || judged_ == Library::kDropIn) check(judged_, trial.drop_in[i]);
  }
}

}  // namespace dacrt::tests

#include "compare.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>

#include "answer.h"

namespace dacrt::tests {
namespace {

bool SameFloatBits(float a, float b) { return std::memcmp(&a, &b, sizeof(float)) == 0; }

/// The record's values against what single precision can make of its triangle.
bool ValuesFit(const RTCRayHit& before, const RTCRayHit& after, const TriangleAnswer& truth) {
  if (!truth.t.Admits(after.ray.tfar) || !truth.u.Admits(after.hit.u) ||
      !truth.v.Admits(after.hit.v)) {
    return false;
  }
  const float normal[3] = {after.hit.Ng_x, after.hit.Ng_y, after.hit.Ng_z};
  const float normal_before[3] = {before.hit.Ng_x, before.hit.Ng_y, before.hit.Ng_z};
  // A form without normals leaves them as they were.
  if (std::memcmp(normal, normal_before, sizeof(normal)) == 0) return true;
  for (int axis = 0; axis < 3; ++axis) {
    if (!truth.normal[axis].Admits(normal[axis])) return false;
  }
  return true;
}

/// A negative tnear counts as zero for the boxes that a ray enters, and as itself for the triangles
/// in them. So what lies behind the origin may be found or not.
bool IsOptional(const RTCRay& ray, const TriangleAnswer& answer) {
  return ray.tnear < 0 && answer.t.value - answer.t.error <= 0;
}

using Judgement = JudgementBy<TriangleAnswer>;

/// What a library's bounding boxes do to its answers.
struct Boxes {
  bool may_lose_hits = false;  ///< slab tests round either way
  Company company = {};
};

/// The drop-in's boxes are widened for the rounding.
constexpr Boxes kBoxesOfDropIn{};

/// Judges hits and misses of one ray. What all triangles must answer is found once.
class Judge {
 public:
  /// Of answers that are no farther than `limit`.
  Judge(const Reference& reference, Query query, const RTCRayHit& before, double limit)
      : reference_(reference),
        query_(query),
        before_(before),
        must_hits_(reference.MustHits(before.ray, limit)) {}

  Judgement Of(const Answer& answer, const Boxes& boxes) const {
    if (!answer.is_legal) return {"changed what no hit changes"};
    if (!answer.is_hit) return WithoutNearer(before_.ray.tfar, kInfinity, boxes);
    return query_ == Query::kClosest ? OfClosest(answer, boxes) : OfOccluded();
  }

 private:
  Judgement OfClosest(const Answer& answer, const Boxes& boxes) const {
    const RTCHit& hit = answer.record.hit;
    const float t = answer.record.ray.tfar;
    const Corners* const corners = reference_.Find(hit.geomID, hit.primID, before_.ray.mask);
    if (!corners) return {"names a triangle that the ray cannot hit"};
    TriangleAnswer truth = TestTriangle(before_.ray, *corners);
    if (!truth.MayHit() && boxes.may_lose_hits) truth = BeyondTheEnd(*corners);
    if (!truth.MayHit()) return {"hits a triangle that the ray misses"};
    if (boxes.may_lose_hits && std::isnan(t) && (truth.doubts & kDoubtParallel)) {
      // The real library divides by a determinant of zero, and finds nothing nearer any more.
      Judgement judgement;
      judgement.truth = truth;
      return judgement;
    }
    if (!ValuesFit(before_, answer.record, truth)) return {"has values beyond rounding"};
    Judgement judgement = WithoutNearer(t, t, boxes);
    judgement.truth = truth;
    return judgement;
  }

  TriangleAnswer BeyondTheEnd(const Corners& corners) const {
    const auto ray = RayBeyondTheEnd(before_.ray, reference_.MayHits(before_.ray));
    if (!ray) return {};
    TriangleAnswer answer = TestTriangle(*ray, corners);
    if (answer.MayHit()) answer.doubts |= kDoubtRange;
    return answer;
  }

  Judgement OfOccluded() const {
    const std::optional<ReferenceHit> hit =
        must_hits_.empty() ? reference_.MayHit(before_.ray) : must_hits_.front();
    if (!hit) return {"is occluded where there is no triangle"};
    Judgement judgement;
    judgement.truth = hit->answer;
    return judgement;
  }

  /// Faults if there is a hit that is certain, and certainly before `limit`. `tfar` is what ends
  /// the box tests.
  Judgement WithoutNearer(float tfar, double limit, const Boxes& boxes) const {
    Judgement judgement;
    for (const ReferenceHit& must : must_hits_) {
      if (IsOptional(before_.ray, must.answer)) continue;
      if (must.answer.t.value + must.answer.t.error >= limit) continue;
      if (!MayLose(must, tfar, boxes)) {
        return {"lacks the hit on geometry " + std::to_string(must.geometry_id) + ", primitive " +
                std::to_string(must.primitive_id) + " at " + std::to_string(must.answer.t.value)};
      }
      judgement.needs_slab_test = true;
    }
    return judgement;
  }

  bool MayLose(const ReferenceHit& hit, float tfar, const Boxes& boxes) const {
    return boxes.may_lose_hits &&
           (PlanesMayBeSwapped(before_.ray, boxes.company.guides) ||
            SlabTestMayMiss(before_.ray, tfar, hit.corners, boxes.company.packet));
  }

  const Reference& reference_;
  Query query_;
  const RTCRayHit& before_;
  std::vector<ReferenceHit> must_hits_;
};

/// How far a ray has seen for such an answer.
double SeenBy(Query query, const RTCRayHit& before, const Answer& answer) {
  return query == Query::kClosest && answer.is_hit ? answer.record.ray.tfar : before.ray.tfar;
}

/// The same triangle, and values within the tolerance: t relative to itself, u and v to 1, the
/// normal to the lengths of the edges whose cross product it is.
bool IsRounding(const RTCRayHit& real, const RTCRayHit& drop_in, const Corners& corners) {
  const auto is_near = [](float a, float b, double scale) {
    // Where a form has no normals, they are the random bits that were there before.
    return SameFloatBits(a, b) || std::abs(static_cast<double>(a) - b) <= kTolerance * scale;
  };
  const double t_scale = std::max(std::abs(real.ray.tfar), std::abs(drop_in.ray.tfar));
  const Double3 v0(corners.v0);
  const double normal_scale = Length(Double3(corners.v1) - v0) * Length(Double3(corners.v2) - v0);
  return is_near(real.ray.tfar, drop_in.ray.tfar, t_scale) &&
         is_near(real.hit.u, drop_in.hit.u, 1) && is_near(real.hit.v, drop_in.hit.v, 1) &&
         is_near(real.hit.Ng_x, drop_in.hit.Ng_x, normal_scale) &&
         is_near(real.hit.Ng_y, drop_in.hit.Ng_y, normal_scale) &&
         is_near(real.hit.Ng_z, drop_in.hit.Ng_z, normal_scale);
}

bool AreWithinUlps(float a, float b, int ulps) {
  for (int i = 0; i < ulps && a != b; ++i) a = std::nextafter(a, b);
  return a == b;
}

bool SameTriangle(const RTCHit& a, const RTCHit& b) {
  return a.geomID == b.geomID && a.primID == b.primID;
}

}  // namespace

const char* Name(Relation relation) {
  constexpr const char* kNames[kRelationCount] = {
      "identical",       "rounding",  "tie",      "edge",  "interval",   "parallel",
      "ill_conditioned", "slab_test", "withheld", "range", "unexplained"};
  return kNames[static_cast<int>(relation)];
}

const char* Name(Side side) {
  constexpr const char* kNames[kSideCount] = {"neither", "real", "drop-in", "both"};
  return kNames[static_cast<int>(side)];
}

Comparison Comparer::Compare(Query query, const RTCRayHit& before, const RTCRayHit& real,
                             const RTCRayHit& drop_in, const Company& company) const {
  if (FindsNothing(before.ray)) {
    if (!SameBits(before, drop_in)) return Unexplained("the drop-in changed an inactive ray");
    if (!SameBits(before, real)) return Unexplained("the real library changed an inactive ray");
    return {};
  }
  if (SameBits(real, drop_in)) return {};

  const Answer real_answer = Read(query, before, real);
  const Answer drop_in_answer = Read(query, before, drop_in);
  const bool both_name_one = query == Query::kClosest && real_answer.is_hit &&
                             drop_in_answer.is_hit && SameTriangle(real.hit, drop_in.hit);
  if (both_name_one && real.hit.instID[0] == drop_in.hit.instID[0] && real_answer.is_legal &&
      drop_in_answer.is_legal) {
    const Corners* const corners =
        reference_.Find(real.hit.geomID, real.hit.primID, before.ray.mask);
    if (corners && IsRounding(real, drop_in, *corners))
      return {Relation::kRounding, Side::kBoth, {}};
  }

  const Judge judge(
      reference_, query, before,
      std::fmax(SeenBy(query, before, real_answer), SeenBy(query, before, drop_in_answer)));
  const Judgement of_drop_in = judge.Of(drop_in_answer, kBoxesOfDropIn);
  if (!of_drop_in.fault.empty()) return Unexplained("the drop-in " + of_drop_in.fault);
  const Judgement of_real = judge.Of(real_answer, {.may_lose_hits = true, .company = company});
  if (!of_real.fault.empty()) return Unexplained("the real library " + of_real.fault);
  if (real_answer.is_hit && drop_in_answer.is_hit && real.hit.instID[0] != drop_in.hit.instID[0]) {
    return Unexplained("instID differs");
  }

  const Side right = SideOfExact(real_answer, of_real, drop_in_answer, of_drop_in);
  if (of_real.needs_slab_test) return {Relation::kSlabTest, right, {}};
  if (both_name_one) return {Relation::kIllConditioned, right, {}};
  if (real_answer.is_hit && drop_in_answer.is_hit &&
      AreWithinUlps(real.ray.tfar, drop_in.ray.tfar, 2)) {
    return {Relation::kTie, right, {}};
  }
  return {RelationOfDoubts({&of_real, &of_drop_in}), right, {}};
}

bool FindsNothing(const RTCRay& ray) {
  for (const float value : {ray.org_x, ray.org_y, ray.org_z, ray.dir_x, ray.dir_y, ray.dir_z}) {
    if (!std::isfinite(value)) return true;
  }
  return !(ray.tnear <= ray.tfar) || ray.tfar < 0;
}

bool RealLibraryAborts(const RTCRay& ray) {
  constexpr float kLargest = 1.844e18f;
  for (const float value : {ray.org_x, ray.org_y, ray.org_z, ray.dir_x, ray.dir_y, ray.dir_z}) {
    if (!(std::abs(value) < kLargest)) return true;
  }
  return !(ray.tnear >= 0) || std::isnan(ray.tfar);
}

std::optional<std::string> Comparer::FindFault(Query query, const RTCRayHit& before,
                                               const RTCRayHit& after) const {
  if (FindsNothing(before.ray)) {
    if (SameBits(before, after)) return std::nullopt;
    return "changed an inactive ray";
  }
  const Answer answer = Read(query, before, after);
  const Judge judge(reference_, query, before, SeenBy(query, before, answer));
  std::string fault = judge.Of(answer, kBoxesOfDropIn).fault;
  if (fault.empty()) return std::nullopt;
  return fault;
}

std::string Comparer::Describe(Query query, const RTCRayHit& before, const RTCRayHit* real,
                               const RTCRayHit& drop_in) const {
  std::ostringstream text;
  // Hexadecimal: exact, and C++ can read it back.
  text << std::hexfloat;
  const RTCRay& ray = before.ray;
  text << "  ray org {" << ray.org_x << ", " << ray.org_y << ", " << ray.org_z << "} dir {"
       << ray.dir_x << ", " << ray.dir_y << ", " << ray.dir_z << "} tnear " << ray.tnear << " tfar "
       << ray.tfar << " mask 0x" << std::hex << ray.mask << std::dec << ", " << tests::Name(query)
       << '\n';
  const auto describe_answer = [&](const char* name, const RTCRayHit& record) {
    text << "  " << std::setw(8) << std::left << name << ' ';
    if (SameBits(before, record)) {
      text << "miss\n";
      return;
    }
    const RTCHit& hit = record.hit;
    text << "t " << record.ray.tfar;
    if (query == Query::kAny) {
      text << '\n';
      return;
    }
    text << " u " << hit.u << " v " << hit.v << " Ng {" << hit.Ng_x << ", " << hit.Ng_y << ", "
         << hit.Ng_z << "} primID " << hit.primID << " geomID " << hit.geomID << " instID "
         << hit.instID[0] << '\n';
  };
  if (real) describe_answer("real", *real);
  describe_answer("drop-in", drop_in);
  if (FindsNothing(ray)) return text.str();

  constexpr std::size_t kShown = 6;
  std::vector<ReferenceHit> hits = reference_.MayHits(ray);
  std::sort(hits.begin(), hits.end(), [](const ReferenceHit& a, const ReferenceHit& b) {
    return a.answer.t.value < b.answer.t.value;
  });
  text << "  reference: " << hits.size() << " possible hits\n";
  for (std::size_t i = 0; i < std::min(kShown, hits.size()); ++i) {
    const ReferenceHit& hit = hits[i];
    const TriangleAnswer& truth = hit.answer;
    text << std::defaultfloat << std::setprecision(17) << "    geomID " << hit.geometry_id
         << " primID " << hit.primitive_id << (truth.is_hit ? " hit" : " miss")
         << (truth.doubts ? ", in doubt by" : ", certain");
    if (truth.doubts & kDoubtEdge) text << " edge";
    if (truth.doubts & kDoubtInterval) text << " interval";
    if (truth.doubts & kDoubtParallel) text << " parallel";
    if (truth.doubts & kDoubtRange) text << " range";
    text << "; t " << truth.t.value << " +- " << std::setprecision(3) << truth.t.error << " u "
         << truth.u.value << " +- " << truth.u.error << " v " << truth.v.value << " +- "
         << truth.v.error << std::hexfloat << "\n      ";
    for (const Float3& p : {hit.corners.v0, hit.corners.v1, hit.corners.v2}) {
      text << " {" << p.x << ", " << p.y << ", " << p.z << '}';
    }
    text << '\n';
  }
  return text.str();
}

}  // namespace dacrt::tests

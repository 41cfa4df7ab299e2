#include "contest.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "random.h"

namespace dacrt::tests {
namespace {

/// Largest number of rays that are held at once.
constexpr std::size_t kLargestBatch = 1u << 20;

/// What the real library gets in place of a ray that it aborts on.
constexpr RTCRayHit kInactive{{0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0}, {}};

/// Answers of the drop-in that are checked by brute force in each batch.
constexpr std::size_t kAuditsPerBatch = 16;

/// Sizes of calls about the widths of packets and of the streams that renderers send.
constexpr std::size_t kSmallCalls[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 33, 64, 65, 100, 1000};

/// How many small calls of one form a kind of rays gets. Each costs the drop-in a partition of the
/// whole scene; this many triangles make a second or two for all kinds.
std::size_t SmallCallBudget(std::size_t triangle_count) {
  constexpr std::size_t kTriangles = 1'000'000;
  return std::clamp<std::size_t>(kTriangles / (triangle_count + 1), 1, 500);
}

std::vector<RTCRayHit> TraceInPieces(const EmbreeScene& scene, const Form& form, Query query,
                                     std::span<const RTCRayHit> rays, std::size_t rays_per_call) {
  if (rays.size() <= rays_per_call) return Trace(scene, form, query, rays);
  std::vector<RTCRayHit> result;
  result.reserve(rays.size());
  while (!rays.empty()) {
    const std::size_t count = std::min(rays_per_call, rays.size());
    const std::vector<RTCRayHit> piece = Trace(scene, form, query, rays.first(count));
    result.insert(result.end(), piece.begin(), piece.end());
    rays = rays.subspan(count);
  }
  return result;
}

}  // namespace

const EmbreeApi& RealEmbree() {
  static const EmbreeApi api = LoadEmbree(DACRT_REAL_EMBREE);
  return api;
}

const EmbreeApi& DropIn() {
  static const EmbreeApi api = LoadEmbree(DACRT_DROP_IN);
  return api;
}

std::vector<std::string> IsaConfigs() {
  std::vector<std::string> configs = {"isa=sse2", "isa=sse4.2", "isa=avx2", "isa=avx512"};
  std::erase_if(configs, [](const std::string& config) {
    const RTCDevice device = RealEmbree().rtcNewDevice(config.c_str());
    if (device) RealEmbree().rtcReleaseDevice(device);
    return !device;
  });
  return configs;
}

std::vector<SceneSource> AllScenes() {
  const char* const folder = std::getenv("DACRT_SCENES_DIR");
  std::vector<SceneSource> scenes = GeneratedScenes();
  for (SceneSource& source : MeshScenes(folder ? folder : DACRT_SCENES_DIR)) {
    scenes.push_back(std::move(source));
  }
  return scenes;
}

TestScene MakeScene(const std::string& name) {
  for (const SceneSource& source : AllScenes()) {
    if (source.name == name) return source.make();
  }
  throw std::invalid_argument("there is no scene " + name);
}

Devices::Devices(const std::string& drop_in_config, const std::vector<std::string>& real_configs)
    : drop_in_(DropIn(), drop_in_config) {
  for (const std::string& config : real_configs) {
    real_.push_back(std::make_unique<EmbreeDevice>(RealEmbree(), config));
  }
}

Contest::Contest(const Devices& devices, const TestScene& scene, Report& report)
    : scene_(scene),
      report_(report),
      real_([&] {
        std::vector<std::unique_ptr<EmbreeScene>> scenes;
        for (const auto& device : devices.real()) {
          scenes.push_back(std::make_unique<EmbreeScene>(*device, scene));
        }
        return scenes;
      }()),
      drop_in_(devices.drop_in(), scene),
      generator_(scene, *real_.front()),
      comparer_(scene) {}

bool Contest::BoundsAreEqual() const {
  const auto is_equal = [](float a, float b) { return a == b; };
  const RTCBounds a = real_.front()->Bounds();
  const RTCBounds b = drop_in_.Bounds();
  return is_equal(a.lower_x, b.lower_x) && is_equal(a.lower_y, b.lower_y) &&
         is_equal(a.lower_z, b.lower_z) && is_equal(a.upper_x, b.upper_x) &&
         is_equal(a.upper_y, b.upper_y) && is_equal(a.upper_z, b.upper_z);
}

void Contest::Compare(const Form& form, Query query, std::string_view kind,
                      std::vector<RTCRayHit> rays, std::size_t rays_per_call) {
  ReplaceAbsent(form, rays);
  const std::string context = scene_.name + ", " + std::string(kind) + ", " + Name(form);
  Tally& tally = report_.At(scene_.name, std::string(kind));
  tally.rays += rays.size();
  const std::vector<RTCRayHit> drop_in = TraceInPieces(drop_in_, form, query, rays, rays_per_call);
  Audit(context, query, tally, rays, drop_in);

  std::vector<RTCRayHit> accepted = rays;
  for (RTCRayHit& record : accepted) {
    if (RealLibraryAborts(record.ray)) record = kInactive;
  }
  for (const auto& real : real_) {
    CompareAnswers(context, form, query, tally, rays,
                   TraceInPieces(*real, form, query, accepted, rays_per_call), drop_in);
  }
}

void Contest::CompareAnswers(const std::string& context, const Form& form, Query query,
                             Tally& tally, std::span<const RTCRayHit> before,
                             std::span<const RTCRayHit> real, std::span<const RTCRayHit> drop_in) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    ++tally.comparisons;
    const Comparison comparison = RealLibraryAborts(before[i].ray)
                                      ? Comparison{Relation::kWithheld, Side::kDropIn, {}}
                                      : comparer_.Compare(query, before[i], real[i], drop_in[i],
                                                          CompanyOf(form, query, before, i));
    Count(context, query, tally, comparison, before[i], &real[i], drop_in[i]);
  }
}

void Contest::Count(const std::string& context, Query query, Tally& tally,
                    const Comparison& comparison, const RTCRayHit& before, const RTCRayHit* real,
                    const RTCRayHit& drop_in) {
  const Relation relation = comparison.relation;
  ++tally.relations[static_cast<int>(relation)];
  if (relation == Relation::kIdentical || relation == Relation::kRounding ||
      relation == Relation::kWithheld) {
    return;
  }
  ++tally.sides[static_cast<int>(relation)][static_cast<int>(comparison.right)];
  if (!report_.WantsExample(scene_.name, relation)) return;
  const std::string reason =
      relation == Relation::kUnexplained
          ? comparison.reason
          : std::string("exact arithmetic sides with ") + Name(comparison.right);
  report_.AddExample(scene_.name, relation,
                     std::string(Name(relation)) + ": " + context + ", " + reason + '\n' +
                         comparer_.Describe(query, before, real, drop_in));
}

void Contest::Audit(const std::string& context, Query query, Tally& tally,
                    std::span<const RTCRayHit> before, std::span<const RTCRayHit> drop_in) {
  const std::size_t step = before.size() / kAuditsPerBatch + 1;
  for (std::size_t i = 0; i < before.size(); ++i) {
    // To see that an inactive ray was left alone takes no reference.
    if (i % step != 0 && !FindsNothing(before[i].ray)) continue;
    ++tally.audits;
    const std::optional<std::string> fault = comparer_.FindFault(query, before[i], drop_in[i]);
    if (!fault) continue;
    Count(context, query, tally,
          {Relation::kUnexplained, Side::kNeither, "audited: the drop-in " + *fault}, before[i],
          nullptr, drop_in[i]);
  }
}

void Contest::CompareEverything(std::size_t rays, uint64_t seed,
                                const std::function<void(const std::string&)>& progress) {
  const std::vector<RayKind> kinds = AllRayKinds();
  const std::vector<Form> stream_forms = StreamForms();
  const std::vector<Form> packet_forms = PacketForms();
  const std::size_t rays_per_cell = rays / (2 * kinds.size());
  const std::size_t small_calls = SmallCallBudget(scene_.TriangleCount());
  Random turn(SeedFor(scene_.name, seed));  // whose turn it is

  for (const RayKind kind : kinds) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      progress(scene_.name + ", " + Name(kind) + ", " + Name(query));
      for (std::size_t done = 0; done < rays_per_cell;) {
        const std::size_t count = std::min(kLargestBatch, rays_per_cell - done);
        const Form& form = stream_forms[turn.Below(static_cast<uint32_t>(stream_forms.size()))];
        Compare(form, query, Name(kind), MakeRays(kind, count, turn.Next()));
        done += count;
      }
      const Form& packets = packet_forms[turn.Below(static_cast<uint32_t>(packet_forms.size()))];
      const Form& stream = stream_forms[turn.Below(static_cast<uint32_t>(stream_forms.size()))];
      const std::size_t stream_size = kSmallCalls[turn.Below(std::size(kSmallCalls))];
      for (const auto& [form, rays_per_call] :
           {std::pair(packets, std::size_t{packets.lanes}), std::pair(stream, stream_size)}) {
        // Not so many rays either that they outweigh the large streams.
        const std::size_t calls = std::min(small_calls, rays_per_cell / 8 / rays_per_call + 1);
        Compare(form, query, Name(kind), MakeRays(kind, calls * rays_per_call, turn.Next()),
                rays_per_call);
      }
    }
  }
}

}  // namespace dacrt::tests

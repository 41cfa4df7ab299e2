#include "embree_library.h"

#include <cstddef>

#include "timing.h"

namespace dacrt::bench {
namespace {

// A RayRecord is handed over as what it is a copy of.
static_assert(sizeof(RayRecord) == sizeof(RTCRayHit));
static_assert(alignof(RayRecord) == alignof(RTCRayHit));
static_assert(offsetof(RayRecord, tfar) == offsetof(RTCRayHit, ray.tfar));
static_assert(offsetof(RayRecord, id) == offsetof(RTCRayHit, ray.id));
static_assert(offsetof(RayRecord, ng) == offsetof(RTCRayHit, hit.Ng_x));
static_assert(offsetof(RayRecord, geometry_id) == offsetof(RTCRayHit, hit.geomID));
static_assert(offsetof(RayRecord, instance_id) == offsetof(RTCRayHit, hit.instID));

constexpr std::size_t kVertexBytes = 3 * sizeof(float);
constexpr std::size_t kTriangleBytes = 3 * sizeof(uint32_t);

}  // namespace

const char* Name(Call call) {
  switch (call) {
    case Call::kCoherentStream:
      return "coherent stream";
    case Call::kIncoherentStream:
      return "incoherent stream";
    case Call::kSingleRays:
      return "single rays";
  }
  return "";
}

EmbreeLibrary::EmbreeLibrary(const std::string& path, const std::string& config)
    : api_(std::make_unique<tests::EmbreeApi>(tests::LoadEmbree(path))),
      device_(std::make_unique<tests::EmbreeDevice>(*api_, config)) {}

CommittedScene::CommittedScene(const EmbreeLibrary& library, const BenchScene& scene,
                               RTCBuildQuality quality)
    : library_(library), scene_(library.api().rtcNewScene(library.device().handle())) {
  const tests::EmbreeApi& api = library.api();
  api.rtcSetSceneBuildQuality(scene_, quality);
  const RTCGeometry geometry =
      api.rtcNewGeometry(library.device().handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const scenes::Mesh& mesh = scene.mesh;
  api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                 mesh.positions.data(), 0, kVertexBytes, mesh.VertexCount());
  api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                 mesh.indices.data(), 0, kTriangleBytes, mesh.TriangleCount());
  const Stopwatch stopwatch;
  api.rtcCommitGeometry(geometry);
  api.rtcAttachGeometryByID(scene_, geometry, 0);
  api.rtcCommitScene(scene_);
  commit_seconds_ = stopwatch.Seconds();
  api.rtcReleaseGeometry(geometry);
  try {
    library.device().CheckErrors();
  } catch (...) {
    api.rtcReleaseScene(scene_);
    throw;
  }
}

CommittedScene::~CommittedScene() { library_.api().rtcReleaseScene(scene_); }

void CommittedScene::Trace(Query query, Call call, std::span<RayRecord> rays) const {
  const tests::EmbreeApi& api = library_.api();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (call == Call::kCoherentStream) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  const auto first = reinterpret_cast<RTCRayHit*>(rays.data());
  const auto count = static_cast<unsigned>(rays.size());

  if (call != Call::kSingleRays) {
    if (query == Query::kAny) {
      api.rtcOccluded1M(scene_, &context, &first->ray, count, sizeof(RTCRayHit));
    } else {
      api.rtcIntersect1M(scene_, &context, first, count, sizeof(RTCRayHit));
    }
  } else if (query == Query::kAny) {
    for (unsigned i = 0; i < count; ++i) api.rtcOccluded1(scene_, &context, &first[i].ray);
  } else {
    for (unsigned i = 0; i < count; ++i) api.rtcIntersect1(scene_, &context, &first[i]);
  }
}

}  // namespace dacrt::bench

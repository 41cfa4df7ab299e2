// Vertices and indices of any bytes: hits are those of the real library, or explained; they are the
// same in every form and whatever is kept; and where there is a hit, the ray is blocked.
#include <cstdlib>
#include <iostream>

#include "contest.h"
#include "input.h"

namespace dacrt::fuzz {
namespace {

using namespace dacrt::tests;

TestScene TakeScene(Input& input) {
  TestScene scene{"fuzz", {}, {}};
  const unsigned int meshes = 1 + input.Below(3);
  for (unsigned int m = 0; m < meshes; ++m) {
    TestMesh mesh;
    mesh.geometry_id = m;
    mesh.mask = input.Below(4) ? UINT32_MAX : input.Take<uint8_t>();
    const unsigned int vertices = input.Below(60), triangles = input.Below(200);
    const bool of_any_bits = input.Below(3) == 0;
    const auto coordinate = [&] {
      return of_any_bits ? input.Take<float>() : static_cast<float>(input.Take<int8_t>()) / 16;
    };
    for (unsigned int i = 0; i < vertices; ++i) {
      const float x = coordinate(), y = coordinate();
      mesh.positions.push_back({x, y, coordinate()});
    }
    for (unsigned int i = 0; i < triangles; ++i) {
      Triangle triangle;
      for (uint32_t& vertex : triangle.vertex) {
        vertex = input.Take<uint8_t>();
        // Some beyond the vertices: those triangles are left out.
        if (vertex < 240 && vertices > 0) vertex %= vertices;
      }
      mesh.triangles.push_back(triangle);
    }
    scene.meshes.push_back(mesh);
  }
  return scene;
}

std::vector<RTCRayHit> TakeRays(Input& input) {
  std::vector<RTCRayHit> rays(64);
  for (RTCRayHit& record : rays) {
    const auto coordinate = [&] { return static_cast<float>(input.Take<int8_t>()) / 16; };
    record = {};
    record.ray.org_x = coordinate();
    record.ray.org_y = coordinate();
    record.ray.org_z = -16;
    record.ray.dir_x = coordinate() / 16;
    record.ray.dir_y = coordinate() / 16;
    record.ray.dir_z = 1;
    record.ray.tfar = 1000;
    record.ray.mask = UINT32_MAX;
    record.hit.geomID = record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
  return rays;
}

void Fail(const char* what) {
  std::cerr << what << '\n';
  std::abort();
}

void Run(Input input) {
  static const Devices devices("threads=1", {"threads=1,isa=avx2"});
  static const EmbreeDevice keeps_nothing(DropIn(), "threads=1,dacrt_budget=0");
  static const EmbreeDevice keeps_little(DropIn(), "threads=1,dacrt_budget=1");
  const TestScene scene = TakeScene(input);
  const std::vector<RTCRayHit> rays = TakeRays(input);
  Report report;
  Contest contest(devices, scene, report);
  const Form stream{Form::Call::kRecords};
  contest.Compare(stream, Query::kClosest, "fuzz", rays);
  contest.Compare(stream, Query::kAny, "fuzz", rays);
  if (report.Total().Count(Relation::kUnexplained) > 0) {
    report.PrintExamples(std::cerr);
    std::abort();
  }
  const auto same = [](const std::vector<RTCRayHit>& a, const std::vector<RTCRayHit>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(RTCRayHit)) == 0;
  };
  const auto hits = Trace(contest.drop_in(), stream, Query::kClosest, rays);
  const auto blocked = Trace(contest.drop_in(), stream, Query::kAny, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if ((hits[i].hit.geomID != RTC_INVALID_GEOMETRY_ID) != (blocked[i].ray.tfar < 0)) {
      Fail("a ray has a hit and is not blocked, or the other way round");
    }
  }
  for (const Form& form : {Form{Form::Call::kRecord}, Form{Form::Call::kPacket, true, 16}}) {
    if (!same(Trace(contest.drop_in(), form, Query::kClosest, rays), hits)) {
      Fail("the form of the call changes hits");
    }
  }
  for (const EmbreeDevice* const device : {&keeps_nothing, &keeps_little}) {
    const EmbreeScene other(*device, scene);
    if (!same(Trace(other, stream, Query::kClosest, rays), hits)) Fail("the budget changes hits");
  }
}

}  // namespace
}  // namespace dacrt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, std::size_t count) {
  dacrt::fuzz::Run(dacrt::fuzz::Input(bytes, count));
  return 0;
}

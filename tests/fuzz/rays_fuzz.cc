// Rays of any bits among ordinary ones, in every form. The real library says what they hit, where
// it says anything: it ends the process over rays that are no numbers or run backwards, and those
// are to miss, or to be right by exact arithmetic, and to leave their neighbours as they are.
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <random>

#include "contest.h"
#include "input.h"

namespace dacrt::fuzz {
namespace {

using namespace dacrt::tests;

/// Triangles of many sizes in the unit cube, some of them needles or without area.
TestScene Scene() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> anywhere(0, 1);
  TestMesh mesh;
  for (uint32_t i = 0; i < 300; ++i) {
    const float size = i % 3 == 0 ? 1.0f : 0.1f;
    const Float3 at{anywhere(random), anywhere(random), anywhere(random)};
    for (int corner = 0; corner < 3; ++corner) {
      const float thin = i % 7 == 0 && corner == 2 ? 0.0f : size;
      mesh.positions.push_back({at.x + thin * anywhere(random), at.y + thin * anywhere(random),
                                at.z + size * anywhere(random)});
    }
    mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
  }
  return {"fuzz", {mesh}, {}};
}

RTCRayHit Ordinary(unsigned int seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> anywhere(0, 1);
  RTCRayHit record{};
  record.ray.org_x = anywhere(random);
  record.ray.org_y = anywhere(random);
  record.ray.org_z = -1;
  record.ray.dir_x = 0.2f * anywhere(random);
  record.ray.dir_z = 1;
  record.ray.tfar = 10;
  record.ray.mask = UINT32_MAX;
  return record;
}

void Run(Input input) {
  static const TestScene scene = Scene();
  static const Devices devices("threads=1", {"threads=1,isa=avx2"});
  static Report report;
  static Contest contest(devices, scene, report);
  static const std::vector<Form> forms = [] {
    std::vector<Form> all = StreamForms();
    for (const Form& form : PacketForms()) all.push_back(form);
    return all;
  }();
  const Form& form = forms[input.Below(static_cast<unsigned int>(forms.size()))];
  const Query query = input.Below(2) ? Query::kClosest : Query::kAny;
  const unsigned int hostile_share = 1 + input.Below(8);
  std::vector<RTCRayHit> rays;
  for (unsigned int i = 0; i < 300 && (!input.IsEmpty() || i % 16 != 0); ++i) {
    RTCRayHit record = Ordinary(i);
    if (i % hostile_share == 0) {
      // All of it, or one word.
      if (input.Below(2)) {
        record.ray = input.Take<RTCRay>();
      } else {
        const uint32_t word = input.Take<uint32_t>();
        std::memcpy(reinterpret_cast<char*>(&record.ray) + 4 * input.Below(9), &word, 4);
      }
    }
    record.hit.geomID = record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rays.push_back(record);
  }
  const std::size_t lanes = form.call == Form::Call::kPacket ? form.lanes : SIZE_MAX;
  while (form.lanes > 1 && rays.size() % form.lanes != 0) rays.push_back(Ordinary(1));
  contest.Compare(form, query, "fuzz", rays, lanes);
  if (report.Total().Count(Relation::kUnexplained) == 0) return;
  report.PrintExamples(std::cerr);
  std::abort();
}

}  // namespace
}  // namespace dacrt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, std::size_t count) {
  dacrt::fuzz::Run(dacrt::fuzz::Input(bytes, count));
  return 0;
}

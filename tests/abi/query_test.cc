// What a query call reads and writes, in every form of it, on both libraries. Whether hits are
// right is the conformance tests' matter.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

constexpr int kRays = 16;

/// Ray i hits the triangle of the scene where i is even, and is inactive where i is 6.
RTCRayHit RayNumber(int i) {
  RTCRayHit record = RayAt(i % 2 == 0 ? 0.01f * static_cast<float>(i) : 5);
  record.ray.id = 100 + i;
  record.ray.flags = 200 + i;
  record.ray.time = 0;
  if (i == 6) record.ray.tnear = 2000;
  return record;
}

bool IsHit(int i) { return i % 2 == 0 && i != 6; }

using Batch = std::array<RTCRayHit, kRays>;

Batch MakeBatch() {
  Batch batch;
  for (int i = 0; i < kRays; ++i) batch[i] = RayNumber(i);
  return batch;
}

/// Value `field` of ray `lane` in a packet of `lanes` rays.
unsigned int& PacketValue(void* packet, int lanes, int lane, int field) {
  return static_cast<unsigned int*>(packet)[field * lanes + lane];
}

constexpr int kFields = sizeof(RTCRayHit) / 4;

/// The rays of `batch` from `first` on as a packet, with or without room for hits.
std::vector<unsigned int> ToPacket(Batch& batch, int first, int lanes, int fields) {
  std::vector<unsigned int> packet(fields * lanes);
  for (int lane = 0; lane < lanes; ++lane) {
    for (int field = 0; field < fields; ++field) {
      PacketValue(packet.data(), lanes, lane, field) =
          PacketValue(&batch[first + lane], 1, 0, field);
    }
  }
  return packet;
}

void FromPacket(const void* packet, Batch& batch, int first, int lanes, int fields) {
  for (int lane = 0; lane < lanes; ++lane) {
    for (int field = 0; field < fields; ++field) {
      PacketValue(&batch[first + lane], 1, 0, field) =
          PacketValue(const_cast<void*>(packet), lanes, lane, field);
    }
  }
}

/// One form of a call: sends the rays of a batch, all valid, through it.
struct Form {
  const char* name;
  void (*intersect)(const Api&, RTCScene, RTCIntersectContext*, Batch&);
  void (*occluded)(const Api&, RTCScene, RTCIntersectContext*, Batch&);
};

void PrintTo(const Form& form, std::ostream* out) { *out << form.name; }

/// Sends a batch through packets of `kLanes`, each aligned as the API wants it.
template <int kLanes, int kPacketFields, class Call>
void ThroughPackets(Batch& batch, Call call) {
  alignas(64) unsigned int packet[kPacketFields * kLanes];
  alignas(64) int valid[kLanes];
  for (int& flag : valid) flag = -1;
  for (int first = 0; first < kRays; first += kLanes) {
    const auto values = ToPacket(batch, first, kLanes, kPacketFields);
    std::memcpy(packet, values.data(), sizeof packet);
    call(valid, packet);
    FromPacket(packet, batch, first, kLanes, kPacketFields);
  }
}

constexpr int kRayFields = sizeof(RTCRay) / 4;
constexpr int kNmLanes = 4;

const Form kForms[] = {
    {"1",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       for (RTCRayHit& record : batch) api.rtcIntersect1(scene, context, &record);
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       for (RTCRayHit& record : batch) api.rtcOccluded1(scene, context, &record.ray);
     }},
    {"4",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       ThroughPackets<4, kFields>(batch, [&](const int* valid, void* packet) {
         api.rtcIntersect4(valid, scene, context, static_cast<RTCRayHit4*>(packet));
       });
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       ThroughPackets<4, kRayFields>(batch, [&](const int* valid, void* packet) {
         api.rtcOccluded4(valid, scene, context, static_cast<RTCRay4*>(packet));
       });
     }},
    {"8",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       ThroughPackets<8, kFields>(batch, [&](const int* valid, void* packet) {
         api.rtcIntersect8(valid, scene, context, static_cast<RTCRayHit8*>(packet));
       });
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       ThroughPackets<8, kRayFields>(batch, [&](const int* valid, void* packet) {
         api.rtcOccluded8(valid, scene, context, static_cast<RTCRay8*>(packet));
       });
     }},
    {"16",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       ThroughPackets<16, kFields>(batch, [&](const int* valid, void* packet) {
         api.rtcIntersect16(valid, scene, context, static_cast<RTCRayHit16*>(packet));
       });
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       ThroughPackets<16, kRayFields>(batch, [&](const int* valid, void* packet) {
         api.rtcOccluded16(valid, scene, context, static_cast<RTCRay16*>(packet));
       });
     }},
    {"1M",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       api.rtcIntersect1M(scene, context, batch.data(), kRays, sizeof(RTCRayHit));
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       api.rtcOccluded1M(scene, context, &batch[0].ray, kRays, sizeof(RTCRayHit));
     }},
    {"1Mp",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       RTCRayHit* pointers[kRays];
       for (int i = 0; i < kRays; ++i) pointers[i] = &batch[kRays - 1 - i];
       api.rtcIntersect1Mp(scene, context, pointers, kRays);
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       RTCRay* pointers[kRays];
       for (int i = 0; i < kRays; ++i) pointers[i] = &batch[kRays - 1 - i].ray;
       api.rtcOccluded1Mp(scene, context, pointers, kRays);
     }},
    {"NM",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       alignas(64) unsigned int packets[kRays / kNmLanes][kFields * kNmLanes + 16];
       for (int p = 0; p < kRays / kNmLanes; ++p) {
         const auto values = ToPacket(batch, p * kNmLanes, kNmLanes, kFields);
         std::copy(values.begin(), values.end(), packets[p]);
       }
       api.rtcIntersectNM(scene, context, reinterpret_cast<RTCRayHitN*>(packets), kNmLanes,
                          kRays / kNmLanes, sizeof packets[0]);
       for (int p = 0; p < kRays / kNmLanes; ++p) {
         FromPacket(packets[p], batch, p * kNmLanes, kNmLanes, kFields);
       }
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       alignas(64) unsigned int packets[kRays / kNmLanes][kRayFields * kNmLanes + 16];
       for (int p = 0; p < kRays / kNmLanes; ++p) {
         const auto values = ToPacket(batch, p * kNmLanes, kNmLanes, kRayFields);
         std::copy(values.begin(), values.end(), packets[p]);
       }
       api.rtcOccludedNM(scene, context, reinterpret_cast<RTCRayN*>(packets), kNmLanes,
                         kRays / kNmLanes, sizeof packets[0]);
       for (int p = 0; p < kRays / kNmLanes; ++p) {
         FromPacket(packets[p], batch, p * kNmLanes, kNmLanes, kRayFields);
       }
     }},
    {"Np",
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       auto values = ToPacket(batch, 0, kRays, kFields);
       // RTCRayHitNp is as many pointers, in the order of RTCRayHit.
       std::array<unsigned int*, kFields> pointers;
       for (int field = 0; field < kFields; ++field) pointers[field] = &values[field * kRays];
       RTCRayHitNp rays;
       static_assert(sizeof rays == sizeof pointers);
       std::memcpy(&rays, pointers.data(), sizeof rays);
       api.rtcIntersectNp(scene, context, &rays, kRays);
       FromPacket(values.data(), batch, 0, kRays, kFields);
     },
     [](const Api& api, RTCScene scene, RTCIntersectContext* context, Batch& batch) {
       auto values = ToPacket(batch, 0, kRays, kRayFields);
       std::array<unsigned int*, kRayFields> pointers;
       for (int field = 0; field < kRayFields; ++field) pointers[field] = &values[field * kRays];
       RTCRayNp rays;
       static_assert(sizeof rays == sizeof pointers);
       std::memcpy(&rays, pointers.data(), sizeof rays);
       api.rtcOccludedNp(scene, context, &rays, kRays);
       FromPacket(values.data(), batch, 0, kRays, kRayFields);
     }},
};

class QueryForm : public testing::TestWithParam<std::tuple<const Api& (*)(), Form>> {
 protected:
  QueryForm() : s(std::get<0>(GetParam())()), form(std::get<1>(GetParam())) {
    rtcInitIntersectContext(&context);
    scene = s.NewScene();
    s.api.rtcAttachGeometryByID(scene, s.Triangle(), 3);
    s.api.rtcCommitScene(scene);
  }

  Session s;
  const Form form;
  RTCIntersectContext context;
  RTCScene scene;
};

INSTANTIATE_TEST_SUITE_P(
    , QueryForm, testing::Combine(testing::Values(&RealEmbree, &DropIn), testing::ValuesIn(kForms)),
    [](const auto& info) {
      return std::get<0>(info.param)().name + "_" + std::get<1>(info.param).name;
    });

TEST_P(QueryForm, ClosestHitWritesHitsAndNothingElse) {
  context.instID[0] = 5;
  Batch batch = MakeBatch();
  form.intersect(s.api, scene, &context, batch);
  for (int i = 0; i < kRays; ++i) {
    RTCRayHit expected = RayNumber(i);
    if (IsHit(i)) {
      expected.ray.tfar = 10;
      expected.hit = {0, 0, 1, expected.ray.org_x, 0.2f, 0, 3, {5}};
      EXPECT_NEAR(batch[i].hit.u, expected.hit.u, 1e-5);
      EXPECT_NEAR(batch[i].hit.v, expected.hit.v, 1e-5);
      EXPECT_NEAR(batch[i].ray.tfar, 10, 1e-4);
      expected.hit.u = batch[i].hit.u;
      expected.hit.v = batch[i].hit.v;
      expected.ray.tfar = batch[i].ray.tfar;
      // -0 where the real library has it
      expected.hit.Ng_x = std::copysign(0.0f, batch[i].hit.Ng_x);
      expected.hit.Ng_y = std::copysign(0.0f, batch[i].hit.Ng_y);
    }
    EXPECT_EQ(std::memcmp(&batch[i], &expected, sizeof expected), 0) << "ray " << i;
  }
}

TEST_P(QueryForm, AnyHitWritesTfarAndNothingElse) {
  Batch batch = MakeBatch();
  form.occluded(s.api, scene, &context, batch);
  for (int i = 0; i < kRays; ++i) {
    RTCRayHit expected = RayNumber(i);
    if (IsHit(i)) expected.ray.tfar = -INFINITY;
    EXPECT_EQ(std::memcmp(&batch[i], &expected, sizeof expected), 0) << "ray " << i;
  }
}

TEST_P(QueryForm, UncommittedSceneTouchesNoRay) {
  const RTCScene uncommitted = s.NewScene();
  Batch batch = MakeBatch();
  form.intersect(s.api, uncommitted, &context, batch);
  form.occluded(s.api, uncommitted, &context, batch);
  const Batch before = MakeBatch();
  EXPECT_EQ(std::memcmp(&batch, &before, sizeof batch), 0);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION);
}

TEST_P(QueryForm, EmptySceneTouchesNoRay) {
  const RTCScene empty = s.NewScene();
  s.api.rtcCommitScene(empty);
  Batch batch = MakeBatch();
  form.intersect(s.api, empty, &context, batch);
  form.occluded(s.api, empty, &context, batch);
  const Batch before = MakeBatch();
  EXPECT_EQ(std::memcmp(&batch, &before, sizeof batch), 0);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

class Packets : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Packets);

/// Sends rays that all hit, of which lane 1 is not valid and lane 2 has a flag that is neither 0
/// nor -1, and gives each lane's distance.
template <int kLanes, class Call>
std::vector<float> Distances(Call call) {
  alignas(64) float packet[kFields * kLanes];
  alignas(64) int valid[kLanes];
  Batch batch;
  batch.fill(RayAt(0.2f));
  const auto values = ToPacket(batch, 0, kLanes, kFields);
  std::memcpy(packet, values.data(), sizeof packet);
  for (int& flag : valid) flag = -1;
  valid[1] = 0;
  valid[2] = 1;
  call(valid, packet);
  const float* const tfar = packet + kLanes * offsetof(RTCRay, tfar) / 4;
  return {tfar, tfar + kLanes};
}

TEST_P(Packets, OnlyLanesWithMinusOneTakePart) {
  Session s(GetParam()());
  const RTCScene scene = s.SceneOf(s.Triangle());
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const auto expect = [](const std::vector<float>& distances, float hit) {
    for (std::size_t lane = 0; lane < distances.size(); ++lane) {
      EXPECT_EQ(distances[lane], lane == 1 || lane == 2 ? 1000 : hit) << "lane " << lane;
    }
  };
  expect(Distances<4>([&](int* valid, void* packet) {
           s.api.rtcIntersect4(valid, scene, &context, static_cast<RTCRayHit4*>(packet));
         }),
         10);
  expect(Distances<8>([&](int* valid, void* packet) {
           s.api.rtcIntersect8(valid, scene, &context, static_cast<RTCRayHit8*>(packet));
         }),
         10);
  expect(Distances<16>([&](int* valid, void* packet) {
           s.api.rtcIntersect16(valid, scene, &context, static_cast<RTCRayHit16*>(packet));
         }),
         10);
  expect(Distances<4>([&](int* valid, void* packet) {
           s.api.rtcOccluded4(valid, scene, &context, static_cast<RTCRay4*>(packet));
         }),
         -INFINITY);
  expect(Distances<8>([&](int* valid, void* packet) {
           s.api.rtcOccluded8(valid, scene, &context, static_cast<RTCRay8*>(packet));
         }),
         -INFINITY);
  expect(Distances<16>([&](int* valid, void* packet) {
           s.api.rtcOccluded16(valid, scene, &context, static_cast<RTCRay16*>(packet));
         }),
         -INFINITY);
}

class Pointers : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Pointers);

// Real programs pass null for what they have no use for.
TEST_P(Pointers, MayBeNullForOptionalComponents) {
  Session s(GetParam()());
  const RTCScene scene = s.SceneOf(s.Triangle());
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  float org_x[2] = {0.2f, 5}, org_y[2] = {0.2f, 0.2f}, org_z[2] = {-10, -10};
  float dir_xy[2] = {0, 0}, dir_z[2] = {1, 1}, tfar[2] = {100, 100};
  float u[2] = {7, 7}, v[2] = {7, 7};
  unsigned int prim_id[2] = {7, 7}, geom_id[2] = {7, 7};
  RTCRayHitNp rays{};
  rays.ray.org_x = org_x;
  rays.ray.org_y = org_y;
  rays.ray.org_z = org_z;
  rays.ray.dir_x = rays.ray.dir_y = dir_xy;
  rays.ray.dir_z = dir_z;
  rays.ray.tfar = tfar;
  rays.hit.u = u;
  rays.hit.v = v;
  rays.hit.primID = prim_id;
  rays.hit.geomID = geom_id;
  s.api.rtcIntersectNp(scene, &context, &rays, 2);
  EXPECT_NEAR(tfar[0], 10, 1e-4);
  EXPECT_NEAR(u[0], 0.2f, 1e-5);
  EXPECT_EQ(geom_id[0], 0u);
  EXPECT_EQ(prim_id[0], 0u);
  EXPECT_EQ(tfar[1], 100);
  EXPECT_EQ(geom_id[1], 7u);

  tfar[0] = 100;
  s.api.rtcOccludedNp(scene, &context, &rays.ray, 2);
  EXPECT_EQ(tfar[0], -INFINITY);
  EXPECT_EQ(tfar[1], 100);
}

}  // namespace
}  // namespace dacrt::tests

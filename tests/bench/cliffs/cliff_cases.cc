#include "cliff_cases.h"

#include <cmath>

#include "random.h"

namespace dacrt::bench {
namespace {

using tests::Float3;
using tests::Random;

void AddTriangle(CliffContent& content, Float3 a, Float3 b, Float3 c) {
  const auto first = static_cast<uint32_t>(content.vertices.size());
  content.vertices.insert(content.vertices.end(), {a, b, c});
  content.triangles.push_back({{first, first + 1, first + 2}});
}

/// Hills over the unit square: two triangles in each of side * side fields.
CliffContent Hills(RTCSceneFlags flags = RTC_SCENE_FLAG_NONE, uint32_t side = 300) {
  CliffContent content;
  content.flags = flags;
  for (uint32_t y = 0; y <= side; ++y) {
    for (uint32_t x = 0; x <= side; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(side);
      const float v = static_cast<float>(y) / static_cast<float>(side);
      content.vertices.push_back({u, v, 0.1f * std::sin(20 * u) * std::cos(17 * v)});
    }
  }
  for (uint32_t y = 0; y < side; ++y) {
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t a = y * (side + 1) + x, b = a + side + 1;
      content.triangles.push_back({{a, a + 1, b}});
      content.triangles.push_back({{a + 1, b + 1, b}});
    }
  }
  return content;
}

CliffContent FilteredHills(RTCSceneFlags flags = RTC_SCENE_FLAG_NONE) {
  CliffContent content = Hills(flags);
  content.has_filter = true;
  return content;
}

CliffContent InstanceOfFilteredHills() {
  CliffContent content = FilteredHills();
  content.instances.push_back({0, 0, 0});
  return content;
}

template <unsigned int kSteps>
CliffContent MovingHills() {
  CliffContent content = Hills();
  content.steps = kSteps;
  return content;
}

CliffContent Instances(RTCSceneFlags flags = RTC_SCENE_FLAG_NONE) {
  CliffContent content = Hills(flags, 4);
  for (Float3& vertex : content.vertices) vertex = 0.02f * vertex;
  Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    content.instances.push_back({random.Uniform(), random.Uniform(), random.Uniform()});
  }
  return content;
}

/// As long as the scene, a thousandth as wide, in all directions.
CliffContent Needles() {
  CliffContent content;
  Random random(2);
  const auto anywhere = [&] {
    return Float3{random.Uniform(), random.Uniform(), random.Uniform()};
  };
  for (int i = 0; i < 20'000; ++i) {
    const Float3 a = anywhere();
    AddTriangle(content, a, anywhere(), a + 0.001f * anywhere());
  }
  return content;
}

CliffContent ClusterBesideHuge() {
  CliffContent content = Hills();
  for (Float3& vertex : content.vertices) vertex = 1e-4f * vertex;
  AddTriangle(content, {-1, -1, 0.5f}, {2, -1, 0.5f}, {0.5f, 3, 0.5f});
  return content;
}

CliffContent OnALine() {
  CliffContent content;
  constexpr int kCount = 1'000'000;
  for (int i = 0; i < kCount; ++i) {
    const float x = static_cast<float>(i) / kCount;
    AddTriangle(content, {x, 0, 0}, {x, 0.001f, 0}, {x, 0, 0.001f});
  }
  return content;
}

CliffContent AroundOneCentre() {
  CliffContent content;
  for (int i = 1; i <= 20'000; ++i) {
    const float r = 0.5f * static_cast<float>(i) / 20'000;
    // Centroid and centre of the box are the same for all.
    AddTriangle(content, {0.5f - r, 0.5f - r, 0.5f}, {0.5f + r, 0.5f, 0.5f - r},
                {0.5f, 0.5f + r, 0.5f + r});
  }
  return content;
}

/// Four triangles for each of 400 * 400 spikes, as narrow as pixels.
CliffContent Spikes() {
  CliffContent content;
  Random random(3);
  constexpr int kSide = 400;
  for (int i = 0; i < kSide * kSide; ++i) {
    const float x = static_cast<float>(i % kSide) / kSide;
    const float y = static_cast<float>(i / kSide) / kSide;
    constexpr float kStep = 1.0f / kSide;
    const Float3 foot[4] = {
        {x, y, 0}, {x + kStep, y, 0}, {x + kStep, y + kStep, 0}, {x, y + kStep, 0}};
    const Float3 top = {x + kStep / 2, y + kStep / 2, random.Uniform(0, kSpikeHeight)};
    for (int side = 0; side < 4; ++side)
      AddTriangle(content, foot[side], foot[(side + 1) % 4], top);
  }
  return content;
}

CliffContent Coincident() {
  CliffContent content;
  for (int i = 0; i < 2'000; ++i) AddTriangle(content, {0, 0, 0.5f}, {1, 0, 0.5f}, {0, 1, 0.5f});
  return content;
}

void Accept(const RTCFilterFunctionNArguments*) {}

}  // namespace

const std::vector<CliffCase>& CliffCases() {
  static const std::vector<CliffCase> cases = {
      {"hills", "180,000 triangles: no cliff, for comparison", 0, [] { return Hills(); }},
      {"robust", "the hills in a ROBUST scene", 0, [] { return Hills(RTC_SCENE_FLAG_ROBUST); }},
      {"filter", "the hills with a filter function that accepts", 0,
       [] { return FilteredHills(); }},
      {"robust-filter", "the same in a ROBUST scene", 0,
       [] { return FilteredHills(RTC_SCENE_FLAG_ROBUST); }},
      {"instance-filter", "one instance of them", 0, InstanceOfFilteredHills},
      {"compact", "the hills in a COMPACT scene", 0, [] { return Hills(RTC_SCENE_FLAG_COMPACT); }},
      {"budget-5", "the hills with 5 bytes a triangle", 5, [] { return Hills(); }},
      {"budget-4.3", "with 4.3", 4.3, [] { return Hills(); }},
      {"budget-4.1", "with 4.1", 4.1, [] { return Hills(); }},
      {"moving-2", "the hills at 2 time steps", 0, MovingHills<2>},
      {"moving-3", "at 3", 0, MovingHills<3>},
      {"moving-9", "at 9", 0, MovingHills<9>},
      {"moving-17", "at 17", 0, MovingHills<17>},
      {"instances", "100,000 instances of 32 triangles, crowded", 0, [] { return Instances(); }},
      {"compact-instances", "the same of a COMPACT scene", 0,
       [] { return Instances(RTC_SCENE_FLAG_COMPACT); }},
      {"needles", "20,000 triangles as long as the scene", 0, Needles},
      {"cluster", "the hills, 10,000 times smaller, beside one huge triangle", 0,
       ClusterBesideHuge},
      {"line", "a million small triangles in a row", 0, OnALine},
      {"one-centre", "20,000 triangles around one centre", 0, AroundOneCentre},
      {"coincident", "2,000 times the same triangle", 0, Coincident},
      {"spikes", "640,000 triangles as narrow as pixels, rays side by side to a lamp", 0, Spikes,
       true},
  };
  return cases;
}

CliffScene::CliffScene(const tests::EmbreeDevice& device, const CliffContent& content)
    : device_(device), inner_(device.api().rtcNewScene(device.handle())), top_(inner_) {
  const tests::EmbreeApi& api = device.api();
  const RTCGeometry mesh = api.rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  api.rtcSetGeometryTimeStepCount(mesh, content.steps);
  // Copied: Embree reads beyond the last vertex.
  for (unsigned int step = 0; step < content.steps; ++step) {
    auto* const vertices = static_cast<Float3*>(api.rtcSetNewGeometryBuffer(
        mesh, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, 12, content.vertices.size()));
    device.CheckErrors();
    const Float3 higher{0, 0, 0.02f * static_cast<float>(step) / static_cast<float>(content.steps)};
    std::transform(content.vertices.begin(), content.vertices.end(), vertices,
                   [&](const Float3& vertex) { return vertex + higher; });
  }
  auto* const triangles = static_cast<tests::Triangle*>(api.rtcSetNewGeometryBuffer(
      mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, content.triangles.size()));
  device.CheckErrors();
  std::copy(content.triangles.begin(), content.triangles.end(), triangles);
  if (content.has_filter) {
    api.rtcSetGeometryIntersectFilterFunction(mesh, Accept);
    api.rtcSetGeometryOccludedFilterFunction(mesh, Accept);
  }
  api.rtcCommitGeometry(mesh);
  api.rtcAttachGeometryByID(inner_, mesh, 0);
  api.rtcReleaseGeometry(mesh);
  api.rtcSetSceneFlags(inner_, content.flags);
  api.rtcCommitScene(inner_);
  if (!content.instances.empty()) {
    top_ = api.rtcNewScene(device.handle());
    for (unsigned int i = 0; i < content.instances.size(); ++i) {
      const Float3 at = content.instances[i];
      const float matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, at.x, at.y, at.z};
      const RTCGeometry instance = api.rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_INSTANCE);
      api.rtcSetGeometryInstancedScene(instance, inner_);
      api.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
      api.rtcCommitGeometry(instance);
      api.rtcAttachGeometryByID(top_, instance, i);
      api.rtcReleaseGeometry(instance);
    }
    api.rtcCommitScene(top_);
  }
  device.CheckErrors();
}

CliffScene::~CliffScene() {
  if (top_ != inner_) api().rtcReleaseScene(top_);
  api().rtcReleaseScene(inner_);
}

}  // namespace dacrt::bench

#include "moving_content.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "geometry_kind.h"
#include "mesh_cut.h"
#include "turn.h"
#include "wave.h"

namespace dacrt::bench {
namespace {

using Of = ContentChange::Of;

// Turns of the wave from one frame to the next: a vertex moves by some thousandths of the scene.
constexpr float kWaveStep = 0.03f;

class WavingMesh : public MovingContent {
 public:
  explicit WavingMesh(const BenchScene& scene)
      : MovingContent({Of::kVertices, 0, 1}), wave_(scene.mesh) {
    content_.floats.push_back(scene.mesh.positions);
    content_.geometries.push_back(WholeMesh(scene.mesh));
    content_.geometries.front().vertices = {content_.floats.front().data()};
  }

 private:
  void Show(int frame) override { wave_.Apply(frame * kWaveStep, 0, content_.floats.front()); }

  const Wave wave_;
};

class WavingPart : public MovingContent {
 public:
  explicit WavingPart(const BenchScene& scene)
      : MovingContent({Of::kVertices, 0, 1}), wave_(scene.mesh) {
    constexpr std::size_t kParts = 1000;
    CutIntoParts(scene.mesh, kParts, content_);
    change_.first = content_.geometries.size() / 2;
    // Its vertices become its own: the others' stand still.
    GeometryContent& part = content_.geometries[change_.first];
    const float* const positions = part.vertices.front();
    first_vertex_ = (positions - scene.mesh.positions.data()) / 3;
    content_.floats.emplace_back(positions, positions + 3 * part.vertex_count + 1);
    part.vertices = {content_.floats.back().data()};
  }

 private:
  void Show(int frame) override {
    wave_.Apply(frame * kWaveStep, first_vertex_, content_.floats.back());
  }

  const Wave wave_;
  std::size_t first_vertex_;
};

class TurningInstances : public MovingContent {
 public:
  explicit TurningInstances(const BenchScene& scene)
      : MovingContent({Of::kTransform, 0, 0}), middle_(Bounds(scene.mesh).center()) {
    content_ = FindGeometryKind("instances-1000")->make(scene);
    change_.count = content_.geometries.size();
  }

 private:
  // Each to and fro by a degree, and no two at the same time.
  void Show(int frame) override {
    constexpr float kTurn = 2 * std::numbers::pi_v<float>;
    const auto count = static_cast<float>(content_.geometries.size());
    for (std::size_t i = 0; i < content_.geometries.size(); ++i) {
      const float degrees = std::sin(kTurn * (frame * kWaveStep + i / count));
      content_.geometries[i].transform = TurnAbout(middle_, degrees);
    }
  }

  const Imath::V3f middle_;
};

class GrowingMesh : public MovingContent {
 public:
  explicit GrowingMesh(const BenchScene& scene) : MovingContent({Of::kPrimitives, 0, 1}) {
    for (int copy = 0; copy < kCopies; ++copy) content_.numbers.push_back(scene.mesh.indices);
    content_.geometries.push_back(WholeMesh(scene.mesh));
    Show(0);
  }

 private:
  // From four fifths of the triangles to all of them, by a fiftieth a frame, and again.
  void Show(int frame) override {
    constexpr std::size_t kSteps = 10, kParts = 50;
    const std::vector<uint32_t>& indices = content_.numbers[frame % kCopies];
    GeometryContent& mesh = content_.geometries.front();
    mesh.primitives = indices.data();
    mesh.primitive_count = indices.size() / 3 * (kParts - kSteps + frame % (kSteps + 1)) / kParts;
  }

  static constexpr int kCopies = 2;
};

class ReplacedMesh : public MovingContent {
 public:
  explicit ReplacedMesh(const BenchScene& scene)
      : MovingContent({Of::kAll, 0, 1}), wave_(scene.mesh) {
    for (int copy = 0; copy < kCopies; ++copy) {
      content_.floats.push_back(scene.mesh.positions);
      content_.numbers.push_back(scene.mesh.indices);
    }
    content_.geometries.push_back(WholeMesh(scene.mesh));
    Show(0);
  }

 private:
  void Show(int frame) override {
    std::vector<float>& positions = content_.floats[frame % kCopies];
    wave_.Apply(frame * kWaveStep, 0, positions);
    GeometryContent& mesh = content_.geometries.front();
    mesh.vertices = {positions.data()};
    mesh.primitives = content_.numbers[frame % kCopies].data();
  }

  static constexpr int kCopies = 2;
  const Wave wave_;
};

template <class Content>
std::unique_ptr<MovingContent> Make(const BenchScene& scene) {
  return std::make_unique<Content>(scene);
}

constexpr ChangeKind kKinds[] = {
    {"wave", true, Make<WavingMesh>},
    {"one-of-1000", true, Make<WavingPart>},
    {"instances", false, Make<TurningInstances>},
    {"growing", false, Make<GrowingMesh>},
    {"replaced", false, Make<ReplacedMesh>},
};

}  // namespace

std::span<const ChangeKind> ChangeKinds() { return kKinds; }

const ChangeKind* FindChangeKind(const std::string& name) {
  const auto found = std::ranges::find(kKinds, name, &ChangeKind::name);
  return found == std::end(kKinds) ? nullptr : found;
}

}  // namespace dacrt::bench

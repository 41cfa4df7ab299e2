#include "generator.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "random.h"
#include "rays.h"

namespace dacrt::tests {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

template <typename T, std::size_t kCount>
const T& Pick(Random& random, const T (&choices)[kCount]) {
  return choices[random.Below(kCount)];
}

/// Makes one world.
class Generator {
 public:
  Generator(uint64_t seed, const Features& features)
      : random_(seed),
        scale_random_(~seed),
        growth_random_(seed + 1),
        leaving_random_(seed + 2),
        features_(features) {}

  World Make(std::size_t rays) {
    extent_ = std::exp2(random_.Uniform(-2, 4));
    if (random_.Chance(0.2f)) center_ = RandomVector(20 * extent_);
    if (Has(features_, Feature::kScales)) ChangeScale();
    on_lattice_ = random_.Chance(0.15f);
    has_context_filters_ = Chance(Feature::kContextFilters, 0.3f);
    World world;
    const uint32_t inner =
        Chance(Feature::kInstances, 0.5f) || shapes().empty() ? 1 + random_.Below(2) : 0;
    for (uint32_t i = 0; i <= inner; ++i) world.scenes.push_back(MakeScene(i, i == inner));
    AddStages(world, rays);
    world.real_config = RealConfig(world);
    if (Chance(Feature::kConfigs, 0.7f)) {
      world.drop_in_config =
          Pick(random_,
               {"isa=sse2", "isa=sse4.2", "isa=avx2", "threads=2", "dacrt_budget=0",
                "dacrt_budget=unlimited", "threads=2,isa=avx2,dacrt_budget=0",
                "dacrt_piece_rays=100", "dacrt_algorithm=afra2012", "dacrt_algorithm=mora2011"});
    }
    return world;
  }

 private:
  bool Chance(Feature feature, float probability) {
    // Drawn in any case, so that a feature that is left out changes little else.
    const bool drawn = random_.Chance(probability);
    return drawn && Has(features_, feature);
  }

  /// Draws numbers of its own, so that worlds of other scales are otherwise the same.
  void ChangeScale() {
    if (scale_random_.Chance(0.5f)) return;
    const float scale = std::pow(10.0f, scale_random_.Uniform(-30, 17));
    extent_ *= scale;
    center_ = scale_random_.Chance(0.3f) ? RandomVector(3e4f * extent_) : scale * center_;
  }

  Float3 RandomVector(float size) {
    return {random_.Uniform(-size, size), random_.Uniform(-size, size),
            random_.Uniform(-size, size)};
  }

  std::vector<Shape> shapes() const {
    std::vector<Shape> shapes;
    for (uint32_t i = 0; i + 1 < kShapeCount; ++i) {
      if (features_[i]) shapes.push_back(static_cast<Shape>(i));
    }
    return shapes;
  }

  WorldScene MakeScene(uint32_t place, bool is_top) {
    WorldScene scene;
    uint32_t flags = RTC_SCENE_FLAG_NONE;
    if (Chance(Feature::kRobust, 0.3f)) flags |= RTC_SCENE_FLAG_ROBUST;
    if (Chance(Feature::kFlags, 0.2f)) flags |= RTC_SCENE_FLAG_COMPACT;
    if (Chance(Feature::kFlags, 0.2f)) flags |= RTC_SCENE_FLAG_DYNAMIC;
    if (has_context_filters_) flags |= RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
    scene.flags = static_cast<RTCSceneFlags>(flags);
    if (Chance(Feature::kFlags, 0.4f)) {
      scene.quality =
          Pick(random_, {RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_HIGH});
    }
    const uint32_t count = random_.Chance(0.02f) ? 0 : 1 + random_.Below(is_top ? 6 : 3);
    const std::vector<Shape> shapes = this->shapes();
    // Most scenes are of few primitives, which find most faults and can be understood.
    most_primitives_ = static_cast<uint32_t>(std::exp2(random_.Uniform(0, 8)));
    moving_share_ = random_.Chance(0.5f) ? random_.Uniform() : 0;
    // Some begin with so many that the drop-in keeps its partition when others are attached.
    const bool grows = is_top && Has(features_, Feature::kChanges) && growth_random_.Chance(0.08f);
    for (uint32_t i = 0; i < count; ++i) {
      least_primitives_ = grows && i == 0 ? 2048 : 1;
      const bool is_instance = is_top && place > 0 && (shapes.empty() || random_.Chance(0.6f));
      if (!is_instance && shapes.empty()) continue;
      WorldGeometry geometry =
          MakeGeometry(is_instance ? Shape::kInstance
                                   : shapes[random_.Below(static_cast<uint32_t>(shapes.size()))],
                       place);
      geometry.id = next_id_;
      next_id_ += random_.Chance(0.2f) ? 1 + random_.Below(5) : 1;
      scene.geometries.push_back(std::move(geometry));
    }
    next_id_ = 0;
    const auto made = static_cast<uint32_t>(scene.geometries.size());
    if (grows && made > 1) {
      grows_ = true;
      WorldGeometry& first = scene.geometries.front();
      first.attached = first.enabled = true;
      // Many that rays pass through would keep the reference busy.
      first.closest_filter = first.any_filter = FilterKind::kNone;
      for (uint32_t i = 1 + growth_random_.Below(made - 1); i < made; ++i) {
        scene.geometries[i].attached = false;
      }
    }
    return scene;
  }

  WorldGeometry MakeGeometry(Shape shape, uint32_t place) {
    WorldGeometry geometry;
    geometry.shape = shape;
    if (Chance(Feature::kMasks, 0.3f)) geometry.mask = random_.Bits() | random_.Bits();
    if (Chance(Feature::kChanges, 0.1f)) geometry.enabled = false;
    if (Chance(Feature::kChanges, 0.1f)) geometry.attached = false;
    const uint32_t steps = StepCount();
    // Of points, Debian's library ends the process over ranges other than [0, 1].
    if (steps > 1 && !HasPoints(shape)) SetTimeRange(geometry);
    if (shape == Shape::kInstance) {
      MakePlacements(geometry, place, steps);
      return geometry;
    }
    if (Chance(Feature::kFilters, 0.3f)) geometry.closest_filter = RandomFilter();
    if (Chance(Feature::kFilters, 0.3f)) geometry.any_filter = RandomFilter();
    if (Chance(Feature::kFlags, 0.2f)) geometry.quality = RTC_BUILD_QUALITY_LOW;
    // Of points, which have four floats, the real library loads aligned ones only.
    if (Chance(Feature::kLayouts, 0.5f)) MakeLayout(geometry.layout, HasPoints(shape) ? 16 : 4);
    MakePrimitives(geometry);
    if (Chance(Feature::kHostile, 0.1f) && shape != Shape::kGrids) MakeHostile(geometry);
    Move(geometry, steps);
    if (shape == Shape::kUser && place > 0 && random_.Chance(0.3f)) {
      geometry.traces_again = true;
      geometry.instanced_scene = random_.Below(place);
    }
    return geometry;
  }

  FilterKind RandomFilter() {
    return Pick(random_, {FilterKind::kAccept, FilterKind::kRejectSome, FilterKind::kRejectSome,
                          FilterKind::kRejectAll, FilterKind::kChange});
  }

  void MakeLayout(ArrayLayout& layout, uint32_t unit) {
    layout.memory =
        Pick(random_, {Memory::kShared, Memory::kNew, Memory::kBuffer, Memory::kSceneBuffer});
    layout.gap = unit * Pick(random_, {0u, 0u, 1u, 3u, 5u});
    if (layout.memory != Memory::kNew) layout.offset = unit * Pick(random_, {0u, 0u, 1u, 4u, 7u});
  }

  uint32_t StepCount() {
    const bool moves = random_.Chance(moving_share_);
    const uint32_t steps = Pick(random_, {2u, 2u, 2u, 3u, 4u, 5u, 2 + random_.Below(16), 129u});
    return moves && Has(features_, Feature::kMotion) ? steps : 1;
  }

  void SetTimeRange(WorldGeometry& geometry) {
    if (random_.Chance(0.6f)) return;
    geometry.time_begin = Pick(random_, {0.0f, 0.25f, -0.5f, random_.Uniform(-0.2f, 0.5f)});
    geometry.time_end = Pick(random_, {1.0f, 0.75f, 1.5f, random_.Uniform(0.55f, 1.2f)});
  }

  float Place(float share) {
    const float value = extent_ * share;
    return on_lattice_ ? std::round(4 * share) * extent_ / 4 : value;
  }

  Vertex RandomVertex(float share) {
    return {center_.x + Place(random_.Uniform(-share, share)),
            center_.y + Place(random_.Uniform(-share, share)),
            center_.z + Place(random_.Uniform(-share, share)), 0};
  }

  Vertex Near(const Vertex& vertex, float share) {
    return {vertex.x + Place(random_.Uniform(-share, share)),
            vertex.y + Place(random_.Uniform(-share, share)),
            vertex.z + Place(random_.Uniform(-share, share)), 0};
  }

  void MakePrimitives(WorldGeometry& geometry) {
    geometry.vertices.resize(1);
    const uint32_t count = least_primitives_ + random_.Below(most_primitives_);
    if (HasPoints(geometry.shape)) return MakePoints(geometry, count);
    if (geometry.shape == Shape::kGrids) return MakeGrids(geometry, count);
    const uint32_t corners = geometry.shape == Shape::kTriangles ? 3 : 4;
    random_.Chance(0.5f) ? MakePatch(geometry, corners, count) : MakeSoup(geometry, corners, count);
    if (random_.Chance(0.1f)) {
      // Degenerate ones: a repeated vertex, which for quads is how a triangle is written.
      for (auto& p : geometry.primitives) {
        if (random_.Chance(0.3f)) p[corners - 1] = p[corners - 2];
      }
    }
    if (random_.Chance(0.1f)) {
      for (auto& p : geometry.primitives) {
        if (random_.Chance(0.1f)) p[random_.Below(corners)] = UINT32_MAX - random_.Below(2);
      }
    }
  }

  /// Vertices that make a library leave out their primitives.
  void MakeHostile(WorldGeometry& geometry) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (Vertex& vertex : geometry.vertices[0]) {
      if (!random_.Chance(0.1f)) continue;
      const float value = Pick(random_, {kInfinity, -kInfinity, kNan, 3e18f, -1e30f});
      switch (random_.Below(4)) {
        case 0:
          vertex.x = value;
          break;
        case 1:
          vertex.y = value;
          break;
        case 2:
          vertex.z = value;
          break;
        default:
          vertex.radius = HasPoints(geometry.shape) ? -vertex.radius : vertex.radius;
      }
    }
  }

  void MakePoints(WorldGeometry& geometry, uint32_t count) {
    const float size = random_.Uniform(0.02f, 0.3f);
    geometry.normals.resize(geometry.shape == Shape::kOrientedDiscs ? 1 : 0);
    for (uint32_t i = 0; i < count; ++i) {
      Vertex vertex = RandomVertex(1);
      vertex.radius = random_.Chance(0.02f) ? 0 : extent_ * size * random_.Uniform(0.1f, 1);
      geometry.vertices[0].push_back(vertex);
      if (geometry.shape != Shape::kOrientedDiscs) continue;
      const Float3 normal = random_.Chance(0.2f)
                                ? Pick(random_, {Float3{1, 0, 0}, {0, 1, 0}, {0, 0, -1}})
                                : RandomVector(1);
      geometry.normals[0].push_back(normal);
    }
  }

  void MakeSoup(WorldGeometry& geometry, uint32_t corners, uint32_t count) {
    const float size = random_.Uniform(0.05f, 0.6f);
    auto& vertices = geometry.vertices[0];
    for (uint32_t i = 0; i < count; ++i) {
      const auto first = static_cast<uint32_t>(vertices.size());
      const Vertex a = RandomVertex(1), b = Near(a, size), d = Near(a, size);
      vertices.insert(vertices.end(), {a, b});
      // The fourth corner of a quad: a parallelogram, bent or not.
      const Vertex c{b.x + d.x - a.x, b.y + d.y - a.y, b.z + d.z - a.z, 0};
      if (corners == 4) vertices.push_back(random_.Chance(0.5f) ? c : Near(c, size / 2));
      vertices.push_back(d);
      geometry.primitives.push_back({first, first + 1, first + 2, first + 3});
    }
  }

  /// A height field over a random plane: primitives that share edges.
  void AddPatchVertices(std::vector<Vertex>& vertices, uint32_t columns, uint32_t rows) {
    const Vertex corner = RandomVertex(1);
    const Float3 right = RandomVector(extent_), up = RandomVector(extent_);
    const float bump = random_.Chance(0.3f) ? 0 : random_.Uniform(0, 0.1f);
    for (uint32_t row = 0; row <= rows; ++row) {
      for (uint32_t column = 0; column <= columns; ++column) {
        const float x = static_cast<float>(column) / static_cast<float>(columns);
        const float y = static_cast<float>(row) / static_cast<float>(rows);
        const Vertex flat{corner.x + x * right.x + y * up.x, corner.y + x * right.y + y * up.y,
                          corner.z + x * right.z + y * up.z, 0};
        vertices.push_back(bump == 0 ? flat : Near(flat, bump));
      }
    }
  }

  void MakePatch(WorldGeometry& geometry, uint32_t corners, uint32_t count) {
    const auto columns = static_cast<uint32_t>(std::ceil(std::sqrt(count)));
    const uint32_t rows = (count + columns - 1) / columns;
    AddPatchVertices(geometry.vertices[0], columns, rows);
    for (uint32_t row = 0; row < rows; ++row) {
      for (uint32_t column = 0; column < columns; ++column) {
        const uint32_t a = row * (columns + 1) + column, d = a + columns + 1;
        if (corners == 4) {
          geometry.primitives.push_back({a, a + 1, d + 1, d});
        } else {
          geometry.primitives.push_back({a, a + 1, d, 0});
          geometry.primitives.push_back({d + 1, d, a + 1, 0});
        }
      }
    }
  }

  void MakeGrids(WorldGeometry& geometry, uint32_t count) {
    const uint32_t grids = 1 + random_.Below(3);
    const auto most = static_cast<uint32_t>(std::sqrt(count)) + 1;
    for (uint32_t i = 0; i < grids; ++i) {
      const uint32_t columns = 1 + random_.Below(most), rows = 1 + random_.Below(most);
      const auto first = static_cast<uint32_t>(geometry.vertices[0].size());
      AddPatchVertices(geometry.vertices[0], columns, rows);
      // Now and then a part of the grid, whose rows are further apart than it is wide.
      const uint32_t width = random_.Chance(0.2f) ? 1 + random_.Below(columns) : columns;
      geometry.primitives.push_back({first, columns + 1, width + 1, rows + 1});
    }
  }

  void Move(WorldGeometry& geometry, uint32_t steps) {
    const Float3 path = RandomVector(extent_);
    const float noise = random_.Chance(0.5f) ? 0 : extent_ * random_.Uniform(0, 0.1f);
    for (uint32_t step = 1; step < steps; ++step) {
      const float share = static_cast<float>(step) / static_cast<float>(steps - 1);
      std::vector<Vertex> vertices = geometry.vertices[0];
      for (Vertex& vertex : vertices) {
        const Float3 off = RandomVector(noise);
        vertex.x += share * path.x + off.x;
        vertex.y += share * path.y + off.y;
        vertex.z += share * path.z + off.z;
        if (noise > 0) vertex.radius *= random_.Uniform(0.5f, 1.5f);
      }
      geometry.vertices.push_back(std::move(vertices));
      if (geometry.normals.empty()) continue;
      std::vector<Float3> normals = geometry.normals[0];
      for (Float3& normal : normals) normal = normal + RandomVector(0.2f);
      geometry.normals.push_back(std::move(normals));
    }
  }

  void MakePlacements(WorldGeometry& geometry, uint32_t place, uint32_t steps) {
    geometry.instanced_scene = random_.Below(place);
    geometry.transform_format =
        Pick(random_, {RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                       RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR});
    geometry.in_parts = Chance(Feature::kQuaternions, 0.3f);
    const bool is_identity = random_.Chance(0.1f);
    Placement placement = is_identity ? Placement{} : RandomPlacement();
    placement.parts = RandomParts();
    geometry.placements.push_back(placement);
    for (uint32_t step = 1; step < steps; ++step) {
      Placement next = placement;
      const Placement other = RandomPlacement();
      const float share = random_.Uniform(0, 0.2f);
      for (std::size_t i = 0; i < 12; ++i) {
        next.matrix[i] += share * (other.matrix[i] - placement.matrix[i]);
      }
      const std::array<float, 16> parts = RandomParts();
      for (std::size_t i = 0; i < 16; ++i) next.parts[i] += share * (parts[i] - next.parts[i]);
      geometry.placements.push_back(next);
    }
  }

  Placement RandomPlacement() {
    Placement placement;
    const Float3 axis = Normalized(RandomVector(1));
    const float angle = random_.Uniform(-kPi, kPi);
    const float c = std::cos(angle), s = std::sin(angle);
    const bool is_even = random_.Chance(0.5f);
    const float scale = std::exp2(random_.Uniform(-1.5f, 1.5f));
    for (int column = 0; column < 3; ++column) {
      const float size = is_even ? scale : std::exp2(random_.Uniform(-2, 2));
      for (int row = 0; row < 3; ++row) {
        const float cross = row == column             ? 0
                            : (row + 1) % 3 == column ? -axis[(row + 2) % 3]
                                                      : axis[(column + 2) % 3];
        const float rotation =
            (row == column ? c : 0) + (1 - c) * axis[row] * axis[column] + s * cross;
        placement.matrix[3 * column + row] = size * rotation;
      }
    }
    if (random_.Chance(0.1f)) {
      for (int i = 0; i < 3; ++i) placement.matrix[i] = -placement.matrix[i];
    }
    if (random_.Chance(0.2f)) {
      for (int i = 0; i < 9; ++i) placement.matrix[i] += random_.Uniform(-0.2f, 0.2f);
    }
    for (int axis_ = 0; axis_ < 3; ++axis_) {
      placement.matrix[9 + axis_] = extent_ * random_.Uniform(-1.5f, 1.5f);
    }
    return placement;
  }

  std::array<float, 16> RandomParts() {
    std::array<float, 16> parts{1, 1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};
    for (int i = 0; i < 3; ++i) parts[i] = std::exp2(random_.Uniform(-1, 1));
    if (random_.Chance(0.3f)) {
      for (int i = 3; i < 6; ++i) parts[i] = random_.Uniform(-0.3f, 0.3f);
    }
    if (random_.Chance(0.3f)) {
      for (int i = 6; i < 9; ++i) parts[i] = extent_ * random_.Uniform(-0.3f, 0.3f);
    }
    float length2 = 0;
    for (int i = 9; i < 13; ++i) {
      parts[i] = random_.Uniform(-1, 1);
      length2 += parts[i] * parts[i];
    }
    // Libraries make it of length one themselves.
    const float length = random_.Chance(0.3f) ? random_.Uniform(0.5f, 2) : 1;
    for (int i = 9; i < 13; ++i) parts[i] *= length / std::sqrt(length2);
    for (int i = 13; i < 16; ++i) parts[i] = extent_ * random_.Uniform(-1.5f, 1.5f);
    return parts;
  }

  void AddStages(World& world, std::size_t rays) {
    const uint32_t drawn = Chance(Feature::kChanges, 0.4f) ? 2 + random_.Below(3) : 1;
    const uint32_t stages = std::max(drawn, grows_ ? 3u : 1u);
    // What the stages so far have made of it.
    std::vector<WorldScene> scenes = world.scenes;
    for (uint32_t i = 0; i < stages; ++i) {
      Stage stage;
      if (i > 0) AddChanges(scenes, stage);
      AddBatches(stage, rays / stages);
      world.stages.push_back(std::move(stage));
    }
  }

  /// Of what is not attached the first one is, and nothing else happens; or something else does.
  bool Grow(std::vector<WorldScene>& scenes, Stage& stage) {
    if (!grows_ || growth_random_.Chance(0.2f)) return false;
    const auto& geometries = scenes.back().geometries;
    const auto next = std::find_if(geometries.begin(), geometries.end(),
                                   [](const auto& geometry) { return !geometry.attached; });
    if (next == geometries.end()) return false;
    Change& change = stage.changes.emplace_back();
    change.kind = Change::Kind::kAttach;
    change.scene = static_cast<uint32_t>(scenes.size() - 1);
    change.geometry = static_cast<uint32_t>(next - geometries.begin());
    Apply(change, scenes);
    return true;
  }

  /// Now and then a geometry goes or comes back instead of what was drawn.
  void GoOrComeBack(const WorldGeometry& geometry, Change& change) {
    if (!leaving_random_.Chance(0.3f)) return;
    using enum Change::Kind;
    const bool is_replaced = leaving_random_.Chance(0.3f);
    const Change::Kind leaves = leaving_random_.Chance(0.5f) ? kDetach : kDisable;
    change.kind = is_replaced          ? kReplace
                  : !geometry.attached ? kAttach
                  : !geometry.enabled  ? kEnable
                                       : leaves;
  }

  void AddChanges(std::vector<WorldScene>& scenes, Stage& stage) {
    if (Grow(scenes, stage)) return;
    const uint32_t count = 1 + random_.Below(4);
    for (uint32_t i = 0; i < count; ++i) {
      Change change;
      change.scene = random_.Below(static_cast<uint32_t>(scenes.size()));
      auto& geometries = scenes[change.scene].geometries;
      if (geometries.empty()) continue;
      change.geometry = random_.Below(static_cast<uint32_t>(geometries.size()));
      const WorldGeometry& geometry = geometries[change.geometry];
      change.kind = static_cast<Change::Kind>(random_.Below(kDrawnKinds));
      GoOrComeBack(geometry, change);
      change.shift = RandomVector(extent_ / 2);
      change.mask = random_.Bits() | 1;
      change.closest_filter = random_.Chance(0.5f) ? RandomFilter() : FilterKind::kNone;
      change.any_filter = random_.Chance(0.5f) ? RandomFilter() : FilterKind::kNone;
      if (change.kind == Change::Kind::kDetach && !geometry.attached) continue;
      if (change.kind == Change::Kind::kAttach && geometry.attached) continue;
      if (change.kind == Change::Kind::kMask && !Has(features_, Feature::kMasks)) continue;
      if (change.kind == Change::Kind::kFilters && !Has(features_, Feature::kFilters)) continue;
      // Grids with such vertices are not compared, here as at the start.
      if (change.kind == Change::Kind::kSpoil &&
          (!Has(features_, Feature::kHostile) || geometry.shape == Shape::kGrids)) {
        continue;
      }
      Apply(change, scenes);
      stage.changes.push_back(change);
    }
  }

  void AddBatches(Stage& stage, std::size_t rays) {
    const std::vector<RayKind> kinds = AllRayKinds();
    const std::vector<Form> streams = StreamForms(), packets = PacketForms();
    constexpr std::size_t kBatches = 10;
    for (std::size_t i = 0; i < kBatches; ++i) {
      Batch batch;
      const bool is_packet = random_.Chance(0.25f);
      const std::vector<Form>& forms = is_packet ? packets : streams;
      batch.form = forms[random_.Below(static_cast<uint32_t>(forms.size()))];
      batch.query = random_.Chance(0.5f) ? Query::kClosest : Query::kAny;
      if (has_context_filters_ && random_.Chance(0.7f)) batch.context_filter = RandomFilter();
      batch.ray_kind = Name(kinds[random_.Below(static_cast<uint32_t>(kinds.size()))]);
      batch.rays_per_call = UINT32_MAX;
      std::size_t count = rays / kBatches;
      if (is_packet) {
        batch.rays_per_call = batch.form.lanes;
        count = std::min<std::size_t>(count, 64 * batch.form.lanes);
      } else if (random_.Chance(0.3f)) {
        batch.rays_per_call = Pick(random_, {1u, 2u, 7u, 8u, 16u, 17u, 64u, 100u, 1000u});
        count = std::min<std::size_t>(count, 64 * batch.rays_per_call);
      }
      batch.rays.resize(std::max<std::size_t>(count, 1));
      stage.batches.push_back(std::move(batch));
    }
  }

  /// The real library's AVX-512 kernels never return from some coherent occlusion queries of
  /// compact scenes and instances.
  std::string RealConfig(const World& world) {
    const bool own_choice = random_.Chance(0.5f);
    for (const WorldScene& scene : world.scenes) {
      if (scene.flags & RTC_SCENE_FLAG_COMPACT) return "isa=avx2";
      for (const WorldGeometry& geometry : scene.geometries) {
        if (geometry.shape == Shape::kInstance) return "isa=avx2";
      }
    }
    return own_choice ? "" : "isa=avx2";
  }

  /// All but kReplace, which GoOrComeBack draws: others stay what they were for a seed.
  static constexpr uint32_t kDrawnKinds = kChangeKindCount - 1;

  Random random_, scale_random_, growth_random_, leaving_random_;
  const Features& features_;
  float extent_ = 1;  ///< half of the scene's size
  Float3 center_;
  bool on_lattice_ = false;
  bool has_context_filters_ = false;
  bool grows_ = false;
  uint32_t least_primitives_ = 1, most_primitives_ = 1;
  float moving_share_ = 0;
  uint32_t next_id_ = 0;
};

}  // namespace

World MakeWorld(uint64_t seed, const Features& features, std::size_t rays) {
  return Generator(SeedFor("world", seed), features).Make(rays);
}

}  // namespace dacrt::tests

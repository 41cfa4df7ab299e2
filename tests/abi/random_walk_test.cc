// Random calls on a few geometries and scenes, the same on both libraries: each gives the same
// code, and each commit the same scene.
//
// Changes that the drop-in and the real library treat differently on purpose are followed by a
// commit: buffers, transforms and instanced scenes, of which the real library uses some parts
// without one. And what a scene is after a commit that failed is not compared; the drop-in's stays
// as it was.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "model.h"

namespace dacrt::tests {
namespace {

constexpr unsigned int kWalks = 300;
constexpr unsigned int kSteps = 150;
constexpr unsigned int kGeometries = 4;
constexpr unsigned int kScenes = 2;
constexpr unsigned int kInner = 0;  ///< that instances show
constexpr unsigned int kOuter = 1;  ///< that may have instances

/// What a call was and what came of it.
struct Note {
  std::string what;
  long result;
  bool operator==(const Note&) const = default;
};

void PrintTo(const Note& note, std::ostream* out) { *out << note.what << ": " << note.result; }

class Walk {
 public:
  Walk(const Api& api, unsigned int seed) : s_(api), random_(seed) {
    for (unsigned int i = 0; i < kScenes; ++i) scenes_.push_back({s_.NewScene()});
    for (unsigned int i = 0; i < kGeometries; ++i) {
      const RTCGeometryType type = kSupportedTypes[Choose(std::size(kSupportedTypes))];
      const RTCGeometry geometry = type == RTC_GEOMETRY_TYPE_INSTANCE
                                       ? Instance(s_, scenes_[kInner].scene)
                                       : UncommittedModel(s_, type);
      items_.push_back({type, geometry, NameOf(type) + std::to_string(i)});
    }
    for (unsigned int i = 0; i < kSteps; ++i) Step();
  }

  const std::vector<Note>& notes() const { return notes_; }

 private:
  struct Item {
    RTCGeometryType type;
    RTCGeometry geometry;
    std::string name;
  };

  struct ItemScene {
    RTCScene scene;
    bool failed = false;  ///< the last commit
  };

  unsigned int Choose(std::size_t count) { return static_cast<unsigned int>(random_() % count); }

  /// Notes the code of a call, which is returned.
  RTCError Add(std::string what) {
    const RTCError code = s_.TakeError();
    notes_.push_back({std::move(what), code});
    return code;
  }

  void Step() {
    const Item& item = items_[Choose(kGeometries)];
    ItemScene& scene = scenes_[Choose(kScenes)];
    switch (Choose(6)) {
      case 0:
        return SetProperty(item);
      case 1:
        return Reshape(item);
      case 2:
        return Enable(item);
      case 3:
        return Attach(item, scene);
      case 4:
        return Configure(scene);
      default:
        return Commit(scene);
    }
  }

  void SetProperty(const Item& item) {
    const RTCGeometry g = item.geometry;
    const unsigned int value = Choose(4);
    const std::pair<const char*, std::function<void()>> calls[] = {
        {"mask", [&] { s_.api.rtcSetGeometryMask(g, value == 0 ? 0 : ~0u); }},
        {"time range", [&] { s_.api.rtcSetGeometryTimeRange(g, 0, 1); }},
        {"update", [&] { s_.api.rtcUpdateGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, value / 3); }},
        {"quality", [&] { s_.api.rtcSetGeometryBuildQuality(g, RTCBuildQuality(value)); }},
        {"attributes", [&] { s_.api.rtcSetGeometryVertexAttributeCount(g, value); }},
        {"user primitives", [&] { s_.api.rtcSetGeometryUserPrimitiveCount(g, value > 0); }},
        {"no filter", [&] { s_.api.rtcSetGeometryIntersectFilterFunction(g, nullptr); }},
        {"user data", [&] { s_.api.rtcSetGeometryUserData(g, nullptr); }},
    };
    const auto& [name, call] = calls[Choose(std::size(calls))];
    call();
    Add(item.name + ": " + name + " " + std::to_string(value));
  }

  /// Other buffers, steps or transforms, and the commit that these need.
  void Reshape(const Item& item) {
    const unsigned int value = Choose(4);
    const float z = 0.25f * static_cast<float>(value);
    if (item.type == RTC_GEOMETRY_TYPE_INSTANCE) {
      const float matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, z};
      s_.api.rtcSetGeometryTransform(item.geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
    } else if (value == 3) {
      s_.api.rtcSetGeometryTimeStepCount(item.geometry, 1 + Choose(2));
    } else if (HasBuffers(item.type)) {
      SetVertices(s_, item.geometry, item.type, 0, z);
      SetPrimitives(s_, item.geometry, item.type, 1 + value % 2);
    }
    Add(item.name + ": shape " + std::to_string(value));
    s_.api.rtcCommitGeometry(item.geometry);
    Add(item.name + ": commit");
  }

  void Enable(const Item& item) {
    switch (Choose(4)) {
      case 0:
        s_.api.rtcDisableGeometry(item.geometry);
        Add(item.name + ": disable");
        return;
      case 1:
        s_.api.rtcEnableGeometry(item.geometry);
        Add(item.name + ": enable");
        return;
      default:
        s_.api.rtcCommitGeometry(item.geometry);
        Add(item.name + ": commit");
    }
  }

  void Attach(const Item& item, const ItemScene& chosen) {
    const bool is_instance = item.type == RTC_GEOMETRY_TYPE_INSTANCE;
    const ItemScene& scene = is_instance ? scenes_[kOuter] : chosen;
    const unsigned int id = Choose(6);
    switch (Choose(3)) {
      case 0:
        notes_.push_back({item.name + ": attach",
                          static_cast<int>(s_.api.rtcAttachGeometry(scene.scene, item.geometry))});
        Add("attach");
        return;
      case 1:
        s_.api.rtcAttachGeometryByID(scene.scene, item.geometry, id);
        Add(item.name + ": attach as " + std::to_string(id));
        return;
      default:
        s_.api.rtcDetachGeometry(scene.scene, id);
        Add("detach " + std::to_string(id));
    }
  }

  void Configure(const ItemScene& scene) {
    const unsigned int value = Choose(4);
    if (Choose(2) == 0) {
      s_.api.rtcSetSceneFlags(scene.scene, RTCSceneFlags(value));
    } else {
      s_.api.rtcSetSceneBuildQuality(scene.scene, RTCBuildQuality(value));
    }
    Add("flags or quality " + std::to_string(value));
  }

  /// Commits or looks first.
  void Commit(ItemScene& scene) {
    RTCBounds bounds{};
    s_.api.rtcGetSceneBounds(scene.scene, &bounds);
    const RTCError code = s_.TakeError();
    if (!scene.failed) notes_.push_back({"bounds", code});
    if (Choose(2) == 0) return;
    if (&scene == &scenes_[kOuter]) CommitInner();
    s_.api.rtcCommitScene(scene.scene);
    scene.failed = Add("commit of a scene") != RTC_ERROR_NONE;
    if (!scene.failed && !scenes_[kInner].failed) Look(scene.scene);
  }

  /// What the outer scene has instances of, and these.
  void CommitInner() {
    s_.api.rtcCommitScene(scenes_[kInner].scene);
    scenes_[kInner].failed = Add("commit of the inner scene") != RTC_ERROR_NONE;
    for (const Item& item : items_) {
      if (item.type != RTC_GEOMETRY_TYPE_INSTANCE) continue;
      s_.api.rtcCommitGeometry(item.geometry);
      Add(item.name + ": commit");
    }
  }

  /// Notes where the scene begins, ends and is hit, in steps that rounding does not reach.
  void Look(RTCScene scene) {
    RTCBounds bounds{};
    s_.api.rtcGetSceneBounds(scene, &bounds);
    Add("bounds");
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit record = RayAt(0.3f);
    s_.api.rtcIntersect1(scene, &context, &record);
    for (const float value : {bounds.lower_z, bounds.upper_z, record.ray.tfar}) {
      notes_.push_back({"place", std::lround(64 * std::clamp(value, -1000.0f, 1000.0f))});
    }
  }

  Session s_;
  std::mt19937 random_;
  std::vector<Item> items_;
  std::vector<ItemScene> scenes_;
  std::vector<Note> notes_;
};

TEST(RandomWalk, LeadsBothLibrariesToTheSamePlaces) {
  for (unsigned int seed = 0; seed < kWalks; ++seed) {
    const Walk real(RealEmbree(), seed), ours(DropIn(), seed);
    const auto [expected, actual] = std::mismatch(real.notes().begin(), real.notes().end(),
                                                  ours.notes().begin(), ours.notes().end());
    if (expected == real.notes().end() && actual == ours.notes().end()) continue;
    std::string way;
    for (auto note = real.notes().begin(); note != expected; ++note) way += note->what + "\n";
    FAIL() << "Walk " << seed << ", after\n"
           << way << "the real library has " << testing::PrintToString(*expected)
           << ", the drop-in has " << testing::PrintToString(*actual);
  }
}

}  // namespace
}  // namespace dacrt::tests

// The same calls to the real library and to the drop-in.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "embree_scene.h"
#include "rays.h"
#include "report.h"
#include "scenes.h"
#include "streams.h"

namespace dacrt::tests {

/// The two libraries, opened once for the process; their paths come from the build.
const EmbreeApi& RealEmbree();
const EmbreeApi& DropIn();

/// Every scene there is: the generated ones, and meshes of the folder that the environment
/// variable DACRT_SCENES_DIR names, or else the build.
std::vector<SceneSource> AllScenes();

/// The scene of that name. Throws std::invalid_argument if there is none.
TestScene MakeScene(const std::string& name);

/// `isa=...` for the instruction sets that the processor has. Either library refuses others.
std::vector<std::string> IsaConfigs();

/// The devices that meet in a contest.
class Devices {
 public:
  /// `real_configs` are the configurations that the real library is run with, one after the other;
  /// without any, its AVX2 kernels and those that it chooses itself.
  explicit Devices(const std::string& drop_in_config = "",
                   const std::vector<std::string>& real_configs = {"isa=avx2", ""});

  const std::vector<std::unique_ptr<EmbreeDevice>>& real() const { return real_; }
  const EmbreeDevice& drop_in() const { return drop_in_; }

 private:
  std::vector<std::unique_ptr<EmbreeDevice>> real_;
  EmbreeDevice drop_in_;
};

/// One scene in both libraries.
class Contest {
 public:
  /// All arguments must outlive the contest.
  Contest(const Devices& devices, const TestScene& scene, Report& report);

  /// Rays for the scene, as RayGenerator::Make.
  std::vector<RTCRayHit> MakeRays(RayKind kind, std::size_t count, uint64_t seed) const {
    return generator_.Make(kind, count, seed);
  }

  /// Gives `rays` to every device in calls of at most `rays_per_call`, and counts and keeps what
  /// differs under `kind`. Rays that the real library aborts on only the drop-in gets.
  void Compare(const Form& form, Query query, std::string_view kind, std::vector<RTCRayHit> rays,
               std::size_t rays_per_call = SIZE_MAX);

  /// About `rays` rays, shared between the kinds and queries: most in large streams, and as many
  /// small calls as the size of the scene lets pass in reasonable time. The forms take turns.
  /// `progress` is called now and then with what is being done.
  void CompareEverything(std::size_t rays, uint64_t seed,
                         const std::function<void(const std::string&)>& progress);

  bool BoundsAreEqual() const;

  const EmbreeScene& drop_in() const { return drop_in_; }

 private:
  void CompareAnswers(const std::string& context, const Form& form, Query query, Tally& tally,
                      std::span<const RTCRayHit> before, std::span<const RTCRayHit> real,
                      std::span<const RTCRayHit> drop_in);
  void Count(const std::string& context, Query query, Tally& tally, const Comparison& comparison,
             const RTCRayHit& before, const RTCRayHit* real, const RTCRayHit& drop_in);
  void Audit(const std::string& context, Query query, Tally& tally,
             std::span<const RTCRayHit> before, std::span<const RTCRayHit> drop_in);

  const TestScene& scene_;
  Report& report_;
  std::vector<std::unique_ptr<EmbreeScene>> real_;
  EmbreeScene drop_in_;
  RayGenerator generator_;
  Comparer comparer_;
};

}  // namespace dacrt::tests

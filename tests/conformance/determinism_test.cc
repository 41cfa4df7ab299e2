// The same ray gets the same bits from the drop-in, whatever stands beside it in the batch, however
// the batch is handed over, whatever the settings, and whoever else is tracing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cfenv>
#include <cstring>
#include <numeric>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "contest.h"
#include "random.h"

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace dacrt::tests {
namespace {

constexpr std::size_t kRaysPerKind = 3'000;

/// Rays of every kind in one batch.
std::vector<RTCRayHit> MixedRays(const TestScene& scene, const EmbreeScene& traced_scene) {
  const RayGenerator generator(scene, traced_scene);
  std::vector<RTCRayHit> rays;
  for (const RayKind kind : AllRayKinds()) {
    const std::vector<RTCRayHit> some = generator.Make(kind, kRaysPerKind, SeedFor(Name(kind), 7));
    rays.insert(rays.end(), some.begin(), some.end());
  }
  return rays;
}

/// The number of the first record that differs; the number of records if none does.
std::size_t FirstDifference(std::span<const RTCRayHit> a, std::span<const RTCRayHit> b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(RTCRayHit)) != 0) return i;
  }
  return a.size();
}

/// What the method is made of, and what changes only where, when and how fast it works.
std::vector<std::string> AllConfigs() {
  std::vector<std::string> configs = {"dacrt_algorithm=afra2012", "dacrt_algorithm=mora2011"};
  // Without a kept partition every constant of the method counts.
  for (const char* const config :
       {"dacrt_piece_rays=64", "dacrt_piece_rays=1000", "dacrt_leaf_triangles=1",
        "dacrt_leaf_triangles=64", "dacrt_leaf_rays=1", "dacrt_leaf_rays=1024", "dacrt_bins=2",
        "dacrt_bins=8", "dacrt_bins=32", "dacrt_sample_rays=1", "dacrt_sample_rays=1024",
        "dacrt_sample_threshold=1", "dacrt_sample_threshold=1000000", "dacrt_sampled_cost=0",
        "dacrt_sampled_order=0", "dacrt_skip_filtering=0",
        "dacrt_bins=3,dacrt_leaf_triangles=5,dacrt_leaf_rays=2,dacrt_piece_rays=777"}) {
    configs.push_back(std::string("dacrt_budget=0,") + config);
  }
  for (const char* const budget : {"0", "20000", "70000", "default", "unlimited"}) {
    for (const char* const threads : {"1", "2", "8"}) {
      for (const char* const piece : {"64", "1000", "4194304"}) {
        configs.push_back(std::string("dacrt_budget=") + budget + ",threads=" + threads +
                          ",dacrt_piece_rays=" + piece);
      }
    }
  }
  return configs;
}

class DeterminismTest : public testing::TestWithParam<const char*> {
 protected:
  const TestScene scene_ = MakeScene(GetParam());
  const EmbreeDevice device_{DropIn(), ""};
  const EmbreeScene drop_in_{device_, scene_};
  const std::vector<RTCRayHit> rays_ = MixedRays(scene_, drop_in_);
};

INSTANTIATE_TEST_SUITE_P(Scenes, DeterminismTest,
                         testing::Values("coincident", "coplanar", "boxes", "masks", "soup"),
                         [](const auto& name) { return std::string(name.param); });

TEST_P(DeterminismTest, OrderOfTheRays) {
  std::vector<uint32_t> order(rays_.size());
  std::iota(order.begin(), order.end(), 0);
  Random random(11);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.Below(static_cast<uint32_t>(i))]);
  }
  std::vector<RTCRayHit> shuffled;
  for (const uint32_t i : order) shuffled.push_back(rays_[i]);
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const std::vector<RTCRayHit> expected = Trace(drop_in_, {Form::Call::kRecords}, query, rays_);
    const std::vector<RTCRayHit> traced = Trace(drop_in_, {Form::Call::kRecords}, query, shuffled);
    std::vector<RTCRayHit> sorted(rays_.size());
    for (std::size_t i = 0; i < order.size(); ++i) sorted[order[i]] = traced[i];
    EXPECT_EQ(FirstDifference(expected, sorted), rays_.size());
  }
}

TEST_P(DeterminismTest, SizeOfTheCalls) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const std::vector<RTCRayHit> expected = Trace(drop_in_, {Form::Call::kRecords}, query, rays_);
    for (const std::size_t rays_per_call : {100, 1'000, 10'000}) {
      std::vector<RTCRayHit> pieces;
      for (std::size_t done = 0; done < rays_.size(); done += rays_per_call) {
        const auto piece =
            std::span(rays_).subspan(done).first(std::min(rays_per_call, rays_.size() - done));
        for (const RTCRayHit& record : Trace(drop_in_, {Form::Call::kRecords}, query, piece)) {
          pieces.push_back(record);
        }
      }
      EXPECT_EQ(FirstDifference(expected, pieces), rays_.size()) << rays_per_call;
    }
  }
}

TEST_P(DeterminismTest, FormOfTheCall) {
  // Calls for single rays and packets are many; a part of the rays is enough for them.
  constexpr std::size_t kPart = 64;
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const std::vector<RTCRayHit> expected = Trace(drop_in_, {Form::Call::kRecords}, query, rays_);
    for (const Form& form : StreamForms()) {
      if (form.call == Form::Call::kRequiredArrays) continue;  // other rays: without their masks
      EXPECT_EQ(FirstDifference(expected, Trace(drop_in_, form, query, rays_)), rays_.size())
          << Name(form);
    }
    for (const Form& form : PacketForms()) {
      for (std::size_t first = 0; first < rays_.size(); first += kRaysPerKind) {
        const auto part = std::span(rays_).subspan(first, kPart);
        EXPECT_EQ(FirstDifference(std::span(expected).subspan(first, kPart),
                                  Trace(drop_in_, form, query, part)),
                  kPart)
            << Name(form);
      }
    }
  }
}

TEST_P(DeterminismTest, Settings) {
  const EmbreeScene& expected_scene = drop_in_;
  for (const std::string& config : AllConfigs()) {
    const EmbreeDevice device(DropIn(), config);
    const EmbreeScene scene(device, scene_);
    for (const Query query : {Query::kClosest, Query::kAny}) {
      EXPECT_EQ(FirstDifference(Trace(expected_scene, {Form::Call::kRecords}, query, rays_),
                                Trace(scene, {Form::Call::kRecords}, query, rays_)),
                rays_.size())
          << config << ", " << Name(query);
    }
  }
}

TEST_P(DeterminismTest, ConcurrentCallers) {
  constexpr int kCallers = 4;
  constexpr int kCallsEach = 5;
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const std::vector<RTCRayHit> expected = Trace(drop_in_, {Form::Call::kRecords}, query, rays_);
    std::vector<std::size_t> first_differences(kCallers, rays_.size());
    {
      std::vector<std::jthread> callers;
      for (int caller = 0; caller < kCallers; ++caller) {
        callers.emplace_back([&, caller] {
          for (int call = 0; call < kCallsEach; ++call) {
            const Form form{Form::Call::kRecords, call % 2 == 1, 1, caller % 2 ? 16u : 0u};
            first_differences[caller] =
                std::min(first_differences[caller],
                         FirstDifference(expected, Trace(drop_in_, form, query, rays_)));
          }
        });
      }
    }
    EXPECT_EQ(first_differences, std::vector<std::size_t>(kCallers, rays_.size()));
  }
}

#if defined(__SSE2__)

/// How a caller's arithmetic rounds, and what it does with the smallest numbers.
struct Arithmetic {
  const char* name;
  unsigned flags = 0;  ///< of the control register that SSE and its kin share
  int rounding = FE_TONEAREST;
};

/// The thread's, as long as it lives.
class WithArithmetic {
 public:
  explicit WithArithmetic(const Arithmetic& arithmetic) : before_(_mm_getcsr()) {
    std::fesetround(arithmetic.rounding);
    _mm_setcsr(_mm_getcsr() | arithmetic.flags);
  }
  ~WithArithmetic() {
    std::fesetround(FE_TONEAREST);
    _mm_setcsr(before_);
  }
  WithArithmetic(const WithArithmetic&) = delete;
  WithArithmetic& operator=(const WithArithmetic&) = delete;

 private:
  const unsigned before_;
};

constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x40;

/// A scene of ordinary triangles, of such as give products that are no normal numbers any more, or
/// of such whose normals are none, and rays for it.
class ArithmeticTest : public testing::TestWithParam<std::tuple<Arithmetic, float>> {
 protected:
  ArithmeticTest() {
    const float scale = std::get<float>(GetParam());
    description_ = MakeScene("soup");
    TestMesh& mesh = description_.meshes.front();
    mesh.triangles.resize(3000);
    for (Float3& p : mesh.positions) p = {scale * p.x, scale * p.y, scale * p.z};
    plain_.emplace(alone_, description_);
    const RayGenerator generator(description_, *plain_);
    for (const RayKind kind : AllRayKinds()) {
      const auto some = generator.Make(kind, 200, SeedFor(Name(kind), 8));
      rays_.insert(rays_.end(), some.begin(), some.end());
    }
  }

  /// Calls for single rays and packets are many; a part of the rays is enough for them.
  std::vector<RTCRayHit> Ask(const EmbreeScene& scene, const Form& form, Query query,
                             const Arithmetic& arithmetic) const {
    const std::size_t step = form.call == Form::Call::kRecords ? 1 : 50;
    std::vector<RTCRayHit> part;
    for (std::size_t i = 0; i < rays_.size(); i += step) part.push_back(rays_[i]);
    const WithArithmetic with_arithmetic(arithmetic);
    return Trace(scene, form, query, part);
  }

  const Arithmetic& arithmetic() const { return std::get<Arithmetic>(GetParam()); }

  static std::vector<Form> Forms() {
    return {{Form::Call::kRecords},
            {Form::Call::kPackets, true, 8},
            {Form::Call::kPacket, false, 8},
            {Form::Call::kRecord}};
  }

  static std::vector<std::string> Configs() {
    std::vector<std::string> configs;
    for (const char* const budget : {"0", "20000", "default", "unlimited"}) {
      for (const char* const rest : {"threads=1", "threads=2,dacrt_piece_rays=64"}) {
        configs.push_back(std::string("dacrt_budget=") + budget + "," + rest);
      }
    }
    return configs;
  }

  TestScene description_;
  const EmbreeDevice alone_{DropIn(), "threads=1,dacrt_budget=0"};
  std::optional<EmbreeScene> plain_;
  std::vector<RTCRayHit> rays_;
};

std::string NameOfArithmetic(const testing::TestParamInfo<std::tuple<Arithmetic, float>>& info) {
  const float scale = std::get<float>(info.param);
  return std::string(std::get<Arithmetic>(info.param).name) + (scale == 1       ? ""
                                                               : scale < 1e-15f ? "Tiny"
                                                                                : "Small");
}

const auto kScales = testing::Values(1.0f, 1e-13f, 1e-20f);

INSTANTIATE_TEST_SUITE_P(
    , ArithmeticTest,
    testing::Combine(testing::Values(Arithmetic{"Default"}, Arithmetic{"FlushToZero", kFlushToZero},
                                     Arithmetic{"DenormalsAreZero", kDenormalsAreZero},
                                     Arithmetic{"Both", kFlushToZero | kDenormalsAreZero}),
                     kScales),
    NameOfArithmetic);

// A hit depends on what the caller's arithmetic makes of small numbers, and on nothing else: not on
// the threads, the pieces, the budget, the form and the size of the calls.
TEST_P(ArithmeticTest, IsTheCallersInEveryPartOfACall) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    for (const Form& form : Forms()) {
      const auto expected = Ask(*plain_, form, query, arithmetic());
      if (arithmetic().flags == 0 && std::get<float>(GetParam()) > 1e-15f) {
        EXPECT_GT(
            std::count_if(expected.begin(), expected.end(),
                          [](const RTCRayHit& r) { return r.hit.geomID == 0 || r.ray.tfar < 0; }),
            10);
      }
      for (const std::string& config : Configs()) {
        SCOPED_TRACE(config + ", " + Name(query) + ", " + Name(form));
        const EmbreeDevice device(DropIn(), config);
        const EmbreeScene scene(device, description_);
        EXPECT_EQ(FirstDifference(expected, Ask(scene, form, query, arithmetic())),
                  expected.size());
      }
    }
  }
}

class SplittingArithmeticTest : public ArithmeticTest {};

INSTANTIATE_TEST_SUITE_P(
    , SplittingArithmeticTest,
    testing::Combine(
        testing::Values(Arithmetic{"Both", kFlushToZero | kDenormalsAreZero},
                        Arithmetic{"Upward", 0, FE_UPWARD}, Arithmetic{"Downward", 0, FE_DOWNWARD},
                        Arithmetic{"TowardZero", 0, FE_TOWARDZERO},
                        Arithmetic{"AllAtOnce", kFlushToZero | kDenormalsAreZero, FE_DOWNWARD}),
        kScales),
    NameOfArithmetic);

// What is kept was made by whoever came first, and serves all: it does not matter with which
// arithmetic.
TEST_P(SplittingArithmeticTest, LeavesNoTraceInWhatIsKept) {
  const Arithmetic ordinary{"Default"};
  for (const std::string& config : Configs()) {
    if (config.starts_with("dacrt_budget=0")) continue;
    const EmbreeDevice device(DropIn(), config);
    std::optional<EmbreeScene> scene;
    {
      const WithArithmetic with_arithmetic(arithmetic());
      scene.emplace(device, description_);
    }
    for (const Query query : {Query::kClosest, Query::kAny}) {
      Ask(*scene, {Form::Call::kRecords}, query, arithmetic());
      Ask(*scene, {Form::Call::kRecord}, query, arithmetic());
    }
    for (const Query query : {Query::kClosest, Query::kAny}) {
      for (const Form& form : Forms()) {
        SCOPED_TRACE(config + ", " + Name(query) + ", " + Name(form));
        const auto expected = Ask(*plain_, form, query, ordinary);
        EXPECT_EQ(FirstDifference(expected, Ask(*scene, form, query, ordinary)), expected.size());
      }
    }
  }
}

#endif

}  // namespace
}  // namespace dacrt::tests

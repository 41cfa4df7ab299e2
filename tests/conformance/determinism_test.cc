// The same ray gets the same bits from the drop-in, whatever stands beside it in the batch, however
// the batch is handed over, whatever the settings, and whoever else is tracing.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <thread>

#include "contest.h"
#include "random.h"

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

}  // namespace
}  // namespace dacrt::tests

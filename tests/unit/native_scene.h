// A soup of triangles over the API as a program meets it, and what its rays should find.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "dacrt/dacrt.h"
#include "unit_test.h"

namespace dacrt {

/// What programs have of their own.
struct Vector {
  float x, y, z;
};

inline bool SameBits(const RayHit& a, const RayHit& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

inline std::vector<RayHit> MakeRayHits(uint64_t seed, std::size_t count) {
  unit::Random random(seed);
  std::vector<RayHit> rays(count);
  for (auto& [ray, hit] : rays) {
    const unit::Float3 org = random.InCube(-1, 1), dir = random.Direction();
    std::ranges::copy(org, ray.org);
    std::ranges::copy(dir, ray.dir);
  }
  return rays;
}

class NativeTest : public testing::Test {
 protected:
  std::size_t CountHits(const std::vector<RayHit>& rays) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(rays, [](const RayHit& ray) { return bool(ray.hit); }));
  }

  void ExpectSame(const std::vector<RayHit>& rays) const {
    ASSERT_EQ(rays.size(), found_.size());
    for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(SameBits(rays[i], found_[i])) << i;
  }

  void SetUp() override {
    unit::Random random(1);
    mesh_ = unit::MakeSoup(random, 500, 1, 0.4f);
    scene_ = std::make_unique<Scene>(device_, Triangles(mesh_.vertices, mesh_.triangles, 7));
    scene_->ClosestHits(found_);
    ASSERT_GT(CountHits(found_), 300u);
    ASSERT_LT(CountHits(found_), found_.size());
  }

  unit::Mesh mesh_;
  const std::shared_ptr<Device> device_ = std::make_shared<Device>();
  std::unique_ptr<Scene> scene_;
  const std::vector<RayHit> rays_ = MakeRayHits(2, 1001);
  std::vector<RayHit> found_ = rays_;
};

}  // namespace dacrt

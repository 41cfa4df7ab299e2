// Calls from several threads at once: the answers are those of one thread.
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <functional>
#include <thread>
#include <vector>

#include "model.h"

namespace dacrt::tests {
namespace {

constexpr int kThreads = 4;

/// Runs `body(thread number)` on kThreads threads at once.
void OnThreads(const std::function<void(int)>& body) {
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) threads.emplace_back(body, i);
  for (std::thread& thread : threads) thread.join();
}

/// A committed scene of `count` small triangles at random places in the unit cube.
RTCScene TriangleSoup(Session& s, unsigned int seed, unsigned int count) {
  const RTCGeometry geometry = UncommittedSoup(s, seed, count, 0.05f);
  s.api.rtcCommitGeometry(geometry);
  return s.SceneOf(geometry);
}

std::vector<RTCRayHit> Answer(Session& s, RTCScene scene, std::vector<RTCRayHit> rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  s.api.rtcIntersect1M(scene, &context, rays.data(), static_cast<unsigned int>(rays.size()),
                       sizeof rays[0]);
  return rays;
}

bool AreEqual(const std::vector<RTCRayHit>& a, const std::vector<RTCRayHit>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST(Concurrency, ThreadsTraceOneScene) {
  Session s(DropIn());
  const RTCScene scene = TriangleSoup(s, 1, 5000);
  const std::size_t sizes[kThreads] = {1, 300, 5000, 40000};
  std::vector<std::vector<RTCRayHit>> expected;
  for (int i = 0; i < kThreads; ++i) {
    expected.push_back(Answer(s, scene, RandomRays(i, sizes[i])));
  }
  OnThreads([&](int i) {
    for (int repeat = 0; repeat < 10; ++repeat) {
      EXPECT_TRUE(AreEqual(Answer(s, scene, RandomRays(i, sizes[i])), expected[i]));
    }
  });
}

TEST(Concurrency, ThreadsMakeAndTraceScenesOfTheirOwn) {
  Session s(DropIn());
  std::vector<std::vector<RTCRayHit>> expected;
  for (int i = 0; i < kThreads; ++i) {
    expected.push_back(Answer(s, TriangleSoup(s, 10 + i, 2000), RandomRays(i, 5000)));
  }
  OnThreads([&](int i) {
    for (int repeat = 0; repeat < 5; ++repeat) {
      Session own(DropIn());
      EXPECT_TRUE(
          AreEqual(Answer(own, TriangleSoup(own, 10 + i, 2000), RandomRays(i, 5000)), expected[i]));
    }
  });
}

TEST(Concurrency, ThreadsAttachToOneSceneAndCommitItTogether) {
  Session s(DropIn());
  constexpr int kEach = 50;
  const RTCScene scene = s.NewScene();
  std::vector<RTCGeometry> geometries;
  for (int i = 0; i < kThreads * kEach; ++i) {
    geometries.push_back(s.Triangle(static_cast<float>(i)));
  }
  OnThreads([&](int thread) {
    for (int i = 0; i < kEach; ++i) {
      const RTCGeometry geometry = geometries[thread * kEach + i];
      const unsigned int id = s.api.rtcAttachGeometry(scene, geometry);
      EXPECT_EQ(s.api.rtcGetGeometryThreadSafe(scene, id), geometry);
    }
  });
  std::vector<unsigned int> hits(kThreads);
  OnThreads([&](int thread) {
    s.api.rtcJoinCommitScene(scene);
    hits[thread] = s.HitGeometry(scene);  // Committed whichever thread did it.
  });
  for (const unsigned int hit : hits) {
    EXPECT_EQ(s.api.rtcGetGeometry(scene, hit), geometries[0]);
  }
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

TEST(Concurrency, ReferencesAreCountedFromAnyThread) {
  const Api& api = DropIn();
  Session s(api);
  const RTCScene scene = s.SceneOf(s.Triangle());
  OnThreads([&](int) {
    for (int i = 0; i < 1000; ++i) {
      api.rtcRetainScene(scene);
      const RTCGeometry geometry = api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_TRIANGLE);
      api.rtcReleaseGeometry(geometry);
      api.rtcReleaseScene(scene);
    }
  });
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

// The threads of a device came, in one call, to an instance whose scene another call was just
// splitting, and waited for it, while that call waited for a free thread to help.
TEST(Concurrency, ASceneIsSplitWhileItIsTracedThroughAnInstance) {
  Session s(DropIn());
  // Large enough for several threads to split it, and rays enough for all threads.
  const std::vector<RTCRayHit> rays = RandomRays(1, 20000);
  std::vector<RTCRayHit> expected;
  for (int repeat = 0; repeat < 30; ++repeat) {
    Session own(DropIn());
    const RTCScene inner = TriangleSoup(own, 1, 100000);
    const RTCGeometry instance = Instance(own, inner);
    own.api.rtcCommitGeometry(instance);
    const RTCScene outer = own.SceneOf(instance);
    std::vector<RTCRayHit> through_instance, direct;
    std::thread first([&] { through_instance = Answer(own, outer, rays); });
    // At another moment of the other call each time.
    std::this_thread::sleep_for(std::chrono::microseconds(40 * repeat));
    direct = Answer(own, inner, rays);
    first.join();
    if (expected.empty()) expected = direct;
    EXPECT_TRUE(AreEqual(direct, expected));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(through_instance[i].hit.primID, direct[i].hit.primID);
    }
  }
}

}  // namespace
}  // namespace dacrt::tests

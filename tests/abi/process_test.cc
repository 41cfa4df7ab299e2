// What happens to processes: one that forks, one that ends during a call, and one that takes the
// library in and out. Each in a process of its own that is ended if it hangs.
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "in_process.h"

namespace {

using dacrt::tests::Ending;
using dacrt::tests::RunInProcess;

void ExpectDone(const Ending& ending) {
  EXPECT_STREQ(ending.Complaint(), nullptr) << "exit code " << WEXITSTATUS(ending.status);
}

/// The library, as a program has it that opens it by its path.
struct Library {
  void* handle = dlopen(DACRT_DROP_IN, RTLD_NOW | RTLD_LOCAL);
#define DACRT_TEST_CALL(name) \
  decltype(&::name) name = reinterpret_cast<decltype(&::name)>(dlsym(handle, #name))
  DACRT_TEST_CALL(rtcNewDevice);
  DACRT_TEST_CALL(rtcReleaseDevice);
  DACRT_TEST_CALL(rtcNewScene);
  DACRT_TEST_CALL(rtcReleaseScene);
  DACRT_TEST_CALL(rtcNewGeometry);
  DACRT_TEST_CALL(rtcReleaseGeometry);
  DACRT_TEST_CALL(rtcSetNewGeometryBuffer);
  DACRT_TEST_CALL(rtcCommitGeometry);
  DACRT_TEST_CALL(rtcAttachGeometry);
  DACRT_TEST_CALL(rtcCommitScene);
  DACRT_TEST_CALL(rtcIntersect1M);
#undef DACRT_TEST_CALL
};

/// A scene whose split and calls are worth several threads.
class TracedScene {
 public:
  explicit TracedScene(const Library& library)
      : library_(library), device_(library.rtcNewDevice("threads=0")) {
    scene_ = library.rtcNewScene(device_);
    const RTCGeometry geometry = library.rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* const vertices = static_cast<float*>(library.rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * kTriangles));
    auto* const indices = static_cast<unsigned*>(library.rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, kTriangles));
    for (unsigned i = 0; i < 3 * kTriangles; ++i) {
      const float corner[3] = {static_cast<float>(i / 3 % 200) + (i % 3 == 1 ? 0.9f : 0),
                               static_cast<float>(i / 600) + (i % 3 == 2 ? 0.9f : 0), 0};
      std::memcpy(vertices + std::size_t{3} * i, corner, sizeof(corner));
      indices[i] = i;
    }
    library.rtcCommitGeometry(geometry);
    library.rtcAttachGeometry(scene_, geometry);
    library.rtcReleaseGeometry(geometry);
    library.rtcCommitScene(scene_);
  }
  ~TracedScene() {
    library_.rtcReleaseScene(scene_);
    library_.rtcReleaseDevice(device_);
  }
  TracedScene(const TracedScene&) = delete;
  TracedScene& operator=(const TracedScene&) = delete;

  /// Whether each of 20,000 rays hits the triangle that it is aimed at.
  bool Trace() const {
    std::vector<RTCRayHit> rays(kTriangles);
    for (unsigned i = 0; i < kTriangles; ++i) {
      RTCRayHit& r = rays[i];
      r.ray = {static_cast<float>(i % 200) + 0.2f,
               static_cast<float>(i / 200) + 0.2f,
               -1,
               0,
               0,
               0,
               1,
               0,
               9,
               UINT32_MAX,
               0,
               0};
      r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    library_.rtcIntersect1M(scene_, &context, rays.data(), kTriangles, sizeof(rays[0]));
    for (unsigned i = 0; i < kTriangles; ++i) {
      if (rays[i].hit.primID != i) return false;
    }
    return true;
  }

 private:
  static constexpr unsigned kTriangles = 20'000;
  const Library& library_;
  RTCDevice device_;
  RTCScene scene_;
};

// A child has none of the threads that its parent had.
TEST(Process, AForkedOneTracesAnOldSceneAndANewOne) {
  ExpectDone(RunInProcess([] {
    const Library library;
    const TracedScene scene(library);
    if (!scene.Trace()) _exit(3);
    const Ending child = RunInProcess([&] {
      if (!scene.Trace()) _exit(4);
      const TracedScene own(library);
      if (!own.Trace()) _exit(5);
    });
    if (child.Complaint() || !scene.Trace()) _exit(6);
  }));
}

TEST(Process, EndsDuringCalls) {
  for (int repeat = 0; repeat < 5; ++repeat) {
    ExpectDone(RunInProcess([] {
      // Neither is there to be released when the process ends.
      const auto& library = *new Library;
      const auto& scene = *new TracedScene(library);
      std::atomic<int> calls{0};
      for (int i = 0; i < 3; ++i) {
        std::thread([&] {
          while (scene.Trace()) ++calls;
          _exit(3);
        }).detach();
      }
      while (calls < 4) std::this_thread::yield();
      std::exit(0);
    }));
  }
}

// Threads of oneTBB ran on where the library, and oneTBB with it, had been.
TEST(Process, TakesTheLibraryInAndOut) {
  ExpectDone(RunInProcess([] {
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Library library;
      {
        const TracedScene scene(library);
        if (!scene.Trace()) _exit(3);
      }
      dlclose(library.handle);
    }
  }));
}

}  // namespace

// The promise about memory: a call takes no more than Scene::WorkspaceBytes says, counted in three
// ways: what the device says that it holds, what goes through operator new, and what the system
// says of the process.

#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>

#include "dacrt/dacrt.h"
#include "unit_test.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DACRT_TEST_SANITIZED 1
#else
#define DACRT_TEST_SANITIZED 0
#endif

namespace {

std::atomic<std::size_t> heap_bytes{0};
std::atomic<std::size_t> heap_peak{0};

[[maybe_unused]] void* Count(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  const std::size_t bytes = heap_bytes += malloc_usable_size(memory);
  std::size_t peak = heap_peak;
  while (peak < bytes && !heap_peak.compare_exchange_weak(peak, bytes)) {
  }
  return memory;
}

[[maybe_unused]] void Release(void* memory) {
  heap_bytes -= malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace

#if !DACRT_TEST_SANITIZED
void* operator new(std::size_t bytes) { return Count(std::malloc(bytes)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  const std::size_t a = static_cast<std::size_t>(alignment);
  return Count(std::aligned_alloc(a, (bytes + a - 1) / a * a));
}
void operator delete(void* memory) noexcept { Release(memory); }
void operator delete(void* memory, std::size_t) noexcept { Release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { Release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { Release(memory); }
#endif

namespace dacrt {
namespace {

using unit::Mesh;
using unit::Random;
using unit::Ray;

/// What a call may take beside the workspace: the pool's record of it on the heap, and pages of the
/// stack, of the library and of its tables that are touched for the first time.
constexpr std::size_t kHeapAllowance = 4 * 1024;
constexpr std::size_t kProcessAllowance = 512 * 1024;

/// A line of /proc/self/status in bytes; 0 if there is none.
std::size_t StatusBytes(const std::string& key) {
  std::FILE* file = std::fopen("/proc/self/status", "r");
  if (file == nullptr) return 0;
  std::size_t kilobytes = 0;
  for (char line[256]; std::fgets(line, sizeof(line), file) != nullptr;) {
    if (std::string(line).starts_with(key)) {
      kilobytes = std::strtoull(line + key.size(), nullptr, 10);
    }
  }
  std::fclose(file);
  return kilobytes * 1024;
}

/// Makes the process's peak its present size. False where the system does not let it.
bool ResetPeak() {
  std::FILE* file = std::fopen("/proc/self/clear_refs", "w");
  if (file == nullptr) return false;
  const bool written = std::fputs("5", file) >= 0;
  return std::fclose(file) == 0 && written;
}

struct Case {
  Algorithm algorithm;
  Query query;
  std::size_t triangles;
  std::size_t rays;
  uint32_t piece_rays;
};

class MemoryTest : public testing::TestWithParam<Case> {};

TEST_P(MemoryTest, ACallTakesNoMoreThanTheFormulaSays) {
  const Case& parameters = GetParam();
  Random random(1);
  const Mesh mesh = unit::MakeSoup(random, parameters.triangles, 1, 0.05f);
  const TriangleMesh mesh_view = mesh.View();
  auto rays = unit::MakeRays(random, parameters.rays, 1);
  const RayView view = ViewOf(rays);

  Settings settings;
  settings.algorithm = parameters.algorithm;
  settings.piece_rays = parameters.piece_rays;
  const auto device = std::make_shared<Device>(settings);
  const Scene scene(device, {&mesh_view, 1});
  const std::size_t promised = scene.WorkspaceBytes(parameters.rays);
  EXPECT_EQ(promised, device->WorkspaceBytes(parameters.triangles, parameters.rays));

  const bool has_peak = ResetPeak();
  const std::size_t process_before = StatusBytes("VmRSS:");
  const std::size_t heap_before = heap_bytes;
  heap_peak = heap_before;
  scene.Trace(parameters.query, view);
  const std::size_t heap_after = heap_peak;
  const std::size_t process_peak = StatusBytes("VmHWM:");

  EXPECT_EQ(device->WorkspaceBytesHeld(), promised);
  if (DACRT_TEST_SANITIZED) return;
  EXPECT_GE(heap_after, heap_before);
  EXPECT_LE(heap_after - heap_before, kHeapAllowance);
  if (has_peak && process_peak > 0) {
    EXPECT_LE(process_peak, process_before + promised + kProcessAllowance);
  }

  // The workspace is kept and serves calls that need no more without another byte.
  scene.Trace(parameters.query, view);
  EXPECT_EQ(device->WorkspaceBytesHeld(), promised);
  device->ReleaseIdleWorkspaces();
  EXPECT_EQ(device->WorkspaceBytesHeld(), 0u);
}

constexpr uint32_t kOnePiece = 1u << 30;

INSTANTIATE_TEST_SUITE_P(
    Calls, MemoryTest,
    testing::Values(Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece},
                    Case{Algorithm::kNabata2013, Query::kAny, 100000, 200000, kOnePiece},
                    Case{Algorithm::kNabata2013, Query::kClosest, 1000, 200000, 1000},
                    Case{Algorithm::kNabata2013, Query::kClosest, 100000, 10, kOnePiece},
                    Case{Algorithm::kNabata2013, Query::kClosest, 1, 1, 64},
                    Case{Algorithm::kAfra2012, Query::kClosest, 30000, 100000, kOnePiece},
                    Case{Algorithm::kMora2011, Query::kClosest, 30000, 100000, kOnePiece}),
    [](const auto& info) {
      const Case& c = info.param;
      return std::string(Name(c.algorithm)) + (c.query == Query::kAny ? "Any" : "Closest") +
             std::to_string(c.triangles) + "Triangles" + std::to_string(c.rays) + "Rays" +
             std::to_string(info.index);
    });

// As many workspaces as there were calls at once, each for its own size: here there is one.
TEST(MemoryGrowthTest, AWorkspaceGrowsToTheLargestCall) {
  Random random(2);
  const Mesh mesh = unit::MakeSoup(random, 1000, 1, 0.1f);
  const TriangleMesh mesh_view = mesh.View();
  const auto device = std::make_shared<Device>();
  const Scene scene(device, {&mesh_view, 1});
  std::size_t largest = 0;
  for (const std::size_t count : {10u, 5000u, 100u, 20000u, 1u}) {
    auto rays = unit::MakeRays(random, count, 1);
    scene.Trace(Query::kAny, ViewOf(rays));
    largest = std::max(largest, scene.WorkspaceBytes(count));
    EXPECT_EQ(device->WorkspaceBytesHeld(), largest);
  }
}

}  // namespace
}  // namespace dacrt

// The promise about memory: a call takes no more than Scene::WorkspaceBytes says, and a scene no
// more than Scene::KeptBytes, counted in three ways: what the device says that it holds, what goes
// through operator new, and what the system says of the process.

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <numeric>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "dacrt/dacrt.h"
#include "partition/grid.h"
#include "runtime/tasks.h"
#include "sanitized.h"
#include "unit_test.h"

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

/// Each thread more has its list of workspaces, its counters and its tasks.
std::size_t HeapAllowance(std::size_t threads) { return kHeapAllowance * threads; }

std::size_t GridBytes(std::size_t triangles, std::size_t threads) {
  return Grid::Bytes(triangles, Grid::PartsFor(triangles, TaskPool(threads).threads()));
}

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

/// Makes the process's peak its present size. False where the system does not let it, and where
/// there is more in the process than the test.
bool ResetPeak() {
  if (DACRT_TEST_EMULATED) return false;
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
  uint64_t budget = 0;
  uint32_t threads = 1;
};

class MemoryTest : public testing::TestWithParam<Case> {};

TEST_P(MemoryTest, ACallTakesNoMoreThanTheFormulaSays) {
  const Case& parameters = GetParam();
  Random random(1);
  const Mesh mesh = unit::MakeSoup(random, parameters.triangles, 1, 0.05f);
  const TriangleMesh mesh_view = mesh.View();
  auto rays = unit::MakeRays(random, parameters.rays, 1);
  const auto before = rays;
  const RayView view = ViewOf(rays);

  Settings settings;
  settings.algorithm = parameters.algorithm;
  settings.piece_rays = parameters.piece_rays;
  settings.budget = parameters.budget;
  settings.threads = parameters.threads;
  const auto device = std::make_shared<Device>(settings);
  // A device like it starts the threads, whose stacks belong to no call.
  if (parameters.threads > 1) {
    Scene(std::make_shared<Device>(settings), {&mesh_view, 1}).Trace(parameters.query, view);
    rays = before;
  }

  // The triangles of a partition are listed when the scene is made; the rest of it grows while rays
  // are traced. Both count.
  const bool has_peak = ResetPeak();
  const std::size_t process_before = StatusBytes("VmRSS:");
  const std::size_t heap_before = heap_bytes;
  const Scene scene(device, {&mesh_view, 1});
  const std::size_t promised = scene.WorkspaceBytes(parameters.rays);
  const std::size_t kept = scene.KeptBytes();
  EXPECT_EQ(promised, device->WorkspaceBytes(parameters.triangles, parameters.rays));
  EXPECT_EQ(kept > 0, parameters.budget > 0);
  EXPECT_LE(kept, parameters.budget);
  const std::size_t heap_of_scene = heap_bytes - heap_before;
  heap_peak = heap_bytes.load();
  scene.Trace(parameters.query, view);
  const std::size_t heap_after = heap_peak;
  const std::size_t process_peak = StatusBytes("VmHWM:");

  // Beside the workspaces a call over a partition has grids, which are gone when it returns.
  const std::size_t held = device->WorkspaceBytesHeld();
  EXPECT_GT(held, 0u);
  if (kept == 0) {
    EXPECT_EQ(held, promised);
  } else {
    EXPECT_EQ(held, promised - GridBytes(parameters.triangles, parameters.threads));
  }
  EXPECT_LE(scene.KeptBytesUsed(), kept);
  if (DACRT_TEST_SANITIZED) return;
  EXPECT_LE(heap_of_scene, kHeapAllowance);
  EXPECT_GE(heap_after, heap_before);
  EXPECT_LE(heap_after - heap_before, HeapAllowance(parameters.threads));
  if (has_peak && process_peak > 0) {
    EXPECT_LE(process_peak, process_before + promised + kept + kProcessAllowance);
  }

  // The workspaces are kept and serve calls that need no more without another byte.
  scene.Trace(parameters.query, view);
  EXPECT_EQ(device->WorkspaceBytesHeld(), held);
  device->ReleaseIdleWorkspaces();
  EXPECT_EQ(device->WorkspaceBytesHeld(), 0u);
}

constexpr uint32_t kOnePiece = 1u << 30;

INSTANTIATE_TEST_SUITE_P(
    Calls, MemoryTest,
    testing::Values(
        // Nothing is kept.
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece},
        Case{Algorithm::kNabata2013, Query::kAny, 100000, 200000, kOnePiece},
        Case{Algorithm::kNabata2013, Query::kClosest, 1000, 200000, 1000},
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 10, kOnePiece},
        Case{Algorithm::kNabata2013, Query::kClosest, 1, 1, 64},
        Case{Algorithm::kAfra2012, Query::kClosest, 30000, 100000, kOnePiece},
        Case{Algorithm::kMora2011, Query::kClosest, 30000, 100000, kOnePiece},
        // A kept partition: of every size, and less of it than there could be.
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece, kDefaultBudget},
        Case{Algorithm::kNabata2013, Query::kAny, 100000, 200000, kOnePiece, kDefaultBudget},
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece, kUnlimitedBudget},
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece, 550000},
        Case{Algorithm::kNabata2013, Query::kClosest, 1000, 200000, 1000, kDefaultBudget},
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 10, kOnePiece, kDefaultBudget},
        Case{Algorithm::kNabata2013, Query::kClosest, 1, 1, 64, kDefaultBudget},
        // Several threads, each with a workspace.
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece, kDefaultBudget, 2},
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece, kDefaultBudget, 8},
        Case{Algorithm::kNabata2013, Query::kAny, 100000, 3000, kOnePiece, kUnlimitedBudget, 8},
        // Pieces for which less would do than what is reserved when a scene is made.
        Case{Algorithm::kNabata2013, Query::kAny, 100000, 600, kOnePiece, kDefaultBudget, 2},
        Case{Algorithm::kNabata2013, Query::kClosest, 100000, 200000, kOnePiece, 0, 8}),
    [](const auto& info) {
      const Case& c = info.param;
      return std::string(Name(c.algorithm)) + (c.query == Query::kAny ? "Any" : "Closest") +
             std::to_string(c.triangles) + "Triangles" + std::to_string(c.rays) + "Rays" +
             std::to_string(info.index);
    });

/// A scene of a soup, and what the device says that it takes, by the monitor.
class MonitoredScene {
 public:
  explicit MonitoredScene(Settings settings, std::size_t triangles = 30000) {
    Random random(3);
    mesh_ = unit::MakeSoup(random, triangles, 1, 0.05f);
    device = std::make_shared<Device>(settings, [this](std::ptrdiff_t bytes) {
      const std::ptrdiff_t now = bytes_ += bytes;
      std::ptrdiff_t before = peak_;
      while (before < now && !peak_.compare_exchange_weak(before, now)) {
      }
      return true;
    });
    const TriangleMesh view = mesh_.View();
    scene = std::make_unique<Scene>(device, std::span(&view, 1));
  }

  std::size_t peak() const { return static_cast<std::size_t>(peak_.load()); }

 private:
  Mesh mesh_;
  std::atomic<std::ptrdiff_t> bytes_{0}, peak_{0};

 public:
  std::shared_ptr<Device> device;
  std::unique_ptr<Scene> scene;
};

/// Single rays and packets of 16 in the order of PacketComponent.
void TracePackets(const Scene& scene, const std::vector<Ray>& rays, uint32_t lanes) {
  std::array<float, kPacketComponents * 16> values{};
  for (std::size_t i = 0; i + lanes <= rays.size(); i += lanes) {
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      const Ray& ray = rays[i + lane];
      const auto set = [&](PacketComponent component, float value) {
        values[static_cast<std::size_t>(component) * lanes + lane] = value;
      };
      set(PacketComponent::kOrgX, ray.org[0]);
      set(PacketComponent::kOrgY, ray.org[1]);
      set(PacketComponent::kOrgZ, ray.org[2]);
      set(PacketComponent::kDirX, ray.dir[0]);
      set(PacketComponent::kDirY, ray.dir[1]);
      set(PacketComponent::kDirZ, ray.dir[2]);
      set(PacketComponent::kTfar, unit::kInfinity);
    }
    RayPacket packet;
    packet.values = values.data();
    packet.lanes = lanes;
    packet.has_masks = false;
    scene.Trace(Query::kClosest, packet);
  }
}

// A short call works on the stack, and borrows the workspace that was reserved when the scene was
// made, to split subsets in. When it is all split, calls take not a byte of the heap.
TEST(MemoryShortCallTest, TakesNothingBesideTheFloor) {
  Random random(4);
  const auto rays = unit::MakeRays(random, 2048, 1);
  for (const uint64_t budget : {uint64_t{1}, kDefaultBudget, kUnlimitedBudget}) {
    for (const std::size_t count : {1u, 16u, 64u, 256u}) {
      Settings settings;
      settings.budget = budget;
      settings.threads = 1;
      const MonitoredScene monitored(settings);
      const Scene& scene = *monitored.scene;
      const std::size_t held = monitored.device->WorkspaceBytesHeld();
      const auto trace_all = [&] {
        if (count <= 16) return TracePackets(scene, rays, static_cast<uint32_t>(count));
        auto copy = std::vector<Ray>(rays.begin(), rays.begin() + 2048);
        heap_peak = heap_bytes.load();
        const std::size_t calls = budget == 1 ? 1 : copy.size() / count;
        for (std::size_t i = 0; i < calls; ++i) {
          scene.Trace(Query::kClosest, unit::ViewOf(std::span(copy).subspan(i * count, count)));
        }
      };
      trace_all();
      EXPECT_EQ(monitored.device->WorkspaceBytesHeld(), held);
      EXPECT_LE(monitored.device->WorkspaceBytesHeld(), scene.WorkspaceBytes(count));
      EXPECT_LE(monitored.peak(), scene.WorkspaceBytes(count) + scene.KeptBytes());
      EXPECT_LE(scene.KeptBytesUsed(), scene.KeptBytes());
      if (DACRT_TEST_SANITIZED || budget == 1) continue;
      heap_peak = heap_bytes.load();
      const std::size_t before = heap_peak;
      trace_all();
      if (count > 16) continue;  // whose copy is on the heap
      EXPECT_EQ(heap_peak, before) << count << " rays a call";
    }
  }
}

// The same for streams, whose rays stand outside of what is counted.
TEST(MemoryShortCallTest, StreamsTakeNothingOfTheHeap) {
  if (DACRT_TEST_SANITIZED) GTEST_SKIP();
  Random random(5);
  const MonitoredScene monitored(Settings{});
  auto rays = unit::MakeRays(random, 256, 1);
  const auto before = rays;
  monitored.scene->Trace(Query::kClosest, unit::ViewOf(rays));
  rays = before;
  heap_peak = heap_bytes.load();
  const std::size_t heap_before = heap_peak;
  monitored.scene->Trace(Query::kClosest, unit::ViewOf(rays));
  EXPECT_EQ(heap_peak, heap_before);
}

// Several threads that come at once each borrow a workspace of their own, no larger than the floor.
TEST(MemoryShortCallTest, ThreadsBorrowOneEach) {
  Random random(6);
  const auto rays = unit::MakeRays(random, 1024, 1);
  constexpr std::size_t kThreads = 4;
  const MonitoredScene monitored(Settings{});
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] { TracePackets(*monitored.scene, rays, 1); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(monitored.device->WorkspaceBytesHeld(), kThreads * monitored.scene->WorkspaceBytes(1));
}

// With instances, whose rays need room of their own.
TEST(MemoryInstanceTest, ACallTakesNoMoreThanTheFormulaSays) {
  Random random(7);
  const Mesh mesh = unit::MakeSoup(random, 20000, 1, 0.05f);
  for (const uint64_t budget : {uint64_t{1}, kDefaultBudget}) {
    for (const std::size_t count : {10u, 300u, 50000u}) {
      Settings settings;
      settings.budget = budget;
      settings.threads = 1;
      const auto device = std::make_shared<Device>(settings);
      Geometry triangles;
      triangles.vertices = {{mesh.vertices.data(), 12}};
      triangles.vertex_count = mesh.vertices.size();
      triangles.primitives = {mesh.triangles.data(), 12};
      triangles.primitive_count = mesh.triangles.size();
      const auto inner =
          std::make_shared<Scene>(device, std::span<const Geometry>(&triangles, 1), SceneOptions{});
      std::vector<Geometry> instances(3);
      for (uint32_t i = 0; i < 3; ++i) {
        instances[i].shape = Shape::kInstance;
        instances[i].geometry_id = i;
        instances[i].primitive_count = 1;
        instances[i].instanced_scene = inner;
        instances[i].transforms.resize(1);
        instances[i].transforms[0].matrix.column[3][0] = static_cast<float>(i);
      }
      const Scene scene(device, instances, SceneOptions{});
      auto rays =
          unit::MakeRays(random, budget == 1 ? std::min(count, std::size_t{2000}) : count, 1);
      heap_peak = heap_bytes.load();
      const std::size_t heap_before = heap_peak;
      scene.Trace(Query::kClosest, unit::ViewOf(rays));
      EXPECT_LE(device->WorkspaceBytesHeld() + GridBytes(mesh.triangles.size(), 1),
                scene.WorkspaceBytes(rays.size()));
      if (!DACRT_TEST_SANITIZED) {
        EXPECT_LE(heap_peak - heap_before, kHeapAllowance);
      }
      EXPECT_LE(inner->KeptBytesUsed(), inner->KeptBytes());
      EXPECT_LE(scene.KeptBytesUsed(), scene.KeptBytes());
    }
  }
}

// As many workspaces as there were threads at once, each for its own size: here there is one.
TEST(MemoryGrowthTest, AWorkspaceGrowsToTheLargestCall) {
  Random random(2);
  const Mesh mesh = unit::MakeSoup(random, 1000, 1, 0.1f);
  const TriangleMesh mesh_view = mesh.View();
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    settings.threads = 1;
    const auto device = std::make_shared<Device>(settings);
    const Scene scene(device, {&mesh_view, 1});
    const std::size_t grid = budget == 0 ? 0 : GridBytes(mesh.triangles.size(), 1);
    std::size_t largest = 0;
    for (const std::size_t count : {10u, 5000u, 100u, 20000u, 1u}) {
      auto rays = unit::MakeRays(random, count, 1);
      scene.Trace(Query::kAny, ViewOf(rays));
      largest = std::max(largest, scene.WorkspaceBytes(count) - grid);
      EXPECT_EQ(device->WorkspaceBytesHeld(), largest);
    }
  }
}

/// A device that logs what it tells, and refuses what `refuses` says.
class Monitored {
 public:
  std::vector<std::ptrdiff_t> log;
  std::function<bool(std::ptrdiff_t)> refuses = [](std::ptrdiff_t) { return false; };

  explicit Monitored(uint32_t threads = 1) {
    Settings settings;
    settings.threads = threads;
    device = std::make_shared<Device>(settings, [this](std::ptrdiff_t bytes) {
      const std::lock_guard lock(mutex_);
      if (bytes > 0 && refuses(bytes)) return false;
      log.push_back(bytes);
      return true;
    });
  }

  std::size_t Times(std::size_t bytes, int sign) const {
    const auto told = sign * static_cast<std::ptrdiff_t>(bytes);
    return static_cast<std::size_t>(std::count(log.begin(), log.end(), told));
  }

 private:
  std::mutex mutex_;

 public:
  std::shared_ptr<Device> device;
};

// It was told when the memory had been taken, by the drop-in only.
TEST(MemoryMonitorTest, IsAskedBeforeASceneKeepsSomething) {
  Random random(5);
  const Mesh mesh = unit::MakeSoup(random, 30000, 1, 0.05f);
  const TriangleMesh view = mesh.View();
  Monitored monitored;
  std::size_t kept;
  {
    const Scene scene(monitored.device, {&view, 1});
    kept = scene.KeptBytes();
    EXPECT_EQ(monitored.Times(kept, 1), 1u);
    EXPECT_EQ(monitored.Times(kept, -1), 0u);
  }
  EXPECT_EQ(monitored.Times(kept, -1), 1u);
  monitored.refuses = [&](std::ptrdiff_t bytes) {
    return bytes == static_cast<std::ptrdiff_t>(kept);
  };
  EXPECT_THROW(Scene(monitored.device, {&view, 1}), std::bad_alloc);
  EXPECT_EQ(monitored.Times(kept, 1), 1u);
  monitored.device->ReleaseIdleWorkspaces();
  EXPECT_EQ(std::accumulate(monitored.log.begin(), monitored.log.end(), std::ptrdiff_t{0}), 0);
}

/// A mesh that is not sorted by a grid while it is listed: one triangle cannot be hit.
Mesh MakeUnsorted(Random& random, std::size_t triangles) {
  Mesh mesh = unit::MakeSoup(random, triangles, 1, 0.05f);
  mesh.vertices.back()[0] = std::numeric_limits<float>::infinity();
  return mesh;
}

// It never heard of them.
TEST(MemoryMonitorTest, IsAskedBeforeAGridIsMade) {
  Random random(6);
  constexpr std::size_t kTriangles = 100001;
  const Mesh mesh = MakeUnsorted(random, kTriangles);
  const TriangleMesh view = mesh.View();
  for (const uint32_t threads : {1u, 2u}) {
    Monitored monitored(threads);
    const Scene scene(monitored.device, {&view, 1});
    const std::size_t grid = GridBytes(kTriangles - 1, threads);
    EXPECT_EQ(monitored.Times(grid, 1), 0u);
    auto rays = unit::MakeRays(random, 1000, 1);
    scene.Trace(Query::kClosest, unit::ViewOf(rays));
    EXPECT_EQ(monitored.Times(grid, 1), 1u);
    EXPECT_EQ(monitored.Times(grid, -1), 1u);
  }
}

// What was reserved when the scenes were made suffices: the hits are the same, and what there is no
// memory for a grid for is split without one. Every ray was tested against every triangle.
TEST(MemoryMonitorTest, CallsDoWithoutGridsIfItRefusesThem) {
  Random random(7);
  const Mesh mesh = MakeUnsorted(random, 100000);
  const TriangleMesh view = mesh.View();
  const auto rays = unit::MakeRays(random, 3000, 1);
  const auto trace = [&](bool refuses, bool through_instance) {
    Monitored monitored(2);
    const auto scene = std::make_shared<Scene>(monitored.device, std::span(&view, 1));
    Geometry instance;
    instance.shape = Shape::kInstance;
    instance.geometry_id = 7;
    instance.primitive_count = 1;
    instance.instanced_scene = scene;
    instance.transforms.resize(1);
    const Scene outer(monitored.device, std::span(&instance, 1), {});
    const std::size_t used = scene->KeptBytesUsed();
    monitored.refuses = [&](std::ptrdiff_t) { return refuses; };
    auto traced = rays;
    (through_instance ? outer : *scene).Trace(Query::kClosest, unit::ViewOf(traced));
    EXPECT_GT(scene->KeptBytesUsed(), used + mesh.triangles.size());
    return traced;
  };
  for (const bool through_instance : {false, true}) {
    const auto expected = trace(false, through_instance);
    const auto actual = trace(true, through_instance);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_TRUE(SameBits(actual[i], expected[i])) << i;
    }
  }
}

}  // namespace
}  // namespace dacrt

// Memory that is handed on, and what the account, the system and the process know of it.
#include "runtime/spare_pages.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "address_space_limit.h"
#include "unit_test.h"

namespace dacrt {
namespace {

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

/// Of pages that were kept just now.
std::byte* KeepSome(SparePages& spare, std::size_t bytes) {
  Pages pages = spare.Take(bytes, nullptr);
  std::byte* const data = pages.data();
  data[bytes - 1] = std::byte{1};
  spare.Keep(std::move(pages));
  return data;
}

TEST(SparePagesTest, WhatOneHadIsTheNextOnes) {
  std::ptrdiff_t told = 0;
  const MemoryAccount account([&](std::ptrdiff_t bytes) {
    told += bytes;
    return true;
  });
  SparePages spare;
  Pages first = spare.Take(4 * kMegabyte, &account);
  std::byte* const place = first.data();
  EXPECT_EQ(told, 4 * kMegabyte);
  spare.Keep(std::move(first));
  EXPECT_EQ(told, 0) << "whoever has them no more does not pay";
  EXPECT_EQ(spare.bytes(), 4 * kMegabyte);
  {
    const Pages next = spare.Take(3 * kMegabyte, &account);
    EXPECT_EQ(next.data(), place);
    EXPECT_EQ(next.bytes(), 3 * kMegabyte);
    EXPECT_EQ(told, 3 * kMegabyte);
    EXPECT_EQ(spare.bytes(), 0u);
    EXPECT_NE(spare.Take(3 * kMegabyte, &account).data(), place);
  }
  EXPECT_EQ(told, 0);
}

TEST(SparePagesTest, TheLeastThatSufficesIsTaken) {
  SparePages spare;
  std::byte* const large = KeepSome(spare, 5 * kMegabyte);
  std::byte* const small = KeepSome(spare, 3 * kMegabyte);
  ASSERT_EQ(spare.bytes(), 8 * kMegabyte);
  const Pages little = spare.Take(kMegabyte, nullptr);
  EXPECT_EQ(spare.bytes(), 8 * kMegabyte) << "most of either would lie idle";
  EXPECT_EQ(spare.Take(3 * kMegabyte, nullptr).data(), small);
  EXPECT_EQ(spare.Take(4 * kMegabyte, nullptr).data(), large);
}

TEST(SparePagesTest, SomeAreKeptAndTheOldestGo) {
  SparePages spare;
  for (const std::size_t bytes : {kMegabyte / 2, 32 * kMegabyte + 1}) {
    KeepSome(spare, bytes);
    EXPECT_EQ(spare.bytes(), 0u) << bytes;
  }
  spare.Keep(Pages());
  for (std::size_t i = 1; i <= 6; ++i) {
    Pages pages((i + 10) * kMegabyte);
    spare.Keep(std::move(pages));
  }
  EXPECT_EQ(spare.bytes(), (13 + 14 + 15 + 16) * kMegabyte);
  EXPECT_TRUE(spare.Clear());
  EXPECT_EQ(spare.bytes(), 0u);
  EXPECT_FALSE(spare.Clear());
}

TEST(SparePagesTest, AMonitorCanRefuseThem) {
  SparePages spare;
  KeepSome(spare, kMegabyte);
  const MemoryAccount refuses([](std::ptrdiff_t bytes) { return bytes < 0; });
  EXPECT_THROW(spare.Take(kMegabyte, &refuses), std::bad_alloc);
  EXPECT_THROW(spare.Take(20 * kMegabyte, &refuses), std::bad_alloc);
}

TEST(SparePagesTest, TheyMakeRoomForOthers) {
  SparePages spare;
  for (int i = 0; i < 4; ++i) {
    Pages pages(20 * kMegabyte);
    spare.Keep(std::move(pages));
  }
  const unit::AddressSpaceLimit limit(0);
  if (!limit.is_set()) GTEST_SKIP() << "the system lets nobody limit addresses";
  EXPECT_EQ(spare.Take(50 * kMegabyte, nullptr).bytes(), 50 * kMegabyte);
  EXPECT_EQ(spare.bytes(), 0u);
  EXPECT_THROW(spare.Take(200 * kMegabyte, nullptr), std::bad_alloc);
}

/// What the process has and the system may take; nothing if it does not say.
std::optional<std::size_t> LazilyFreeBytes() {
  std::ifstream file("/proc/self/smaps_rollup");
  for (std::string word; file >> word;) {
    std::size_t kilobytes;
    if (word == "LazyFree:" && file >> kilobytes) return kilobytes * 1024;
  }
  return std::nullopt;
}

TEST(SparePagesTest, AScenesMemoryStaysWithItsDeviceUnlessItIsToKeepLittle) {
  unit::Random random(1);
  const unit::Mesh mesh = unit::MakeSoup(random, 100000, 1, 0.1f);
  const std::vector<Geometry> geometries = {unit::GeometryOf(mesh)};
  const auto before = LazilyFreeBytes();
  if (!before || DACRT_TEST_EMULATED) GTEST_SKIP() << "the system does not say";
  for (const Keep keep : {Keep::kLittle, Keep::kByBudget}) {
    auto device = std::make_shared<Device>(Settings{.threads = 1});
    {
      const Scene scene(device, geometries, SceneOptions{.keep = keep});
      std::vector<unit::Ray> rays = unit::MakeRays(random, 5000, 1);
      scene.Trace(Query::kClosest, unit::ViewOf(rays));
    }
    EXPECT_EQ(LazilyFreeBytes() > *before, keep != Keep::kLittle);
    device.reset();
    EXPECT_EQ(LazilyFreeBytes(), before) << "it goes with the device";
  }
}

}  // namespace
}  // namespace dacrt

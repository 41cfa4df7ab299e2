#include <gtest/gtest.h>

#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ray_lists_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "trace/ray_lists-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

/// Lists and masks that end where their slack does.
struct Lists {
  explicit Lists(size_t count)
      : list(count + kListSlack), masks(count + kListSlack), out(count + kListSlack) {}

  unit::GuardedArray<RayNumber> list;
  unit::GuardedArray<uint8_t> masks;
  unit::GuardedArray<RayNumber> out;
};

constexpr RayNumber kGuard = 0xBEEF;

/// FilterList against a loop. Behind the list stands what must not come through, behind the slack of
/// the output what must not be touched.
void ExpectFiltered(const Lists& lists, size_t count) {
  for (size_t child = 0; child < 8; ++child) {
    std::vector<RayNumber> expected;
    for (size_t i = 0; i < count; ++i) {
      if (lists.masks[i] >> child & 1) expected.push_back(lists.list[i]);
    }
    std::fill(lists.out.begin(), lists.out.end(), kGuard);
    const size_t filtered =
        FilterList(lists.list.data(), lists.masks.data(), count, child, lists.out.data());
    ASSERT_EQ(filtered, expected.size()) << count << " rays, child " << child;
    for (size_t i = 0; i < filtered; ++i) {
      ASSERT_EQ(lists.out[i], expected[i]) << i << " of " << filtered;
    }
    // A caller cuts the output to what came through and its slack, and puts the next list there.
    for (size_t i = filtered + kListSlack; i < lists.out.size(); ++i) {
      ASSERT_EQ(lists.out[i], kGuard) << i << " after " << filtered << " of " << count;
    }
  }
}

void FiltersListsOfEveryLength() {
  Random random(1);
  for (size_t count = 0; count <= 200; ++count) {
    for (int round = 0; round < 4; ++round) {
      const Lists lists(count);
      for (size_t i = 0; i < lists.list.size(); ++i) {
        lists.list[i] = static_cast<RayNumber>(random.Next());
        // Behind the list masks are 0.
        lists.masks[i] = i < count ? static_cast<uint8_t>(random.Next()) : 0;
      }
      ExpectFiltered(lists, count);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

void AllOrNoneComeThrough() {
  for (size_t count = 0; count <= 200; ++count) {
    for (const uint8_t mask : {uint8_t{0}, uint8_t{255}, uint8_t{1}, uint8_t{128}}) {
      const Lists lists(count);
      for (size_t i = 0; i < lists.list.size(); ++i) {
        lists.list[i] = static_cast<RayNumber>(65535 - i);
        lists.masks[i] = i < count ? mask : 0;
      }
      ExpectFiltered(lists, count);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// All rays of the largest piece, the last of which has the largest number that there is.
void TheLargestPiece() {
  Random random(2);
  const Lists lists(kMostPieceRays);
  for (size_t i = 0; i < lists.list.size(); ++i) {
    lists.list[i] = static_cast<RayNumber>(i);
    lists.masks[i] = i < kMostPieceRays ? static_cast<uint8_t>(random.Next()) : 0;
  }
  ExpectFiltered(lists, kMostPieceRays);
}

void CutsWholeLinesThatDoNotOverlap() {
  alignas(64) std::byte bytes[4096];
  ListMemory memory{bytes, bytes + sizeof(bytes)};
  const std::byte* last_end = bytes;
  for (const size_t count : {1u, 63u, 64u, 65u, 200u}) {
    uint8_t* const masks = CutList<uint8_t>(memory, count);
    EXPECT_EQ(reinterpret_cast<std::byte*>(masks), last_end);
    RayNumber* const numbers = CutList<RayNumber>(memory, count);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(numbers) % 64, 0u);
    EXPECT_GE(reinterpret_cast<uint8_t*>(numbers), masks + count);
    EXPECT_GE(memory.top, reinterpret_cast<std::byte*>(numbers + count));
    last_end = memory.top;
  }
}

// What ListBytes says is what a visit cuts off.
void AVisitTakesNoMoreThanItsBytes() {
  std::vector<std::byte> bytes(ListBytes(kMostPieceRays));
  for (size_t count = 0; count <= kMostPieceRays; count = count * 3 / 2 + 1) {
    ListMemory memory{bytes.data(), bytes.data() + ListBytes(count)};
    EXPECT_TRUE(HasRoom(memory, ListBytes(count)));
    EXPECT_FALSE(HasRoom(memory, ListBytes(count) + 1));
    CutList<uint8_t>(memory, count + kListSlack);
    CutList<RayNumber>(memory, count + kListSlack);
    EXPECT_LE(memory.top, memory.end);
  }
  EXPECT_FALSE(HasRoom(ListMemory{}, 1));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(RayListsTest);
HWY_EXPORT_AND_TEST_P(RayListsTest, FiltersListsOfEveryLength);
HWY_EXPORT_AND_TEST_P(RayListsTest, AllOrNoneComeThrough);
HWY_EXPORT_AND_TEST_P(RayListsTest, TheLargestPiece);
HWY_EXPORT_AND_TEST_P(RayListsTest, CutsWholeLinesThatDoNotOverlap);
HWY_EXPORT_AND_TEST_P(RayListsTest, AVisitTakesNoMoreThanItsBytes);

}  // namespace dacrt
#endif  // HWY_ONCE

// Small blocks in large pages, and who gets them.
#include "runtime/shared_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "address_space_limit.h"
#include "runtime/pages.h"
#include "unit_test.h"

namespace dacrt {
namespace {

constexpr std::size_t kSmallPage = 4096, kLargePage = std::size_t{2} << 20;

struct Block {
  std::byte* data;
  std::size_t bytes;
  std::byte mark;

  bool HoldsOnly(std::byte value) const {
    return std::all_of(data, data + bytes, [&](std::byte held) { return held == value; });
  }
};

TEST(SharedPagesTest, BlocksAreZerosAndApart) {
  SharedPages pages;
  unit::Random random(1);
  std::vector<Block> blocks;
  const auto give_back = [&](std::size_t i) {
    ASSERT_TRUE(blocks[i].HoldsOnly(blocks[i].mark)) << "somebody else wrote to it";
    pages.Return(blocks[i].data, blocks[i].bytes);
    blocks[i] = blocks.back();
    blocks.pop_back();
  };
  std::size_t bytes = 0, most_bytes = 0, most_pages = 0;
  for (int step = 0; step < 2000; ++step) {
    if (blocks.size() > 40 || (!blocks.empty() && random.Below(3) == 0)) {
      const std::size_t i = random.Below(static_cast<uint32_t>(blocks.size()));
      bytes -= blocks[i].bytes;
      ASSERT_NO_FATAL_FAILURE(give_back(i));
      continue;
    }
    const std::size_t size = 1 + random.Below(step % 10 == 0 ? SharedPages::kMostBytes : 60000);
    const Block block{pages.Take(size), size, static_cast<std::byte>(1 + step % 255)};
    ASSERT_NE(block.data, nullptr);
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(block.data) % kSmallPage, 0u);
    ASSERT_TRUE(block.HoldsOnly(std::byte{0}));
    std::fill_n(block.data, size, block.mark);
    blocks.push_back(block);
    bytes += size;
    most_bytes = std::max(most_bytes, bytes);
    most_pages = std::max(most_pages, pages.large_pages());
  }
  EXPECT_LE(most_pages * kLargePage, 2 * most_bytes) << "what was returned is taken again";
  while (!blocks.empty()) ASSERT_NO_FATAL_FAILURE(give_back(0));
  EXPECT_EQ(pages.large_pages(), 0u);
}

TEST(SharedPagesTest, TheFullestThatSufficesIsTaken) {
  SharedPages pages;
  std::vector<std::byte*> blocks;
  while (pages.large_pages() < 3) blocks.push_back(pages.Take(SharedPages::kMostBytes));
  const std::size_t a_page = (blocks.size() - 1) / 2;
  // A gap in the first one, and there is much room in the third.
  pages.Return(blocks[1], SharedPages::kMostBytes);
  std::byte* const again = pages.Take(SharedPages::kMostBytes);
  EXPECT_EQ(again, blocks[1]);
  for (std::size_t i = 0; i < a_page; ++i) pages.Return(blocks[i], SharedPages::kMostBytes);
  EXPECT_EQ(pages.large_pages(), 2u) << "an empty one goes";
  for (std::size_t i = a_page; i < blocks.size(); ++i) {
    pages.Return(blocks[i], SharedPages::kMostBytes);
  }
  EXPECT_EQ(pages.large_pages(), 0u);
}

TEST(SharedPagesTest, WithoutMemoryThereIsNoBlock) {
  SharedPages pages;
  std::byte* const first = pages.Take(SharedPages::kMostBytes);
  ASSERT_NE(first, nullptr);
  std::vector<std::byte*> others;
  others.reserve(8);
  {
    const unit::AddressSpaceLimit limit(0);
    if (!limit.is_set()) GTEST_SKIP() << "the system lets nobody limit addresses";
    while (std::byte* const block = pages.Take(SharedPages::kMostBytes)) others.push_back(block);
  }
  EXPECT_EQ(pages.large_pages(), 1u) << "what there is can be taken all the same";
  EXPECT_FALSE(others.empty());
  others.push_back(pages.Take(SharedPages::kMostBytes));
  EXPECT_NE(others.back(), nullptr);
  pages.Return(first, SharedPages::kMostBytes);
  for (std::byte* const block : others) pages.Return(block, SharedPages::kMostBytes);
  EXPECT_EQ(pages.large_pages(), 0u);
}

std::vector<Pages> TakeMany(std::size_t count, std::size_t bytes, std::size_t span) {
  std::vector<Pages> many;
  for (std::size_t i = 0; i < count; ++i) {
    many.emplace_back(bytes, nullptr, span);
    std::fill_n(many.back().data(), bytes, std::byte{1});
  }
  return many;
}

TEST(SharedPagesTest, ManySmallOnesShare) {
  constexpr std::size_t kBytes = 5000, kMany = 100;
  const SharedPages& shared = SharedPages::Get();
  ASSERT_EQ(shared.large_pages(), 0u);
  EXPECT_EQ((TakeMany(10, kBytes, 0), shared.large_pages()), 0u) << "few have no use for it";
  for (int turn = 0; turn < 2; ++turn) {
    std::vector<Pages> many = TakeMany(kMany, kBytes, 0);
    EXPECT_EQ(shared.large_pages(), 1u);
    for (const Pages& pages : many) EXPECT_EQ(pages.data()[kBytes - 1], std::byte{1});
    Pages moved = std::move(many[50]), other;
    many.clear();
    EXPECT_EQ(shared.large_pages(), 1u);
    other = std::move(moved);
    EXPECT_EQ(other.data()[0], std::byte{1});
    other = Pages();
    EXPECT_EQ(shared.large_pages(), 0u);
  }
}

TEST(SharedPagesTest, WhatIsLargeOrMayNotBeTouchedStandsAlone) {
  const SharedPages& shared = SharedPages::Get();
  const auto large = TakeMany(20, SharedPages::kMostBytes + 1, 0);
  EXPECT_EQ(shared.large_pages(), 0u);
  const auto spare = TakeMany(20, 5000, 10000);
  EXPECT_EQ(shared.large_pages(), 0u);
}

TEST(SharedPagesTest, WithoutLargePagesSmallOnesStandAlone) {
  const auto few = TakeMany(16, 5000, 0);
  const unit::AddressSpaceLimit limit(kLargePage / 2);
  if (!limit.is_set()) GTEST_SKIP() << "the system lets nobody limit addresses";
  const Pages more(5000);
  EXPECT_NE(more.data(), nullptr);
  EXPECT_EQ(SharedPages::Get().large_pages(), 0u);
}

}  // namespace
}  // namespace dacrt

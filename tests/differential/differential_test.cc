// A fixed share of random worlds, and the worlds that failed once.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "campaign.h"
#include "isolation.h"
#include "world_text.h"

namespace dacrt::tests {
namespace {

/// Worlds of each group of features; differential_run takes more.
constexpr uint64_t kWorlds = 200;

/// Fails for what is unexplained; prints what was counted.
void Check(const Campaign& campaign) {
  const CampaignResult result = RunCampaign(campaign);
  std::ostringstream text;
  result.report.PrintTable(text);
  for (const auto& failure : result.failures) {
    text << "\nseed " << failure.seed << ": " << failure.reason << '\n';
    PrintFailure(text, campaign, failure.seed);
  }
  std::cout << text.str();
  EXPECT_EQ(result.failures.size(), 0u);
  // Few worlds end the real library's process.
  EXPECT_GE(result.worlds, campaign.worlds * 9 / 10);
}

// A process that ended itself with an exit code, as a sanitizer does, was taken for one that was done.
TEST(Isolation, AProcessThatExitsIsNotDone) {
  const auto ending = [](int exit_code) {
    return Isolated([=](const Isolated::Write&, Progress&) {
             if (exit_code != 0) _exit(exit_code);
           })
        .Wait();
  };
  EXPECT_TRUE(ending(0).IsDone());
  EXPECT_FALSE(ending(3).IsDone());
}

/// The real library's other kernels must be explained by the same rules, or the rules are wrong.
TEST(Rules, HoldForTheRealLibraryAlone) {
  Campaign campaign;
  campaign.opponents.real_alone = "isa=sse2";
  campaign.features.set();
  campaign.worlds = kWorlds;
  Check(campaign);
}

struct Share {
  const char* name;
  const char* features;
};

class WorldsTest : public testing::TestWithParam<Share> {};

TEST_P(WorldsTest, AnswersAreEmbrees) {
  Campaign campaign;
  campaign.features = ParseFeatures(GetParam().features);
  campaign.worlds = kWorlds;
  campaign.most_failures = 2;
  Check(campaign);
}

INSTANTIATE_TEST_SUITE_P(
    , WorldsTest,
    testing::Values(
        Share{"Triangles", "triangles,masks,layouts,changes"},
        Share{"Facets", "triangles,quads,grids,robust,flags,configs,motion"},
        Share{"Points", "spheres,discs,oriented_discs,motion,filters,layouts"},
        Share{"UserGeometries", "user,instances,masks,motion,context_filters,changes"},
        Share{"Instances", "triangles,quads,instances,quaternions,masks,motion,filters,robust"},
        Share{"Scales", "triangles,quads,grids,spheres,discs,user,instances,robust,scales"},
        Share{"Everything", ""}, Share{"EverythingByDefaults", "-configs,-hostile"}),
    [](const auto& share) { return share.param.name; });

std::vector<std::filesystem::path> Regressions() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(DACRT_REGRESSIONS_DIR)) {
    if (entry.path().extension() == ".world") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

TEST(Regressions, AreAnsweredRightNow) {
  for (const std::filesystem::path& path : Regressions()) {
    SCOPED_TRACE(path.filename().string());
    std::ifstream file(path);
    const World world = ReadWorld(file);
    Report report;
    const std::optional<std::string> fault = ReplayWorld({}, world, report);
    EXPECT_FALSE(fault) << *fault;
    EXPECT_GT(report.Total().rays, 0u);
  }
}

}  // namespace
}  // namespace dacrt::tests

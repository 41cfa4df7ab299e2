// The lidar sample as its user meets it: command line in, cloud and picture out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/pictures.h"
#include "tests/program.h"

namespace sample_test {
namespace {

using Arguments = std::vector<std::string>;

struct CloudPoint {
  float position[3];
  uint8_t intensity, geometry;
};

// The points of a file, as its header announces them.
std::vector<CloudPoint> ReadCloud(const std::filesystem::path& path) {
  constexpr size_t kPointBytes = 14;
  const std::string content = ReadFile(path);
  const std::string end = "end_header\n", element = "element vertex ";
  const size_t header = content.find(end), count = content.find(element);
  EXPECT_EQ(content.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
  if (header == std::string::npos || count == std::string::npos) {
    ADD_FAILURE() << "no header";
    return {};
  }
  std::vector<CloudPoint> points(std::stoul(content.substr(count + element.size())));
  const size_t body = header + end.size();
  EXPECT_EQ(content.size(), body + kPointBytes * points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const char* point = content.data() + body + i * kPointBytes;
    std::memcpy(points[i].position, point, sizeof(points[i].position));
    std::memcpy(&points[i].intensity, point + sizeof(points[i].position), 2);
  }
  return points;
}

class Lidar : public testing::Test {
 protected:
  Outcome Run(const Arguments& arguments) const {
    return RunProgram(folder_.path(), LIDAR, arguments);
  }

  void ExpectFailure(const Arguments& arguments, int exit_code, const std::string& message) const {
    const std::vector<std::string> before = folder_.Names();
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.errors;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_EQ(outcome.errors.rfind("lidar: ", 0), 0u) << outcome.errors;
    EXPECT_NE(outcome.errors.find(message), std::string::npos) << outcome.errors;
    EXPECT_EQ(folder_.Names(), before);
  }

  const TemporaryFolder folder_;
};

TEST_F(Lidar, ScansTheStreetAndTheVan) {
  const Outcome outcome = Run({"--sweeps", "3", "--rays", "64000"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "") << "no bar where there is no terminal";
  EXPECT_EQ(folder_.Names(), (std::vector<std::string>{"lidar.ply", "lidar.png"}));
  const std::vector<CloudPoint> points = ReadCloud(folder_ / "lidar.ply");
  EXPECT_GT(points.size(), 3 * 64000 * 0.7);
  EXPECT_LT(points.size(), 3 * 64000);
  EXPECT_NE(outcome.output.find(std::to_string(points.size()) + " points: lidar.ply"),
            std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("had found out: 2\n"), std::string::npos) << outcome.output;
  std::set<long> van_rears;  // where its rear side is, in decimetres
  for (const auto& [position, intensity, geometry] : points) {
    ASSERT_TRUE(position[1] > -0.01f && position[1] < 21) << position[1];
    ASSERT_LT(std::abs(position[2]), 31);
    ASSERT_LE(geometry, 1);
    if (geometry == 1 && position[1] > 1.3f && std::abs(position[2] - 1.8f) < 0.5f) {
      van_rears.insert(std::lround(position[0] * 10));
    }
  }
  // 9 m ahead of where the scanner begins, and each sweep 4.2 m farther: it moves between sweeps.
  for (const long rear : {162, 204, 246}) EXPECT_TRUE(van_rears.contains(rear)) << rear;
  const Picture picture = ReadPicture(folder_ / "lidar.png");
  EXPECT_EQ(picture.width, 1280);
  EXPECT_EQ(picture.height, 720);
  const float background = picture.samples[0];
  const auto drawn =
      std::ranges::count_if(picture.samples, [&](float sample) { return sample != background; });
  EXPECT_GT(drawn, 1280 * 720 / 20);
}

TEST_F(Lidar, IsTheSameOnAnyNumberOfThreadsAndSeeded) {
  const Arguments small = {"--sweeps", "1", "--rays", "10000"};
  const auto scan = [&](Arguments more, const std::string& name) {
    more.insert(more.end(), small.begin(), small.end());
    more.insert(more.end(), {"-o", name, "--picture", name + ".png"});
    EXPECT_EQ(Run(more).exit_code, 0);
    return ReadFile(folder_ / name);
  };
  const std::string one = scan({"--threads", "1"}, "one.ply");
  EXPECT_TRUE(one == scan({}, "all.ply"));
  EXPECT_FALSE(one == scan({"--seed", "2"}, "other.ply"));
}

// On a terminal: a bar that grows, and nothing left of it.
TEST_F(Lidar, ShowsHowFarItIs) {
  const Outcome outcome = RunOnTerminal(folder_.path(), LIDAR, {"--sweeps", "4"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::regex drawn(R"(\r\x1b\[Kscanning +\[(#*)(\.*)\] +([0-9]+) %, [0-9]+ s left)");
  long last = 0;
  for (std::sregex_iterator bar(outcome.output.begin(), outcome.output.end(), drawn), end;
       bar != end; ++bar) {
    const long percent = std::stol((*bar)[3]);
    EXPECT_GE(percent, last);
    EXPECT_LE(percent, 100);
    EXPECT_EQ(bar->length(1) + bar->length(2), 40);
    EXPECT_NEAR(bar->length(1) * 2.5, percent, 3);
    last = percent;
  }
  EXPECT_GT(last, 50) << outcome.output;
  EXPECT_NE(outcome.output.find("\r\x1b[Kstreet and van: "), std::string::npos) << outcome.output;
}

// By Ctrl-C on a terminal, as soon as there is a bar.
TEST_F(Lidar, WritesWhatItHasWhenItIsInterrupted) {
  const Outcome outcome =
      RunOnTerminal(folder_.path(), LIDAR, {"--rays", "4000000", "--sweeps", "22"}, "s left");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("\n22 "), std::string::npos) << outcome.output;
  const std::vector<CloudPoint> points = ReadCloud(folder_ / "lidar.ply");
  EXPECT_LT(points.size(), 22 * 4'000'000 * 0.7);
  std::ostringstream line;
  line << '\n' << points.size() << " points: lidar.ply";
  EXPECT_NE(outcome.output.find(line.str()), std::string::npos) << outcome.output;
  EXPECT_EQ(ReadPicture(folder_ / "lidar.png").width, 1280);
}

TEST_F(Lidar, RefusesWhatItCannotDo) {
  constexpr int kUsage = 2, kOutput = 4;
  for (const Arguments& bad : std::vector<Arguments>{{"--no-such-option"},
                                                     {"--sweeps", "0"},
                                                     {"--sweeps", "1000"},
                                                     {"--rays", "3"},
                                                     {"--rays", "many"},
                                                     {"--threads", "2000"},
                                                     {"mesh.ply"}}) {
    SCOPED_TRACE(testing::PrintToString(bad));
    ExpectFailure(bad, kUsage, "--help");
  }
  ExpectFailure({"--no-such-option"}, kUsage, "; there are --help --sweeps --rays");
  ExpectFailure({"-o", "cloud.xyz"}, kOutput, "cloud.xyz: the name must end in .ply");
  ExpectFailure({"-o", "missing/cloud.ply"}, kOutput, "there is no such folder");
  ExpectFailure({"-o", "/proc/cloud.ply"}, kOutput, "/proc/cloud.ply: ");
  ExpectFailure({"--picture", "p.gif"}, kOutput, "p.gif: the name must end in");
  ExpectFailure({"--picture", "missing/p.png"}, kOutput, "there is no such folder");
  EXPECT_EQ(Run({"--help"}).exit_code, 0);
}

}  // namespace
}  // namespace sample_test

// The benchmarks as a user meets them: run as programs, judged by exit code, messages and files.
// Speed is never judged.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace dacrt::bench {
namespace {

using nlohmann::json;

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class BenchTest : public testing::Test {
 protected:
  BenchTest()
      : folder_(std::filesystem::path(testing::TempDir()) /
                (std::string("dacrt_bench_test_") +
                 testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~BenchTest() override { std::filesystem::remove_all(folder_); }

  // Runs the program and returns its exit code. What it prints is kept.
  int Run(const std::string& program, const std::string& arguments) {
    const std::string command =
        "'" + program + "' " + arguments + " >'" + Path("out") + "' 2>'" + Path("error") + "'";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  // Draws what a program has left in "json", in the folder "plots".
  int Plot(const std::string& page = "") {
    return Run(PLOT, "'" + Path("json") + "' '" + Path("plots") + "'" +
                         (page.empty() ? "" : " '" + Path(page) + "'"));
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Out() const { return ReadFile(Path("out")); }
  std::string Error() const { return ReadFile(Path("error")); }

 private:
  std::filesystem::path folder_;
};

// Every row of a table on the page has as many cells as the others.
bool AreTablesEven(const std::string& page) {
  std::istringstream lines(page);
  std::ptrdiff_t bars = 0;  // of the table's rows before
  for (std::string line; std::getline(lines, line);) {
    const std::ptrdiff_t more = std::ranges::count(line, '|');
    if (bars > 0 && more > 0 && more != bars) return false;
    bars = more;
  }
  return true;
}

TEST_F(BenchTest, ShortReproductionRunsAndTheAlgorithmsAgree) {
  ASSERT_EQ(Run(METHOD_BENCH, "--short --json '" + Path("json") + "'"), 0) << Error();
  const json results = json::parse(ReadFile(Path("json")));
  constexpr std::size_t kFrames = 10;  // five kinds, two numbers of rays
  ASSERT_EQ(results["comparison"].size(), kFrames);
  for (const json& frame : results["comparison"]) {
    ASSERT_EQ(frame["methods"].size(), 3u);
    for (const json& method : frame["methods"]) {
      EXPECT_GT(method["median_seconds"], 0);
      EXPECT_LE(method["least_seconds"], method["median_seconds"]);
      EXPECT_EQ(method["statistics"]["counts"]["rays"], frame["rays"]);
      EXPECT_EQ(method["statistics"]["counts"]["hits"],
                frame["methods"][0]["statistics"]["counts"]["hits"]);
      EXPECT_GT(method["workspace_bytes"], 0);
    }
  }
  EXPECT_NE(Out().find("mora2011 x"), std::string::npos);

  ASSERT_EQ(Plot(), 0) << Error();
  for (const char* const rival : {"afra2012", "mora2011"}) {
    const std::string svg = ReadFile(Path("plots/ratio-") + rival + ".svg");
    for (const char* const text : {"path tracing", "hall-75k", "512²"}) {
      EXPECT_NE(svg.find(text), std::string::npos) << rival << ": " << text;
    }
  }
  const std::string stages = ReadFile(Path("plots/stages.svg"));
  for (const char* const text : {"direct solve", "rest", "ambient occlusion: mora2011"}) {
    EXPECT_NE(stages.find(text), std::string::npos) << text;
  }
}

TEST_F(BenchTest, AblationChangesOneSettingAtATime) {
  ASSERT_EQ(Run(METHOD_BENCH,
                "--scene hall-75k --rays 32 --repeat 1 --kind ambient --ablation "
                "--algorithm nabata2013 --json '" +
                    Path("json") + "'"),
            0)
      << Error();
  const json results = json::parse(ReadFile(Path("json")));
  ASSERT_EQ(results["ablation"].size(), 1u);
  EXPECT_EQ(results["ablation"][0]["methods"][1]["name"], "sampled_cost=0");
  EXPECT_NE(Out().find("skip_filtering=0"), std::string::npos);
  ASSERT_EQ(Plot(), 0) << Error();
  EXPECT_NE(ReadFile(Path("plots/ablation.svg")).find("skip_filtering=0"), std::string::npos);
}

TEST_F(BenchTest, BadCommandLinesAreRefusedWithTheLegalValues) {
  const struct {
    const char* arguments;
    std::vector<const char*> said;
  } kCases[] = {
      {"--algorithm quick", {"quick", "nabata2013", "afra2012", "mora2011"}},
      {"--set colour=red", {"colour", "skip_filtering", "bins"}},
      {"--set bins=100", {"bins", "100", "2 to 32"}},
      {"--set bins", {"bins", "NAME=VALUE"}},
      {"--set algorithm=mora2011", {"--algorithm"}},
      {"--kind caustics", {"caustics", "point", "path-dof"}},
      {"--rays 700", {"700", "512"}},
      {"--rays 0", {"0", "512"}},
      {"--short --full", {"--short"}},
      {"--repeat 0", {"repeat"}},
  };
  for (const auto& bad : kCases) {
    EXPECT_EQ(Run(METHOD_BENCH, bad.arguments), 2) << bad.arguments;
    for (const char* const word : bad.said) {
      EXPECT_NE(Error().find(word), std::string::npos) << bad.arguments << ": " << Error();
    }
  }
}

TEST_F(BenchTest, SceneThatCannotBeReadDoesNotStopTheOthers) {
  std::ofstream(Path("broken.ply")) << "ply\n";
  ASSERT_EQ(Run(METHOD_BENCH, "--scene '" + Path("missing.obj") + "' '" + Path("broken.ply") +
                                  "' hall-75k --rays 16 --repeat 1 --kind ambient --json '" +
                                  Path("json") + "'"),
            3)
      << Error();
  EXPECT_NE(Error().find("missing.obj"), std::string::npos);
  EXPECT_NE(Error().find("broken.ply"), std::string::npos);
  const json results = json::parse(ReadFile(Path("json")));
  EXPECT_EQ(results["unreadable"].size(), 2u);
  EXPECT_EQ(results["comparison"].size(), 1u);
}

TEST_F(BenchTest, OutputThatCannotBeWrittenIsFoundBeforeMeasuring) {
  for (const char* const program : {METHOD_BENCH, EMBREE_BENCH, MOVING_BENCH}) {
    ASSERT_EQ(Run(program, "--full --json '" + Path("missing/json") + "'"), 5) << program;
    EXPECT_NE(Error().find("missing/json"), std::string::npos) << program;
    EXPECT_FALSE(std::filesystem::exists(Path("missing"))) << program;
  }
}

TEST_F(BenchTest, EmbreeAndTheDropInAreMeasuredSideBySide) {
  const std::string measure =
      "--scene hall-75k --kind shadow diffuse --rays 4K 64K --repeat 1 --json '" + Path("json") +
      "' --markdown '" + Path("page.md") + "'";
  ASSERT_EQ(Run(EMBREE_BENCH, measure + " --threads 1 2"), 0) << Error();
  const json results = json::parse(ReadFile(Path("json")));
  ASSERT_EQ(results["cells"].size(), 8u);
  for (const json& cell : results["cells"]) {
    EXPECT_EQ(cell["geometry"], "triangles");
    EXPECT_GT(cell["equal_hits"], 0.999);
    EXPECT_GT(cell["one_shot_ratio"], 0);
    EXPECT_GT(cell["steady_ratio"], 0);
    const bool is_slice = cell["size"] == "4K";
    EXPECT_EQ(cell["rays"] == 4096, is_slice);
    if (!is_slice) {
      EXPECT_EQ(cell["batches"], 1);
    }
    for (const char* const library : {"embree", "dacrt"}) {
      for (const char* const time : {"commit_seconds", "first_seconds", "steady_seconds"}) {
        ASSERT_FALSE(cell[library][time].empty());
        for (const json& seconds : cell[library][time]) EXPECT_GT(seconds, 0);
      }
    }
    EXPECT_EQ(cell["embree_high_steady_seconds"].size(), cell["embree"]["steady_seconds"].size());
  }
  ASSERT_EQ(results["memory"].size(), 2u);  // diffuse, 64K, on one thread and on two
  for (const json& cell : results["memory"]) {
    EXPECT_GT(cell["embree"]["kept_resident_bytes"], 0);
    EXPECT_GT(cell["dacrt"]["peak_resident_bytes"], 0);
  }
  EXPECT_NE(Out().find("hall-75k, "), std::string::npos) << "the worst cell has its name";
  EXPECT_NE(ReadFile(Path("page.md")).find("| steady, from 64K rays | worst cell | 4 |"),
            std::string::npos);
  EXPECT_TRUE(AreTablesEven(ReadFile(Path("page.md"))));

  // The pictures end the page once, however often they are drawn.
  for (int i = 0; i < 2; ++i) ASSERT_EQ(Plot("page.md"), 0) << Error();
  const std::string page = ReadFile(Path("page.md"));
  EXPECT_NE(page.find("| worst cell | 4 |"), std::string::npos);
  EXPECT_TRUE(page.ends_with("|\n\n## Plots\n\n![embree-hall-75k](plots/embree-hall-75k.svg)\n"));
  const std::string svg = ReadFile(Path("plots/embree-hall-75k.svg"));
  for (const char* const text : {"diffuse", "64K", "one shot, 2 threads"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }

  // A run that is resumed adds what is missing, and keeps what there is.
  ASSERT_EQ(Run(EMBREE_BENCH, measure + " --resume --threads 1 2 --rays 64"), 0) << Error();
  const json resumed = json::parse(ReadFile(Path("json")));
  ASSERT_EQ(resumed["cells"].size(), 12u);
  for (std::size_t i = 0; i < results["cells"].size(); ++i) {
    EXPECT_EQ(resumed["cells"][i], results["cells"][i]);
  }
}

TEST_F(BenchTest, CallsGeometriesAndInstructionSetsAreMeasuredOnStillScenes) {
  ASSERT_EQ(Run(EMBREE_BENCH,
                "--scene box-36 --geometry quads instance --isa avx2 sse4.2 --kind shadow "
                "--rays 1 8 64 --threads 2 --repeat 1 --json '" +
                    Path("json") + "' --markdown '" + Path("page.md") + "'"),
            0)
      << Error();
  const json results = json::parse(ReadFile(Path("json")));
  ASSERT_EQ(results["cells"].size(), 12u);
  for (const json& cell : results["cells"]) {
    EXPECT_GT(cell["steady_ratio"], 0);
    EXPECT_FALSE(cell.contains("one_shot_ratio"));
    const std::string best = cell["embree_steady"];
    EXPECT_TRUE(best.starts_with(cell["isa"].get<std::string>())) << best;
  }
  EXPECT_NE(ReadFile(Path("page.md")).find("| quads, 2 threads |"), std::string::npos);
  EXPECT_TRUE(AreTablesEven(ReadFile(Path("page.md"))));
}

TEST_F(BenchTest, CallsAreShownAsATable) {
  std::ofstream(Path("triangle.obj")) << "v -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n";
  ASSERT_EQ(Run(CALL_BENCH, "--scene '" + Path("triangle.obj") +
                                "' --eye 0 0 3 --look-at 0 0 0 --fov 40 --geometry parts-200 "
                                "--robust --kind primary ambient --rays 1 16 64 64K --side 64 "
                                "--repeat 1 --seconds 0 --threads 2 --isa sse4.2 --drop-in '" +
                                DROP_IN + "'"),
            0)
      << Error();
  EXPECT_NE(Out().find("primary       16"), std::string::npos) << Out();
  EXPECT_NE(Out().find("geometric mean"), std::string::npos);
  for (const char* const bad : {"--kind caustics", "--rays 5", "--isa mmx", "--geometry hair",
                                "--eye 0 0 0", "--drop-in nowhere.so", "--side 7"}) {
    EXPECT_EQ(Run(CALL_BENCH, bad), 2) << bad;
  }
  EXPECT_EQ(Run(CALL_BENCH, "--scene '" + Path("missing.obj") + "'"), 3);
}

TEST_F(BenchTest, BadCommandLinesOfTheComparisonAreRefusedWithTheLegalValues) {
  std::ofstream(Path("list.json")) << "[]";
  const struct {
    std::string arguments;
    std::vector<const char*> said;
  } kCases[] = {
      {"--kind caustics", {"caustics", "primary", "diffuse"}},
      {"--rays 1000", {"1000", "64K", "16M"}},
      {"--geometry hair", {"hair", "quads", "parts-10000"}},
      {"--isa mmx", {"mmx", "avx2"}},
      {"--threads 0", {"threads"}},
      {"--repeat 0", {"repeat"}},
      {"--resume", {"--json"}},
      {"--resume --json '" + Path("list.json") + "'", {"list.json", "resumed"}},
  };
  for (const auto& bad : kCases) {
    EXPECT_EQ(Run(EMBREE_BENCH, bad.arguments), 2) << bad.arguments;
    for (const char* const word : bad.said) {
      EXPECT_NE(Error().find(word), std::string::npos) << bad.arguments << ": " << Error();
    }
  }
}

TEST_F(BenchTest, ComparisonGoesOnWithoutASceneThatCannotBeRead) {
  ASSERT_EQ(Run(EMBREE_BENCH, "--scene '" + Path("missing.obj") +
                                  "' hall-75k --kind primary --rays 64K --threads 1 --repeat 1 "
                                  "--json '" +
                                  Path("json") + "'"),
            3)
      << Error();
  EXPECT_NE(Error().find("missing.obj"), std::string::npos);
  EXPECT_EQ(json::parse(ReadFile(Path("json")))["cells"].size(), 1u);
}

TEST_F(BenchTest, MovingScenesAreMeasuredFrameByFrame) {
  const std::string measure =
      "--scene box-36 '" + Path("missing.obj") + "' --change wave replaced --kind diffuse " +
      "--rays 1K 10K --repeat 1 --json '" + Path("json") + "' --markdown '" + Path("page.md") + "'";
  ASSERT_EQ(Run(MOVING_BENCH, measure + " --threads 1"), 3) << Error();
  EXPECT_NE(Error().find("missing.obj"), std::string::npos);
  const json results = json::parse(ReadFile(Path("json")));
  ASSERT_EQ(results["cells"].size(), 4u);
  for (const json& cell : results["cells"]) {
    EXPECT_GT(cell["ratio"], 0);
    EXPECT_GT(cell["equal_hits"], 0.99);
  }
  EXPECT_NE(ReadFile(Path("page.md")).find("| waves | worst cell | 2 |"), std::string::npos);
  EXPECT_TRUE(AreTablesEven(ReadFile(Path("page.md"))));
  EXPECT_NE(Out().find("box-36"), std::string::npos);
  ASSERT_EQ(Plot(), 0) << Error();
  EXPECT_NE(ReadFile(Path("plots/moving-box-36.svg")).find("diffuse, 1 thread"), std::string::npos);

  ASSERT_EQ(Run(MOVING_BENCH, measure + " --resume --threads 1 2"), 3) << Error();
  const json resumed = json::parse(ReadFile(Path("json")));
  ASSERT_EQ(resumed["cells"].size(), 8u);
  EXPECT_EQ(resumed["cells"][0], results["cells"][0]);

  for (const char* const bad :
       {"--change melting", "--rays 64K", "--kind shadow", "--resume", "--threads 0"}) {
    EXPECT_EQ(Run(MOVING_BENCH, bad), 2) << bad;
  }
}

TEST_F(BenchTest, WhatCannotBePlottedIsSaidInALine) {
  std::ofstream(Path("json")) << "{}";
  EXPECT_EQ(Plot(), 1);
  EXPECT_EQ(Error().find("plot: " + Path("json") + ": not what one of method_bench"), 0u)
      << Error();
  std::ofstream(Path("json")) << R"({"benchmark": "moving_bench", "cells": []})";
  std::ofstream(Path("plots"));
  EXPECT_EQ(Plot(), 1);
  EXPECT_EQ(Error(), "plot: " + Path("plots") + ": File exists\n");
}

TEST_F(BenchTest, UnevenTablesAreNoticed) {
  EXPECT_TRUE(AreTablesEven("| a | b |\n|---|---|\n| 1 | 2 |\n\n| a |\n"));
  EXPECT_FALSE(AreTablesEven("| a | b |\n|---|---|\n| 1 | 2 | 3 |\n"));
}

}  // namespace
}  // namespace dacrt::bench

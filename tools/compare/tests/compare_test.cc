#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "exit_codes.h"
#include "libraries.h"
#include "program_run.h"
#include "verdict.h"

namespace dacrt::compare {
namespace {

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// -- Counting -------------------------------------------------------------------------------------

TEST(FormOfStreamTest, HasTheEndsWhereTheNamesSay) {
  EXPECT_EQ(FormOfStream(0), Form::kTo64);
  EXPECT_EQ(FormOfStream(64), Form::kTo64);
  EXPECT_EQ(FormOfStream(65), Form::kTo1K);
  EXPECT_EQ(FormOfStream(4096), Form::kTo4K);
  EXPECT_EQ(FormOfStream(4097), Form::kTo64K);
  EXPECT_EQ(FormOfStream(1 << 20), Form::kTo1M);
  EXPECT_EQ(FormOfStream((1 << 20) + 1), Form::kMore);
}

/// Of the calls that known_calls.c makes.
void ExpectKnownCalls(const ProgramRun& run) {
  const auto expect = [&](Kind kind, Form form, uint64_t calls, uint64_t rays, uint64_t inner) {
    const CallTotals& totals =
        run.of[static_cast<std::size_t>(kind)][static_cast<std::size_t>(form)];
    SCOPED_TRACE(NameOf(kind, form));
    EXPECT_EQ(totals.calls, calls);
    EXPECT_EQ(totals.rays, rays);
    EXPECT_EQ(totals.inner_calls, inner);
    EXPECT_GE(totals.seconds, 0);
    EXPECT_LE(totals.seconds, run.seconds);
  };
  expect(Kind::kCommit, Form::kSingle, 1, 0, 0);
  expect(Kind::kClosest, Form::kSingle, 1, 1, 0);
  expect(Kind::kAny, Form::kSingle, 11, 11, 1);
  expect(Kind::kAny, Form::kPacket, 1, 3, 0);
  expect(Kind::kClosest, Form::kTo64, 1, 64, 0);
  expect(Kind::kClosest, Form::kTo1K, 1, 65, 0);
  expect(Kind::kClosest, Form::kTo64K, 1, 5000, 0);
  expect(Kind::kAny, Form::kTo1K, 1, 1024, 0);
  expect(Kind::kClosest, Form::kMore, 0, 0, 0);
  expect(Kind::kPoint, Form::kSingle, 0, 0, 0);
  EXPECT_GT(run.SecondsInside(), 0);
  EXPECT_LE(run.SecondsInside(), run.seconds);
  EXPECT_GT(run.peak_bytes, 1u << 20);
}

const std::string kDropInFolder = std::filesystem::path(DACRT_DROP_IN).parent_path().string();

TEST(RunProgramTest, CountsTheCallsOfBothLibraries) {
  const ProgramRun embree = RunProgram({KNOWN_CALLS, "embree"}, COUNTER, "", "");
  EXPECT_EQ(embree.exit_code, 0) << embree.last_words;
  EXPECT_EQ(embree.last_words, "traced");
  EXPECT_TRUE(IsSameFile(embree.library, DACRT_REAL_EMBREE)) << embree.library;
  EXPECT_EQ(embree.devices, 1u);
  ExpectKnownCalls(embree);
  const ProgramRun dacrt = RunProgram({KNOWN_CALLS, "dacrt"}, COUNTER, kDropInFolder, "");
  EXPECT_EQ(dacrt.exit_code, 0) << dacrt.last_words;
  EXPECT_TRUE(IsSameFile(dacrt.library, DACRT_DROP_IN)) << dacrt.library;
  ExpectKnownCalls(dacrt);
}

TEST(RunProgramTest, AProgramThatCrashesHasBeenCounted) {
  const ProgramRun run = RunProgram({KNOWN_CALLS, "crash"}, COUNTER, "", "");
  EXPECT_EQ(run.exit_code, 128 + 6);
  ExpectKnownCalls(run);
}

TEST(RunProgramTest, CountsThroughAScriptAndWhatItStarts) {
  const std::string command = std::string(KNOWN_CALLS) + " all && " + KNOWN_CALLS + " all; exit 9";
  const ProgramRun run = RunProgram({"sh", "-c", command}, COUNTER, "", "");
  EXPECT_EQ(run.exit_code, 9);
  EXPECT_EQ(run.devices, 2u);
  EXPECT_EQ(run.of[1][0].calls, 22u);
}

TEST(RunProgramTest, TellsOfGeometriesThatAreRefused) {
  EXPECT_EQ(RunProgram({KNOWN_CALLS, "curves"}, COUNTER, "", "").refused_geometries, 0u);
  EXPECT_EQ(RunProgram({KNOWN_CALLS, "curves"}, COUNTER, kDropInFolder, "").refused_geometries, 1u);
}

TEST(RunProgramTest, HandsOnTheConfigurationAndTellsTheLastWords) {
  const ProgramRun run =
      RunProgram({"sh", "-c", "echo first; echo \"config: $DACRT_CONFIG\" >&2; echo"}, COUNTER, "",
                 "threads=1");
  EXPECT_EQ(run.last_words, "config: threads=1");
  EXPECT_EQ(run.devices, 0u);
}

TEST(RunProgramTest, RefusesWhatCannotBeStarted) {
  EXPECT_THROW(RunProgram({"/no/such/program"}, COUNTER, "", ""), ProgramError);
}

// -- The verdict ----------------------------------------------------------------------------------

std::string Text(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(VerdictTest, GoesByTheTimeOfTheWholeWork) {
  const std::vector<Compared> parts = {
      {"one", Kind::kClosest, Form::kTo64K, 10, 5},
      {"two", Kind::kAny, Form::kSingle, 1, 2},
      {"three", Kind::kAny, Form::kTo1K, 1, 1.05},
  };
  const Compared total{"in the library", Kind::kClosest, Form::kSingle, 12, 8};
  const std::string text = Text(Verdict(parts, &total, {}));
  EXPECT_TRUE(Has(text, "verdict: switch: in the library, dacrt is 1.50 times as fast\n")) << text;
  EXPECT_TRUE(Has(text, "gains: one (2.00 times as fast)\n")) << text;
  EXPECT_TRUE(Has(text, "loses: two (2.00 times as slow)\n")) << text;
  EXPECT_TRUE(Has(text, "set: send rays thousands a call")) << text;
  EXPECT_FALSE(Has(text, "collect more rays")) << "an even part is no loss\n" << text;
  EXPECT_FALSE(Has(text, "COMPACT")) << text;
}

TEST(VerdictTest, NamesFirstWhatCostsMost) {
  const std::vector<Compared> parts = {
      {"small", Kind::kAny, Form::kTo1K, 0.1, 0.9},
      {"large", Kind::kAny, Form::kTo1K, 10, 15},
  };
  const Compared slower{"in all", Kind::kClosest, Form::kSingle, 10.1, 15.9};
  const std::string of_one_work = Text(Verdict(parts, &slower, {}));
  EXPECT_TRUE(Has(of_one_work, "verdict: stay")) << of_one_work;
  EXPECT_TRUE(Has(of_one_work, "loses: large (1.50 times as slow); small (9.00")) << of_one_work;
  EXPECT_TRUE(Has(of_one_work, "gains: nowhere")) << of_one_work;
  EXPECT_TRUE(Has(of_one_work, "collect more rays")) << of_one_work;
  EXPECT_TRUE(Has(Text(Verdict(parts, nullptr, {})), "loses: small (9.00"));
}

TEST(VerdictTest, FirstAndLaterPassesHaveVerdictsOfTheirOwn) {
  const std::vector<Compared> parts = {
      {"a", Kind::kCommit, Form::kTo1K, 4, 1},
      {"b", Kind::kCommit, Form::kTo1K, 1, 1},
      {"c", Kind::kClosest, Form::kTo64K, 1, 1.02},
  };
  const std::string text = Text(Verdict(parts, nullptr, {}));
  EXPECT_TRUE(Has(text,
                  "verdict: switch: on scenes that are new in each frame (first passes), "
                  "dacrt is 2.00 times as fast"))
      << text;
  EXPECT_TRUE(Has(text, "verdict: about even: on scenes that stay as they are")) << text;
}

TEST(VerdictTest, SaysHowToTakeLessMemory) {
  const std::vector<Compared> parts = {{"a", Kind::kAny, Form::kTo64K, 2, 1}};
  EXPECT_TRUE(Has(Text(Verdict(parts, nullptr, {100'000'000, 150'000'000})), "COMPACT"));
  EXPECT_FALSE(Has(Text(Verdict(parts, nullptr, {10'000'000, 20'000'000})), "COMPACT"));
  EXPECT_FALSE(Has(Text(Verdict(parts, nullptr, {150'000'000, 100'000'000})), "COMPACT"));
}

TEST(VerdictTest, ListsAreShort) {
  std::vector<Compared> parts;
  for (int i = 0; i < 10; ++i) {
    parts.push_back({"part " + std::to_string(i), Kind::kAny, Form::kTo64K, 2, 1});
  }
  EXPECT_TRUE(Has(Text(Verdict(parts, nullptr, {})), "; and 4 more\n"));
}

// -- The program ----------------------------------------------------------------------------------

class CompareTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "compare_test.XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  int Run(const std::string& arguments) {
    const std::string command =
        "cd '" + folder_.string() + "' && '" COMPARE "' " + arguments + " >out 2>errors";
    const int status = std::system(command.c_str());
    out_ = Read("out");
    errors_ = Read("errors");
    return WEXITSTATUS(status);
  }

  std::string Read(const std::string& name) const {
    std::ostringstream content;
    content << std::ifstream(folder_ / name).rdbuf();
    return content.str();
  }

  void ExpectRefusal(const std::string& arguments, int exit_code, const std::string& message) {
    SCOPED_TRACE(arguments);
    EXPECT_EQ(Run(arguments), exit_code);
    EXPECT_EQ(out_, "");
    EXPECT_EQ(std::count(errors_.begin(), errors_.end(), '\n'), 1) << errors_;
    EXPECT_TRUE(errors_.starts_with("dacrt-compare: ")) << errors_;
    EXPECT_TRUE(Has(errors_, message)) << errors_;
  }

  std::filesystem::path folder_;
  std::string out_, errors_;
};

TEST_F(CompareTest, AProgramGetsATableAndAVerdict) {
  ASSERT_EQ(Run("--repeat 1 --config threads=1 --json figures '" KNOWN_CALLS "' all --help"), 0)
      << errors_;
  EXPECT_EQ(errors_, "");
  for (const char* const text :
       {"closest hit, single rays", "any hit, single rays (1 in callbacks)", "any hit, packets",
        "closest hit, streams to 64K", "5 000", "commit", "in the library, all threads",
        "peak memory, MB", "verdict: ", "gains: ", "loses: "}) {
    EXPECT_TRUE(Has(out_, text)) << text << " in\n" << out_;
  }
  const auto figures = nlohmann::json::parse(Read("figures"));
  EXPECT_EQ(figures["program"], (std::vector<std::string>{KNOWN_CALLS, "all", "--help"}));
  for (const char* const library : {"embree", "dacrt"}) {
    const auto& run = figures[library];
    EXPECT_GT(run["seconds_inside"], 0);
    EXPECT_EQ(run["calls"].size(), 8u);
    EXPECT_EQ(run["calls"][0]["calls"], "closest hit, single rays");
    EXPECT_EQ(run["calls"][0]["rays"], 1);
  }
  EXPECT_TRUE(figures["verdict"][0].get<std::string>().starts_with("verdict: "));
}

TEST_F(CompareTest, AMeshGetsTablesAndAVerdict) {
  std::ofstream(folder_ / "mesh.obj")
      << "v -9 -9 0\nv 9 -9 0\nv 0 9 0\nv 0 0 3\nf 1 2 3\nf 1 2 4\n";
  ASSERT_EQ(
      Run("--repeat 1 --threads 1 --kind primary ambient --rays 1 64K --json figures mesh.obj"), 0)
      << errors_;
  for (const char* const text :
       {"mesh.obj: 2 triangles", "commit, ms", "peak, MB", "first: Embree", "primary", "ambient",
        "64K", "verdict: ", "(first passes)", "(later passes)", "gains: ", "loses: "}) {
    EXPECT_TRUE(Has(out_, text)) << text << " in\n" << out_;
  }
  const auto figures = nlohmann::json::parse(Read("figures"));
  ASSERT_EQ(figures["cells"].size(), 4u);
  EXPECT_EQ(figures["cells"][0]["triangles"], 2);
  EXPECT_GT(figures["cells"][0]["steady_ratio"], 0);
  EXPECT_GT(figures["memory"][0]["dacrt"]["peak_resident_bytes"], 0);
  EXPECT_TRUE(figures["verdict"][0].get<std::string>().starts_with("verdict: "));
}

TEST_F(CompareTest, AProgramThatNeedsEmbreeIsToldToStay) {
  EXPECT_EQ(Run("--repeat 1 '" KNOWN_CALLS "' embree"), kNotForDacrt) << errors_;
  EXPECT_TRUE(Has(out_,
                  "verdict: stay: it does not run with dacrt: exit code 3, after "
                  "\"the wrong library\""))
      << out_;
  EXPECT_EQ(Run("--repeat 1 '" KNOWN_CALLS "' curves"), kNotForDacrt) << errors_;
  EXPECT_TRUE(Has(out_, "verdict: stay: 1 of its geometries")) << out_;
}

TEST_F(CompareTest, BadInputGetsOneLineAndAnExitCode) {
  constexpr int kUsage = 2, kMesh = 3, kOutput = 5;
  ExpectRefusal("", kUsage, "a mesh or a program is needed");
  ExpectRefusal("--colour red mesh.ply", kUsage, "there are --help --embree");
  ExpectRefusal("--repeat 0 mesh.ply", kUsage, "repeat");
  ExpectRefusal("--isa mmx mesh.ply", kUsage, "avx2");
  ExpectRefusal("--embree nowhere.so mesh.ply", kUsage, "nowhere.so");
  ExpectRefusal("--json missing/figures hall-75k", kOutput, "missing/figures: cannot be written");
  ExpectRefusal("hall-75k --threads 1", kUsage, "options stand before it");
  ExpectRefusal("missing.ply", kMesh, "missing.ply: there is no such file");
  std::ofstream(folder_ / "broken.ply") << "ply\n";
  ExpectRefusal("broken.ply", kMesh, "broken.ply: ");
  ExpectRefusal("no_such_program", kProgramFailed, "neither a mesh");
  std::ofstream(folder_ / "plain.txt") << "no program\n";
  ExpectRefusal("./plain.txt", kProgramFailed, "neither a mesh");
  ExpectRefusal("--repeat 1 true", kProgramFailed, "makes no call of Embree 3");
  ExpectRefusal("--repeat 1 '" KNOWN_CALLS "' dacrt", kProgramFailed,
                "does not run with Embree: exit code 3, after \"the wrong library\"");
  ExpectRefusal("--repeat 1 --embree '" DACRT_DROP_IN "' '" KNOWN_CALLS "' all", kProgramFailed,
                "which is dacrt's");
  EXPECT_EQ(Run("--help"), 0);
}

}  // namespace
}  // namespace dacrt::compare

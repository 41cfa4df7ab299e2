// The sample as its user meets it: command line in, picture and exit code out.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <string>
#include <vector>

#include "tests/meshes.h"
#include "tests/pictures.h"
#include "tests/program.h"

namespace sample_test {
namespace {

using Arguments = std::vector<std::string>;

Arguments operator+(Arguments a, const Arguments& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class AmbientOcclusion : public testing::Test {
 protected:
  Outcome Run(const Arguments& arguments, const std::string& limits = ":") const {
    return RunProgram(folder_.path(), AMBIENT_OCCLUSION, arguments, limits);
  }

  Outcome RunWithEmbree(const Arguments& arguments) const {
    return RunProgram(folder_.path(), AMBIENT_OCCLUSION_EMBREE, arguments);
  }

  Picture Draw(const Arguments& arguments, const std::string& name) const {
    const Outcome outcome = Run(arguments + Arguments{"-o", name});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return ReadPicture(folder_ / name);
  }

  // Every failure says so in one line, and leaves the folder as it was.
  void ExpectFailure(const Arguments& arguments, int exit_code, const std::string& message,
                     const std::string& limits = ":") const {
    const std::vector<std::string> before = folder_.Names();
    const Outcome outcome = Run(arguments, limits);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.errors;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_EQ(outcome.errors.rfind("ambient_occlusion: ", 0), 0u) << outcome.errors;
    EXPECT_NE(outcome.errors.find(message), std::string::npos) << outcome.errors;
    EXPECT_EQ(folder_.Names(), before);
  }

  const TemporaryFolder folder_;
};

const Arguments kSmall = {"--size", "40", "30", "--samples", "1", "--ao-samples", "4"};
const Arguments kMeshCamera = {"--eye", "3", "2", "4", "--look-at", "0", "0.25", "0"};

// -- Pictures -------------------------------------------------------------------------------------

// A thousand occlusion rays a pixel: one that differs is less than one step of 8 bits.
TEST_F(AmbientOcclusion, DropInAndEmbreeDrawTheSameHall) {
  const Arguments hall = {"--triangles", "75000", "--size",       "160", "90",
                          "--samples",   "16",    "--ao-samples", "64"};
  const Picture with_dacrt = Draw(hall, "dacrt.png");
  const Outcome embree = RunWithEmbree(hall + Arguments{"-o", "embree.png"});
  ASSERT_EQ(embree.exit_code, 0) << embree.errors;
  const Difference difference = Compare(with_dacrt, ReadPicture(folder_ / "embree.png"));
  std::cout << "pixels that differ: " << difference.pixels << " of " << 160 * 90 << ", by at most "
            << difference.largest << " of 255\n";
  EXPECT_LE(difference.largest, 1);
  EXPECT_LE(difference.pixels, 160 * 90 / 100u);
}

TEST_F(AmbientOcclusion, IsDeterministicAndSeeded) {
  const Picture first = Draw(kSmall, "first.png");
  Draw(kSmall, "second.png");
  EXPECT_EQ(ReadFile(folder_ / "first.png"), ReadFile(folder_ / "second.png"));
  const Picture other = Draw(kSmall + Arguments{"--seed", "1"}, "other.png");
  EXPECT_GT(Compare(first, other).pixels, 40 * 30 / 2u);
}

TEST_F(AmbientOcclusion, EveryMeshFormatGivesTheSamePicture) {
  const Arguments view = kSmall + kMeshCamera;
  Picture reference;
  for (const MeshFile& file : MeshInEveryFormat()) {
    SCOPED_TRACE(file.name);
    WriteFile(folder_ / file.name, file.content);
    const Picture picture = Draw(view + Arguments{file.name}, file.name + ".png");
    if (reference.samples.empty()) reference = picture;
    ASSERT_EQ(picture.samples.size(), reference.samples.size());
    EXPECT_EQ(Compare(picture, reference).pixels, 0u);
  }
  // And there is something to be seen.
  const auto [darkest, brightest] =
      std::minmax_element(reference.samples.begin(), reference.samples.end());
  EXPECT_LT(*darkest, 180);
  EXPECT_GT(*brightest, 220);
}

TEST_F(AmbientOcclusion, LeavesOutTrianglesThatAreNotFinite) {
  WriteFile(folder_ / "mesh.obj", MeshAs("mesh.obj"));
  WriteFile(folder_ / "nan.obj",
            MeshAs("mesh.obj") + "v nan 0 0\nv 1e30 0 0\nf 1 2 11\nf 1 2 12\n");
  const Picture without = Draw(kSmall + Arguments{"mesh.obj"}, "without.png");
  const Picture with = Draw(kSmall + Arguments{"nan.obj"}, "with.png");
  EXPECT_EQ(Compare(with, without).pixels, 0u);
}

TEST_F(AmbientOcclusion, WritesEveryPictureFormat) {
  const auto mean = [](const Picture& picture) {
    return std::accumulate(picture.samples.begin(), picture.samples.end(), 0.0) /
           double(picture.samples.size());
  };
  for (const std::string name : {"p.png", "p.jpg", "p.jpeg", "P.PNG", "p.exr"}) {
    SCOPED_TRACE(name);
    const Picture picture = Draw(kSmall, name);
    EXPECT_EQ(picture.width, 40);
    EXPECT_EQ(picture.height, 30);
    EXPECT_EQ(picture.channels, 3);
    EXPECT_EQ(picture.is_half, name == "p.exr");
    EXPECT_NEAR(mean(picture), mean(ReadPicture(folder_ / "p.png")), picture.is_half ? 255 : 1);
    if (picture.is_half) {  // linear: darker than its sRGB code, and within 0 and 1
      EXPECT_GT(mean(picture), 0.1);
      EXPECT_LT(mean(picture), mean(ReadPicture(folder_ / "p.png")) / 255);
    }
  }
  EXPECT_EQ(folder_.Names(),
            (std::vector<std::string>{"P.PNG", "p.exr", "p.jpeg", "p.jpg", "p.png"}));
}

TEST_F(AmbientOcclusion, ReplacesAnOlderPicture) {
  WriteFile(folder_ / "p.png", "something else");
  EXPECT_EQ(Draw(kSmall, "p.png").width, 40);
  EXPECT_EQ(folder_.Names(), std::vector<std::string>{"p.png"});
}

TEST_F(AmbientOcclusion, ReportsRaysAndSpeed) {
  const Outcome outcome = Run(kSmall + Arguments{"-o", "p.png"});
  for (const char* text : {"hall: ", " triangles", "commit", "closest hit", "1,200", "occlusion",
                           "M rays/s", "peak memory: ", "picture: p.png"}) {
    EXPECT_NE(outcome.output.find(text), std::string::npos) << text << " in\n" << outcome.output;
  }
  EXPECT_EQ(outcome.errors, "") << "no progress where there is no terminal";
}

TEST_F(AmbientOcclusion, ShowsAMeshWholeFromOutside) {
  WriteFile(folder_ / "mesh.obj", MeshAs("mesh.obj"));
  const Picture picture = Draw(kSmall + Arguments{"mesh.obj"}, "p.png");
  const auto pixel = [&](int x, int y) {
    const float* sample = &picture.samples[(size_t(y) * picture.width + x) * 3];
    return std::vector<float>(sample, sample + 3);
  };
  const std::vector<float> background = pixel(0, 0);
  EXPECT_NE(pixel(20, 15), background);
  for (int x = 0; x < 40; ++x) {
    EXPECT_EQ(pixel(x, 0), background);
    EXPECT_EQ(pixel(x, 29), background);
  }
}

// Ten units wide, its faces inwards.
TEST_F(AmbientOcclusion, ShowsARoomFromWithin) {
  WriteFile(folder_ / "room.obj",
            "v 0 0 0\nv 10 0 0\nv 10 0 10\nv 0 0 10\nv 0 4 0\nv 10 4 0\nv 10 4 10\nv 0 4 10\n"
            "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n");
  const Outcome outcome = Run(kSmall + Arguments{"room.obj", "-o", "p.png"});
  EXPECT_NE(outcome.output.find("occlusion             4,800"), std::string::npos)
      << "every camera ray ends at a wall:\n"
      << outcome.output;
}

TEST_F(AmbientOcclusion, PrintsItsHelp) {
  const Outcome outcome = Run({"--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("--ao-radius"), std::string::npos);
}

// -- Errors ---------------------------------------------------------------------------------------

TEST_F(AmbientOcclusion, RejectsBadCommandLines) {
  constexpr int kUsage = 2;
  const std::vector<Arguments> bad = {
      {"--no-such-option"},
      {"a.obj", "b.obj"},
      {"--size", "0", "10"},
      {"--size", "10"},
      {"--size", "many", "10"},
      {"--size", "70000", "10"},
      {"--size", "65536", "65536"},
      {"--samples", "0"},
      {"--samples", "-1"},
      {"--ao-samples", "0"},
      {"--ao-radius", "0"},
      {"--ao-radius", "-1"},
      {"--ao-radius", "nan"},
      {"--seed", "x"},
      {"--triangles", "10"},
      {"--triangles", "75000", "mesh.obj"},
      {"--eye", "1", "2"},
      {"--eye", "1", "2", "nan"},
      {"--eye", "1", "2", "inf"},
      {"--eye", "1", "2", "x"},
      {"--fov", "0"},
      {"--fov", "180"},
      {"--fov", "nan"},
  };
  for (const Arguments& arguments : bad) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    ExpectFailure(arguments, kUsage, "--help");
  }
  ExpectFailure({"--no-such-option"}, kUsage, "; there are --help MESH --triangles");
}

TEST_F(AmbientOcclusion, RejectsACameraWithoutDirection) {
  for (const Arguments& camera : std::vector<Arguments>{
           {"--eye", "1", "2", "3", "--look-at", "1", "2", "3"},
           {"--eye", "1", "2", "3", "--look-at", "1", "5", "3"},
           {"--up", "0", "0", "0"},
       }) {
    SCOPED_TRACE(testing::PrintToString(camera));
    ExpectFailure(kSmall + camera, 2, "no direction");
  }
}

TEST_F(AmbientOcclusion, RejectsWhatIsNoMesh) {
  constexpr int kMesh = 3;
  ExpectFailure({"missing.obj"}, kMesh, "missing.obj: there is no such file");
  ExpectFailure({"."}, kMesh, "this is a folder");
  const std::vector<MeshFile> broken = {
      {"empty.obj", ""},
      {"empty.ply", ""},
      {"empty.stl", ""},
      {"empty.glb", ""},
      {"text.obj", "This is no mesh, though it is called one, and says nothing of vertices.\n"},
      {"text.ply", "This is no mesh, though it is called one, and says nothing of vertices.\n"},
      {"text.glb", "This is no mesh, though it is called one, and says nothing of vertices.\n"},
      {"mesh.xyzzy", "v 0 0 0\n"},
      {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\nl 1 2\n"},
      {"nan.obj", "v nan 0 0\nv 1 nan 0\nv 0 1 nan\nf 1 2 3\n"},
      {"huge.obj", "v 1e30 0 0\nv 0 1e30 0\nv 0 0 1e30\nf 1 2 3\n"},
      {"dot.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"},
      {"index.ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n5 7 8 9 999999999 -5\n"},
  };
  for (const MeshFile& file : broken) {
    SCOPED_TRACE(file.name);
    WriteFile(folder_ / file.name, file.content);
    ExpectFailure(kSmall + Arguments{file.name}, kMesh, file.name + ": ");
  }
}

// Some of these send Assimp into a crash or an endless loop. Text formats without a count, which
// still make sense when cut, are left out.
TEST_F(AmbientOcclusion, RejectsTruncatedMeshes) {
  for (const std::string name :
       {"binary.ply", "ascii.ply", "binary.stl", "mesh.gltf", "mesh.glb"}) {
    const std::string whole = MeshAs(name);
    for (int tenths = 1; tenths < 10; tenths += 2) {
      const std::string cut = std::to_string(tenths) + name;
      SCOPED_TRACE(cut);
      WriteFile(folder_ / cut, whole.substr(0, whole.size() * tenths / 10));
      ExpectFailure(kSmall + Arguments{cut}, 3, cut + ": ");
    }
  }
}

TEST_F(AmbientOcclusion, SurvivesDamagedMeshes) {
  uint32_t state = 1;
  const auto random = [&] { return (state = state * 1664525 + 1013904223) >> 8; };
  for (const MeshFile& file : MeshInEveryFormat()) {
    if (file.name == "ascii.ply") continue;  // Assimp may read it for ever
    for (int round = 0; round < 4; ++round) {
      std::string damaged = file.content;
      for (int byte = 0; byte < 4; ++byte) damaged[random() % damaged.size()] = char(random());
      const std::string name = std::to_string(round) + file.name;
      SCOPED_TRACE(name);
      WriteFile(folder_ / name, damaged);
      const Outcome outcome = Run(kSmall + Arguments{name, "-o", "p.png"});
      EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 3 || outcome.exit_code == 6)
          << outcome.exit_code << outcome.errors;
    }
  }
}

TEST_F(AmbientOcclusion, RejectsWhereNoPictureCanBeWritten) {
  constexpr int kOutput = 4;
  ExpectFailure({"-o", "p.gif"}, kOutput, "p.gif: the name must end in");
  ExpectFailure({"-o", "p"}, kOutput, "must end in");
  ExpectFailure({"-o", ""}, kOutput, "must end in");
  ExpectFailure({"-o", "missing/p.png"}, kOutput, "missing/p.png: there is no such folder");
  ExpectFailure({"-o", "/proc/p.png"}, kOutput, "/proc/p.png: ");
  std::filesystem::create_directory(folder_ / "folder.png");
  ExpectFailure({"-o", "folder.png"}, kOutput, "this is a folder");
  // Found before any work is done, also before a mesh is looked for.
  ExpectFailure({"missing.obj", "-o", "missing/p.png"}, kOutput, "missing/p.png");
}

TEST_F(AmbientOcclusion, ReportsErrorsOfTheLibrary) {
  const Arguments bad_device = kSmall + Arguments{"--device", "threads=x", "-o", "p.png"};
  for (const Outcome& outcome : {Run(bad_device), RunWithEmbree(bad_device)}) {
    EXPECT_EQ(outcome.exit_code, 5);
    EXPECT_NE(outcome.errors.find("ambient_occlusion: Embree reports error 1"), std::string::npos)
        << outcome.errors;
  }
  EXPECT_TRUE(folder_.Names().empty());
}

// The file system is full, or the file too large for it.
TEST_F(AmbientOcclusion, KeepsTheOlderPictureWhenTheNewOneCannotBeWritten) {
  WriteFile(folder_ / "p.exr", "older");
  ExpectFailure({"--size", "200", "200", "--samples", "1", "--ao-samples", "1", "-o", "p.exr"}, 4,
                "p.exr: ", "trap '' XFSZ && ulimit -f 8");
  EXPECT_EQ(ReadFile(folder_ / "p.exr"), "older");
}

TEST_F(AmbientOcclusion, ReportsThatMemoryRanOut) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the address sanitizer needs all of the address space";
#endif
  ExpectFailure({"--size", "8000", "8000", "--samples", "64"}, 6, "out of memory",
                "ulimit -v 4000000");
}

}  // namespace
}  // namespace sample_test

// The configuration string and the environment variable DACRT_CONFIG.
#include <gtest/gtest.h>

#include <cstdlib>

#include "session.h"

namespace dacrt::tests {
namespace {

/// What rtcNewDevice says to `config`.
RTCError NewDeviceError(const Api& api, const char* config) {
  const RTCDevice device = api.rtcNewDevice(config);
  const RTCError error = api.rtcGetDeviceError(nullptr);
  EXPECT_EQ(device == nullptr, error != RTC_ERROR_NONE) << config;
  if (device) api.rtcReleaseDevice(device);
  return error;
}

class Config : public testing::TestWithParam<const char*> {};

TEST_P(Config, GetsTheRealLibrarysCode) {
  EXPECT_EQ(NewDeviceError(DropIn(), GetParam()), NewDeviceError(RealEmbree(), GetParam()));
}

INSTANTIATE_TEST_SUITE_P(
    Grammar, Config,
    testing::Values("", ",", "=", "==", "threads", "threads=", "threads=1,", ",threads=1",
                    "threads = 1", "threads=1 verbose=0", "threads=1 threads=abc",
                    "threads=1;threads=abc", "threads=1:threads=abc", "threads=1\nthreads=abc",
                    "threads=1,,threads=abc", "#threads=abc", "threads=1=2", "threads==1",
                    "threads=1 2", "threads=,isa=avx2", "isa= ,threads=1", "isa==avx", "isa avx2",
                    "a=b=c", "unknown", "unknown=3", "unknown=a.b,threads=abc",
                    "unknown=threads=abc", "Threads=abc", "xthreads=abc", "[", "\n"));

INSTANTIATE_TEST_SUITE_P(Numbers, Config,
                         testing::Values("threads=abc", "threads=1.5", "threads=1.", "threads=-1",
                                         "threads=+1", "threads=--1", "threads=1-", "threads=1a",
                                         "threads=a1", "threads=0x10", "threads=1e3",
                                         "threads=99999999999", "threads=\"1\"", "cache_size=1.5",
                                         "cache_size=1e3", "cache_size=3", "cache_size=x",
                                         "max_spatial_split_replications=1.2",
                                         "max_spatial_split_replications=x"));

INSTANTIATE_TEST_SUITE_P(
    Keys, Config,
    testing::Values("isa=sse2", "isa=sse4.2", "isa=sse42", "isa=avx", "isa=AVX2", "isa=avx512",
                    "isa=avx512,max_isa=avx2", "max_isa=avx2,isa=avx512", "max_isa=avx512",
                    "isa=foo", "isa=1", "isa=3a", "isa=-avx", "isa=\"avx2\"", "max_isa=1",
                    "max_isa=avx2", "verbose=x", "verbose=0", "set_affinity=x", "set_affinity=1",
                    "start_threads=x", "start_threads=1", "user_threads=x", "user_threads=1",
                    "hugepages=x", "hugepages=0", "float_exceptions=x", "tri_accel=1",
                    "tri_accel=bvh4.triangle4", "accel=1", "accel_mb=1", "builder=1", "traverser=1",
                    "tri_builder_mb=1", "quad_traverser=1", "line_accel_mb=1", "hair_builder=1",
                    "object_builder_mb=1", "subdiv_accel=1", "grid_accel_mb=1", "grid_builder=1",
                    "frequency_level=1", "frequency_level=simd256", "tessellation_cache_size=x",
                    "alloc_main_block_size=x", "instancing_open_factor=1.5",
                    "instancing_open_max=x", "presplits=x", "object_accel_mb_max_leaf_size=x",
                    "ignore_config_files=x", "benchmark=x", "enable_selockmemoryprivilege=x"));

TEST(OwnConfig, PassesSettingsToTheEngine) {
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_bins=8,dacrt_leaf_triangles=4"), RTC_ERROR_NONE);
  EXPECT_EQ(NewDeviceError(DropIn(), "threads=1, dacrt_bins = 8"), RTC_ERROR_NONE);
  // A limit, which may be above what the processor has.
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_instruction_set=avx512"), RTC_ERROR_NONE);
  EXPECT_EQ(NewDeviceError(DropIn(), "isa=sse2,dacrt_instruction_set=avx512"), RTC_ERROR_NONE);
}

TEST(OwnConfig, RefusesWhatTheEngineRefuses) {
  for (const char* const config :
       {"dacrt_nonsense=1", "dacrt_bins=1", "dacrt_bins=33", "dacrt_bins=eight", "dacrt_bins=8x",
        "dacrt_bins=", "dacrt_bins", "dacrt_=1", "threads=1,dacrt_bins=0,verbose=0",
        "dacrt_threads=1025"}) {
    EXPECT_EQ(NewDeviceError(DropIn(), config), RTC_ERROR_INVALID_ARGUMENT) << config;
  }
}

TEST(OwnConfig, BudgetIsANumberOfBytesOrAWord) {
  for (const char* const budget : {"0", "1", "100000000", "default", "unlimited"}) {
    EXPECT_EQ(NewDeviceError(DropIn(), (std::string("dacrt_budget=") + budget).c_str()),
              RTC_ERROR_NONE)
        << budget;
  }
  for (const char* const budget : {"-1", "1.5", "lots", "8M", "", "99999999999999999999999"}) {
    EXPECT_EQ(NewDeviceError(DropIn(), (std::string("dacrt_budget=") + budget).c_str()),
              RTC_ERROR_INVALID_ARGUMENT)
        << budget;
  }
}

TEST(OwnConfig, SaysWhatIsWrong) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_bins=99"), RTC_ERROR_INVALID_ARGUMENT);
  const std::string message = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(message.starts_with("rtcNewDevice: ")) << message;
  EXPECT_NE(message.find("bins"), std::string::npos) << message;
  EXPECT_NE(message.find("99"), std::string::npos) << message;
}

TEST(OwnConfig, IgnoreMasksIsASwitch) {
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_ignore_masks=0"), RTC_ERROR_NONE);
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_ignore_masks=1"), RTC_ERROR_NONE);
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_ignore_masks=2"), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(NewDeviceError(DropIn(), "dacrt_ignore_masks=yes"), RTC_ERROR_INVALID_ARGUMENT);
}

TEST(OwnConfig, IgnoreMasksIgnoresMasks) {
  for (const bool ignore : {false, true}) {
    Session s(DropIn(), ignore ? "dacrt_ignore_masks=1" : "");
    const RTCGeometry geometry = s.UncommittedTriangle();
    s.api.rtcSetGeometryMask(geometry, 0);
    s.api.rtcCommitGeometry(geometry);
    const RTCScene scene = s.SceneOf(geometry);
    EXPECT_EQ(s.HitGeometry(scene, 0), ignore ? 0 : RTC_INVALID_GEOMETRY_ID);
    EXPECT_EQ(s.HitGeometry(scene, 1), ignore ? 0 : RTC_INVALID_GEOMETRY_ID);
  }
}

TEST(OwnConfig, VerboseNamesTheLibraryAndTheInstructionSet) {
  const auto first_line = [](const char* config) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(NewDeviceError(DropIn(), config), RTC_ERROR_NONE);
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_EQ(first_line("verbose=0"), "");
  EXPECT_TRUE(first_line("verbose=1").starts_with("dacrt ")) << first_line("verbose=1");
  // What is compiled for one instruction set, as under sanitizers, has no other.
  if (first_line("verbose=1,isa=sse2") == first_line("verbose=1")) return;
  // Never more than what was asked for; what the machine has not is not used either.
  EXPECT_NE(first_line("verbose=1,isa=sse2").find("scalar"), std::string::npos);
  EXPECT_EQ(first_line("verbose=1,isa=avx").find("avx"), std::string::npos);
  EXPECT_EQ(first_line("verbose=1,isa=avx2").find("avx512"), std::string::npos);
  EXPECT_EQ(first_line("verbose=1,max_isa=sse42").find("avx"), std::string::npos);
  EXPECT_EQ(first_line("verbose=1,isa=sse42,max_isa=avx2").find("avx"), std::string::npos);
  EXPECT_NE(first_line("verbose=1,isa=avx2,isa=SSE2").find("scalar"), std::string::npos);
}

/// Sets DACRT_CONFIG for a scope.
class Environment {
 public:
  explicit Environment(const char* value) { setenv("DACRT_CONFIG", value, 1); }
  ~Environment() { unsetenv("DACRT_CONFIG"); }
};

TEST(EnvironmentConfig, SpeaksForProgramsThatPassNone) {
  const Environment environment("dacrt_nonsense=1");
  EXPECT_EQ(NewDeviceError(DropIn(), nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(NewDeviceError(DropIn(), "threads=1"), RTC_ERROR_INVALID_ARGUMENT);
}

TEST(EnvironmentConfig, GivesWayToTheProgramsOwn) {
  const Environment environment("dacrt_ignore_masks=1");
  const auto hits = [](const char* config) {
    Session s(DropIn(), config);
    return s.HitGeometry(s.SceneOf(s.Triangle()), 0) == 0;
  };
  EXPECT_TRUE(hits(nullptr));
  EXPECT_TRUE(hits("threads=1"));
  EXPECT_FALSE(hits("dacrt_ignore_masks=0"));
}

}  // namespace
}  // namespace dacrt::tests

#include "call_options.h"

#include <CLI/CLI.hpp>

#include "command_line.h"
#include "geometry_kind.h"
#include "isa.h"

namespace dacrt::bench {
namespace {

constexpr char kDescription[] =
    R"(The quick view of `tests/bench/run embree`: million rays a second of both libraries on one still
scene, and Embree's time over dacrt's, for kinds of rays x rays a call. Both in one process, in
turn, medians. Embree is at its best for each: of coherent and incoherent calls, streams and single
rays, and of AVX2 and AVX-512 where it may use both.)";

constexpr char kFooter[] = R"(
Scenes: hall-N (generated; N as 75k, 2m or 123456), box-36, a name such as sponza (a PLY file in the
folder of scenes), or any mesh that Assimp reads.

Calls of 1 ray are rtcIntersect1 and rtcOccluded1, of 4, 8 and 16 rays packets, of more rays streams.
Single rays, packets and streams of up to 4K rays are sent from as many threads to both libraries; a larger
stream is cut up between threads for Embree and sent in one call to dacrt.

  tests/bench/run calls --scene box-36
  tests/bench/run calls --scene sponza --kind diffuse --rays 1 64 1M --isa avx2
  tests/bench/run calls --scene scan.ply --eye 0 1 3 --look-at 0 1 0 --fov 40 --geometry quads --robust)";

}  // namespace

std::optional<CallOptions> ParseCallOptions(int argc, char** argv) {
  CallOptions options;
  options.folder = DACRT_SCENES_DIR;
  options.setup.isa = IsasHere().front();
  options.setup.embree = DACRT_REAL_EMBREE;
  options.setup.drop_in = DACRT_DROP_IN;
  options.kinds = {"primary", "shadow", "ambient", "diffuse"};
  options.sizes = {"1", "4", "8", "16", "64", "1K", "4K", "64K", "1M"};
  options.effort = {.repeat = 3,
                    .rounds_seconds = 0.3,
                    .warm_seconds = 0.5,
                    .slices_seconds = 0.1,
                    .sliced_side = 256};
  std::vector<float> eye, look_at;
  float fov = 60;
  bool is_robust = false, is_compact = false;

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.add_option("--scene", options.scene, "Scene")->capture_default_str()->type_name("NAME|FILE");
  app.add_option("--scenes-dir", options.folder, "Folder of the PLY scenes")
      ->envname("DACRT_SCENES_DIR")
      ->type_name("DIR");
  CLI::Option* const eye_option =
      app.add_option("--eye", eye, "Where the camera stands")->expected(3)->type_name("X Y Z");
  CLI::Option* const look_at_option =
      app.add_option("--look-at", look_at, "What it looks at")->expected(3)->type_name("X Y Z");
  eye_option->needs(look_at_option);
  look_at_option->needs(eye_option);
  app.add_option("--fov", fov, "Its vertical angle of view in degrees, with --eye")
      ->check(CLI::Range(1.0, 170.0))
      ->capture_default_str();
  app.add_option("--geometry", options.geometry, "Kind of geometry")
      ->check(CLI::IsMember(NamesOf(GeometryKinds())))
      ->capture_default_str()
      ->type_name("KIND");
  app.add_flag("--robust", is_robust, "RTC_SCENE_FLAG_ROBUST");
  app.add_flag("--compact", is_compact, "RTC_SCENE_FLAG_COMPACT");
  app.add_option("--isa", options.setup.isa, "The most that both may use")
      ->check(CLI::IsMember(IsasHere()))
      ->capture_default_str()
      ->type_name("ISA");
  app.add_option("--threads", options.setup.threads, "Threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--drop-in", options.setup.drop_in,
                 "The library to hold against Embree, by default this build's")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  app.add_option("--kind", options.kinds, "Kinds of rays")
      ->check(CLI::IsMember(NamesOf(RayKinds())))
      ->capture_default_str()
      ->type_name("KIND");
  app.add_option("--rays", options.sizes, "Rays a call")
      ->check(CLI::IsMember(NamesOf(BatchSizes())))
      ->capture_default_str()
      ->type_name("SIZE");
  app.add_option("--side", options.effort.sliced_side,
                 "Rays along one side of the picture that calls of less than 64K rays slice")
      ->check(CLI::Range(64, 512))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--repeat", options.effort.repeat, "Rounds at least")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--seconds", options.effort.rounds_seconds,
                 "More rounds, up to five times as many, until they have taken so long")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (!eye.empty()) {
    options.view = BenchView{{eye[0], eye[1], eye[2]}, {look_at[0], look_at[1], look_at[2]}, fov};
  }
  options.flags = static_cast<RTCSceneFlags>((is_robust ? RTC_SCENE_FLAG_ROBUST : 0) |
                                             (is_compact ? RTC_SCENE_FLAG_COMPACT : 0));
  return options;
}

}  // namespace dacrt::bench

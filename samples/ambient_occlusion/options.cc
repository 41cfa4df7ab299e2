#include "ambient_occlusion/options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <limits>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/program.h"

namespace ao {
namespace {

constexpr char kDescription[] =
    "Draws a mesh, or a generated hall, lit by ambient occlusion. Written against Embree 3.";

constexpr char kFooter[] = R"(
Without a camera, the hall is seen from its entrance, a mesh with rooms from within, and any other
mesh from outside, whole. What is given of the camera is kept.

Exit codes: 0 drawn, 2 bad command line, 3 mesh cannot be loaded, 4 picture cannot be written,
5 Embree reports an error, 6 out of memory, 1 anything else.)";

const CLI::Validator kFinite(
    [](std::string& text) {
      float value = 0;
      const bool finite = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
      return finite ? std::string() : "not a finite number: " + text;
    },
    "", "finite");

void AddVector(CLI::App& app, const std::string& name, std::optional<Imath::V3f>& target,
               const std::string& description) {
  app.add_option_function<std::array<float, 3>>(
         name, [&target](const std::array<float, 3>& v) { target = Imath::V3f(v[0], v[1], v[2]); },
         description)
      ->type_name("X Y Z")
      ->check(kFinite);
}

}  // namespace

std::optional<Options> ParseOptions(int argc, char** argv) {
  Options options;
  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);

  CLI::Option* mesh =
      app.add_option("MESH", options.mesh, "OBJ, PLY, glTF or STL file; the hall if none is named")
          ->type_name("");
  app.add_option("--triangles", options.hall_triangles, "Triangles of the hall, about")
      ->check(CLI::Range(scenes::kHallLeastTriangles, scenes::kHallMostTriangles))
      ->capture_default_str()
      ->type_name("N")
      ->excludes(mesh);
  app.add_option("-o,--output", options.output, "Picture to write: .png, .jpg, .jpeg or .exr")
      ->capture_default_str()
      ->type_name("FILE");

  constexpr uint32_t kMostPixels = 65'536;  // along one side
  std::array<uint32_t, 2> size = {options.width, options.height};
  app.add_option("--size", size, "Size of the picture, in pixels")
      ->check(CLI::Range(1u, kMostPixels))
      ->capture_default_str()
      ->type_name("WIDTH HEIGHT");
  app.add_option("--samples", options.samples_per_pixel, "Camera rays for each pixel")
      ->check(CLI::Range(1u, 4'096u))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--ao-samples", options.ao_samples, "Occlusion rays for each camera ray that hits")
      ->check(CLI::Range(1u, 65'536u))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--ao-radius", options.ao_radius,
                 "How far occluders are looked for [0.15 of the diagonal of the bounds]")
      ->check(kFinite & CLI::PositiveNumber)
      ->type_name("LENGTH");
  app.add_option("--seed", options.seed, "Another seed, another noise")
      ->capture_default_str()
      ->type_name("N");

  AddVector(app, "--eye", options.eye, "Position of the camera");
  AddVector(app, "--look-at", options.look_at, "What is in the middle of the picture");
  AddVector(app, "--up", options.up, "What is up in the picture [0 1 0]");
  app.add_option("--fov", options.vertical_fov, "Vertical field of view [62 in the hall, else 50]")
      ->check(kFinite & CLI::Range(0.1f, 179.0f))
      ->type_name("DEGREES");
  app.add_option("--device", options.device, "Configuration for rtcNewDevice, as in threads=4")
      ->type_name("CONFIG");

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  options.width = size[0];
  options.height = size[1];

  // All camera rays go into one call, which counts them in 32 bits.
  const uint64_t rays = uint64_t(options.width) * options.height * options.samples_per_pixel;
  if (rays > std::numeric_limits<uint32_t>::max()) {
    throw Error(ExitCode::kUsage,
                "--size and --samples make " + std::to_string(rays) +
                    " camera rays; at most 4294967295 fit into one call (see --help)");
  }
  return options;
}

}  // namespace ao

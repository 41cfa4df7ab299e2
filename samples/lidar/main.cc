// Drives a laser scanner down a street: a still scene, a mesh that moves, a million rays a sweep.
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ambient_occlusion/image_file.h"
#include "ambient_occlusion/program.h"
#include "ambient_occlusion/progress.h"
#include "ambient_occlusion/stopwatch.h"
#include "dacrt/callback_of.h"
#include "dacrt/dacrt.h"
#include "lidar/cloud_file.h"
#include "lidar/cloud_picture.h"
#include "lidar/options.h"
#include "lidar/scanner.h"
#include "lidar/street.h"

namespace lidar {
namespace {

constexpr float kVanAhead = 9, kVanSpeed = 10.5f;  // metres, metres a second: slower than we are
constexpr uint32_t kPictureWidth = 1280, kPictureHeight = 720;

volatile std::sig_atomic_t was_interrupted = 0;

void Interrupt(int) { was_interrupted = 1; }

struct Sweep {
  uint64_t rays;
  uint64_t hits;
  double scene_seconds;
  double trace_seconds;
};

class Drive {
 public:
  explicit Drive(const Options& options)
      : options_(options),
        device_(std::make_shared<dacrt::Device>(dacrt::Settings{.threads = options.threads})),
        street_(MakeStreet(options.seed)),
        van_model_(MakeVan()),
        van_(van_model_),
        still_(std::make_shared<dacrt::Scene>(
            device_, dacrt::Triangles(street_.positions, street_.indices, kStreet))) {}

  size_t TriangleCount() const { return street_.TriangleCount() + van_.TriangleCount(); }

  // The street keeps what it finds out from sweep to sweep, because it is a scene of its own. The
  // van has moved: the next scene takes over what the last one has found out, and renews its
  // bounds.
  Sweep Scan(uint32_t number, ao::Progress& bar, std::vector<Point>* points) {
    const float seconds = float(number) * kSecondsASweep;
    const Imath::V3f start = ScannerAt(0);
    Place(van_model_, {start.x + kVanAhead + kVanSpeed * seconds, 0, start.z}, &van_);
    std::vector<dacrt::RayHit> rays = MakeSweep(number, options_.rays);

    Sweep sweep{};
    const ao::Stopwatch scene_watch;
    const std::vector<dacrt::Geometry> geometries = {
        dacrt::InstanceOf(still_, dacrt::AffineTransform(), kStreet),
        dacrt::Triangles(van_.positions, van_.indices, kVan)};
    if (!scene_) {
      scene_ = std::make_unique<dacrt::Scene>(device_, geometries);
    } else {
      auto next =
          std::make_unique<dacrt::Scene>(device_, geometries, dacrt::SceneOptions(), *scene_);
      taken_over_ += next->takes_over();
      next->TakeOver(*scene_);
      scene_ = std::move(next);
    }
    sweep.scene_seconds = scene_watch.Seconds();

    const auto report = [&](size_t done, size_t all) {
      const double part = double(number) + double(done) / double(all);
      bar.Update(part / options_.sweeps);
      return was_interrupted == 0;
    };
    const ao::Stopwatch trace_watch;
    const dacrt::Statistics statistics =
        scene_->ClosestHits(rays, {.progress = dacrt::ProgressOf(report)});
    sweep.trace_seconds = trace_watch.Seconds();
    sweep.rays = statistics.rays;
    sweep.hits = statistics.hits;
    AddPoints(rays, points);
    return sweep;
  }

  void Report(const std::vector<Sweep>& sweeps) const {
    std::printf("street and van: %zu triangles\n", TriangleCount());
    std::printf("%-6s %11s %11s %9s %9s %10s\n", "sweep", "rays", "hits", "scene s", "trace s",
                "M rays/s");
    for (size_t i = 0; i < sweeps.size(); ++i) {
      const Sweep& sweep = sweeps[i];
      std::printf("%-6zu %11llu %11llu %9.4f %9.3f %10.2f\n", i + 1,
                  static_cast<unsigned long long>(sweep.rays),
                  static_cast<unsigned long long>(sweep.hits), sweep.scene_seconds,
                  sweep.trace_seconds, double(sweep.rays) / sweep.trace_seconds / 1e6);
    }
    std::printf("scenes that took over what the one before had found out: %u\n", taken_over_);
    std::printf("kept of the street: %.1f bytes a triangle; workspaces: %.1f MB\n",
                double(still_->KeptBytesUsed()) / double(street_.TriangleCount()),
                double(device_->WorkspaceBytesHeld()) / 1e6);
  }

 private:
  const Options& options_;
  const std::shared_ptr<dacrt::Device> device_;
  const scenes::Mesh street_;
  const scenes::Mesh van_model_;
  scenes::Mesh van_;  // where it is now
  const std::shared_ptr<const dacrt::Scene> still_;
  std::unique_ptr<dacrt::Scene> scene_;  // of the last sweep
  uint32_t taken_over_ = 0;              // scenes
};

void Run(const Options& options) {
  const CloudFile cloud_file(options.cloud);
  const ao::ImageFile picture_file(options.picture);
  std::signal(SIGINT, Interrupt);
  Drive drive(options);
  std::vector<Point> points;
  std::vector<Sweep> sweeps;
  {
    ao::Progress bar("scanning");
    for (uint32_t i = 0; i < options.sweeps && !was_interrupted; ++i) {
      sweeps.push_back(drive.Scan(i, bar, &points));
    }
  }
  cloud_file.Write(points);
  picture_file.Write(DrawCloud(points, kPictureWidth, kPictureHeight));
  drive.Report(sweeps);
  std::printf("%zu points: %s\npicture: %s\n", points.size(), options.cloud.c_str(),
              options.picture.c_str());
}

}  // namespace
}  // namespace lidar

int main(int argc, char** argv) {
  return ao::RunProgram("lidar", [&] {
    if (const auto options = lidar::ParseOptions(argc, argv)) lidar::Run(*options);
  });
}

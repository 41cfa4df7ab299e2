// Draws a hall of which every rank holds a slice, lit by ambient occlusion. Every rank draws some
// rows of the one picture, with rays that go where the triangles are.
//
//   mpirun -n 4 divided_ambient_occlusion --triangles 100000000 --output hall.png
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "ambient_occlusion/image_file.h"
#include "ambient_occlusion/sampling.h"
#include "ambient_occlusion/view.h"
#include "dacrt/mpi.h"
#include "divided_ambient_occlusion/share.h"

namespace divided {
namespace {

using Imath::V3f;

struct Options {
  uint32_t triangles = scenes::kHallDefaultTriangles;
  uint32_t width = 960, height = 540;
  uint32_t ao_samples = 16;
  float ao_radius = 4;  // metres
  std::string output = "hall.png";
};

constexpr float kOffset = 1e-4f;  // of occlusion rays from the surface, in metres

// The components of records in memory.
dacrt::RayView ViewOf(RTCRay* rays, size_t count, size_t stride) {
  const auto at = [](auto& value) { return reinterpret_cast<dacrt::RayView::Component>(&value); };
  dacrt::RayView view;
  view.count = count;
  view.packet_stride = stride;
  if (count == 0) return view;
  view.org_x = at(rays->org_x), view.org_y = at(rays->org_y), view.org_z = at(rays->org_z);
  view.dir_x = at(rays->dir_x), view.dir_y = at(rays->dir_y), view.dir_z = at(rays->dir_z);
  view.tnear = at(rays->tnear), view.tfar = at(rays->tfar);
  return view;
}

dacrt::RayView ViewOf(std::vector<RTCRayHit>& rays) {
  dacrt::RayView view = ViewOf(&rays.data()->ray, rays.size(), sizeof(RTCRayHit));
  if (rays.empty()) return view;
  RTCHit& hit = rays[0].hit;
  const auto at = [](auto& value) { return reinterpret_cast<dacrt::RayView::Component>(&value); };
  view.ng_x = at(hit.Ng_x), view.ng_y = at(hit.Ng_y), view.ng_z = at(hit.Ng_z);
  view.geometry_id = at(hit.geomID), view.primitive_id = at(hit.primID);
  return view;
}

class Rank {
 public:
  Rank(const Options& options, MPI_Comm communicator)
      : options_(options), group_(dacrt::mpi::Divide(communicator)) {
    const uint32_t rank = uint32_t(group_->rank()), ranks = uint32_t(group_->size());
    mesh_ = TakeShare(scenes::MakeHall(options.triangles), rank, ranks);
    first_row_ = options.height * rank / ranks;
    end_row_ = options.height * (rank + 1) / ranks;
    dacrt::Geometry geometry;
    geometry.geometry_id = rank;
    geometry.primitive_count = mesh_.TriangleCount();
    geometry.vertices = {{mesh_.positions.data(), 12}};
    geometry.vertex_count = mesh_.VertexCount();
    geometry.primitives = {mesh_.indices.data(), 12};
    local_ =
        std::make_unique<dacrt::Scene>(device_, std::span(&geometry, 1), dacrt::SceneOptions{});
    scene_ = group_->Commit(dacrt::mpi::Local(*device_, *local_), {&geometry, 1}, {});
  }

  // The pixels of this rank's rows.
  std::vector<float> Draw() {
    const auto start = std::chrono::steady_clock::now();
    const scenes::Camera hall = scenes::HallCamera();
    const auto vector = [](const float(&v)[3]) { return V3f(v[0], v[1], v[2]); };
    const ao::Camera camera(
        {vector(hall.eye), vector(hall.look_at), vector(hall.up), hall.vertical_fov},
        options_.width, options_.height);
    std::vector<RTCRayHit> rays;
    for (uint32_t y = first_row_; y < end_row_; ++y) {
      for (uint32_t x = 0; x < options_.width; ++x) {
        rays.push_back(ao::MakeRayHit(camera.eye(), camera.DirectionThrough(x + 0.5f, y + 0.5f)));
      }
    }
    // Collective, as all calls: every rank makes them, whether it has rays or not.
    scene_->Trace(dacrt::Query::kClosest, ViewOf(rays));
    std::vector<RTCRay> occlusion = OcclusionRays(rays);
    scene_->Trace(dacrt::Query::kAny, ViewOf(occlusion.data(), occlusion.size(), sizeof(RTCRay)));

    std::vector<float> pixels;
    const RTCRay* shadow = occlusion.data();
    for (const RTCRayHit& ray : rays) {
      float light = 1;
      if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        const auto open = std::count_if(shadow, shadow + options_.ao_samples,
                                        [](const RTCRay& one) { return one.tfar >= 0; });
        light = float(open) / float(options_.ao_samples);
        shadow += options_.ao_samples;
      }
      pixels.insert(pixels.end(), 3, light);
    }
    rays_ = rays.size() + occlusion.size();
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return pixels;
  }

  void Report() const {
    const dacrt::mpi::Traffic traffic = group_->traffic();
    std::printf(
        "rank %d: %zu triangles; %llu rays of its own, %llu traced here; %.1f MB sent; "
        "%.2f s, of which tracing %.2f s, moving rays %.2f s, waiting %.2f s\n",
        group_->rank(), mesh_.TriangleCount(), static_cast<unsigned long long>(rays_),
        static_cast<unsigned long long>(traffic.rays_traced), double(traffic.bytes_sent) * 1e-6,
        seconds_, traffic.seconds_tracing, traffic.seconds_moving, traffic.seconds_waiting);
    std::fflush(stdout);
  }

 private:
  std::vector<RTCRay> OcclusionRays(const std::vector<RTCRayHit>& hits) const {
    std::vector<RTCRay> rays;
    for (size_t i = 0; i < hits.size(); ++i) {
      const auto& [ray, hit] = hits[i];
      if (hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      const V3f direction(ray.dir_x, ray.dir_y, ray.dir_z);
      V3f normal(hit.Ng_x, hit.Ng_y, hit.Ng_z);
      normal.normalize();
      if (normal.dot(direction) > 0) normal = -normal;
      const V3f origin =
          V3f(ray.org_x, ray.org_y, ray.org_z) + direction * ray.tfar + normal * kOffset;
      const uint32_t pixel = first_row_ * options_.width + uint32_t(i);
      const ao::PixelSamples samples(pixel, 0, options_.ao_samples);
      for (uint32_t sample = 0; sample < options_.ao_samples; ++sample) {
        rays.push_back(
            ao::MakeRay(origin, ao::CosineDirection(normal, samples(sample)), options_.ao_radius));
      }
    }
    return rays;
  }

  const Options& options_;
  const std::shared_ptr<dacrt::mpi::Group> group_;
  const std::shared_ptr<dacrt::Device> device_ = std::make_shared<dacrt::Device>();
  scenes::Mesh mesh_;
  uint32_t first_row_ = 0, end_row_ = 0;
  std::unique_ptr<dacrt::Scene> local_;
  std::unique_ptr<dacrt::mpi::GroupScene> scene_;
  uint64_t rays_ = 0;
  double seconds_ = 0;
};

// The rows of all ranks, on rank 0.
std::vector<float> Collect(const std::vector<float>& rows) {
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int count = int(rows.size());
  std::vector<int> counts(size_t(ranks), 0), places(size_t(ranks), 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  for (size_t i = 1; i < places.size(); ++i) places[i] = places[i - 1] + counts[i - 1];
  std::vector<float> picture(rank == 0 ? size_t(places.back() + counts.back()) : 0);
  MPI_Gatherv(rows.data(), count, MPI_FLOAT, picture.data(), counts.data(), places.data(),
              MPI_FLOAT, 0, MPI_COMM_WORLD);
  return picture;
}

/// What the program ends with: 0, or 2 if the command line is wrong.
int Run(int argc, char** argv) {
  Options options;
  CLI::App app("Draws a hall of which every MPI rank holds a slice.");
  app.add_option("--triangles", options.triangles, "of the whole hall")->capture_default_str();
  app.add_option("--width", options.width)->capture_default_str();
  app.add_option("--height", options.height)->capture_default_str();
  app.add_option("--ao-samples", options.ao_samples, "occlusion rays a pixel")
      ->capture_default_str();
  app.add_option("-o,--output", options.output, "the picture")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& end) {
    // All ranks have the same command line, and one of them talks about it.
    int rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank == 0) app.exit(end);
    return end.get_exit_code() == 0 ? 0 : 2;
  }
  MPI_Comm communicator;
  MPI_Comm_dup(MPI_COMM_WORLD, &communicator);
  Rank rank(options, communicator);
  std::vector<float> picture = Collect(rank.Draw());
  rank.Report();
  if (!picture.empty()) {
    ao::ImageFile(options.output).Write({options.width, options.height, std::move(picture)});
  }
  return 0;
}

}  // namespace
}  // namespace divided

int main(int argc, char** argv) {
  int level, code = 1;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level);
  try {
    code = divided::Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "divided_ambient_occlusion: %s\n", error.what());
    // The other ranks may be waiting for this one.
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return code;
}

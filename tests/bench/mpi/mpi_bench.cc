// Several ranks beside one, on one machine: under mpirun. Times are the least of several rounds, in
// which one process and the group take turns.
//
//   mpirun -n 2 build/tests/bench/mpi_bench --mode replicate
//   mpirun -n 2 build/tests/bench/mpi_bench --mode divide
#include <CLI/CLI.hpp>
#include <mpi.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <optional>

#include "command_line.h"
#include "dacrt/mpi.h"
#include "errors.h"
#include "mpi_model.h"
#include "ray_kind.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

struct Options {
  std::string mode = "replicate", scene = "hall-1m", kind = "diffuse";
  uint32_t rays_a_side = 1024;
  int repeat = 7;
  uint32_t piece_rays = 65536;
  float longest = 1;
  int axis = -1;  ///< of the first cut in two; the longest if negative
};

/// Waits for all without keeping the processor busy: another rank may be measured on it.
void Barrier() {
  MPI_Request request;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  for (int is_done = 0; !is_done;) {
    MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
    const timespec time{0, 200'000};
    nanosleep(&time, nullptr);
  }
}

double Largest(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return value;
}

double Sum(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return value;
}

MPI_Comm OwnCommunicator() {
  MPI_Comm communicator;
  MPI_Comm_dup(MPI_COMM_WORLD, &communicator);
  return communicator;
}

Settings WithThreads(uint32_t threads) {
  Settings settings;
  settings.threads = threads;
  return settings;
}

/// A device and a scene on it.
struct Local {
  Local(const TriangleMesh& mesh, uint32_t threads)
      : device(std::make_shared<Device>(WithThreads(threads))), scene(device, {&mesh, 1}) {}
  std::shared_ptr<Device> device;
  Scene scene;
};

Geometry AsGeometry(const TriangleMesh& mesh) {
  Geometry geometry;
  geometry.geometry_id = mesh.geometry_id;
  geometry.primitive_count = mesh.triangle_count;
  geometry.vertices = {{mesh.vertices, mesh.vertex_stride}};
  geometry.vertex_count = mesh.vertex_count;
  geometry.primitives = {mesh.triangles, mesh.triangle_stride};
  return geometry;
}

/// Of the processor, by all ranks: on a machine with other work it says more than the clock does.
class ProcessorClock {
 public:
  ProcessorClock() : processes_(RankCount()) {
    const int64_t own = getpid();
    MPI_Allgather(&own, 1, MPI_INT64_T, processes_.data(), 1, MPI_INT64_T, MPI_COMM_WORLD);
  }

  double Seconds() const {
    double seconds = 0;
    for (const int64_t process : processes_) {
      clockid_t clock;
      timespec time{};
      if (clock_getcpuclockid(static_cast<pid_t>(process), &clock) == 0)
        clock_gettime(clock, &time);
      seconds += static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    return seconds;
  }

 private:
  static std::size_t RankCount() {
    int ranks;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    return static_cast<std::size_t>(ranks);
  }

  std::vector<int64_t> processes_;
};

double TimeOf(const std::function<void()>& body) {
  const Stopwatch watch;
  body();
  return watch.Seconds();
}

mpi::Traffic Difference(mpi::Traffic a, const mpi::Traffic& b) {
  a.calls_shared -= b.calls_shared;
  a.rays_out -= b.rays_out;
  a.rays_traced -= b.rays_traced;
  a.messages_sent -= b.messages_sent;
  a.messages_received -= b.messages_received;
  a.bytes_sent -= b.bytes_sent;
  a.bytes_received -= b.bytes_received;
  a.seconds_tracing -= b.seconds_tracing;
  a.seconds_moving -= b.seconds_moving;
  a.seconds_waiting -= b.seconds_waiting;
  return a;
}

/// A call that was timed.
struct Timed {
  double seconds = 1e30;
  double processor_seconds = 1e30;  ///< of all ranks
  mpi::Traffic traffic;

  /// Takes over what another round has done better.
  void Improve(const Timed& other) {
    processor_seconds = std::min(processor_seconds, other.processor_seconds);
    if (other.seconds >= seconds) return;
    seconds = other.seconds;
    traffic = other.traffic;
  }
};

Timed TimedCall(const ProcessorClock& clock, const std::function<void()>& call) {
  const double before = clock.Seconds();
  Timed timed;
  timed.seconds = TimeOf(call);
  timed.processor_seconds = clock.Seconds() - before;
  return timed;
}

constexpr int kRankCounts[] = {2, 4, 8, 16, 32, 64, 128, 256};
constexpr double kGigabits[] = {25, 100};
constexpr double kRoundTrip = 5e-6;  // between machines with such networks, through MPI

template <class Predict>
void PrintPredictions(const Predict& predict) {
  std::printf("\nmodel, million rays a second, and the share of %s\n", "ranks times one rank");
  for (const double gigabits : kGigabits) {
    const Network network{gigabits * 1e9 / 8, kRoundTrip};
    const double one = predict(network, 1);
    std::printf("%4.0f Gbit/s:", gigabits);
    for (const int ranks : kRankCounts) {
      const double rate = predict(network, ranks);
      std::printf("  %d: %.1f (%.2f)", ranks, rate / 1e6, rate / (one * ranks));
    }
    std::printf("\n");
  }
}

void PrintTimes(const char* mode, int ranks, double rays, const Timed& one, const Timed& all,
                const Timed& group) {
  std::printf("%s, %d ranks of one thread, %.0f rays: %.3f s, %.2f M/s\n", mode, ranks, rays,
              group.seconds, rays / group.seconds / 1e6);
  std::printf(
      "one rank of one thread %.3f s, %.2f M/s; of %d threads %.3f s: the group has %.2f of "
      "its speed\n",
      one.seconds, rays / one.seconds / 1e6, ranks, all.seconds, all.seconds / group.seconds);
  std::printf("processor time %.3f s, one rank of one thread %.3f s, of %d %.3f s: %.2f\n",
              group.processor_seconds, one.processor_seconds, ranks, all.processor_seconds,
              all.processor_seconds / group.processor_seconds);
}

void Replicate(const Options& options, const BenchScene& scene, RayBuffer& rays, Query query) {
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const MPI_Comm communicator = OwnCommunicator();
  const ProcessorClock clock;
  if (rank > 0) {
    mpi::Serve(communicator);
    return;
  }
  const TriangleMesh mesh = scene.AsTriangleMesh();
  Local one(mesh, 1), all(mesh, static_cast<uint32_t>(ranks));
  mpi::Options group_options;
  group_options.piece_rays = options.piece_rays;
  const auto group = mpi::Replicate(communicator, group_options);
  const Geometry geometry = AsGeometry(mesh);
  const double commit = TimeOf([&] {
    group->Commit(mpi::Local(*one.device, one.scene), {&geometry, 1}, {});
  });
  const auto shared = group->Commit(mpi::Local(*one.device, one.scene), {&geometry, 1}, {});
  Timed of_one, of_all, best;
  for (int i = 0; i < options.repeat + 1; ++i) {
    rays.Rearm();
    const Timed all_now = TimedCall(clock, [&] { all.scene.Trace(query, rays.View()); });
    rays.Rearm();
    const Timed one_now = TimedCall(clock, [&] { one.scene.Trace(query, rays.View()); });
    rays.Rearm();
    const mpi::Traffic before = group->traffic();
    Timed now = TimedCall(clock, [&] { shared->Trace(query, rays.View()); });
    now.traffic = Difference(group->traffic(), before);
    if (i == 0) continue;
    of_all.Improve(all_now);
    of_one.Improve(one_now);
    best.Improve(now);
  }
  const double count = static_cast<double>(rays.rays().size());
  PrintTimes("replicate", ranks, count, of_one, of_all, best);
  const mpi::Traffic& traffic = best.traffic;
  const double sent = std::max<double>(1, static_cast<double>(traffic.rays_out));
  MeasuredRank measured{count / of_one.seconds, traffic.seconds_moving / sent,
                        static_cast<double>(traffic.bytes_sent) / sent,
                        static_cast<double>(traffic.bytes_received) / sent};
  std::printf("calls from %zu rays on are shared; the first commit took %.3f s\n",
              group->least_rays(), commit);
  std::printf(
      "a call: %llu messages out, %llu in; %.0f%% of the rays out; bytes a ray %.1f out, "
      "%.1f back\n",
      static_cast<unsigned long long>(traffic.messages_sent),
      static_cast<unsigned long long>(traffic.messages_received), 100 * sent / count,
      measured.bytes_out_per_ray, measured.bytes_in_per_ray);
  std::printf("rank 0: tracing %.3f s, moving %.3f s (%.1f ns a ray), waiting %.3f s\n",
              traffic.seconds_tracing, traffic.seconds_moving,
              measured.moving_seconds_per_ray * 1e9, traffic.seconds_waiting);
  const Network memory{5e9, 2e-5};
  std::printf("model for this run: %.2f M/s\n",
              PredictReplicate(measured, memory, ranks, count) / 1e6);
  PrintPredictions(
      [&](const Network& network, int n) { return PredictReplicate(measured, network, n, 16e6); });
}

/// Cuts triangles in two until none is longer than `most` along an axis. Walls of a few triangles
/// would give every rank the bounds of the whole scene.
void CutLongTriangles(scenes::Mesh& mesh, float most) {
  std::vector<float>& positions = mesh.positions;
  std::vector<uint32_t>& indices = mesh.indices;
  for (std::size_t first = 0; first < indices.size();) {
    int longest = 0;
    float length = 0;
    for (int edge = 0; edge < 3; ++edge) {
      const uint32_t a = indices[first + edge], b = indices[first + (edge + 1) % 3];
      for (int axis = 0; axis < 3; ++axis) {
        const float extent = std::abs(positions[3 * a + axis] - positions[3 * b + axis]);
        if (extent > length) longest = edge, length = extent;
      }
    }
    if (length <= most) {
      first += 3;
      continue;
    }
    const uint32_t a = indices[first + longest], b = indices[first + (longest + 1) % 3],
                   c = indices[first + (longest + 2) % 3];
    const auto middle = static_cast<uint32_t>(positions.size() / 3);
    for (int axis = 0; axis < 3; ++axis) {
      positions.push_back((positions[3 * a + axis] + positions[3 * b + axis]) / 2);
    }
    const uint32_t halves[] = {a, middle, c, middle, b, c};
    std::copy(halves, halves + 3, indices.begin() + static_cast<std::ptrdiff_t>(first));
    indices.insert(indices.end(), halves + 3, halves + 6);
  }
}

/// The triangles of one rank: a part of the scene that a cut along `axis` or its longest axis, then
/// along the next, leaves. As many triangles for each.
std::vector<uint32_t> PartOf(const BenchScene& scene, int first_axis, int rank, int ranks) {
  const std::vector<float>& positions = scene.mesh.positions;
  const std::vector<uint32_t>& indices = scene.mesh.indices;
  std::vector<uint32_t> triangles(scene.TriangleCount());
  std::iota(triangles.begin(), triangles.end(), 0);
  const auto centre = [&](uint32_t triangle, int axis) {
    float sum = 0;
    for (int corner = 0; corner < 3; ++corner) {
      sum += positions[3 * indices[3 * triangle + corner] + axis];
    }
    return sum;
  };
  for (int left = ranks, number = rank; left > 1;) {
    int longest = 0;
    float length = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto by_axis = [&](uint32_t a, uint32_t b) {
        return centre(a, axis) < centre(b, axis);
      };
      const auto [low, high] = std::minmax_element(triangles.begin(), triangles.end(), by_axis);
      const float extent = centre(*high, axis) - centre(*low, axis);
      if (extent > length) longest = axis, length = extent;
    }
    if (left == ranks && first_axis >= 0) longest = first_axis;
    const int half = left / 2;
    const auto cut =
        triangles.begin() + static_cast<std::ptrdiff_t>(triangles.size() * half / left);
    std::nth_element(triangles.begin(), cut, triangles.end(), [&](uint32_t a, uint32_t b) {
      return centre(a, longest) < centre(b, longest);
    });
    if (number < half) {
      triangles.erase(cut, triangles.end());
      left = half;
    } else {
      triangles.erase(triangles.begin(), cut);
      number -= half;
      left -= half;
    }
  }
  std::vector<uint32_t> part;
  for (const uint32_t triangle : triangles) {
    for (int corner = 0; corner < 3; ++corner) part.push_back(indices[3 * triangle + corner]);
  }
  return part;
}

void Divide(const Options& options, const BenchScene& scene, RayBuffer& all_rays, Query query) {
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const MPI_Comm communicator = OwnCommunicator();
  const ProcessorClock clock;
  const std::vector<uint32_t> indices = PartOf(scene, options.axis, rank, ranks);
  TriangleMesh part = scene.AsTriangleMesh();
  part.triangles = indices.data();
  part.triangle_count = indices.size() / 3;
  part.geometry_id = static_cast<uint32_t>(rank);
  Local own(part, 1);
  std::optional<Local> one, all;
  if (rank == 0) {
    one.emplace(scene.AsTriangleMesh(), 1);
    all.emplace(scene.AsTriangleMesh(), static_cast<uint32_t>(ranks));
  }
  mpi::Options group_options;
  group_options.piece_rays = options.piece_rays;
  const auto group = mpi::Divide(communicator, group_options);
  const Geometry geometry = AsGeometry(part);
  const auto divided = group->Commit(mpi::Local(*own.device, own.scene), {&geometry, 1}, {});
  const std::size_t count = all_rays.rays().size();
  const std::size_t first = count * static_cast<std::size_t>(rank) / ranks;
  const std::size_t end = count * (static_cast<std::size_t>(rank) + 1) / ranks;
  RayBuffer own_rays = all_rays.Part(first, end - first);
  Timed of_one, of_all, best;
  for (int i = 0; i < options.repeat + 1; ++i) {
    Timed all_now, one_now;
    if (rank == 0) {
      all_rays.Rearm();
      all_now = TimedCall(clock, [&] { all->scene.Trace(query, all_rays.View()); });
      all_rays.Rearm();
      one_now = TimedCall(clock, [&] { one->scene.Trace(query, all_rays.View()); });
    }
    own_rays.Rearm();
    Barrier();
    const mpi::Traffic before = group->traffic();
    Timed now = TimedCall(clock, [&] { divided->Trace(query, own_rays.View()); });
    now.seconds = Largest(now.seconds);
    now.traffic = Difference(group->traffic(), before);
    if (i == 0) continue;
    of_all.Improve(all_now);
    of_one.Improve(one_now);
    best.Improve(now);
  }
  const mpi::Traffic& traffic = best.traffic;
  const double hops = Sum(static_cast<double>(traffic.rays_out));
  const double visits = Sum(static_cast<double>(traffic.rays_traced));
  const double bytes = Sum(static_cast<double>(traffic.bytes_sent));
  const double messages = Sum(static_cast<double>(traffic.messages_sent));
  const double tracing = Sum(traffic.seconds_tracing), moving = Sum(traffic.seconds_moving);
  const double waiting = Sum(traffic.seconds_waiting);
  const double most_visits = Largest(static_cast<double>(traffic.rays_traced));
  if (rank > 0) return;
  const double rays = static_cast<double>(count);
  PrintTimes("divide", ranks, rays, of_one, of_all, best);
  std::printf("a ray: %.2f ranks trace it, %.2f hops, %.1f bytes; %.0f messages a call\n",
              visits / rays, hops / rays, bytes / rays, messages);
  std::printf("the busiest rank traces %.2f of its share\n", most_visits * ranks / visits);
  std::printf("all ranks: tracing %.3f s, moving %.3f s, waiting %.3f s\n", tracing, moving,
              waiting);
  if (ranks == 1) return;
  const MeasuredDivide measured{visits / rays,
                                hops / rays,
                                ranks,
                                visits / tracing,
                                moving / std::max(1.0, hops),
                                bytes / std::max(1.0, hops)};
  const Network memory{5e9, 2e-5};
  std::printf("model for this run: %.2f M/s\n",
              PredictDivide(measured, memory, ranks, rays / ranks) / 1e6);
  PrintPredictions(
      [&](const Network& network, int n) { return PredictDivide(measured, network, n, 1e6); });
}

int Run(int argc, char** argv) {
  Options options;
  CLI::App app("Several MPI ranks beside one process.");
  app.add_option("--mode", options.mode, "replicate or divide")
      ->check(CLI::IsMember({"replicate", "divide"}));
  app.add_option("--scene", options.scene, "as in embree_bench");
  app.add_option("--kind", options.kind, "primary, shadow, ambient or diffuse");
  app.add_option("--rays", options.rays_a_side, "rays along a side of the picture");
  app.add_option("--repeat", options.repeat, "rounds");
  app.add_option("--piece", options.piece_rays, "rays a message");
  app.add_option("--longest", options.longest,
                 "triangles are cut to at most this; 0: they are not");
  app.add_option("--axis", options.axis, "of the first cut between ranks; -1: the longest")
      ->check(CLI::Range(-1, 2));
  if (!ParseCommandLine(app, argc, argv)) return kSuccess;
  const RayKind* const kind = FindRayKind(options.kind);
  if (!kind) throw UsageError("--kind: there is no " + options.kind);
  BenchScene scene = SceneSource(options.scene, DACRT_SCENES_DIR).Load();
  if (options.longest > 0) CutLongTriangles(scene.mesh, options.longest);
  // In replicate rank 0 alone has rays, in divide each has a share of the same.
  RaySource source(scene);
  RayBuffer rays = source.Make(*kind, options.rays_a_side, [&](RayBuffer& primary) {
    Local(scene.AsTriangleMesh(), 0).scene.Trace(Query::kClosest, primary.View());
  });
  (options.mode == "replicate" ? Replicate : Divide)(options, scene, rays, kind->query);
  return kSuccess;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  int level;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level);
  const int code =
      dacrt::bench::RunGuarded("mpi_bench", [&] { return dacrt::bench::Run(argc, argv); });
  // One rank that fails would leave the others waiting.
  if (code != 0) MPI_Abort(MPI_COMM_WORLD, code);
  MPI_Finalize();
  return code;
}

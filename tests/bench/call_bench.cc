// The quick view of the comparison with Embree: one scene, calls of every size, a table: see
// --help.
#include <cstdio>
#include <iostream>
#include <map>
#include <utility>

#include "call_options.h"
#include "errors.h"
#include "format.h"
#include "geometry_kind.h"
#include "table.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

std::string Rate(const CellResult& result, const Times& times) {
  return Fixed(result.rays / times.Steady() / 1e6, 2);
}

BenchScene LoadScene(const CallOptions& options) {
  BenchScene scene = SceneSource(options.scene, options.folder).LoadForEmbree();
  if (options.view) scene.view = *options.view;
  return scene;
}

// Kinds of rays down, sizes across, and geometric means.
void PrintRatios(const CallOptions& options,
                 const std::map<std::pair<std::string, std::string>, double>& ratios) {
  std::vector<std::string> header = {"Embree's time over dacrt's"};
  header.insert(header.end(), options.sizes.begin(), options.sizes.end());
  constexpr std::size_t kLeft = 1;
  Table table(header, kLeft);
  std::map<std::string, std::vector<double>> columns;
  for (const std::string& kind : options.kinds) {
    std::vector<std::string> row = {kind};
    for (const std::string& size : options.sizes) {
      const auto found = ratios.find({kind, size});
      row.push_back(found == ratios.end() ? "" : Fixed(found->second, 2));
      if (found != ratios.end()) columns[size].push_back(found->second);
    }
    table.Add(std::move(row));
  }
  std::vector<std::string> means = {"geometric mean"};
  for (const std::string& size : options.sizes) {
    means.push_back(columns[size].empty() ? "" : Fixed(GeometricMean(columns[size]), 2));
  }
  table.Add(std::move(means));
  table.Print(std::cout);
}

int Main(int argc, char** argv) {
  const auto options = ParseCallOptions(argc, argv);
  if (!options) return kSuccess;
  const BenchScene scene = LoadScene(*options);
  SceneContent content = FindGeometryKind(options->geometry)->make(scene);
  content.flags = static_cast<RTCSceneFlags>(content.flags | options->flags);
  EmbreeContest contest(scene, content, options->setup, options->effort);

  std::printf("%s, %s triangles, %s, %s, threads: %d; million rays a second\n", scene.name.c_str(),
              Grouped(scene.TriangleCount()).c_str(), options->geometry.c_str(),
              options->setup.isa.c_str(), options->setup.threads);
  constexpr char kRow[] = "%-9s  %5s  %8s  %8s  %6s  %7s  %s\n";
  std::printf(kRow, "rays", "call", "Embree", "dacrt", "ratio", "hits %", "Embree's best");
  std::map<std::pair<std::string, std::string>, double> ratios;
  for (const std::string& kind : options->kinds) {
    for (const std::string& size : options->sizes) {
      const Cell cell{options->scene, options->geometry,     options->setup.isa, kind,
                      size,           options->setup.threads};
      RayBuffer rays = contest.MakeRays(cell);
      if (rays.rays().size() < FindBatchSize(size)->rays && FindBatchSize(size)->IsSlice())
        continue;
      const CellResult result = contest.Measure(
          cell, [](const std::string&) {}, rays);
      ratios[{kind, size}] = result.SteadyRatio();
      std::printf(kRow, kind.c_str(), size.c_str(), Rate(result, result.embree).c_str(),
                  Rate(result, result.dacrt).c_str(), Fixed(result.SteadyRatio(), 2).c_str(),
                  Fixed(100 * result.hits, 1).c_str(), result.embree_steady.c_str());
      std::fflush(stdout);
    }
  }
  std::puts("");
  PrintRatios(*options, ratios);
  return kSuccess;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("call_bench", [=] { return dacrt::bench::Main(argc, argv); });
}

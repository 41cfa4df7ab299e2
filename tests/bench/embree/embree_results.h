// What a run of embree_bench found, and its form as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace dacrt::bench {

/// A place in the matrix.
struct Cell {
  std::string scene;
  std::string geometry;  ///< by its name in GeometryKinds
  std::string isa;       ///< the most that both libraries may use
  std::string kind;      ///< of the rays, by its name in RayKinds
  std::string size;      ///< of a call, by its name in BatchSizes
  int threads;

  bool operator==(const Cell&) const = default;
};

/// As "hall-1m, quads, avx2, diffuse, 64K, 2 threads"; triangles are not named.
std::string Name(const Cell& cell);

/// Seconds, one value a round.
struct Times {
  std::vector<double> commit;  ///< of a scene not seen before; none where that is not measured
  std::vector<double> first;   ///< the first batch on it
  std::vector<double> steady;  ///< a later batch on a still scene

  double OneShot() const;  ///< median of commit and first batch together, which there must be
  double Steady() const;   ///< median
};

/// Both libraries with the same rays.
struct CellResult {
  Cell cell;
  std::size_t triangles;
  std::size_t rays;     ///< of a batch; of a whole picture, those that this kind has
  std::size_t batches;  ///< of whose time `steady` is the mean
  double hits;          ///< the share of rays that hit something
  double equal_hits;    ///< and of those that get the same answer from both
  std::string embree_one_shot, embree_steady;  ///< the fastest ways to use Embree
  Times embree, dacrt;
  /// Seconds of embree_steady, where the scene was built with RTC_BUILD_QUALITY_HIGH instead.
  std::vector<double> high_steady;

  /// The same with Embree's scenes of high quality where rays are quicker in them.
  CellResult WithHighQuality() const;

  bool HasOneShot() const { return !dacrt.commit.empty(); }
  double OneShotRatio() const { return embree.OneShot() / dacrt.OneShot(); }
  double SteadyRatio() const { return embree.Steady() / dacrt.Steady(); }
};

/// Bytes beyond those of the mesh and the rays: what is kept after a call, and the most that there
/// was from before the scene was made until then.
struct MemoryUse {
  std::size_t kept_announced, peak_announced;  ///< to the memory monitor
  std::size_t kept_resident, peak_resident;    ///< in the memory of the process
  std::size_t left_resident;                   ///< when the scene has been released: the workspaces
};

/// Each library in a process of its own, with the same rays.
struct MemoryResult {
  Cell cell;
  std::size_t triangles;
  std::size_t rays;
  MemoryUse embree, dacrt;
};

struct EmbreeResults {
  std::string command;
  std::string processor;
  int repeat;
  std::vector<CellResult> cells;
  std::vector<MemoryResult> memory;
};

nlohmann::ordered_json ToJson(const EmbreeResults& results);

/// Adds the cells of what ToJson made. Throws nlohmann::json::exception if it is anything else.
void AddCells(const nlohmann::ordered_json& json, EmbreeResults& results);

}  // namespace dacrt::bench

// What a run of moving_bench found, and its form as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

namespace dacrt::bench {

/// Rays of a frame: a square picture's, or as many as hit something.
struct FrameSize {
  const char* name;
  std::uint32_t side;
};

/// 1K, 10K, 100K, 1M.
std::span<const FrameSize> FrameSizes();

/// Null if there is none of this name.
const FrameSize* FindFrameSize(const std::string& name);

/// A place in the matrix.
struct MovingCell {
  std::string scene;
  std::string change;  ///< by its name in ChangeKinds
  std::string kind;    ///< of the rays: primary or diffuse
  std::string size;    ///< by its name in FrameSizes
  int threads;

  bool operator==(const MovingCell&) const = default;
};

/// As "hall-1m, wave, diffuse, 10K, 2 threads".
std::string Name(const MovingCell& cell);

/// Seconds, one value a frame.
struct FrameTimes {
  std::vector<double> commit;  ///< with what tells the library of the change
  std::vector<double> stream;

  double Frame() const;  ///< median of the two together
};

struct MovingResult {
  MovingCell cell;
  std::size_t triangles;
  std::size_t rays;
  double equal_hits;        ///< the share of rays that get the same answer from both
  std::string embree_best;  ///< the fastest way to use Embree
  FrameTimes embree, dacrt;

  double Ratio() const { return embree.Frame() / dacrt.Frame(); }
};

struct MovingResults {
  std::string command;
  std::string processor;
  int repeat;
  std::vector<MovingResult> cells;
};

nlohmann::ordered_json ToJson(const MovingResults& results);

/// Adds the cells of what ToJson made. Throws nlohmann::json::exception if it is anything else.
void AddCells(const nlohmann::ordered_json& json, MovingResults& results);

}  // namespace dacrt::bench

#include "moving_results.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>

#include "format.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr FrameSize kFrameSizes[] = {{"1K", 32}, {"10K", 100}, {"100K", 316}, {"1M", 1000}};

Json ToJson(const FrameTimes& times) {
  return {{"commit_seconds", times.commit}, {"stream_seconds", times.stream}};
}

FrameTimes TimesFrom(const Json& json) {
  return {json.at("commit_seconds"), json.at("stream_seconds")};
}

Json ToJson(const MovingResult& result) {
  const MovingCell& cell = result.cell;
  return {{"scene", cell.scene},
          {"triangles", result.triangles},
          {"change", cell.change},
          {"kind", cell.kind},
          {"size", cell.size},
          {"rays", result.rays},
          {"threads", cell.threads},
          {"equal_hits", result.equal_hits},
          {"embree_best", result.embree_best},
          {"embree", ToJson(result.embree)},
          {"dacrt", ToJson(result.dacrt)},
          {"ratio", result.Ratio()}};
}

MovingResult ResultFrom(const Json& json) {
  return {
      {json.at("scene"), json.at("change"), json.at("kind"), json.at("size"), json.at("threads")},
      json.at("triangles"),
      json.at("rays"),
      json.at("equal_hits"),
      json.at("embree_best"),
      TimesFrom(json.at("embree")),
      TimesFrom(json.at("dacrt"))};
}

}  // namespace

std::span<const FrameSize> FrameSizes() { return kFrameSizes; }

const FrameSize* FindFrameSize(const std::string& name) {
  const auto found = std::ranges::find(kFrameSizes, name, &FrameSize::name);
  return found == std::end(kFrameSizes) ? nullptr : found;
}

std::string Name(const MovingCell& cell) {
  return cell.scene + ", " + cell.change + ", " + cell.kind + ", " + cell.size + ", " +
         ThreadsText(cell.threads);
}

double FrameTimes::Frame() const {
  std::vector<double> sums;
  for (std::size_t i = 0; i < commit.size(); ++i) sums.push_back(commit[i] + stream[i]);
  return Median(sums);
}

nlohmann::ordered_json ToJson(const MovingResults& results) {
  Json cells = Json::array();
  for (const MovingResult& result : results.cells) cells.push_back(ToJson(result));
  return {{"benchmark", "moving_bench"},
          {"command", results.command},
          {"processor", results.processor},
          {"repeat", results.repeat},
          {"cells", cells}};
}

void AddCells(const nlohmann::ordered_json& json, MovingResults& results) {
  for (const Json& cell : json.at("cells")) results.cells.push_back(ResultFrom(cell));
}

}  // namespace dacrt::bench

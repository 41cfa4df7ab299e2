#include "embree_results.h"

#include <nlohmann/json.hpp>

#include "format.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Times& times) {
  return {{"commit_seconds", times.commit},
          {"first_seconds", times.first},
          {"steady_seconds", times.steady}};
}

Times TimesFrom(const Json& json) {
  return {json.at("commit_seconds"), json.at("first_seconds"), json.at("steady_seconds")};
}

Json ToJson(const MemoryUse& use) {
  return {{"kept_announced_bytes", use.kept_announced},
          {"peak_announced_bytes", use.peak_announced},
          {"kept_resident_bytes", use.kept_resident},
          {"peak_resident_bytes", use.peak_resident},
          {"left_resident_bytes", use.left_resident}};
}

MemoryUse MemoryUseFrom(const Json& json) {
  return {json.at("kept_announced_bytes"), json.at("peak_announced_bytes"),
          json.at("kept_resident_bytes"), json.at("peak_resident_bytes"),
          json.at("left_resident_bytes")};
}

Json ToJson(const Cell& cell, std::size_t triangles, std::size_t rays) {
  return {{"scene", cell.scene}, {"triangles", triangles}, {"geometry", cell.geometry},
          {"isa", cell.isa},     {"kind", cell.kind},      {"size", cell.size},
          {"rays", rays},        {"threads", cell.threads}};
}

Cell CellFrom(const Json& json) {
  return {json.at("scene"), json.at("geometry"), json.at("isa"),
          json.at("kind"),  json.at("size"),     json.at("threads")};
}

Json ToJson(const CellResult& result) {
  Json json = ToJson(result.cell, result.triangles, result.rays);
  json.update({{"batches", result.batches},
               {"hits", result.hits},
               {"equal_hits", result.equal_hits},
               {"embree_one_shot", result.embree_one_shot},
               {"embree_steady", result.embree_steady},
               {"embree", ToJson(result.embree)},
               {"dacrt", ToJson(result.dacrt)},
               {"embree_high_steady_seconds", result.high_steady},
               {"steady_ratio", result.SteadyRatio()}});
  if (result.HasOneShot()) json["one_shot_ratio"] = result.OneShotRatio();
  return json;
}

CellResult CellResultFrom(const Json& json) {
  return {CellFrom(json),
          json.at("triangles"),
          json.at("rays"),
          json.at("batches"),
          json.at("hits"),
          json.at("equal_hits"),
          json.at("embree_one_shot"),
          json.at("embree_steady"),
          TimesFrom(json.at("embree")),
          TimesFrom(json.at("dacrt")),
          json.at("embree_high_steady_seconds")};
}

Json ToJson(const MemoryResult& result) {
  Json json = ToJson(result.cell, result.triangles, result.rays);
  json.update({{"embree", ToJson(result.embree)}, {"dacrt", ToJson(result.dacrt)}});
  return json;
}

MemoryResult MemoryResultFrom(const Json& json) {
  return {CellFrom(json), json.at("triangles"), json.at("rays"), MemoryUseFrom(json.at("embree")),
          MemoryUseFrom(json.at("dacrt"))};
}

template <class Result>
Json ListOf(const std::vector<Result>& results) {
  Json list = Json::array();
  for (const Result& result : results) list.push_back(ToJson(result));
  return list;
}

}  // namespace

std::string Name(const Cell& cell) {
  const std::string geometry = cell.geometry == "triangles" ? "" : ", " + cell.geometry;
  return cell.scene + geometry + ", " + cell.isa + ", " + cell.kind + ", " + cell.size + ", " +
         ThreadsText(cell.threads);
}

double Times::OneShot() const {
  std::vector<double> sums;
  for (std::size_t i = 0; i < commit.size(); ++i) sums.push_back(commit[i] + first[i]);
  return Median(sums);
}

double Times::Steady() const { return Median(steady); }

CellResult CellResult::WithHighQuality() const {
  CellResult result = *this;
  if (Median(high_steady) < embree.Steady()) result.embree.steady = high_steady;
  return result;
}

nlohmann::ordered_json ToJson(const EmbreeResults& results) {
  return {{"benchmark", "embree_bench"},    {"command", results.command},
          {"processor", results.processor}, {"repeat", results.repeat},
          {"cells", ListOf(results.cells)}, {"memory", ListOf(results.memory)}};
}

void AddCells(const nlohmann::ordered_json& json, EmbreeResults& results) {
  for (const Json& cell : json.at("cells")) results.cells.push_back(CellResultFrom(cell));
  for (const Json& cell : json.at("memory")) results.memory.push_back(MemoryResultFrom(cell));
}

}  // namespace dacrt::bench

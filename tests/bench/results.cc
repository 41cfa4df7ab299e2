#include "results.h"

#include <nlohmann/json.hpp>

#include <algorithm>

#include "paper.h"

namespace dacrt::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Count {
  const char* name;
  uint64_t Statistics::*value;
};
constexpr Count kCounts[] = {{"rays", &Statistics::rays},
                             {"hits", &Statistics::hits},
                             {"pieces", &Statistics::pieces},
                             {"subproblems", &Statistics::subproblems},
                             {"max_depth", &Statistics::max_depth},
                             {"sampled_splits", &Statistics::sampled_splits},
                             {"sah_splits", &Statistics::sah_splits},
                             {"median_splits", &Statistics::median_splits},
                             {"box_tests", &Statistics::box_tests},
                             {"rays_filtered", &Statistics::rays_filtered},
                             {"filters", &Statistics::filters},
                             {"filters_skipped", &Statistics::filters_skipped},
                             {"direct_solves", &Statistics::direct_solves},
                             {"direct_rays", &Statistics::direct_rays},
                             {"triangle_tests", &Statistics::triangle_tests}};

Json ToJson(const Statistics& statistics) {
  Json counts;
  for (const Count& count : kCounts) counts[count.name] = statistics.*count.value;
  Json seconds;
  for (const Stage& stage : kStages) seconds[stage.name] = statistics.*stage.seconds;
  return {{"counts", counts}, {"seconds", seconds}};
}

Json ToJson(const PassResult& pass) {
  Json seconds = Json::array();  // a list for each method
  for (const Runs& runs : pass.by_method) {
    Json& list = seconds.emplace_back(Json::array());
    for (const Run& run : runs.runs) list.push_back(run.seconds);
  }
  return {{"name", pass.pass.name},
          {"query", pass.pass.query == Query::kAny ? "any" : "closest"},
          {"rays", pass.rays},
          {"hits", pass.by_method.front().Median().statistics.hits},
          {"seconds", seconds}};
}

Json ToJson(const FrameResult& frame) {
  Json methods = Json::array();
  for (std::size_t i = 0; i < frame.methods.size(); ++i) {
    Json& method = methods.emplace_back(Json{{"name", frame.methods[i].name},
                                             {"median_seconds", frame.Seconds(i)},
                                             {"least_seconds", frame.LeastSeconds(i)},
                                             {"rays_per_second", frame.Rays() / frame.Seconds(i)},
                                             {"ratio_to_first", frame.Ratio(i, 0)},
                                             {"workspace_bytes", frame.workspace_bytes[i]},
                                             {"statistics", ToJson(frame.Total(i))}});
    const auto paper = PaperRatio(frame, frame.methods[i].name);
    if (paper) method["paper_ratio"] = *paper;
  }
  Json passes = Json::array();
  for (const PassResult& pass : frame.passes) passes.push_back(ToJson(pass));
  return {{"scene", frame.scene},
          {"triangles", frame.triangles},
          {"kind", frame.kind->name},
          {"title", frame.kind->title},
          {"rays_a_side", frame.raster.rays_a_side()},
          {"pixels_a_side", frame.raster.pixels_a_side()},
          {"rays", frame.Rays()},
          {"methods", methods},
          {"passes", passes}};
}

Json ToJson(const std::vector<FrameResult>& frames) {
  Json array = Json::array();
  for (const FrameResult& frame : frames) array.push_back(ToJson(frame));
  return array;
}

}  // namespace

Json ToJson(const Results& results) {
  return {{"benchmark", "method_bench"},
          {"command", results.command},
          {"processor", results.processor},
          {"instruction_set", results.instruction_set},
          {"threads", 1},
          {"repeat", results.repeat},
          {"comparison", ToJson(results.comparison)},
          {"ablation", ToJson(results.ablation)},
          {"unreadable", results.unreadable}};
}

double RestOf(const Statistics& statistics, double seconds) {
  for (const Stage& stage : kStages) seconds -= statistics.*stage.seconds;
  return std::max(seconds, 0.0);
}

}  // namespace dacrt::bench

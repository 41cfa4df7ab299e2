// Where dacrt falls off a cliff beside Embree: see --help.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cliff_cases.h"
#include "command_line.h"
#include "errors.h"
#include "format.h"
#include "output_file.h"
#include "processor.h"
#include "random.h"
#include "streams.h"
#include "table.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

using tests::EmbreeDevice;
using tests::Form;
using tests::Query;
using tests::Random;

/// A way to call, and how many times Embree's time is still no cliff.
struct Way {
  const char* name;
  Form::Call call;
  Query query;
  double goal;
  std::size_t rays;  ///< of a call; a power of two
};
constexpr std::size_t kMostRays = 1 << 15;
constexpr unsigned int kPacket = 8;
constexpr Way kWays[] = {
    {"single, closest", Form::Call::kRecord, Query::kClosest, 3, 1},
    {"single, any", Form::Call::kRecord, Query::kAny, 3, 1},
    {"32 a call, closest", Form::Call::kRecords, Query::kClosest, 2, 32},
    {"32 a call, any", Form::Call::kRecords, Query::kAny, 2, 32},
    {"stream, closest", Form::Call::kRecords, Query::kClosest, 1.5, kMostRays},
    {"stream, any", Form::Call::kRecords, Query::kAny, 1.5, kMostRays},
    {"stream of packets, closest", Form::Call::kPackets, Query::kClosest, 1.5, kMostRays},
    {"stream of packets, any", Form::Call::kPackets, Query::kAny, 1.5, kMostRays}};
constexpr double kLeastSeconds = 0.03;  ///< of a measurement: a thousand times what a clock errs by
constexpr int kRounds = 3;

RTCRayHit RayBetween(const float* from, const float* to) {
  RTCRayHit record = {};
  record.ray = {from[0],
                from[1],
                from[2],
                0,
                to[0] - from[0],
                to[1] - from[1],
                to[2] - from[2],
                0,
                std::numeric_limits<float>::infinity(),
                UINT32_MAX,
                0,
                0};
  record.hit.geomID = record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return record;
}

/// From around the unit cube to anywhere in it.
std::vector<RTCRayHit> RaysFromAnywhere() {
  Random random(7);
  std::vector<RTCRayHit> rays(kMostRays);
  for (RTCRayHit& record : rays) {
    float from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = random.Uniform(-0.5f, 1.5f);
      to[axis] = random.Uniform();
    }
    // One side in six directions of them is outside.
    from[random.Below(3)] = random.Chance(0.5f) ? -0.5f : 1.5f;
    record = RayBetween(from, to);
    record.ray.time = random.Uniform();
  }
  return rays;
}

/// From what some lines of a picture show, now nearer and now farther away, to a lamp. Lines run
/// askew, so that the box around some neighbours holds far more than they see.
std::vector<RTCRayHit> RaysToLamp() {
  Random random(8);
  constexpr std::size_t kWidth = 1024;
  constexpr float kLamp[3] = {-0.8f, 1.9f, 1};
  std::vector<RTCRayHit> rays(kMostRays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const float along = 0.8f * static_cast<float>(i % kWidth) / kWidth;
    const float across = static_cast<float>(i / kWidth) / kWidth;
    const float from[3] = {0.1f + along + across, 0.1f + along - across,
                           random.Uniform(0.6f * kSpikeHeight, 1.2f * kSpikeHeight)};
    rays[i] = RayBetween(from, kLamp);
  }
  return rays;
}

/// The same rays in packets of eight, which have the values of a record in the same order.
std::vector<RTCRayHit8> InPackets(const std::vector<RTCRayHit>& rays, std::size_t count) {
  constexpr std::size_t kValues = sizeof(RTCRayHit) / sizeof(float);
  static_assert(sizeof(RTCRayHit8) == kPacket * sizeof(RTCRayHit));
  std::vector<RTCRayHit8> packets(count / kPacket);
  for (std::size_t i = 0; i < count; ++i) {
    const auto* const record = reinterpret_cast<const std::byte*>(&rays[i]);
    auto* const lane =
        reinterpret_cast<std::byte*>(&packets[i / kPacket]) + i % kPacket * sizeof(float);
    for (std::size_t value = 0; value < kValues; ++value) {
      std::memcpy(lane + value * sizeof(RTCRayHit8) / kValues, record + value * sizeof(float),
                  sizeof(float));
    }
  }
  return packets;
}

bool IsHit(unsigned int geometry, float tfar) {
  return geometry != RTC_INVALID_GEOMETRY_ID || tfar < 0;
}

/// Traces `count` of the rays, and returns what it took and how many hit.
double Trace(const CliffScene& scene, const Way& way, std::vector<RTCRayHit> rays,
             std::size_t count, std::size_t& hits) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const tests::EmbreeApi& api = scene.api();
  const bool is_closest = way.query == Query::kClosest;
  const std::size_t of_call = std::min(count, way.rays);
  const auto number = static_cast<unsigned int>(of_call);
  std::vector<RTCRayHit8> packets;
  if (way.call == Form::Call::kPackets) packets = InPackets(rays, count);
  const Stopwatch stopwatch;
  for (std::size_t i = 0; i < count; i += of_call) {
    if (way.call == Form::Call::kPackets) {
      RTCRayHit8* const first = &packets[i / kPacket];
      auto* const records = reinterpret_cast<RTCRayHitN*>(first);
      if (is_closest) {
        api.rtcIntersectNM(scene.handle(), &context, records, kPacket, number / kPacket,
                           sizeof(RTCRayHit8));
      } else {
        api.rtcOccludedNM(scene.handle(), &context, RTCRayHitN_RayN(records, kPacket), kPacket,
                          number / kPacket, sizeof(RTCRayHit8));
      }
    } else if (way.call == Form::Call::kRecords) {
      if (is_closest) {
        api.rtcIntersect1M(scene.handle(), &context, &rays[i], number, sizeof(RTCRayHit));
      } else {
        api.rtcOccluded1M(scene.handle(), &context, &rays[i].ray, number, sizeof(RTCRayHit));
      }
    } else if (is_closest) {
      api.rtcIntersect1(scene.handle(), &context, &rays[i]);
    } else {
      api.rtcOccluded1(scene.handle(), &context, &rays[i].ray);
    }
  }
  const double seconds = stopwatch.Seconds();
  hits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (packets.empty()) {
      hits += IsHit(rays[i].hit.geomID, rays[i].ray.tfar);
    } else {
      const RTCRayHit8& packet = packets[i / kPacket];
      hits += IsHit(packet.hit.geomID[i % kPacket], packet.ray.tfar[i % kPacket]);
    }
  }
  return seconds;
}

struct Cell {
  double embree = 0, dacrt = 0;  ///< seconds a ray
  double Ratio() const { return dacrt / embree; }
};

/// As many rays as Embree takes long enough for, the least time of some rounds. The first, in which
/// scenes are split, does not count.
Cell Measure(const std::vector<const CliffScene*>& embree, const CliffScene& dacrt, const Way& way,
             const std::vector<RTCRayHit>& rays) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::size_t count = 64, hits, own_hits;
  while (count < kMostRays && Trace(*embree[0], way, rays, count, hits) < kLeastSeconds) count *= 2;
  Cell cell{kNever, kNever};
  for (int round = 0; round <= kRounds; ++round) {
    for (const CliffScene* const scene : embree) {
      const double seconds = Trace(*scene, way, rays, count, hits);
      if (round > 0) cell.embree = std::min(cell.embree, seconds / static_cast<double>(count));
    }
    const double seconds = Trace(dacrt, way, rays, count, own_hits);
    if (round > 0) cell.dacrt = std::min(cell.dacrt, seconds / static_cast<double>(count));
  }
  // Rounding decides of rays along edges: of some, not of many.
  const double apart = static_cast<double>(std::max(hits, own_hits) - std::min(hits, own_hits));
  if (apart > 3 + 0.002 * static_cast<double>(count)) {
    throw Disagreement(std::string(way.name) + ": " + std::to_string(hits) +
                       " of Embree's rays hit, " + std::to_string(own_hits) + " of dacrt's");
  }
  return cell;
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Times dacrt beside Embree, one thread, where something once was many times slower.");
  std::vector<std::string> names;
  std::string json_path, markdown_path;
  AddNamesOption(app, "--cases", names, NamesOf(CliffCases()), "what to measure; all by default");
  app.add_option("--json", json_path, "write the figures to this file");
  app.add_option("--markdown", markdown_path, "write the page to this file");
  if (!ParseCommandLine(app, argc, argv)) return kSuccess;

  static const tests::EmbreeApi real = tests::LoadEmbree(DACRT_REAL_EMBREE);
  static const tests::EmbreeApi own = tests::LoadEmbree(DACRT_DROP_IN);
  const EmbreeDevice avx2(real, "threads=1,isa=avx2"), best(real, "threads=1");
  const std::vector<RTCRayHit> from_anywhere = RaysFromAnywhere(), to_lamp = RaysToLamp();
  std::vector<std::string> header = {"case", "what"};
  for (const Way& way : kWays) header.push_back(way.name);
  Table table(header, 2);
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  int cliffs = 0;
  for (const CliffCase& item : CliffCases()) {
    if (!names.empty() && std::ranges::find(names, item.name) == names.end()) continue;
    std::cerr << item.name << std::endl;
    const CliffContent content = item.make();
    std::string config = "threads=1";
    if (item.budget > 0) {
      const double bytes = item.budget * static_cast<double>(content.triangles.size());
      config += ",dacrt_budget=" + std::to_string(static_cast<uint64_t>(bytes));
    }
    const EmbreeDevice device(own, config);
    const CliffScene with_avx2(avx2, content), with_best(best, content), dacrt(device, content);
    std::vector<std::string> row = {item.name, item.what};
    for (const Way& way : kWays) {
      const Cell cell =
          Measure({&with_avx2, &with_best}, dacrt, way, item.is_lit ? to_lamp : from_anywhere);
      const bool is_cliff = cell.Ratio() > way.goal;
      cliffs += is_cliff;
      row.push_back(Fixed(cell.Ratio(), 2) + (is_cliff ? " !" : ""));
      cells.push_back({{"case", item.name},
                       {"way", way.name},
                       {"embree_ns", 1e9 * cell.embree},
                       {"dacrt_ns", 1e9 * cell.dacrt},
                       {"ratio", cell.Ratio()},
                       {"goal", way.goal}});
    }
    table.Add(row);
  }
  table.Print(std::cout);
  std::cout << "dacrt's time over Embree's; ! above the goal, 3 for single rays, 2 for small "
               "calls, 1.5 for streams: "
            << cliffs << "\n";
  const std::string command = CommandText("tests/bench/run cliffs", argc, argv);
  if (!json_path.empty()) {
    WriteFile(json_path,
              JsonText({{"command", command}, {"processor", ProcessorName()}, {"cells", cells}}));
  }
  if (!markdown_path.empty()) {
    std::ostringstream page;
    page << "# Cliffs\n\nScenes and settings over which something once was many times slower than "
            "elsewhere. dacrt's time a ray over\nEmbree's, one thread, steady; Embree with the "
            "faster "
            "of AVX2 and its best instruction set. The goal is 3 for\nsingle rays, 2 for small "
            "calls and 1.5 for streams; what is above it has a `!`.\n\n";
    table.PrintMarkdown(page);
    page << "\n" << ProcessorName() << ". To repeat it: `" << command << "`.\n";
    WriteFile(markdown_path, page.str());
  }
  return kSuccess;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("cliffs_bench", [=] { return dacrt::bench::Main(argc, argv); });
}

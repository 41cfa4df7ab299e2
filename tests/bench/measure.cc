#include "measure.h"

#include <algorithm>
#include <span>
#include <utility>

#include "hit_check.h"
#include "timing.h"

namespace dacrt::bench {
const Run& Runs::Median() const {
  std::vector<const Run*> order;
  for (const Run& run : runs) order.push_back(&run);
  const auto middle = order.begin() + (order.size() - 1) / 2;
  std::nth_element(order.begin(), middle, order.end(),
                   [](const Run* a, const Run* b) { return a->seconds < b->seconds; });
  return **middle;
}

double Runs::LeastSeconds() const {
  return std::ranges::min_element(runs, {}, &Run::seconds)->seconds;
}

std::size_t FrameResult::Rays() const {
  std::size_t rays = 0;
  for (const PassResult& pass : passes) rays += pass.rays;
  return rays;
}

double FrameResult::Seconds(std::size_t method) const {
  double seconds = 0;
  for (const PassResult& pass : passes) seconds += pass.by_method[method].Median().seconds;
  return seconds;
}

double FrameResult::LeastSeconds(std::size_t method) const {
  double seconds = 0;
  for (const PassResult& pass : passes) seconds += pass.by_method[method].LeastSeconds();
  return seconds;
}

Statistics FrameResult::Total(std::size_t method) const {
  Statistics total;
  for (const PassResult& pass : passes) total += pass.by_method[method].Median().statistics;
  return total;
}

Contest::Contest(const BenchScene& scene, std::vector<Method> methods) : scene_(scene) {
  const TriangleMesh mesh = scene.AsTriangleMesh();
  for (Method& method : methods) {
    auto device = std::make_shared<Device>(method.settings);
    auto committed = std::make_unique<Scene>(device, std::span(&mesh, 1));
    entrants_.push_back({std::move(method), std::move(device), std::move(committed)});
  }
}

PassResult Contest::MeasurePass(const Pass& pass, int warm_ups, int repeat, RayBuffer& rays) const {
  PassResult result{pass, rays.rays().size(), std::vector<Runs>(entrants_.size())};
  HitCheck hits(pass.query);
  for (int round = -warm_ups; round < repeat; ++round) {
    for (std::size_t i = 0; i < entrants_.size(); ++i) {
      rays.Rearm();
      const RayView view = rays.View();
      const Stopwatch stopwatch;
      const Statistics statistics = entrants_[i].scene->Trace(pass.query, view);
      const double seconds = stopwatch.Seconds();
      hits.Check(entrants_[i].method.name, rays);
      if (round >= 0) result.by_method[i].runs.push_back({seconds, statistics});
    }
  }
  return result;
}

FrameResult Contest::Measure(const FrameKind& kind, const Raster& raster, int repeat,
                             const OnPass& on_pass) const {
  FrameResult result{scene_.name, scene_.TriangleCount(), &kind, raster, {}, {}, {}};
  TraceFrame(kind, scene_, raster, [&](const Pass& pass, RayBuffer& rays) {
    on_pass(pass, rays.rays().size());
    const int warm_ups = result.passes.empty() ? 1 : 0;
    result.passes.push_back(MeasurePass(pass, warm_ups, repeat, rays));
  });
  for (const Entrant& entrant : entrants_) {
    result.methods.push_back(entrant.method);
    result.workspace_bytes.push_back(entrant.device->WorkspaceBytesHeld());
  }
  return result;
}

}  // namespace dacrt::bench

#include "measure.h"

#include <algorithm>
#include <span>
#include <sstream>
#include <utility>

#include "errors.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

// The hits that every method must find: those of the first trace of a batch.
class Reference {
 public:
  Reference(const Pass& pass, const std::string& method) : pass_(pass), method_(method) {}

  // Takes the hits in `rays` as the reference, or throws Disagreement unless they are the same.
  void Check(const std::string& method, const RayBuffer& rays) {
    if (fingerprints_.empty()) {
      fingerprints_.reserve(rays.rays().size());
      for (const RayRecord& ray : rays.rays()) fingerprints_.push_back(Print(ray));
      return;
    }
    std::size_t differences = 0;
    std::size_t first = 0;
    for (std::size_t i = rays.rays().size(); i-- > 0;) {
      if (Print(rays.rays()[i]) == fingerprints_[i]) continue;
      ++differences;
      first = i;
    }
    if (differences > 0) Fail(method, rays, differences, first);
  }

 private:
  uint64_t Print(const RayRecord& ray) const { return Fingerprint(pass_.query, ray); }

  [[noreturn]] void Fail(const std::string& method, const RayBuffer& rays, std::size_t differences,
                         std::size_t first) const {
    const RayRecord& ray = rays.rays()[first];
    std::ostringstream text;
    text.precision(9);
    text << pass_.name << ": " << method << " and " << method_ << " differ in " << differences
         << " of " << rays.rays().size() << " rays, first in ray " << first << " from "
         << ray.org[0] << ' ' << ray.org[1] << ' ' << ray.org[2] << " along " << ray.dir[0] << ' '
         << ray.dir[1] << ' ' << ray.dir[2] << ", where " << method << " has tfar " << ray.tfar;
    if (pass_.query == Query::kClosest) text << " and primitive " << ray.primitive_id;
    throw Disagreement(text.str());
  }

  const Pass& pass_;
  const std::string& method_;
  std::vector<uint64_t> fingerprints_;
};

}  // namespace

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
  Reference reference(pass, entrants_.front().method.name);
  for (int round = -warm_ups; round < repeat; ++round) {
    for (std::size_t i = 0; i < entrants_.size(); ++i) {
      rays.Rearm();
      const RayView view = rays.View();
      const Stopwatch stopwatch;
      const Statistics statistics = entrants_[i].scene->Trace(pass.query, view);
      const double seconds = stopwatch.Seconds();
      reference.Check(entrants_[i].method.name, rays);
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

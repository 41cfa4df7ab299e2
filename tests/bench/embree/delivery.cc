#include "delivery.h"

#include <algorithm>
#include <limits>
#include <span>

#include "callers.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

std::size_t CountParts(std::size_t all, std::size_t part) { return (all + part - 1) / part; }

std::span<RayRecord> Part(std::span<RayRecord> rays, std::size_t size, std::size_t i) {
  return rays.subspan(i * size, std::min(size, rays.size() - i * size));
}

struct Delivered {
  std::size_t batches = 0;
  double seconds = 0;
};

Delivered Send(double limit, const CommittedScene& scene, Query query, const Delivery& delivery,
               RayBuffer& rays) {
  rays.Rearm();
  const std::size_t width = delivery.call.PacketWidth();
  if (width > 1) MakePackets(width, rays.rays());
  const bool is_cut = delivery.slice < delivery.batch;
  Callers callers(is_cut ? delivery.callers : 1);
  const std::size_t batches = CountParts(rays.rays().size(), delivery.batch);
  Delivered done;
  const Stopwatch stopwatch;
  while (done.batches < batches && done.seconds < limit) {
    const std::span<RayRecord> batch = Part(rays.rays(), delivery.batch, done.batches);
    callers.Run(CountParts(batch.size(), delivery.slice), [&](std::size_t i) {
      scene.Trace(query, delivery.call, Part(batch, delivery.slice, i));
    });
    ++done.batches;
    done.seconds = stopwatch.Seconds();
  }
  if (width > 1) MakeRecords(width, rays.rays());
  return done;
}

}  // namespace

double Deliver(const CommittedScene& scene, Query query, const Delivery& delivery,
               RayBuffer& rays) {
  return Send(std::numeric_limits<double>::infinity(), scene, query, delivery, rays).seconds;
}

std::size_t DeliverFor(double seconds, const CommittedScene& scene, Query query,
                       const Delivery& delivery, RayBuffer& rays) {
  return Send(seconds, scene, query, delivery, rays).batches;
}

}  // namespace dacrt::bench

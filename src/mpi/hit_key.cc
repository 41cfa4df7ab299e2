#include "hit_key.h"

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "view_piece.h"

namespace dacrt::mpi {
namespace {

/// A ray, and the question whether it hits something up to `tfar`; in the order of PacketComponent.
struct Probe {
  float org[3], tnear;
  float dir[3], time;
  float tfar;
  uint32_t mask;
};

RayView ViewOf(std::vector<Probe>& probes) {
  RayView view;
  view.count = probes.size();
  view.packet_stride = sizeof(Probe);
  const auto at = [](auto& value) { return reinterpret_cast<RayView::Component>(&value); };
  Probe& first = probes[0];
  view.org_x = at(first.org[0]), view.org_y = at(first.org[1]), view.org_z = at(first.org[2]);
  view.dir_x = at(first.dir[0]), view.dir_y = at(first.dir[1]), view.dir_z = at(first.dir[2]);
  view.tnear = at(first.tnear), view.tfar = at(first.tfar);
  view.mask = at(first.mask), view.time = at(first.time);
  return view;
}

/// For each of `hits`: whether its ray hits something up to tfar(its number).
template <class Tfar>
std::vector<bool> HitsWithin(const LocalScene& local, std::span<FoundHit* const> hits,
                             const Tfar& tfar) {
  std::vector<Probe> probes;
  probes.reserve(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const RayRecord& ray = *hits[i]->ray;
    probes.push_back({{ray.org[0], ray.org[1], ray.org[2]},
                      ray.tnear,
                      {ray.dir[0], ray.dir[1], ray.dir[2]},
                      ray.time,
                      tfar(i),
                      ray.mask});
  }
  if (!probes.empty()) local.trace(Query::kAny, ViewOf(probes), {});
  std::vector<bool> does_hit;
  does_hit.reserve(probes.size());
  for (const Probe& probe : probes) does_hit.push_back(probe.tfar == -kInfinity);
  return does_hit;
}

/// One more than t, because a hit at tfar may be rounded away.
float Above(float t) { return std::nextafter(t, kInfinity); }

}  // namespace

void FindKeys(const LocalScene& local, std::span<FoundHit> hits) {
  std::vector<FoundHit*> unsure;
  for (FoundHit& hit : hits) {
    hit.key = std::min(hit.ray->tfar, hit.limit);
    if (Above(hit.ray->tfar) < hit.limit) unsure.push_back(&hit);
  }
  const std::vector<bool> is_t =
      HitsWithin(local, unsure, [&](std::size_t i) { return Above(unsure[i]->ray->tfar); });
  std::vector<FoundHit*> grazing;
  for (std::size_t i = 0; i < unsure.size(); ++i) {
    if (!is_t[i]) grazing.push_back(unsure[i]);
  }
  if (grazing.empty()) return;

  // Numbers that are not negative are ordered as their bits are. Between `miss` and `hit` lies the
  // key; 31 steps find it.
  struct Search {
    uint32_t miss, hit;
    float Middle() const { return std::bit_cast<float>(miss + (hit - miss) / 2); }
  };
  std::vector<Search> searches;
  searches.reserve(grazing.size());
  for (const FoundHit* const hit : grazing) {
    searches.push_back(
        {std::bit_cast<uint32_t>(Above(hit->ray->tfar)), std::bit_cast<uint32_t>(hit->limit)});
  }
  for (int step = 0; step < 31; ++step) {
    const std::vector<bool> does_hit =
        HitsWithin(local, grazing, [&](std::size_t i) { return searches[i].Middle(); });
    for (std::size_t i = 0; i < searches.size(); ++i) {
      Search& search = searches[i];
      (does_hit[i] ? search.hit : search.miss) = std::bit_cast<uint32_t>(search.Middle());
    }
  }
  for (std::size_t i = 0; i < grazing.size(); ++i) {
    grazing[i]->key = std::bit_cast<float>(searches[i].hit);
  }
}

}  // namespace dacrt::mpi

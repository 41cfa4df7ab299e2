// The same rays in every form in which a caller may keep them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "dacrt/callback.h"
#include "dacrt/ray_view.h"
#include "unit_test.h"

namespace dacrt::unit {

/// All that a ray and its hit have, in the order of PacketComponent.
struct FullRay {
  uint32_t bits[kPacketComponents];

  template <class T = float>
  T Get(PacketComponent component) const {
    T value;
    std::memcpy(&value, &bits[static_cast<std::size_t>(component)], sizeof(value));
    return value;
  }
  template <class T>
  void Set(PacketComponent component, T value) {
    static_assert(sizeof(T) == sizeof(uint32_t));
    std::memcpy(&bits[static_cast<std::size_t>(component)], &value, sizeof(value));
  }

  bool IsHit() const { return Get<uint32_t>(PacketComponent::kGeometryId) != UINT32_MAX; }
  bool operator==(const FullRay& other) const {
    return std::memcmp(bits, other.bits, sizeof(bits)) == 0;
  }
};

inline FullRay FullRayOf(const Ray& ray, float time = 0) {
  using enum PacketComponent;
  FullRay full{};
  full.Set(kOrgX, ray.org[0]);
  full.Set(kOrgY, ray.org[1]);
  full.Set(kOrgZ, ray.org[2]);
  full.Set(kTnear, ray.tnear);
  full.Set(kDirX, ray.dir[0]);
  full.Set(kDirY, ray.dir[1]);
  full.Set(kDirZ, ray.dir[2]);
  full.Set(kTime, time);
  full.Set(kTfar, ray.tfar);
  full.Set(kMask, ray.mask);
  for (const PacketComponent id : {kPrimitiveId, kGeometryId, kInstanceId}) full.Set(id, UINT32_MAX);
  return full;
}

/// Rays of every kind, a part of them inactive or not numbers.
inline std::vector<FullRay> RaysOfEveryKind(Random& random, std::size_t count) {
  const float bad[] = {kNaN, kInfinity, -kInfinity};
  std::vector<FullRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Ray ray = MakeRay(random.InCube(-2, 2), random.Direction());
    if (random.Below(2) == 0) ray.tnear = random.Uniform(-1, 1);
    if (random.Below(3) == 0) ray.tfar = random.Uniform(0, 3);
    if (random.Below(4) == 0) ray.dir[random.Below(3)] = random.Next() & 1 ? 0.0f : -0.0f;
    ray.mask = static_cast<uint32_t>(random.Next()) | 0x100;
    switch (random.Below(16)) {
      case 0:
        ray.tfar = bad[random.Below(3)];
        break;
      case 1:
        ray.org[random.Below(3)] = bad[random.Below(3)];
        break;
      case 2:
        ray.dir[random.Below(3)] = bad[random.Below(3)];
        break;
      case 3:
        ray.tnear = bad[random.Below(3)];
        break;
      case 4:
        ray.mask = 0;
        break;
    }
    rays.push_back(FullRayOf(ray, random.Uniform(0, 1)));
  }
  return rays;
}

/// How rays lie in memory: packets of some lanes, side by side or known by pointers; or an array for
/// each component.
struct Form {
  std::size_t lanes;
  bool by_pointers;
  bool apart;  ///< an array for each component

  std::string Text() const {
    if (apart) return "an array for each component";
    return "packets of " + std::to_string(lanes) + (by_pointers ? " by pointers" : "");
  }
};

inline std::vector<Form> AllForms() {
  std::vector<Form> forms = {{1, false, true}};
  for (const std::size_t lanes : {1u, 3u, 4u, 8u, 16u}) {
    forms.push_back({lanes, false, false});
    forms.push_back({lanes, true, false});
  }
  return forms;
}

/// Rays in one form. What lies between them, and behind the last, may not be touched or is checked.
class FormedRays {
 public:
  FormedRays(const std::vector<FullRay>& rays, const Form& form)
      : form_(form), count_(rays.size()) {
    const std::size_t lanes = form.apart ? count_ : form.lanes;
    const std::size_t packets = form.apart ? 1 : (count_ + lanes - 1) / lanes;
    // A few words between packets.
    packet_words_ = lanes * kPacketComponents + (form.apart ? 0 : 3);
    memory_ = std::make_unique<GuardedArray<uint32_t>>(packets * packet_words_);
    std::fill(memory_->begin(), memory_->end(), kGuard);
    for (std::size_t p = 0; p < packets; ++p) {
      // In another order than that of the memory.
      pointers_.push_back(memory_->data() + (packets - 1 - p) * packet_words_);
    }
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t c = 0; c < kPacketComponents; ++c) *Word(i, c) = rays[i].bits[c];
    }
  }

  RayView View() {
    RayView view;
    view.count = count_;
    view.lanes = form_.apart ? 1 : form_.lanes;
    view.lane_stride = sizeof(float);
    view.packet_stride = form_.apart ? sizeof(float) : packet_words_ * sizeof(uint32_t);
    if (form_.by_pointers) {
      view.packets = pointers_.data();
      view.packet_stride = sizeof(float);  // which is not used
    }
    const auto start = form_.by_pointers ? 0 : reinterpret_cast<std::uintptr_t>(memory_->data());
    const std::size_t lanes = form_.apart ? count_ : form_.lanes;
    std::size_t c = 0;
    for (RayView::Component* component :
         {&view.org_x, &view.org_y, &view.org_z, &view.tnear, &view.dir_x, &view.dir_y,
          &view.dir_z, &view.time, &view.tfar, &view.mask, &view.id, &view.flags, &view.ng_x,
          &view.ng_y, &view.ng_z, &view.u, &view.v, &view.primitive_id, &view.geometry_id,
          &view.instance_id}) {
      *component = start + lanes * sizeof(uint32_t) * c++;
    }
    return view;
  }

  std::vector<FullRay> Rays() const {
    std::vector<FullRay> rays(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t c = 0; c < kPacketComponents; ++c) rays[i].bits[c] = *Word(i, c);
    }
    return rays;
  }

  /// Whether all that is no ray's is as it was.
  bool GuardsHold() const {
    std::vector<bool> is_of_ray(memory_->size());
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t c = 0; c < kPacketComponents; ++c) {
        is_of_ray[static_cast<std::size_t>(Word(i, c) - memory_->data())] = true;
      }
    }
    for (std::size_t i = 0; i < memory_->size(); ++i) {
      if (!is_of_ray[i] && (*memory_)[i] != kGuard) return false;
    }
    return true;
  }

 private:
  static constexpr uint32_t kGuard = 0x7FC0BEEF;  // as a float, not a number

  uint32_t* Word(std::size_t ray, std::size_t component) const {
    if (form_.apart) return memory_->data() + component * count_ + ray;
    const std::size_t packet = ray / form_.lanes;
    uint32_t* const start =
        form_.by_pointers ? const_cast<uint32_t*>(static_cast<const uint32_t*>(pointers_[packet]))
                          : memory_->data() + packet * packet_words_;
    return start + component * form_.lanes + ray % form_.lanes;
  }

  Form form_;
  std::size_t count_;
  std::size_t packet_words_;
  std::unique_ptr<GuardedArray<uint32_t>> memory_;
  std::vector<const void*> pointers_;
};

}  // namespace dacrt::unit

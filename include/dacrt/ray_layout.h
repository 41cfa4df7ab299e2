// Views of a program's own rays, whatever they look like: the easy way to a RayView.
//
//   struct Beam { Vector from, towards; float reach; unsigned surface; double power; };
//
//   RayView view = RaysIn(beams)                  // std::vector<Beam>, or std::vector<Beam*>
//                      .Origin(&Beam::from)
//                      .Direction(&Beam::towards)
//                      .Tfar(&Beam::reach)
//                      .PrimitiveId(&Beam::surface);
//
//   struct Eight { float x[8], y[8], z[8], dx[8], dy[8], dz[8], reach[8]; };  // interleaved
//
//   RayView view = RaysIn(packets)
//                      .Origin(&Eight::x, &Eight::y, &Eight::z)
//                      .Direction(&Eight::dx, &Eight::dy, &Eight::dz)
//                      .Tfar(&Eight::reach);
//
//   RayView view = RaysInArrays(count)            // structure of arrays
//                      .Origin(x, y, z)
//                      .Direction(dx, dy, dz)
//                      .Tfar(reach)
//                      .GeometryId(surface);
//
// Nothing is copied. What is named is used by Scene::Trace as RayView says; what is not named has
// RayView's default where it is read, and is not written. Origin, Direction and Tfar are needed.
// Members are floats, the mask and all IDs integers of four bytes; a vector is three floats in a
// row at the start of a member of any type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>

#include "dacrt/error.h"
#include "dacrt/in_place.h"
#include "dacrt/ray_view.h"

namespace dacrt {

/// The setters of both builders, of which each says what a field is: a pointer to a member, or to
/// an array.
template <class Layout>
class RayViewBuilder {
 public:
  operator RayView() const { return view_; }

  template <class F>
  Layout& Origin(F x, F y, F z) {
    return Set(view_.org_x, x, view_.org_y, y, view_.org_z, z);
  }
  template <class V>
  Layout& Origin(V vector) {
    return SetVector(view_.org_x, view_.org_y, view_.org_z, vector);
  }
  template <class F>
  Layout& Direction(F x, F y, F z) {
    return Set(view_.dir_x, x, view_.dir_y, y, view_.dir_z, z);
  }
  template <class V>
  Layout& Direction(V vector) {
    return SetVector(view_.dir_x, view_.dir_y, view_.dir_z, vector);
  }
  Layout& Tnear(auto tnear) { return Set<float>(view_.tnear, tnear); }
  Layout& Tfar(auto tfar) { return Set<float>(view_.tfar, tfar); }
  Layout& Time(auto time) { return Set<float>(view_.time, time); }
  Layout& Mask(auto mask) { return Set<uint32_t>(view_.mask, mask); }
  Layout& Id(auto id) { return Set<uint32_t>(view_.id, id); }
  Layout& Flags(auto flags) { return Set<uint32_t>(view_.flags, flags); }

  template <class F>
  Layout& Normal(F x, F y, F z) {
    return Set(view_.ng_x, x, view_.ng_y, y, view_.ng_z, z);
  }
  template <class V>
  Layout& Normal(V vector) {
    return SetVector(view_.ng_x, view_.ng_y, view_.ng_z, vector);
  }
  template <class F>
  Layout& Uv(F u, F v) {
    Set<float>(view_.u, u);
    return Set<float>(view_.v, v);
  }
  Layout& PrimitiveId(auto id) { return Set<uint32_t>(view_.primitive_id, id); }
  Layout& GeometryId(auto id) { return Set<uint32_t>(view_.geometry_id, id); }
  Layout& InstanceId(auto id) { return Set<uint32_t>(view_.instance_id, id); }

 protected:
  /// What can stand for a value of type T.
  template <class T, class Value>
  static constexpr bool kIsValue = std::is_same_v<T, float> ? std::is_same_v<Value, float>
                                                            : std::is_integral_v<Value> &&
                                                                  sizeof(Value) == sizeof(uint32_t);

  RayView view_;

 private:
  Layout& self() { return static_cast<Layout&>(*this); }

  template <class T, class F>
  Layout& Set(RayView::Component& component, F field) {
    component = self().template Place<T>(field);
    return self();
  }
  template <class F>
  Layout& Set(RayView::Component& to_x, F x, RayView::Component& to_y, F y,
              RayView::Component& to_z, F z) {
    Set<float>(to_x, x);
    Set<float>(to_y, y);
    return Set<float>(to_z, z);
  }
  template <class V>
  Layout& SetVector(RayView::Component& x, RayView::Component& y, RayView::Component& z, V vector) {
    x = self().PlaceVector(vector);
    y = x + sizeof(float);
    z = y + sizeof(float);
    return self();
  }
};

/// Records, each a ray, or a packet of rays where the members are arrays, all of one length (else
/// Error is thrown); side by side, or behind a table of pointers, none of which is null.
template <class Record>
class RayRecords : public RayViewBuilder<RayRecords<Record>> {
 public:
  explicit RayRecords(std::span<Record> records)
      : first_(records.data()), start_(reinterpret_cast<std::uintptr_t>(first_)) {
    this->view_.count = records.size();
    this->view_.packet_stride = sizeof(Record);
  }
  explicit RayRecords(std::span<Record* const> records)
      : first_(records.empty() ? nullptr : records.front()) {
    this->view_.count = records.size();
    this->view_.packets = reinterpret_cast<const void* const*>(records.data());
  }

  /// The first `count` rays only: where the last packet is not full.
  RayRecords& Count(std::size_t count) {
    this->view_.count = count;
    return *this;
  }

 private:
  friend class RayViewBuilder<RayRecords<Record>>;

  template <class T, class Value>
  RayView::Component Place(Value Record::*member) {
    if constexpr (std::is_array_v<Value>) {
      static_assert(RayRecords::template kIsValue<T, std::remove_extent_t<Value>>);
      SetLanes(std::extent_v<Value>);
    } else {
      static_assert(RayRecords::template kIsValue<T, Value>);
    }
    return At(member);
  }

  template <class Vector>
  RayView::Component PlaceVector(Vector Record::*member) {
    static_assert(sizeof(Vector) >= 3 * sizeof(float) && alignof(Vector) % alignof(float) == 0);
    return At(member);
  }

  template <class Value>
  RayView::Component At(Value Record::*member) const {
    if (!first_) return 0;  // nothing will be read
    return start_ + static_cast<std::size_t>(reinterpret_cast<const char*>(&(first_->*member)) -
                                             reinterpret_cast<const char*>(first_));
  }

  void SetLanes(std::size_t lanes) {
    if (this->view_.lanes == lanes) return;
    if (this->view_.lanes != 1) {
      throw Error(Error::Kind::kArgument, "RaysIn", "member", std::to_string(lanes) + " values",
                  "other members have " + std::to_string(this->view_.lanes));
    }
    this->view_.count *= lanes;
    this->view_.lanes = lanes;
    this->view_.lane_stride = sizeof(float);
  }

  Record* first_;
  RayView::Component start_ = 0;  ///< with a table, components are offsets
};

/// An array for each component, with a value for each ray, `stride` bytes apart.
class RayArrays : public RayViewBuilder<RayArrays> {
 public:
  explicit RayArrays(std::size_t count, std::size_t stride = sizeof(float)) {
    view_.count = count;
    view_.packet_stride = stride;
  }

 private:
  friend class RayViewBuilder<RayArrays>;

  template <class T, class Value>
  RayView::Component Place(Value* values) {
    static_assert(kIsValue<T, std::remove_const_t<Value>>);
    // A null pointer stands for a component that is not there.
    return values ? reinterpret_cast<RayView::Component>(values) : RayView::kAbsent;
  }

  RayView::Component PlaceVector(const float* vectors) { return Place<float>(vectors); }
};

/// Rays in a std::vector, std::span ... of records or of pointers to them.
template <ArrayInPlace Records>
auto RaysIn(Records&& records) {
  using Record = std::remove_reference_t<std::ranges::range_reference_t<Records>>;
  if constexpr (std::is_pointer_v<std::remove_const_t<Record>>) {
    using Target = std::remove_pointer_t<std::remove_const_t<Record>>;
    return RayRecords<Target>(
        std::span<Target* const>(std::ranges::data(records), std::ranges::size(records)));
  } else {
    static_assert(!std::is_const_v<Record>, "hits are written into the records");
    return RayRecords<Record>(
        std::span<Record>(std::ranges::data(records), std::ranges::size(records)));
  }
}

inline RayArrays RaysInArrays(std::size_t count, std::size_t stride = sizeof(float)) {
  return RayArrays(count, stride);
}

}  // namespace dacrt

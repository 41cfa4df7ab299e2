// Geometries over the arrays that a program has: the easy way to a Geometry.
//
//   std::vector<float> vertices;            // x, y, z, x, y, z ...
//   std::vector<uint32_t> triangles;        // three numbers of vertices each
//   Geometry mesh = Triangles(vertices, triangles);
//
//   struct Vertex { float colour[4]; Vector position; };
//   std::vector<Vertex> vertices;           // interleaved with anything else
//   std::vector<std::array<int, 3>> triangles;
//   Geometry mesh = Triangles({vertices, &Vertex::position}, triangles);
//
// Nothing is copied: the arrays stay the program's, and must stay where they are, as TriangleMesh
// says. A temporary std::vector does not compile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <ranges>
#include <type_traits>
#include <utility>

#include "dacrt/geometry.h"
#include "dacrt/in_place.h"

namespace dacrt {

/// Groups of kWidth values in the caller's memory: a plain array of values, an array of anything
/// that begins with a group (std::array, a vector class, a struct), or one member of each element.
template <class Value, std::size_t kWidth>
class Groups {
 public:
  template <ArrayInPlace Elements>
  Groups(Elements&& elements)  // NOLINT: meant to be implicit
      : array_{std::ranges::data(elements), sizeof(ElementOf<Elements>)},
        count_(std::ranges::size(elements)) {
    using Element = ElementOf<Elements>;
    if constexpr (std::is_arithmetic_v<Element>) {
      static_assert(kIsValue<Element>, "another type of number is wanted");
      array_.stride = kWidth * sizeof(Value);
      count_ /= kWidth;  // what is left over is no group
    } else {
      CheckGroup<Element>();
    }
  }

  template <ArrayInPlace Elements, class Member, class Element>
  Groups(Elements&& elements, Member Element::*member)
      : array_{nullptr, sizeof(Element)}, count_(std::ranges::size(elements)) {
    CheckGroup<Member>();
    if (count_ > 0) array_.data = &((*std::ranges::data(elements)).*member);
  }

  const Array& array() const { return array_; }
  std::size_t count() const { return count_; }

 private:
  template <class Elements>
  using ElementOf = std::remove_cvref_t<std::ranges::range_reference_t<Elements>>;

  template <class T>
  static constexpr bool kIsValue = std::is_same_v<Value, float>
                                       ? std::is_same_v<T, float>
                                       : std::is_integral_v<T> && sizeof(T) == sizeof(Value);

  template <class Group>
  static constexpr void CheckGroup() {
    static_assert(sizeof(Group) >= kWidth * sizeof(Value), "too small for a group of values");
  }

  Array array_;
  std::size_t count_;
};

/// What the functions below have in common.
inline Geometry GeometryOf(Shape shape, std::size_t primitives, uint32_t geometry_id,
                           uint32_t mask) {
  Geometry geometry;
  geometry.shape = shape;
  geometry.geometry_id = geometry_id;
  geometry.mask = mask;
  geometry.primitive_count = primitives;
  return geometry;
}

template <std::size_t kCorners>
Geometry MeshOf(Shape shape, const Groups<float, 3>& vertices,
                const Groups<uint32_t, kCorners>& primitives, uint32_t geometry_id, uint32_t mask) {
  Geometry mesh = GeometryOf(shape, primitives.count(), geometry_id, mask);
  mesh.vertices = {vertices.array()};
  mesh.vertex_count = vertices.count();
  mesh.primitives = primitives.array();
  return mesh;
}

/// `geometry_id` and `mask` of all of these: see TriangleMesh.
inline Geometry Triangles(const Groups<float, 3>& vertices, const Groups<uint32_t, 3>& triangles,
                          uint32_t geometry_id = 0, uint32_t mask = UINT32_MAX) {
  return MeshOf(Shape::kTriangles, vertices, triangles, geometry_id, mask);
}

inline Geometry Quads(const Groups<float, 3>& vertices, const Groups<uint32_t, 4>& quads,
                      uint32_t geometry_id = 0, uint32_t mask = UINT32_MAX) {
  return MeshOf(Shape::kQuads, vertices, quads, geometry_id, mask);
}

/// Centre and radius of each.
inline Geometry Spheres(const Groups<float, 4>& spheres, uint32_t geometry_id = 0,
                        uint32_t mask = UINT32_MAX) {
  Geometry geometry = GeometryOf(Shape::kSpheres, spheres.count(), geometry_id, mask);
  geometry.vertices = {spheres.array()};
  geometry.vertex_count = spheres.count();
  return geometry;
}

/// `scene`, which stays as it is and keeps what it has found out, put at `place`. Both scenes are
/// of one device.
inline Geometry InstanceOf(std::shared_ptr<const Scene> scene, const AffineTransform& place,
                           uint32_t geometry_id = 0, uint32_t mask = UINT32_MAX) {
  Geometry geometry = GeometryOf(Shape::kInstance, 1, geometry_id, mask);
  geometry.instanced_scene = std::move(scene);
  geometry.transforms.emplace_back().matrix = place;
  return geometry;
}

/// `count` primitives that only callbacks know: see callback_of.h.
inline Geometry UserPrimitives(std::size_t count, const BoundsCallback& bounds,
                               const Callback& hits, uint32_t geometry_id = 0,
                               uint32_t mask = UINT32_MAX) {
  Geometry geometry = GeometryOf(Shape::kUser, count, geometry_id, mask);
  geometry.bounds = bounds;
  geometry.intersect = geometry.occluded = hits;
  return geometry;
}

}  // namespace dacrt

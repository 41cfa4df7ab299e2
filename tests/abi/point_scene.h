// A scene for point queries, and a model of it for brute force.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <tuple>
#include <vector>

#include "point_query.h"

namespace dacrt::tests {

using Point = std::array<double, 3>;
using Triangle = std::array<Point, 3>;

inline Point operator-(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline double Dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Point Mix(const Point& a, const Point& b, double t) {
  Point out;
  for (int i = 0; i < 3; ++i) out[i] = (1 - t) * a[i] + t * b[i];
  return out;
}

inline Triangle Mix(const Triangle& a, const Triangle& b, double t) {
  return {Mix(a[0], b[0], t), Mix(a[1], b[1], t), Mix(a[2], b[2], t)};
}

inline double SquareToSegment(const Point& p, const Point& a, const Point& b) {
  const Point edge = b - a;
  const double length = Dot(edge, edge);
  const double t = length > 0 ? std::clamp(Dot(p - a, edge) / length, 0.0, 1.0) : 0;
  const Point to = p - Mix(a, b, t);
  return Dot(to, to);
}

inline double Distance(const Point& p, const Triangle& t) {
  double square = std::min({SquareToSegment(p, t[0], t[1]), SquareToSegment(p, t[1], t[2]),
                            SquareToSegment(p, t[2], t[0])});
  const Point e1 = t[1] - t[0], e2 = t[2] - t[0], to = p - t[0];
  const double a = Dot(e1, e1), b = Dot(e1, e2), c = Dot(e2, e2);
  const double d = Dot(e1, to), e = Dot(e2, to), determinant = a * c - b * b;
  if (determinant > 0) {
    const double u = (c * d - b * e) / determinant, v = (a * e - b * d) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1) {
      const Point beside =
          to - Point{u * e1[0] + v * e2[0], u * e1[1] + v * e2[1], u * e1[2] + v * e2[2]};
      square = std::min(square, Dot(beside, beside));
    }
  }
  return std::sqrt(square);
}

inline double Distance(const Point& p, const std::vector<Triangle>& triangles) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& triangle : triangles) least = std::min(least, Distance(p, triangle));
  return least;
}

inline Point Apply(const Matrix& m, const Point& p) {
  Point out;
  for (int i = 0; i < 3; ++i) out[i] = m[i] * p[0] + m[3 + i] * p[1] + m[6 + i] * p[2] + m[9 + i];
  return out;
}

/// The same for the matrices of a context.
inline Point Apply4x4(const float* m, const Point& p) {
  Point out;
  for (int i = 0; i < 3; ++i) out[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
  return out;
}

/// instID, geomID, primID.
using Key = std::tuple<unsigned int, unsigned int, unsigned int>;

/// A primitive with its triangles in the world at the ends of its time, between which they move
/// along straight lines.
struct Item {
  std::vector<Triangle> begin, end;
  std::vector<Triangle> local;  ///< in an instance: in its space
  float first_time = 0, last_time = 1;
  bool is_moving = false;

  bool IsThereAt(float time) const {
    return !is_moving || (time >= first_time && time <= last_time);
  }
  std::vector<Triangle> At(float time) const {
    if (!is_moving) return begin;
    std::vector<Triangle> triangles;
    const double t = (time - first_time) / (last_time - first_time);
    for (std::size_t i = 0; i < begin.size(); ++i) triangles.push_back(Mix(begin[i], end[i], t));
    return triangles;
  }
};

struct InstanceModel {
  Matrix begin, end;
  float scale;  ///< of distances, from the world to the instance; 0 if it is not a similarity
};

/// A random scene of everything that point queries see, and some of what they do not, with a model
/// of it for brute force.
class PointScene {
 public:
  PointScene(Session& session, unsigned int seed, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE)
      : s_(session), random_(seed) {
    scene = s_.NewScene();
    s_.api.rtcSetSceneFlags(scene, flags);
    constexpr unsigned int kOutside = RTC_INVALID_GEOMETRY_ID;
    AddFacets(scene, items, kOutside, RTC_GEOMETRY_TYPE_TRIANGLE, 300, 10);
    AddFacets(scene, items, kOutside, RTC_GEOMETRY_TYPE_QUAD, 60, 10);
    AddGrids(scene, items, kOutside);
    AddUser(scene, items, kOutside, 50, 10);
    AddSpheres();
    AddFacets(scene, items, kOutside, RTC_GEOMETRY_TYPE_TRIANGLE, 100, 10, true, 0, 1);
    AddFacets(scene, items, kOutside, RTC_GEOMETRY_TYPE_QUAD, 50, 10, true, 0.25f, 0.75f);
    std::map<Key, Item> disabled;
    const RTCGeometry hidden =
        AddFacets(scene, disabled, kOutside, RTC_GEOMETRY_TYPE_TRIANGLE, 50, 10);
    s_.api.rtcDisableGeometry(hidden);

    const RTCScene inner = s_.NewScene();
    std::map<Key, Item> inside;
    AddFacets(inner, inside, 0, RTC_GEOMETRY_TYPE_TRIANGLE, 100, 1);
    AddFacets(inner, inside, 0, RTC_GEOMETRY_TYPE_QUAD, 30, 1);
    AddUser(inner, inside, 0, 20, 1);
    s_.api.rtcCommitScene(inner);
    const float c = std::cos(0.7f), s = std::sin(0.7f);
    const Matrix turned{3 * c, 3 * s, 0, -3 * s, 3 * c, 0, 0, 0, 3, 4, -5, 2};
    // Instances that are smaller than their scene, the real library searches in too small a radius:
    // it divides by the scale where it should multiply.
    const float size = &s_.api == &DropIn() ? 0.5f : 2;
    const Matrix mirrored{-size, 0, 0, 0, size, 0, 0, 0, size, -6, 6, 1};
    const Matrix squeezed{2, 0, 0, 0, 0.5f, 0, 0, 1, 4, -4, -4, -4};
    Matrix moved = mirrored;
    moved[9] += 5;
    AddInstance(inner, inside, {turned, turned, 1.0f / 3}, false);
    AddInstance(inner, inside, {mirrored, mirrored, 1 / size}, false);
    AddInstance(inner, inside, {squeezed, squeezed, 0}, false);
    AddInstance(inner, inside, {mirrored, moved, 1 / size}, true);
    s_.api.rtcCommitScene(scene);
    EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
  }

  Point RandomPoint() { return {Coordinate(12), Coordinate(12), Coordinate(12)}; }

  RTCScene scene;
  std::map<Key, Item> items;
  std::map<unsigned int, InstanceModel> instances;
  std::set<unsigned int> unseen;  ///< geometries that are not offered

 private:
  double Coordinate(double size) {
    return std::uniform_real_distribution<float>(-1, 1)(random_) * size;
  }

  std::vector<float>& NewValues(std::size_t count) { return values_.emplace_back(count + 4); }
  std::vector<unsigned int>& NewIndices(std::size_t count) { return indices_.emplace_back(count); }

  void Set(RTCGeometry geometry, RTCBufferType type, unsigned int slot, RTCFormat format,
           const void* data, std::size_t stride, std::size_t count) {
    s_.api.rtcSetSharedGeometryBuffer(geometry, type, slot, format, data, 0, stride, count);
  }

  unsigned int Attach(RTCScene to, RTCGeometry geometry) {
    s_.api.rtcCommitGeometry(geometry);
    EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
    return s_.api.rtcAttachGeometry(to, geometry);
  }

  /// Small triangles or quads all over a cube.
  RTCGeometry AddFacets(RTCScene to, std::map<Key, Item>& model, unsigned int instance,
                        RTCGeometryType type, unsigned int count, double size,
                        bool is_moving = false, float first_time = 0, float last_time = 1) {
    const unsigned int corners = type == RTC_GEOMETRY_TYPE_QUAD ? 4 : 3;
    const RTCGeometry geometry = s_.Own(s_.api.rtcNewGeometry(s_.device, type));
    s_.api.rtcSetGeometryTimeStepCount(geometry, is_moving ? 2 : 1);
    s_.api.rtcSetGeometryTimeRange(geometry, first_time, last_time);
    std::vector<unsigned int>& indices = NewIndices(count * corners);
    for (unsigned int i = 0; i < indices.size(); ++i) indices[i] = i;
    Set(geometry, RTC_BUFFER_TYPE_INDEX, 0, corners == 4 ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
        indices.data(), 4 * corners, count);
    std::vector<const std::vector<float>*> steps;
    for (unsigned int step = 0; step < (is_moving ? 2u : 1u); ++step) {
      std::vector<float>& vertices = NewValues(3 * indices.size());
      for (unsigned int i = 0; i < count; ++i) {
        const Point center{Coordinate(size), Coordinate(size), Coordinate(size)};
        for (unsigned int k = 0; k < 3 * corners; ++k) {
          vertices[3 * corners * i + k] = static_cast<float>(center[k % 3] + Coordinate(size / 10));
        }
      }
      Set(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices.data(), 12,
          indices.size());
      steps.push_back(&vertices);
    }
    const unsigned int id = Attach(to, geometry);
    for (unsigned int i = 0; i < count; ++i) {
      Item item;
      item.is_moving = is_moving;
      item.first_time = first_time;
      item.last_time = last_time;
      item.begin = FacetTriangles(*steps.front(), i, corners);
      item.end = FacetTriangles(*steps.back(), i, corners);
      model[{instance, id, i}] = item;
    }
    return geometry;
  }

  static std::vector<Triangle> FacetTriangles(const std::vector<float>& vertices, unsigned int i,
                                              unsigned int corners) {
    const auto corner = [&](unsigned int k) {
      const float* const v = &vertices[3 * (corners * i + k)];
      return Point{v[0], v[1], v[2]};
    };
    if (corners == 3) return {{corner(0), corner(1), corner(2)}};
    return {{corner(0), corner(1), corner(3)}, {corner(2), corner(3), corner(1)}};
  }

  void AddGrids(RTCScene to, std::map<Key, Item>& model, unsigned int instance) {
    const RTCGeometry geometry = s_.Own(s_.api.rtcNewGeometry(s_.device, RTC_GEOMETRY_TYPE_GRID));
    static const RTCGrid kGrids[] = {{0, 7, 7, 6}, {42, 5, 5, 9}};
    std::vector<float>& vertices = NewValues(3 * 87);
    for (float& value : vertices) value = static_cast<float>(Coordinate(8));
    Set(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, kGrids, sizeof(RTCGrid), 2);
    Set(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 12, 87);
    const unsigned int id = Attach(to, geometry);
    for (unsigned int i = 0; i < 2; ++i) {
      Item item;
      const RTCGrid& grid = kGrids[i];
      for (unsigned int y = 0; y + 1 < grid.height; ++y) {
        for (unsigned int x = 0; x + 1 < grid.width; ++x) {
          const auto at = [&](unsigned int column, unsigned int row) {
            const float* const v = &vertices[3 * (grid.startVertexID + row * grid.stride + column)];
            return Point{v[0], v[1], v[2]};
          };
          item.begin.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
          item.begin.push_back({at(x + 1, y + 1), at(x, y + 1), at(x + 1, y)});
        }
      }
      model[{instance, id, i}] = item;
    }
  }

  /// Boxes, which the model has the corners of.
  void AddUser(RTCScene to, std::map<Key, Item>& model, unsigned int instance, unsigned int count,
               double size) {
    const RTCGeometry geometry = s_.Own(s_.api.rtcNewGeometry(s_.device, RTC_GEOMETRY_TYPE_USER));
    std::vector<float>& boxes = NewValues(6 * count);
    for (unsigned int i = 0; i < 6 * count; i += 6) {
      for (unsigned int k = 0; k < 3; ++k) {
        boxes[i + k] = static_cast<float>(Coordinate(size));
        boxes[i + 3 + k] = boxes[i + k] + static_cast<float>(std::abs(Coordinate(size / 10)));
      }
    }
    s_.api.rtcSetGeometryUserPrimitiveCount(geometry, count);
    s_.api.rtcSetGeometryUserData(geometry, boxes.data());
    s_.api.rtcSetGeometryBoundsFunction(
        geometry,
        [](const RTCBoundsFunctionArguments* args) {
          const float* const box =
              static_cast<const float*>(args->geometryUserPtr) + std::size_t{6} * args->primID;
          *args->bounds_o = {box[0], box[1], box[2], 0, box[3], box[4], box[5], 0};
        },
        nullptr);
    const unsigned int id = Attach(to, geometry);
    for (unsigned int i = 0; i < count; ++i) {
      Item item;
      for (unsigned int corner = 0; corner < 8; ++corner) {
        const float* const box = &boxes[6 * i];
        const Point p{box[corner & 1 ? 3 : 0], box[corner & 2 ? 4 : 1], box[corner & 4 ? 5 : 2]};
        item.begin.push_back({p, p, p});
      }
      model[{instance, id, i}] = item;
    }
  }

  void AddSpheres() {
    const RTCGeometry geometry =
        s_.Own(s_.api.rtcNewGeometry(s_.device, RTC_GEOMETRY_TYPE_SPHERE_POINT));
    std::vector<float>& spheres = NewValues(4 * 50);
    for (float& value : spheres) value = static_cast<float>(std::abs(Coordinate(5)));
    Set(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, spheres.data(), 16, 50);
    unseen.insert(Attach(scene, geometry));
  }

  void AddInstance(RTCScene inner, const std::map<Key, Item>& inside, const InstanceModel& model,
                   bool is_moving) {
    const RTCGeometry geometry =
        s_.Own(s_.api.rtcNewGeometry(s_.device, RTC_GEOMETRY_TYPE_INSTANCE));
    s_.api.rtcSetGeometryInstancedScene(geometry, inner);
    s_.api.rtcSetGeometryTimeStepCount(geometry, is_moving ? 2 : 1);
    s_.api.rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                   model.begin.data());
    if (is_moving) {
      s_.api.rtcSetGeometryTransform(geometry, 1, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                     model.end.data());
    }
    const unsigned int id = Attach(scene, geometry);
    unseen.insert(id);  // its primitives are those of the instanced scene
    instances[id] = model;
    for (const auto& [key, local] : inside) {
      Item item;
      item.is_moving = is_moving;
      item.local = local.begin;
      for (const Triangle& t : local.begin) {
        const auto move = [&](const Matrix& m) {
          return Triangle{Apply(m, t[0]), Apply(m, t[1]), Apply(m, t[2])};
        };
        item.begin.push_back(move(model.begin));
        item.end.push_back(move(model.end));
      }
      items[{id, std::get<1>(key), std::get<2>(key)}] = item;
    }
  }

  Session& s_;
  std::mt19937 random_;
  std::deque<std::vector<float>> values_;
  std::deque<std::vector<unsigned int>> indices_;
};

}  // namespace dacrt::tests

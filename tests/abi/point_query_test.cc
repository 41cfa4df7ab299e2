// Point queries: what both libraries must offer, the nearest point that a program finds with them,
// and what its functions are called with.
//
// The real library offers all primitives of a leaf of its BVH, and a grid once for each part of it;
// dacrt offers what lies within the radius, once. So sets are compared with brute force only.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <thread>
#include <tuple>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

using Point = std::array<double, 3>;
using Triangle = std::array<Point, 3>;

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double Dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Point Mix(const Point& a, const Point& b, double t) {
  Point out;
  for (int i = 0; i < 3; ++i) out[i] = (1 - t) * a[i] + t * b[i];
  return out;
}

Triangle Mix(const Triangle& a, const Triangle& b, double t) {
  return {Mix(a[0], b[0], t), Mix(a[1], b[1], t), Mix(a[2], b[2], t)};
}

double SquareToSegment(const Point& p, const Point& a, const Point& b) {
  const Point edge = b - a;
  const double length = Dot(edge, edge);
  const double t = length > 0 ? std::clamp(Dot(p - a, edge) / length, 0.0, 1.0) : 0;
  const Point to = p - Mix(a, b, t);
  return Dot(to, to);
}

double Distance(const Point& p, const Triangle& t) {
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

double Distance(const Point& p, const std::vector<Triangle>& triangles) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& triangle : triangles) least = std::min(least, Distance(p, triangle));
  return least;
}

/// Twelve numbers as RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR has them.
using Matrix = std::array<float, 12>;

Point Apply(const Matrix& m, const Point& p) {
  Point out;
  for (int i = 0; i < 3; ++i) out[i] = m[i] * p[0] + m[3 + i] * p[1] + m[6 + i] * p[2] + m[9 + i];
  return out;
}

/// The same for the matrices of a context.
Point Apply4x4(const float* m, const Point& p) {
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

RTCPointQuery QueryAt(const Point& p, float radius, float time = 0) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), time,
          radius};
}

Point PointOf(const RTCPointQuery& query) { return {query.x, query.y, query.z}; }

Key KeyOf(const RTCPointQueryFunctionArguments& args) {
  const unsigned int instance =
      args.context->instStackSize > 0 ? args.context->instID[0] : RTC_INVALID_GEOMETRY_ID;
  return {instance, args.geomID, args.primID};
}

/// What a function was called for. Given as the user pointer.
struct Collection {
  const PointScene* scene = nullptr;
  bool shrinks = false;
  std::map<Key, int> offered = {};
  Key nearest = {};
};

/// Checks what the context says of the instance.
void CheckInstance(const RTCPointQueryFunctionArguments& args, const PointScene& scene) {
  const RTCPointQueryContext& context = *args.context;
  if (context.instStackSize == 0) {
    EXPECT_EQ(args.similarityScale, 1);
    EXPECT_EQ(context.instID[0], RTC_INVALID_GEOMETRY_ID);
    return;
  }
  EXPECT_EQ(context.instStackSize, 1u);
  ASSERT_TRUE(scene.instances.contains(context.instID[0]));
  const InstanceModel& instance = scene.instances.at(context.instID[0]);
  EXPECT_NEAR(args.similarityScale, instance.scale, 1e-5);
  const Point local{0.25, -0.5, 1};
  const Point want =
      Mix(Apply(instance.begin, local), Apply(instance.end, local), args.query->time);
  const Point world = Apply4x4(context.inst2world[0], local);
  const Point back = Apply4x4(context.world2inst[0], world);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(world[i], want[i], 1e-5);
    EXPECT_NEAR(back[i], local[i], 1e-5);
  }
}

/// As far from the candidate as the query's point is, measured as the manual says: in the instance
/// where it is a similarity, else in the world.
double DistanceOf(const RTCPointQueryFunctionArguments& args, const Item& item) {
  const Point point = PointOf(*args.query);
  if (args.context->instStackSize > 0 && args.similarityScale > 0) {
    return Distance(Apply4x4(args.context->world2inst[0], point), item.local) /
           args.similarityScale;
  }
  return Distance(point, item.At(args.query->time));
}

bool Collect(RTCPointQueryFunctionArguments* args) {
  auto& collection = *static_cast<Collection*>(args->userPtr);
  CheckInstance(*args, *collection.scene);
  const Key key = KeyOf(*args);
  ++collection.offered[key];
  const auto item = collection.scene->items.find(key);
  if (item == collection.scene->items.end()) {
    ADD_FAILURE() << "instance " << std::get<0>(key) << ", geometry " << std::get<1>(key);
    return false;
  }
  if (!collection.shrinks || !item->second.IsThereAt(args->query->time)) return false;
  const double distance = DistanceOf(*args, item->second);
  if (!(distance < args->query->radius)) return false;
  args->query->radius = static_cast<float>(distance);
  collection.nearest = key;
  return true;
}

bool Query(const Api& api, RTCScene scene, RTCPointQuery& query, RTCPointQueryFunction function,
           void* user_pointer) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const bool changed = api.rtcPointQuery(scene, &query, &context, function, user_pointer);
  EXPECT_EQ(context.instStackSize, 0u);
  EXPECT_EQ(context.instID[0], RTC_INVALID_GEOMETRY_ID);
  return changed;
}

class PointQueries : public OnBothLibraries {
 protected:
  bool IsOurs() const { return &s_.api == &DropIn(); }

  Session s_{GetParam()()};
};

INSTANTIATE_ON_BOTH_LIBRARIES(PointQueries);

constexpr float kTimes[] = {0, 0.2f, 0.3f, 0.5f, 1};

/// The distance of a point from the box around triangles.
double DistanceFromBox(const Point& p, const std::vector<Triangle>& triangles) {
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    for (const Triangle& triangle : triangles) {
      for (const Point& corner : triangle) {
        lower = std::min(lower, corner[axis]);
        upper = std::max(upper, corner[axis]);
      }
    }
    const double beyond = std::max({lower - p[axis], p[axis] - upper, 0.0});
    square += beyond * beyond;
  }
  return std::sqrt(square);
}

void ExpectWhatLiesWithin(Session& s, PointScene& scene, bool is_ours) {
  for (int i = 0; i < 60; ++i) {
    const float time = kTimes[i % std::size(kTimes)];
    const float radius = std::array{0.0f, 0.5f, 2.0f, 8.0f}[i % 4];
    RTCPointQuery query = QueryAt(scene.RandomPoint(), radius, time);
    const Point point = PointOf(query);
    Collection collection{&scene};
    EXPECT_FALSE(Query(s.api, scene.scene, query, Collect, &collection));
    EXPECT_EQ(query.radius, radius);
    for (const auto& [key, item] : scene.items) {
      const auto& [instance, geometry, primitive] = key;
      const bool is_offered = collection.offered.contains(key);
      const auto where = testing::Message()
                         << "query " << i << ", instance " << instance << ", geometry " << geometry
                         << ", primitive " << primitive;
      const auto triangles = item.At(time);
      if (item.IsThereAt(time) && Distance(point, triangles) <= radius) {
        EXPECT_TRUE(is_offered) << where;
      }
      if (!is_ours || !is_offered) continue;
      EXPECT_EQ(collection.offered[key], 1) << where;
      EXPECT_TRUE(item.IsThereAt(time)) << where;
      // What is not in an instance is offered by its bounds, with nothing but rounding beside it.
      // The bounds of what moves do so themselves, and are wider.
      if (instance == RTC_INVALID_GEOMETRY_ID && !item.is_moving) {
        EXPECT_LE(DistanceFromBox(point, triangles), radius * 1.0001 + 1e-6) << where;
      }
    }
    for (const auto& [key, count] : collection.offered) {
      if (std::get<0>(key) == RTC_INVALID_GEOMETRY_ID) {
        EXPECT_FALSE(scene.unseen.contains(std::get<1>(key)));
      }
    }
    if (testing::Test::HasFailure()) return;
  }
}

TEST_P(PointQueries, OfferWhatLiesWithinTheRadius) {
  PointScene scene(s_, 1);
  ExpectWhatLiesWithin(s_, scene, IsOurs());
}

TEST_P(PointQueries, OfferWhatLiesWithinTheRadiusOfACompactScene) {
  PointScene scene(s_, 2, RTC_SCENE_FLAG_COMPACT);
  ExpectWhatLiesWithin(s_, scene, IsOurs());
}

TEST_P(PointQueries, OfferEverythingWithinInfinity) {
  PointScene scene(s_, 3);
  RTCPointQuery query = QueryAt(scene.RandomPoint(), std::numeric_limits<float>::infinity(), 0.5f);
  Collection collection{&scene};
  Query(s_.api, scene.scene, query, Collect, &collection);
  EXPECT_EQ(collection.offered.size(), scene.items.size());
}

void ExpectNearest(Session& s, PointScene& scene) {
  for (int i = 0; i < 100; ++i) {
    const float time = kTimes[i % std::size(kTimes)];
    const float radius = i % 2 == 0 ? std::numeric_limits<float>::infinity() : 3.0f;
    RTCPointQuery query = QueryAt(scene.RandomPoint(), radius, time);
    double nearest = radius;
    for (const auto& [key, item] : scene.items) {
      if (!item.IsThereAt(time)) continue;
      nearest = std::min(nearest, Distance(PointOf(query), item.At(time)));
    }
    Collection collection{&scene, true};
    const bool changed = Query(s.api, scene.scene, query, Collect, &collection);
    EXPECT_EQ(changed, nearest < radius);
    ASSERT_NEAR(query.radius, nearest, 1e-5 * (1 + nearest)) << "query " << i;
    if (!changed) continue;
    const Item& item = scene.items.at(collection.nearest);
    EXPECT_NEAR(Distance(PointOf(query), item.At(time)), nearest, 1e-5 * (1 + nearest));
  }
}

TEST_P(PointQueries, FindTheNearestPoint) {
  for (unsigned int seed = 10; seed < 14; ++seed) {
    PointScene scene(s_, seed);
    ExpectNearest(s_, scene);
  }
}

TEST_P(PointQueries, FindTheNearestPointFromSeveralThreads) {
  // Each scene is new, so that the threads meet where dacrt partitions it.
  for (unsigned int seed = 20; seed < 24; ++seed) {
    PointScene scene(s_, seed);
    const std::vector<Point> points = [&] {
      std::vector<Point> random;
      for (int i = 0; i < 200; ++i) random.push_back(scene.RandomPoint());
      return random;
    }();
    const auto find_all = [&](std::vector<float>& radii) {
      for (const Point& point : points) {
        RTCPointQuery query = QueryAt(point, std::numeric_limits<float>::infinity());
        Collection collection{&scene, true};
        Query(s_.api, scene.scene, query, Collect, &collection);
        radii.push_back(query.radius);
      }
    };
    std::array<std::vector<float>, 4> radii;
    {
      std::vector<std::jthread> threads;
      for (auto& own : radii) threads.emplace_back([&] { find_all(own); });
    }
    for (const auto& own : radii) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(own[i], radii[0][i], 1e-5f * (1 + radii[0][i]));
      }
    }
  }
}

/// Packets of `kLanes` queries, each lane as a query alone.
template <int kLanes, class Packet, class Call>
void ExpectLanesToBeQueries(Session& s, PointScene& scene, Call call) {
  for (int round = 0; round < 10; ++round) {
    alignas(64) Packet packet;
    alignas(64) int valid[kLanes];
    Collection collections[kLanes];
    void* user_pointers[kLanes];
    RTCPointQuery queries[kLanes];
    const int flags[] = {-1, 0, 1, std::numeric_limits<int>::min()};  // all but 0 are valid
    for (int i = 0; i < kLanes; ++i) {
      queries[i] = QueryAt(scene.RandomPoint(), 5, kTimes[i % std::size(kTimes)]);
      packet.x[i] = queries[i].x;
      packet.y[i] = queries[i].y;
      packet.z[i] = queries[i].z;
      packet.time[i] = queries[i].time;
      packet.radius[i] = queries[i].radius;
      valid[i] = round == 0 ? 0 : flags[(i + round) % 4];
      collections[i] = {&scene, true};
      user_pointers[i] = &collections[i];
    }
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const bool changed = call(valid, scene.scene, &packet, &context, Collect, user_pointers);
    bool any_changed = false;
    for (int i = 0; i < kLanes; ++i) {
      Collection alone{&scene, true};
      if (valid[i] != 0) {
        any_changed |= Query(s.api, scene.scene, queries[i], Collect, &alone);
      }
      EXPECT_EQ(packet.radius[i], queries[i].radius);
      EXPECT_EQ(packet.x[i], queries[i].x);
      EXPECT_EQ(collections[i].offered, alone.offered);
    }
    EXPECT_EQ(changed, any_changed);
    if (testing::Test::HasFailure()) return;
  }
}

TEST_P(PointQueries, PacketsAreQueriesLaneByLane) {
  PointScene scene(s_, 30);
  const Api& api = s_.api;
  ExpectLanesToBeQueries<4, RTCPointQuery4>(
      s_, scene, [&](auto... args) { return api.rtcPointQuery4(args...); });
  ExpectLanesToBeQueries<8, RTCPointQuery8>(
      s_, scene, [&](auto... args) { return api.rtcPointQuery8(args...); });
  ExpectLanesToBeQueries<16, RTCPointQuery16>(
      s_, scene, [&](auto... args) { return api.rtcPointQuery16(args...); });
}

/// A function's calls, in order. There is one test at a time.
struct CallRecord {
  char function;
  RTCPointQueryFunctionArguments args;
  float radius;
};
std::vector<CallRecord> calls;

template <char kName, bool kAnswer>
bool Record(RTCPointQueryFunctionArguments* args) {
  calls.push_back({kName, *args, args->query->radius});
  return kAnswer;
}

std::string NamesOfCalls() {
  std::string names;
  for (const CallRecord& call : calls) names += call.function;
  calls.clear();
  return names;
}

TEST_P(PointQueries, CallTheirOwnFunctionAndThenTheGeometrys) {
  const Api& api = s_.api;
  const RTCGeometry geometry = s_.Triangle();
  const RTCScene scene = s_.SceneOf(geometry);
  int user_value = 0;
  RTCPointQuery query = QueryAt({0.2, 0.2, 0}, 1);
  const auto run = [&](RTCPointQueryFunction function) {
    calls.clear();
    return Query(api, scene, query, function, &user_value);
  };
  EXPECT_FALSE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "");
  EXPECT_TRUE(run(Record<'q', true>));
  EXPECT_EQ(NamesOfCalls(), "q");
  // A function counts at once, without another commit.
  api.rtcSetGeometryPointQueryFunction(geometry, Record<'g', false>);
  api.rtcCommitScene(scene);
  EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
  EXPECT_FALSE(run(Record<'q', false>));
  for (const CallRecord& call : calls) {
    EXPECT_EQ(call.args.userPtr, &user_value);
    EXPECT_EQ(call.args.query, &query);
    EXPECT_EQ(call.args.geomID, 0u);
    EXPECT_EQ(call.args.primID, 0u);
    EXPECT_EQ(call.args.similarityScale, 1);
  }
  EXPECT_EQ(NamesOfCalls(), "qg");
  EXPECT_TRUE(run(Record<'q', true>));
  EXPECT_EQ(NamesOfCalls(), "qg");
  EXPECT_FALSE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "g");
  EXPECT_FALSE(run(Record<'g', false>));
  EXPECT_EQ(NamesOfCalls(), "gg");
  api.rtcSetGeometryPointQueryFunction(geometry, Record<'h', true>);
  EXPECT_TRUE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "h");
  api.rtcSetGeometryPointQueryFunction(geometry, nullptr);
  EXPECT_FALSE(run(nullptr));
  EXPECT_EQ(NamesOfCalls(), "");
}

TEST_P(PointQueries, InAnInstanceCallTheFunctionsOfItsGeometries) {
  const Api& api = s_.api;
  const RTCGeometry geometry = s_.Triangle();
  const RTCScene inner = s_.SceneOf(geometry);
  const RTCGeometry instance = s_.Own(api.rtcNewGeometry(s_.device, RTC_GEOMETRY_TYPE_INSTANCE));
  const Matrix moved{1, 0, 0, 0, 1, 0, 0, 0, 1, 10, 0, 0};
  api.rtcSetGeometryInstancedScene(instance, inner);
  api.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, moved.data());
  api.rtcCommitGeometry(instance);
  api.rtcSetGeometryPointQueryFunction(geometry, Record<'g', false>);
  api.rtcSetGeometryPointQueryFunction(instance, Record<'i', false>);
  EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
  const RTCScene scene = s_.SceneOf(instance);
  RTCPointQuery query = QueryAt({10.2, 0.2, 0}, 1);
  calls.clear();
  Query(api, scene, query, Record<'q', false>, nullptr);
  for (const CallRecord& call : calls) EXPECT_EQ(call.args.query->x, 10.2f);
  EXPECT_EQ(NamesOfCalls(), "qg");
}

/// Shrinks the radius without saying so.
bool ShrinkInSilence(RTCPointQueryFunctionArguments* args) {
  ++*static_cast<int*>(args->userPtr);
  args->query->radius = 0.5f;
  return false;
}

TEST_P(PointQueries, ARadiusThatShrinksInSilenceDoesNotCount) {
  const RTCScene scene = s_.NewScene();
  for (const float z : {0.0f, 5.0f}) s_.api.rtcAttachGeometry(scene, s_.Triangle(z));
  s_.api.rtcCommitScene(scene);
  RTCPointQuery query = QueryAt({0.2, 0.2, 0}, 100);
  int count = 0;
  EXPECT_FALSE(Query(s_.api, scene, query, ShrinkInSilence, &count));
  EXPECT_EQ(count, 2);
  EXPECT_EQ(query.radius, 0.5f);
}

struct Reentrance {
  const Api& api;
  RTCScene scene;
  int depth = 0;
  int inner_calls = 0;
};

/// Traces a ray and asks once more.
bool Reenter(RTCPointQueryFunctionArguments* args) {
  auto& state = *static_cast<Reentrance*>(args->userPtr);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = RayAt(0.2f);
  state.api.rtcIntersect1(state.scene, &context, &ray);
  EXPECT_EQ(ray.hit.geomID, 0u);
  if (state.depth > 0) {
    ++state.inner_calls;
    return false;
  }
  ++state.depth;
  RTCPointQuery query = QueryAt({0, 0, 0}, 100);
  Query(state.api, state.scene, query, Reenter, &state);
  --state.depth;
  return false;
}

TEST_P(PointQueries, FunctionsMayQueryAndTraceThemselves) {
  const RTCScene scene = s_.NewScene();
  for (const float z : {0.0f, 5.0f}) s_.api.rtcAttachGeometry(scene, s_.Triangle(z));
  s_.api.rtcCommitScene(scene);
  Reentrance state{s_.api, scene};
  RTCPointQuery query = QueryAt({0.2, 0.2, 0}, 100);
  Query(s_.api, scene, query, Reenter, &state);
  EXPECT_EQ(state.inner_calls, 4);
}

// Programs that keep instances themselves put them on the stack, and the query comes to the scene
// through the topmost one.
TEST_P(PointQueries, GoThroughTheStackThatTheyAreCalledWith) {
  const Api& api = s_.api;
  const RTCScene scene = s_.NewScene();
  for (const float z : {0.0f, 5.0f}) api.rtcAttachGeometry(scene, s_.Triangle(z));
  api.rtcCommitScene(scene);
  struct {
    Matrix world2inst;
    float scale;
  } const stacks[] = {{{0.5f, 0, 0, 0, 0.5f, 0, 0, 0, 0.5f, -5, -5, -5}, 0.5f},
                      {{0.5f, 0, 0, 0, 1, 0, 0, 0, 0.5f, -5, -10, -5}, 0}};
  for (const auto& stack : stacks) {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const float kIgnored = 9;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row) {
        context.world2inst[0][4 * column + row] = stack.world2inst[3 * column + row];
      }
      context.world2inst[0][4 * column + 3] = kIgnored;
    }
    context.instStackSize = 1;
    context.instID[0] = 7;
    // Around (0.1, 0.1, 0) in the scene; the other triangle is 5 away there, and 10 here.
    RTCPointQuery query = QueryAt({10.2, 10.1, 10}, 12);
    calls.clear();
    api.rtcPointQuery(scene, &query, &context, Record<'q', false>, nullptr);
    ASSERT_EQ(calls.size(), 2u);
    for (const CallRecord& call : calls) {
      EXPECT_EQ(call.args.similarityScale, stack.scale);
      EXPECT_EQ(call.args.context->instStackSize, 1u);
      EXPECT_EQ(call.args.context->instID[0], 7u);
      EXPECT_EQ(call.args.query->x, 10.2f);
    }
    EXPECT_EQ(context.instStackSize, 1u);
    EXPECT_EQ(context.world2inst[0][3], kIgnored);
    if (!IsOurs()) continue;  // The real library offers all of a leaf.
    query.radius = 9;
    calls.clear();
    api.rtcPointQuery(scene, &query, &context, Record<'q', false>, nullptr);
    ASSERT_EQ(calls.size(), 1u);
    EXPECT_EQ(calls[0].args.geomID, 0u);
  }
}

TEST_P(PointQueries, TakeFunctionsForGeometriesOfEveryType) {
  for (const RTCGeometryType type :
       {RTC_GEOMETRY_TYPE_TRIANGLE, RTC_GEOMETRY_TYPE_QUAD, RTC_GEOMETRY_TYPE_GRID,
        RTC_GEOMETRY_TYPE_SPHERE_POINT, RTC_GEOMETRY_TYPE_DISC_POINT,
        RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT, RTC_GEOMETRY_TYPE_USER,
        RTC_GEOMETRY_TYPE_INSTANCE}) {
    const RTCGeometry geometry = s_.Own(s_.api.rtcNewGeometry(s_.device, type));
    s_.api.rtcSetGeometryPointQueryFunction(geometry, Record<'g', false>);
    s_.api.rtcSetGeometryPointQueryFunction(geometry, nullptr);
    EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE) << type;
  }
}

TEST_P(PointQueries, FindNothingWithoutAPlace) {
  const RTCScene scene = s_.SceneOf(s_.Triangle());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  if (IsOurs()) {  // The real library offers all of a leaf.
    for (RTCPointQuery query : {QueryAt({nan, 0, 0}, 1), QueryAt({0, 0, 0}, nan)}) {
      calls.clear();
      EXPECT_FALSE(Query(s_.api, scene, query, Record<'q', true>, nullptr));
      EXPECT_EQ(NamesOfCalls(), "");
    }
  }
  const RTCScene empty = s_.NewScene();
  s_.api.rtcCommitScene(empty);
  RTCPointQuery query = QueryAt({0, 0, 0}, 1);
  calls.clear();
  EXPECT_FALSE(Query(s_.api, empty, query, Record<'q', true>, nullptr));
  EXPECT_EQ(NamesOfCalls(), "");
  EXPECT_EQ(s_.TakeError(), RTC_ERROR_NONE);
}

// The real library checks nothing, and crashes on each of these.
TEST(PointQueryErrors, AreReported) {
  Session s(DropIn());
  const Api& api = s.api;
  const RTCScene scene = s.SceneOf(s.Triangle());
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query = QueryAt({0, 0, 0}, 1);
  alignas(64) RTCPointQuery16 packet{};
  alignas(64) const int valid[16] = {-1};
  const RTCPointQueryFunction function = Record<'q', true>;
  calls.clear();

  EXPECT_FALSE(api.rtcPointQuery(s.NewScene(), &query, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_FALSE(api.rtcPointQuery(scene, nullptr, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery(scene, &query, nullptr, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery16(nullptr, scene, &packet, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery16(valid, scene, nullptr, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  context.instStackSize = 2;
  EXPECT_FALSE(api.rtcPointQuery(scene, &query, &context, function, nullptr));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(api.rtcPointQuery(nullptr, &query, &context, function, nullptr));
  EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(NamesOfCalls(), "");
  for (const ErrorReport& report : s.reports) {
    EXPECT_TRUE(report.message.starts_with("rtcPointQuery")) << report.message;
  }
}

}  // namespace
}  // namespace dacrt::tests

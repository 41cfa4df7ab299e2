#include "world_reference.h"

#include <algorithm>
#include <cmath>

#include "slab_test.h"

namespace dacrt::tests {
namespace {

/// The coordinates beyond which Embree leaves a primitive out.
constexpr float kLargestCoordinate = 1.844e18f;

bool IsLegal(float coordinate) { return std::abs(coordinate) < kLargestCoordinate; }

bool IsLegal(const Vertex& vertex, bool has_radius) {
  return IsLegal(vertex.x) && IsLegal(vertex.y) && IsLegal(vertex.z) &&
         (!has_radius || (vertex.radius >= 0 && IsLegal(vertex.radius)));
}

Double3 PositionOf(const Vertex& vertex) { return {vertex.x, vertex.y, vertex.z}; }

std::size_t VertexCountOf(const Part& part) { return HasPoints(part.geometry->shape) ? 1 : 3; }

/// Of those that the library tests itself.
bool IsPoint(const Part& part) {
  return HasPoints(part.geometry->shape) && part.geometry->shape != Shape::kUser;
}

/// Whether a quad or triangle is there at all times: neither library takes one with a vertex that
/// is missing or not finite at any time step.
bool IsPresent(const WorldGeometry& geometry, std::span<const uint32_t> indices) {
  for (const auto& step : geometry.vertices) {
    for (const uint32_t index : indices) {
      if (index >= step.size() || !IsLegal(step[index], HasPoints(geometry.shape))) return false;
    }
  }
  if (geometry.shape != Shape::kOrientedDiscs) return true;
  for (const auto& step : geometry.normals) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!IsLegal(step[indices[0]][axis])) return false;
    }
  }
  return true;
}

/// A value of a quad's second triangle, which a library may also compute as a quotient of its own.
Approximate FromOppositeCorner(const Approximate& value) {
  Approximate result = Exactly(1) - value;
  result.error += RoundingOf(kQuotientOperations) * Magnitude(result);
  return result;
}

/// Values of a quad's cell as the whole grid counts them.
Approximate InGrid(const Approximate& value, uint32_t cell, uint32_t cells) {
  return (value + Exactly(cell)) / Exactly(cells);
}

}  // namespace

WorldReference::WorldReference(const std::vector<WorldScene>& scenes) : scenes_(scenes) {
  AddScene(scenes.back(), nullptr);
  for (const Part& part : parts_) spheres_.push_back(BoundingSphere(part));
  for (Group& group : groups_) {
    Sphere& sphere = group.sphere;
    const auto count = static_cast<double>(group.end - group.first);
    for (std::size_t i = group.first; i < group.end; ++i) {
      sphere.center = sphere.center + (1 / count) * spheres_[i].center;
    }
    for (std::size_t i = group.first; i < group.end; ++i) {
      sphere.radius =
          std::max(sphere.radius, Length(spheres_[i].center - sphere.center) + spheres_[i].radius);
    }
  }
}

void WorldReference::AddScene(const WorldScene& scene, const WorldGeometry* instance) {
  for (const WorldGeometry& geometry : scene.geometries) {
    if (!geometry.enabled || !geometry.attached) continue;
    has_time_ranges_ = has_time_ranges_ || geometry.time_begin != 0 || geometry.time_end != 1;
    if (geometry.shape == Shape::kInstance) {
      // There is one level of instances.
      if (!instance) AddScene(scenes_[geometry.instanced_scene], &geometry);
    } else {
      AddGeometry(scene, geometry, instance);
    }
  }
}

void WorldReference::AddGeometry(const WorldScene& scene, const WorldGeometry& geometry,
                                 const WorldGeometry* instance) {
  const std::size_t first = parts_.size();
  Part part{};
  part.scene = &scene;
  part.geometry = &geometry;
  part.instance = instance;
  part.name.instance_id = instance ? instance->id : RTC_INVALID_GEOMETRY_ID;
  part.name.geometry_id = geometry.id;
  part.columns = part.rows = 1;
  const auto add_quad = [&](const std::array<uint32_t, 4>& q) {
    if (!IsPresent(geometry, q)) return;
    part.is_second = false;
    part.vertex = {q[0], q[1], q[3]};
    parts_.push_back(part);
    part.is_second = true;
    part.vertex = {q[2], q[3], q[1]};
    parts_.push_back(part);
  };
  for (uint32_t i = 0; i < geometry.PrimitiveCount(); ++i) {
    part.name.primitive_id = i;
    if (HasPoints(geometry.shape)) {
      part.vertex = {i, i, i};
      if (IsPresent(geometry, {{i}})) parts_.push_back(part);
      continue;
    }
    const std::array<uint32_t, 4>& p = geometry.primitives[i];
    if (geometry.shape == Shape::kTriangles) {
      part.vertex = {p[0], p[1], p[2]};
      if (IsPresent(geometry, part.vertex)) parts_.push_back(part);
    } else if (geometry.shape == Shape::kQuads) {
      add_quad(p);
    } else {
      part.columns = p[2] - 1;
      part.rows = p[3] - 1;
      for (part.row = 0; part.row < part.rows; ++part.row) {
        for (part.column = 0; part.column < part.columns; ++part.column) {
          const uint32_t corner = p[0] + part.row * p[1] + part.column;
          add_quad({corner, corner + 1, corner + p[1] + 1, corner + p[1]});
        }
      }
    }
  }
  if (parts_.size() == first) return;
  const bool may_be_left_out = instance && MayBeLeftOut(*instance);
  groups_.push_back({&geometry, instance, first, parts_.size(), {}, may_be_left_out});
}

WorldReference::Sphere WorldReference::BoundingSphere(const Part& part) {
  const auto& steps = part.geometry->vertices;
  const std::size_t vertices = VertexCountOf(part);
  Sphere sphere;
  const double count = static_cast<double>(steps.size() * vertices);
  for (const auto& step : steps) {
    for (std::size_t i = 0; i < vertices; ++i) {
      sphere.center = sphere.center + (1 / count) * PositionOf(step[part.vertex[i]]);
    }
  }
  for (const auto& step : steps) {
    for (std::size_t i = 0; i < vertices; ++i) {
      const Vertex& vertex = step[part.vertex[i]];
      const double own = HasPoints(part.geometry->shape) ? vertex.radius : 0;
      sphere.radius = std::max(sphere.radius, Length(PositionOf(vertex) - sphere.center) + own);
    }
  }
  return sphere;
}

bool WorldReference::IsNear(const ApproximateRay& ray, const Sphere& sphere) {
  constexpr double kScale = 2;
  // Far above double rounding, and above what an instance's transform does to the line.
  constexpr double kSlack = 1e-9;
  const Double3 direction{ray.dir[0].value, ray.dir[1].value, ray.dir[2].value};
  const Double3 origin{ray.org[0].value, ray.org[1].value, ray.org[2].value};
  const Double3 to_center = sphere.center - origin;
  const Double3 offset = Cross(to_center, direction);
  const double radius = kScale * sphere.radius;
  const double limit = radius * radius + kSlack * (Dot(to_center, to_center) + radius * radius);
  return !(Dot(offset, offset) > limit * Dot(direction, direction));
}

namespace {

/// What two tests may find together.
ShapeAnswer Either(ShapeAnswer a, const ShapeAnswer& b) {
  if (!b.MayHit()) {
    if (a.MayHit()) a.doubts |= kDoubtEdge;
    return a;
  }
  if (!a.MayHit()) return Either(b, a);
  a.is_hit = a.is_hit && b.is_hit;
  a.doubts |= b.doubts;
  const auto widen = [](Bounded& bound, const Bounded& other) {
    bound.error = std::max(bound.error, other.error + std::abs(other.value - bound.value));
  };
  widen(a.t, b.t);
  widen(a.u, b.u);
  widen(a.v, b.v);
  for (int axis = 0; axis < 3; ++axis) widen(a.normal[axis], b.normal[axis]);
  return a;
}

ShapeAnswer TestFacetOf(const Part& part, const ApproximateRay& ray,
                        const ApproximateVertex* vertex) {
  const auto& [v0, v1, v2] = std::array{vertex[0].position, vertex[1].position, vertex[2].position};
  if (part.scene->IsRobust()) return TestFacetRobustly(ray, v0, v1, v2);
  const ShapeAnswer answer = TestFacet(ray, v0, v1, v2);
  if (part.geometry->shape != Shape::kGrids || part.geometry->StepCount() == 1) return answer;
  // The real library tests moving grids as robust ones always.
  return Either(answer, TestFacetRobustly(ray, v0, v1, v2));
}

}  // namespace

void WorldReference::Test(const ApproximateRay& ray, const Part& part, const Moment& moment,
                          std::vector<PossibleHit>& hits) {
  const WorldGeometry& geometry = *part.geometry;
  std::vector<ShapeAnswer> answers;
  ApproximateVertex vertex[3];
  for (std::size_t i = 0; i < VertexCountOf(part); ++i) {
    vertex[i] = VertexAt(geometry, part.vertex[i], moment);
  }
  switch (geometry.shape) {
    case Shape::kSpheres:
    case Shape::kUser:
      answers = TestSphere(ray, vertex[0]);
      break;
    case Shape::kDiscs:
      answers.push_back(TestDisc(ray, vertex[0]));
      break;
    case Shape::kOrientedDiscs:
      answers.push_back(
          TestOrientedDisc(ray, vertex[0], NormalAt(geometry, part.vertex[0], moment)));
      break;
    default: {
      ShapeAnswer answer = TestFacetOf(part, ray, vertex);
      if (part.is_second) {
        answer.u = FromOppositeCorner(answer.u);
        answer.v = FromOppositeCorner(answer.v);
      }
      if (geometry.shape == Shape::kGrids) {
        answer.u = InGrid(answer.u, part.column, part.columns);
        answer.v = InGrid(answer.v, part.row, part.rows);
      }
      answers.push_back(answer);
    }
  }
  for (ShapeAnswer& answer : answers) {
    if (moment.is_doubtful) answer.doubts |= kDoubtInterval;
    if (answer.MayHit()) hits.push_back({&part, answer});
  }
}

std::vector<PossibleHit> WorldReference::Hits(const RTCRay& ray, bool near_only,
                                              const HitName* name) const {
  const ApproximateRay world_ray = Exactly(ray);
  std::vector<PossibleHit> hits;
  for (const Group& group : groups_) {
    const Part& any = parts_[group.first];
    if (name &&
        (any.name.instance_id != name->instance_id || any.name.geometry_id != name->geometry_id)) {
      continue;
    }
    if ((group.geometry->mask & ray.mask) == 0) continue;
    Moment moment = MomentAt(*group.geometry, ray.time);
    ApproximateRay local_ray = world_ray;
    if (group.instance) {
      if ((group.instance->mask & ray.mask) == 0) continue;
      const Moment placed = MomentAt(*group.instance, ray.time);
      if (!placed.is_there && !placed.is_doubtful) continue;
      moment.is_doubtful = moment.is_doubtful || placed.is_doubtful;
      local_ray = ToInstance(world_ray, ToWorld(*group.instance, placed));
    }
    if (!moment.is_there && !moment.is_doubtful) continue;
    if (near_only && !IsNear(local_ray, group.sphere)) continue;
    moment.is_doubtful = moment.is_doubtful || group.may_be_left_out;
    for (std::size_t i = group.first; i < group.end; ++i) {
      if (name && parts_[i].name.primitive_id != name->primitive_id) continue;
      if (near_only && !IsNear(local_ray, spheres_[i])) continue;
      Test(local_ray, parts_[i], moment, hits);
    }
  }
  return hits;
}

bool WorldReference::IsAtEndOfTimes(const RTCRay& ray) const {
  const auto is_at_end = [&](const WorldGeometry* geometry) {
    if (!geometry || geometry->StepCount() == 1) return false;
    // Where rays have no times beyond it, it is no end.
    return (ray.time <= geometry->time_begin && geometry->time_begin > 0) ||
           (ray.time >= geometry->time_end && geometry->time_end < 1) ||
           MomentAt(*geometry, ray.time).is_doubtful;
  };
  return std::any_of(groups_.begin(), groups_.end(), [&](const Group& group) {
    return is_at_end(group.geometry) || is_at_end(group.instance);
  });
}

struct WorldReference::Box : SlabBox {};

WorldReference::Box WorldReference::BoxOf(const Part& part, float time) {
  const WorldGeometry& geometry = *part.geometry;
  const Moment moment = MomentAt(geometry, time);
  Box box;
  for (std::size_t i = 0; i < VertexCountOf(part); ++i) {
    const ApproximateVertex vertex = VertexAt(geometry, part.vertex[i], moment);
    const Approximate radius = HasPoints(geometry.shape) ? vertex.radius : Approximate{};
    box.Extend(vertex.position, radius);
  }
  const bool is_user = geometry.shape == Shape::kUser;
  if (!is_user && geometry.shape != Shape::kGrids && geometry.StepCount() == 1) return box;
  // Boxes that move are given by their places at two times, which may be the ends of a part of the
  // range, and stretched to the whole; those of a grid's quads count in parts of the grid's.
  for (int axis = 0; axis < 3; ++axis) {
    double largest = 0;
    for (const auto& step : geometry.vertices) {
      for (const Vertex& vertex : step) {
        largest = std::max(largest, std::abs(PositionOf(vertex)[axis]) + vertex.radius);
      }
    }
    constexpr int kOperations = 8;
    box.plane_error[axis] += RoundingOf(kOperations) * geometry.StepCount() * largest;
  }
  return box;
}

WorldReference::Box WorldReference::BoxOfInstance(const WorldGeometry& instance,
                                                  const ApproximateTransform& to_world) const {
  // Of everything that is there at any time, which the real library's box may be smaller than.
  Double3 lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
  for (const WorldGeometry& geometry : scenes_[instance.instanced_scene].geometries) {
    if (!geometry.enabled || !geometry.attached) continue;
    for (const auto& step : geometry.vertices) {
      for (const Vertex& vertex : step) {
        const double radius = HasPoints(geometry.shape) ? vertex.radius : 0;
        for (int axis = 0; axis < 3; ++axis) {
          lower[axis] = std::min(lower[axis], PositionOf(vertex)[axis] - radius);
          upper[axis] = std::max(upper[axis], PositionOf(vertex)[axis] + radius);
        }
      }
    }
  }
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    Approximate3 position;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& c = to_world.column;
      const Approximate factors[4] = {c[0][axis], c[1][axis], c[2][axis], c[3][axis]};
      const Approximate point[4] = {Exactly(corner & 1 ? upper.x : lower.x),
                                    Exactly(corner & 2 ? upper.y : lower.y),
                                    Exactly(corner & 4 ? upper.z : lower.z), Exactly(1)};
      position[axis] = SumOfProducts(factors, point);
      constexpr int kOperations = 8;
      box.plane_error[axis] =
          std::max(box.plane_error[axis],
                   RoundingOf(kOperations) * instance.StepCount() * Magnitude(position[axis]));
    }
    box.Extend(position, {});
  }
  return box;
}

WorldReference::Box WorldReference::LongestBoxWith(const Part& points) const {
  const auto moves = [](const Part& part) { return part.geometry->StepCount() > 1; };
  Box box;
  bool bends = false;
  for (const Part& part : parts_) {
    if (part.scene != points.scene || !IsPoint(part) || moves(part) != moves(points)) continue;
    bends = bends || part.geometry->StepCount() > 2;
    for (const auto& step : part.geometry->vertices) {
      const Vertex& vertex = step[part.vertex[0]];
      const Double3 p = PositionOf(vertex);
      box.Extend({Exactly(p.x), Exactly(p.y), Exactly(p.z)}, Exactly(vertex.radius));
    }
  }
  if (!bends) return box;
  // Bounds that are linear in time are moved out, at both ends, by what a step stands out of them.
  for (int axis = 0; axis < 3; ++axis) {
    const double length = box.upper[axis] - box.lower[axis];
    box.lower[axis] -= length;
    box.upper[axis] += length;
  }
  return box;
}

/// It is where its bounds at one of its steps are, which both libraries round.
bool WorldReference::MayBeLeftOut(const WorldGeometry& instance) const {
  constexpr double kSurelyTaken = 0.999 * kLargestCoordinate;
  const uint32_t steps = instance.StepCount();
  for (uint32_t step = 0; step < steps; ++step) {
    Moment moment;
    moment.step = step + 1 < steps || steps == 1 ? step : step - 1;
    moment.fraction = Exactly(step - moment.step);
    const Box box = BoxOfInstance(instance, ToWorld(instance, moment));
    for (int axis = 0; axis < 3; ++axis) {
      if (!(box.lower[axis] > -kSurelyTaken && box.upper[axis] < kSurelyTaken)) return true;
    }
  }
  return false;
}

bool WorldReference::SlabTestMayMiss(const RTCRay& ray, float tfar, const Part& part,
                                     const Company& company) const {
  if (PlanesMayBeSwapped(ray, company.guides)) return true;
  const auto moves = [](const WorldGeometry* geometry) {
    return geometry && geometry->StepCount() > 1;
  };
  if (has_time_ranges_ && (moves(part.geometry) || moves(part.instance))) return true;
  const ApproximateRay world_ray = Exactly(ray);
  const Box box = BoxOf(part, ray.time);
  const auto may_miss = [&](const ApproximateRay& local_ray, std::span<const RTCRayHit> packet) {
    return tests::SlabTestMayMiss(local_ray, tfar, box, packet) ||
           (IsPoint(part) && OwnSpaceTestMayMiss(local_ray, box, LongestBoxWith(part)));
  };
  if (!part.instance) return may_miss(world_ray, company.packet);
  const ApproximateTransform to_world = ToWorld(*part.instance, MomentAt(*part.instance, ray.time));
  if (tests::SlabTestMayMiss(world_ray, tfar, BoxOfInstance(*part.instance, to_world),
                             company.packet)) {
    return true;
  }
  // Packets stay together in instances.
  const auto to_instance = [&](RTCRayHit record) {
    const ApproximateRay local = ToInstance(Exactly(record.ray), to_world);
    for (int axis = 0; axis < 3; ++axis) {
      (&record.ray.org_x)[axis] = static_cast<float>(local.org[axis].value);
      (&record.ray.dir_x)[axis] = static_cast<float>(local.dir[axis].value);
    }
    return record;
  };
  std::vector<RTCRayHit> local_packet;
  for (const RTCRayHit& other : company.packet) local_packet.push_back(to_instance(other));
  return PlanesMayBeSwapped(to_instance({ray, {}}).ray, local_packet) ||
         may_miss(ToInstance(world_ray, to_world), local_packet);
}

}  // namespace dacrt::tests

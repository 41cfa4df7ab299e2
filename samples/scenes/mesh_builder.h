// The few shapes that the hall is made of. Every curved one is a patch: a grid of points on a
// surface, cut into triangles.
#pragma once

#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "scenes/hall.h"

namespace scenes {

using Imath::V3d;

// Sine and cosine of an angle given in full turns. The standard library's differ between machines
// in the last bit; these are plain arithmetic, and exact at every quarter turn.
struct Direction {
  double cosine;
  double sine;
};
Direction AtTurn(double turns);
inline double Cos(double turns) { return AtTurn(turns).cosine; }
inline double Sin(double turns) { return AtTurn(turns).sine; }

inline double Mix(double from, double to, double t) { return from + (to - from) * t; }

// Numbers that look random and are the same everywhere.
class Random {
 public:
  explicit Random(uint32_t seed) : state_(seed * 747796405u + 2891336453u) {}
  double Between(double low, double high);

 private:
  uint32_t state_;
};

// A local coordinate system: where a piece stands and how it is turned.
struct Frame {
  V3d origin{0, 0, 0};
  V3d x{1, 0, 0};
  V3d y{0, 1, 0};
  V3d z{0, 0, 1};

  V3d operator()(const V3d& local) const {
    return origin + x * local.x + y * local.y + z * local.z;
  }
  Frame At(double px, double py, double pz) const { return {(*this)({px, py, pz}), x, y, z}; }
  Frame Scaled(double sx, double sy, double sz) const { return {origin, x * sx, y * sy, z * sz}; }
  Frame Scaled(double s) const { return Scaled(s, s, s); }
  Frame TurnedAboutX(double turns) const;  // y towards z
  Frame TurnedAboutY(double turns) const;  // z towards x
  Frame TurnedAboutZ(double turns) const;  // x towards y
};

// A point of a profile: a curve in the half plane of (radius, height), or of (z, y) when extruded.
// The curve runs smoothly through the points, except at corners.
struct ProfilePoint {
  double radius;
  double height;
  bool corner = false;
};
inline constexpr bool kCorner = true;
using Profile = std::initializer_list<ProfilePoint>;

struct PatchShape {
  int across;               // cells along u
  int along;                // cells along v
  bool closed = false;      // u = 1 is u = 0
  bool closed_end = false;  // v = 1 is v = 0
  bool start_pole = false;  // all of v = 0 is one point
  bool end_pole = false;    // all of v = 1 is one point

  int Columns() const { return closed ? across : across + 1; }
  int Rows() const { return closed_end ? along : along + 1; }
  uint64_t VertexCount() const { return uint64_t(Columns()) * Rows(); }
  uint64_t TriangleCount() const {
    return uint64_t(across) * (2 * uint64_t(along) - start_pole - end_pole);
  }
};

class MeshBuilder {
 public:
  // `detail` multiplies the number of cells along every curve. Without a mesh,
  // vertices and triangles are only counted.
  MeshBuilder(double detail, Mesh* mesh) : detail_(detail), mesh_(mesh) {}

  uint64_t vertex_count() const { return vertex_count_; }
  uint64_t triangle_count() const { return triangle_count_; }

  // The number of cells for a curve that takes `usual` of them at detail 1.
  int Cells(double usual, int least) const {
    return std::max(least, int(std::floor(usual * detail_ + 0.5)));
  }

  // How many of `all` the pieces of a kind to make: fewer than all where the detail is low.
  int Pieces(int all) const {
    constexpr double kAllFrom = 0.5;
    return std::clamp(int(all * detail_ / kAllFrom), (all + 7) / 8, all);
  }

  // The surface is a function of (u, v), both from 0 to 1, to a local point.
  template <class Surface>
  void Patch(const Frame& frame, const PatchShape& shape, const Surface& surface);

  // Four corners in order around the face.
  void Quad(const Frame& frame, const V3d& a, const V3d& b, const V3d& c, const V3d& d);
  void Box(const Frame& frame, const V3d& low, const V3d& high);

  // A surface of revolution about y. `smoothness` is the usual number of cells from one profile
  // point to the next.
  void Revolve(const Frame& frame, Profile profile, double around, double smoothness);

  // The profile, as (z, y), drawn along x from 0 to `length`.
  void Extrude(const Frame& frame, Profile profile, double length, double smoothness);

  // A tube along the curve, a function of t from 0 to 1 to a local point, with the radius at t.
  // `normal` must never be parallel to the curve; for a plane curve it is the normal of the plane.
  template <class Curve, class Radius>
  void Tube(const Frame& frame, const Curve& curve, const Radius& radius, const V3d& normal,
            int along, int around, bool closed = false);
  void Rod(const Frame& frame, const V3d& from, const V3d& to, double radius, double around);

  void Ellipsoid(const Frame& frame, const V3d& radii, double around);
  // A box with bulging faces and soft edges.
  void Cushion(const Frame& frame, const V3d& radii, double around);
  // A ring in the plane of x and z.
  void Ring(const Frame& frame, double ring_radius, double tube_radius, double along,
            double around);

 private:
  uint32_t AddVertex(const V3d& position);
  void AddTriangle(uint32_t a, uint32_t b, uint32_t c);

  double detail_;
  Mesh* mesh_;
  uint64_t vertex_count_ = 0;
  uint64_t triangle_count_ = 0;
};

template <class Surface>
void MeshBuilder::Patch(const Frame& frame, const PatchShape& shape, const Surface& surface) {
  vertex_count_ += shape.VertexCount();
  triangle_count_ += shape.TriangleCount();
  if (!mesh_) return;

  const uint32_t columns = shape.Columns();
  const uint32_t rows = shape.Rows();
  const uint32_t first = uint32_t(mesh_->VertexCount());
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      AddVertex(frame(surface(double(column) / shape.across, double(row) / shape.along)));
    }
  }

  for (int row = 0; row < shape.along; ++row) {
    const uint32_t low = first + row * columns;
    const uint32_t high = first + (row + 1) % rows * columns;
    for (int column = 0; column < shape.across; ++column) {
      const uint32_t left = column;
      const uint32_t right = (column + 1) % columns;
      if (!(shape.start_pole && row == 0)) AddTriangle(low + left, low + right, high + right);
      if (!(shape.end_pole && row == shape.along - 1)) {
        AddTriangle(low + left, high + right, high + left);
      }
    }
  }
}

template <class Curve, class Radius>
void MeshBuilder::Tube(const Frame& frame, const Curve& curve, const Radius& radius,
                       const V3d& normal, int along, int around, bool closed) {
  constexpr double kStep = 1e-4;  // for the tangent, as a part of the curve
  Patch(frame, {.across = around, .along = along, .closed = true, .closed_end = closed},
        [&](double u, double v) {
          const V3d tangent = curve(v + kStep) - curve(v - kStep);
          const V3d side = tangent.cross(normal).normalized();
          const V3d top = side.cross(tangent).normalized();
          const auto [cosine, sine] = AtTurn(u);
          return curve(v) + (side * cosine + top * sine) * radius(v);
        });
}

}  // namespace scenes

#include "scenes/mesh_builder.h"

namespace scenes {
namespace {

// A cubic from p to q with the tangents given (Hermite).
double Cubic(double p, double q, double tangent_p, double tangent_q, double t) {
  const double a = 2 * (p - q) + tangent_p + tangent_q;
  const double b = 3 * (q - p) - 2 * tangent_p - tangent_q;
  return ((a * t + b) * t + tangent_p) * t + p;
}

// The profile at t, from 0 to 1: a Catmull-Rom spline, broken at its corners.
ProfilePoint ProfileAt(Profile profile, double t) {
  const int spans = int(profile.size()) - 1;
  const int span = std::min(int(t * spans), spans - 1);
  const ProfilePoint* p = profile.begin() + span;
  const ProfilePoint* q = p + 1;
  const ProfilePoint* before = span == 0 || p->corner ? p : p - 1;
  const ProfilePoint* after = span == spans - 1 || q->corner ? q : q + 1;
  // Half of the chord round an inner point; the span itself at an end and at a corner.
  const double weight_p = before == p ? 1 : 0.5;
  const double weight_q = after == q ? 1 : 0.5;
  const double local = t * spans - span;
  return {Cubic(p->radius, q->radius, (q->radius - before->radius) * weight_p,
                (after->radius - p->radius) * weight_q, local),
          Cubic(p->height, q->height, (q->height - before->height) * weight_p,
                (after->height - p->height) * weight_q, local)};
}

}  // namespace

Direction AtTurn(double turns) {
  constexpr double kQuarterTurn = 1.57079632679489661923;  // radians
  const double quarters = turns * 4;
  const double nearest = std::floor(quarters + 0.5);
  const double x = (quarters - nearest) * kQuarterTurn;  // at most an eighth of a turn from 0
  const double square = x * x;
  // Taylor series; the first term left out is below 1e-15.
  double sine = 0;
  double cosine = 0;
  for (int n = 14; n > 0; n -= 2) {
    sine = (1 + sine) * -square / (n * (n + 1));
    cosine = (1 + cosine) * -square / (n * (n - 1));
  }
  sine = (1 + sine) * x;
  cosine = 1 + cosine;
  switch (int64_t(nearest) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

// PCG-RXS-M-XS 32 (O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good
// Algorithms for Random Number Generation", 2014).
double Random::Between(double low, double high) {
  state_ = state_ * 747796405u + 2891336453u;
  const uint32_t word = ((state_ >> ((state_ >> 28) + 4)) ^ state_) * 277803737u;
  return Mix(low, high, ((word >> 22) ^ word) * 0x1p-32);
}

Frame Frame::TurnedAboutX(double turns) const {
  const auto [c, s] = AtTurn(turns);
  return {origin, x, y * c + z * s, z * c - y * s};
}

Frame Frame::TurnedAboutY(double turns) const {
  const auto [c, s] = AtTurn(turns);
  return {origin, x * c - z * s, y, z * c + x * s};
}

Frame Frame::TurnedAboutZ(double turns) const {
  const auto [c, s] = AtTurn(turns);
  return {origin, x * c + y * s, y * c - x * s, z};
}

uint32_t MeshBuilder::AddVertex(const V3d& position) {
  const uint32_t index = uint32_t(mesh_->VertexCount());
  for (double coordinate : {position.x, position.y, position.z}) {
    mesh_->positions.push_back(float(coordinate));
  }
  return index;
}

void MeshBuilder::AddTriangle(uint32_t a, uint32_t b, uint32_t c) {
  mesh_->indices.insert(mesh_->indices.end(), {a, b, c});
}

void MeshBuilder::Quad(const Frame& frame, const V3d& a, const V3d& b, const V3d& c, const V3d& d) {
  Patch(frame, {.across = 1, .along = 1},
        [&](double u, double v) { return v == 0 ? (u == 0 ? a : b) : (u == 0 ? d : c); });
}

void MeshBuilder::Box(const Frame& frame, const V3d& low, const V3d& high) {
  vertex_count_ += 8;
  triangle_count_ += 12;
  if (!mesh_) return;
  const uint32_t first = uint32_t(mesh_->VertexCount());
  for (int corner = 0; corner < 8; ++corner) {
    AddVertex(frame(
        {corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z}));
  }
  constexpr uint32_t kFaces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& face : kFaces) {
    AddTriangle(first + face[0], first + face[1], first + face[2]);
    AddTriangle(first + face[0], first + face[2], first + face[3]);
  }
}

void MeshBuilder::Revolve(const Frame& frame, Profile profile, double around, double smoothness) {
  const int spans = int(profile.size()) - 1;
  Patch(frame,
        {.across = Cells(around, 6),
         .along = spans * Cells(smoothness, 1),
         .closed = true,
         .start_pole = profile.begin()->radius == 0,
         .end_pole = (profile.end() - 1)->radius == 0},
        [&](double u, double v) {
          const ProfilePoint point = ProfileAt(profile, v);
          const auto [cosine, sine] = AtTurn(u);
          return V3d(point.radius * cosine, point.height, point.radius * sine);
        });
}

void MeshBuilder::Extrude(const Frame& frame, Profile profile, double length, double smoothness) {
  const int spans = int(profile.size()) - 1;
  Patch(frame, {.across = 1, .along = spans * Cells(smoothness, 1)}, [&](double u, double v) {
    const ProfilePoint point = ProfileAt(profile, v);
    return V3d(length * u, point.height, point.radius);
  });
}

void MeshBuilder::Rod(const Frame& frame, const V3d& from, const V3d& to, double radius,
                      double around) {
  const V3d axis = to - from;
  const V3d normal = std::abs(axis.y) < 0.9 * axis.length() ? V3d(0, 1, 0) : V3d(1, 0, 0);
  Tube(
      frame, [&](double t) { return from + axis * t; }, [&](double) { return radius; }, normal, 1,
      Cells(around, 3));
}

void MeshBuilder::Ellipsoid(const Frame& frame, const V3d& radii, double around) {
  const int half = Cells(around / 2, 3);
  Patch(frame,
        {.across = 2 * half, .along = half, .closed = true, .start_pole = true, .end_pole = true},
        [&](double u, double v) {
          const Direction longitude = AtTurn(u);
          const Direction latitude = AtTurn(v / 2);
          return V3d(radii.x * latitude.sine * longitude.cosine, -radii.y * latitude.cosine,
                     radii.z * latitude.sine * longitude.sine);
        });
}

void MeshBuilder::Cushion(const Frame& frame, const V3d& radii, double around) {
  const auto soften = [](double s) { return std::copysign(std::sqrt(std::abs(s)), s); };
  const int half = Cells(around / 2, 4);
  Patch(frame,
        {.across = 2 * half, .along = half, .closed = true, .start_pole = true, .end_pole = true},
        [&](double u, double v) {
          const Direction longitude = AtTurn(u);
          const Direction latitude = AtTurn(v / 2);
          const double girth = soften(latitude.sine);
          return V3d(radii.x * girth * soften(longitude.cosine), -radii.y * latitude.cosine,
                     radii.z * girth * soften(longitude.sine));
        });
}

void MeshBuilder::Ring(const Frame& frame, double ring_radius, double tube_radius, double along,
                       double around) {
  Tube(
      frame,
      [&](double t) {
        const auto [cosine, sine] = AtTurn(t);
        return V3d(ring_radius * cosine, 0, ring_radius * sine);
      },
      [&](double) { return tube_radius; }, V3d(0, 1, 0), Cells(along, 8), Cells(around, 4),
      /*closed=*/true);
}

}  // namespace scenes

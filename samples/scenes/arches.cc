#include "scenes/arches.h"

namespace scenes {
namespace {

int ArchCells(const MeshBuilder& builder, double radius) {
  return 2 * builder.Cells(8 + 4 * radius, 4);
}

}  // namespace

void ArchedWall(MeshBuilder& builder, const Frame& frame, const ArchedPanel& wall) {
  const double opening = wall.opening;
  const double near = -wall.thickness / 2;
  const double far = wall.thickness / 2;
  const int cells = ArchCells(builder, opening);
  const auto arch = [&](double u, double z) {
    const auto [cosine, sine] = AtTurn((1 - u) / 2);
    return V3d(opening * cosine, wall.spring + opening * sine, z);
  };

  for (double z : {near, far}) {
    for (double side : {-1.0, 1.0}) {
      builder.Quad(frame, {side * opening, wall.low, z}, {side * wall.half_width, wall.low, z},
                   {side * wall.half_width, wall.high, z}, {side * opening, wall.high, z});
    }
    if (wall.sill > wall.low) {
      builder.Quad(frame, {-opening, wall.low, z}, {opening, wall.low, z}, {opening, wall.sill, z},
                   {-opening, wall.sill, z});
    }
    builder.Patch(frame, {.across = cells, .along = 1}, [&](double u, double v) {
      const V3d edge = arch(u, z);
      return V3d(edge.x, Mix(edge.y, wall.high, v), z);
    });
  }

  builder.Patch(frame, {.across = cells, .along = 1},
                [&](double u, double v) { return arch(u, Mix(near, far, v)); });
  if (wall.spring > wall.sill) {
    for (double x : {-opening, opening}) {
      builder.Quad(frame, {x, wall.sill, near}, {x, wall.sill, far}, {x, wall.spring, far},
                   {x, wall.spring, near});
    }
  }
  if (wall.sill > wall.low) {
    builder.Quad(frame, {-opening, wall.sill, near}, {opening, wall.sill, near},
                 {opening, wall.sill, far}, {-opening, wall.sill, far});
  }
}

void Archivolt(MeshBuilder& builder, const Frame& frame, double arch, double margin,
               double thickness) {
  const double radius = arch + margin;
  builder.Tube(
      frame,
      [&](double t) {
        const auto [cosine, sine] = AtTurn(t / 2);
        return V3d(radius * cosine, radius * sine, 0);
      },
      [&](double) { return thickness; }, V3d(0, 0, 1), ArchCells(builder, arch),
      builder.Cells(10, 4));
}

void Grille(MeshBuilder& builder, const Frame& frame, double opening, double sill, double spring) {
  constexpr double kSpacing = 0.3;
  constexpr double kBar = 0.014;
  const int half = int(opening / kSpacing);
  for (int bar = -half; bar <= half; ++bar) {
    const double x = bar * kSpacing;
    const double top = spring + std::sqrt(opening * opening - x * x);
    builder.Rod(frame, {x, sill, 0}, {x, top, 0}, kBar, 6);
  }
  for (double y = sill + kSpacing; y < spring + opening; y += kSpacing) {
    const double rise = std::max(0.0, y - spring);
    const double x = std::sqrt(opening * opening - rise * rise);
    builder.Rod(frame, {-x, y, 0}, {x, y, 0}, kBar * 0.8, 6);
  }
}

void Tracery(MeshBuilder& builder, const Frame& frame, double opening, double sill, double spring) {
  const double light = opening / 2;  // half of the width of either light
  constexpr double kStone = 0.06;
  builder.Rod(frame, {0, sill, 0}, {0, spring, 0}, kStone, 10);
  for (double side : {-1.0, 1.0}) {
    Archivolt(builder, frame.At(side * light, spring, 0), light, 0, kStone);
  }
  const double rose = opening * 0.36;
  const Frame centre = frame.At(0, spring + opening * 0.62, 0).TurnedAboutX(0.25);
  builder.Ring(centre, rose, kStone, 32, 8);
  for (int petal = 0; petal < 6; ++petal) {
    builder.Ring(centre.TurnedAboutY(petal / 6.0).At(rose * 0.58, 0, 0), rose * 0.34, kStone * 0.6,
                 20, 6);
  }
  builder.Ring(centre, rose * 0.24, kStone * 0.6, 20, 6);
}

}  // namespace scenes

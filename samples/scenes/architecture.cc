#include "scenes/architecture.h"

#include "scenes/arches.h"

namespace scenes {
namespace {

constexpr double kCapitalTop = 4.0;  // where arcade and aisle vaults spring
constexpr double kAisleVaultRise = 2.7;
constexpr double kCorniceHeight = 7.0;
constexpr double kRoof = 12;

// Bevelled stone slabs, laid with open joints.
void Floor(MeshBuilder& builder) {
  constexpr double kSlabLength = 1.5;
  constexpr double kSlabWidth = 1;
  constexpr double kJoint = 0.006;
  constexpr double kBevel = 0.014;
  constexpr double kBed = -0.02;
  const Frame frame;
  builder.Quad(frame, {-kHallHalfLength, kBed, -kAisleWall}, {kHallHalfLength, kBed, -kAisleWall},
               {kHallHalfLength, kBed, kAisleWall}, {-kHallHalfLength, kBed, kAisleWall});
  Random random(1);
  for (double x = -kHallHalfLength; x < kHallHalfLength; x += kSlabLength) {
    for (double z = -kAisleWall; z < kAisleWall; z += kSlabWidth) {
      const double top = random.Between(-0.002, 0.002);
      const auto corner = [&](int index, double inset, double y) {
        return V3d((index == 1 || index == 2) ? x + kSlabLength - inset : x + inset, y,
                   index >= 2 ? z + kSlabWidth - inset : z + inset);
      };
      const auto bed = [&](int index) { return corner(index % 4, kJoint, kBed); };
      const auto face = [&](int index) { return corner(index % 4, kJoint + kBevel, top); };
      builder.Quad(frame, face(0), face(1), face(2), face(3));
      for (int edge = 0; edge < 4; ++edge) {
        builder.Quad(frame, bed(edge), bed(edge + 1), face(edge + 1), face(edge));
      }
    }
  }
}

// A leaf of stone that climbs along y and curls over towards z.
void Acanthus(MeshBuilder& builder, const Frame& frame, double height, double width) {
  builder.Patch(frame,
                {.across = builder.Cells(8, 2), .along = builder.Cells(16, 4), .end_pole = true},
                [&](double u, double v) {
                  const double s = 2 * u - 1;
                  const double lobes = 0.85 + 0.15 * Cos(3.5 * v);
                  const double breadth = (1 - v * v) * (0.55 + 0.9 * v) * lobes;
                  const double curl = v * v * v;
                  return V3d(width * s * breadth, height * (Sin(0.3 * v) - 0.16 * curl * v),
                             height * (0.05 + 0.5 * curl) + width * (0.18 * (1 - s * s) * (1 - v)));
                });
}

void Column(MeshBuilder& builder, const Frame& frame) {
  constexpr double kShaftFoot = 0.5;
  constexpr double kShaftTop = 3.2;
  constexpr double kRadius = 0.36;
  builder.Box(frame, {-0.55, 0, -0.55}, {0.55, 0.2, 0.55});
  builder.Revolve(frame,
                  {{0.52, 0.2, kCorner},
                   {0.54, 0.26},
                   {0.5, 0.32},
                   {0.43, 0.345, kCorner},
                   {0.41, 0.38},
                   {0.43, 0.415, kCorner},
                   {0.455, 0.45},
                   {0.42, kShaftFoot, kCorner},
                   {kRadius - 0.06, kShaftFoot}},
                  40, 2);

  // Twenty flutes, tapering upwards.
  constexpr int kFlutes = 20;
  builder.Patch(
      frame,
      {.across = kFlutes * builder.Cells(4, 2), .along = builder.Cells(10, 2), .closed = true},
      [&](double u, double v) {
        const double radius = kRadius * (1 - 0.14 * v * v);
        const double depth = 0.035 * std::abs(Sin(u * kFlutes / 2));
        const auto [cosine, sine] = AtTurn(u);
        return V3d((radius - depth) * cosine, Mix(kShaftFoot, kShaftTop, v),
                   (radius - depth) * sine);
      });

  builder.Revolve(frame,
                  {{0.25, 3.19, kCorner},
                   {0.36, 3.22},
                   {0.31, 3.26, kCorner},
                   {0.31, 3.4},
                   {0.36, 3.6},
                   {0.5, 3.78, kCorner},
                   {0.52, 3.82}},
                  40, 2);
  const int leaves = builder.Pieces(12);
  for (int leaf = 0; leaf < leaves; ++leaf) {
    const Frame turned = frame.TurnedAboutY(double(leaf) / leaves);
    Acanthus(builder, turned.At(0, 3.26, 0.3), 0.3, 0.09);
    Acanthus(builder, turned.TurnedAboutY(0.5 / leaves).At(0, 3.34, 0.32), 0.42, 0.1);
  }
  builder.Box(frame, {-0.5, 3.8, -0.5}, {0.5, 3.88, 0.5});
  builder.Box(frame, {-0.56, 3.88, -0.56}, {0.56, kCapitalTop, 0.56});
}

// The slender shaft on the nave wall that carries the vault.
void Respond(MeshBuilder& builder, const Frame& frame) {
  constexpr double kTop = kNaveVaultSpring;
  builder.Revolve(frame,
                  {{0.17, kCapitalTop, kCorner},
                   {0.18, kCapitalTop + 0.06},
                   {0.13, kCapitalTop + 0.14, kCorner},
                   {0.13, kTop - 0.46, kCorner},
                   {0.16, kTop - 0.43},
                   {0.13, kTop - 0.4, kCorner},
                   {0.15, kTop - 0.24},
                   {0.24, kTop - 0.1, kCorner},
                   {0.26, kTop - 0.1, kCorner},
                   {0.26, kTop}},
                  20, 1);
  const int leaves = builder.Pieces(8);
  for (int leaf = 0; leaf < leaves; ++leaf) {
    Acanthus(builder, frame.TurnedAboutY(double(leaf) / leaves).At(0, kTop - 0.4, 0.12), 0.28,
             0.055);
  }
}

// The flat counterpart on the aisle wall.
void Pilaster(MeshBuilder& builder, const Frame& frame) {
  builder.Box(frame, {-0.42, 0, -0.34}, {0.42, 0.3, 0});
  builder.Box(frame, {-0.34, 0.3, -0.26}, {0.34, 3.5, 0});
  builder.Box(frame, {-0.38, 3.5, -0.3}, {0.38, 3.58, 0});
  builder.Box(frame, {-0.34, 3.58, -0.26}, {0.34, 3.8, 0});
  builder.Box(frame, {-0.44, 3.8, -0.36}, {0.44, kCapitalTop, 0});
}

// Two barrels of the same height that cross: four webs with a groin between any two, ribs below
// the groins and a boss in the middle. The frame stands in the middle, at the springing.
void GroinVault(MeshBuilder& builder, const Frame& frame, double half_x, double half_z,
                double rise) {
  const Frame unit = frame.Scaled(half_x, rise, half_z);
  for (bool across : {false, true}) {
    for (double side : {-1.0, 1.0}) {
      // Straight courses of stone, from the groin to the wall.
      builder.Patch(
          unit,
          {.across = 1, .along = 2 * builder.Cells(20, 4), .start_pole = true, .end_pole = true},
          [&](double u, double v) {
            const auto [height, run] = AtTurn((2 * v - 1) / 4);
            const double out = side * Mix(std::abs(run), 1, u);
            return across ? V3d(out, height, run) : V3d(run, height, out);
          });
    }
  }
  constexpr double kRib = 0.09;
  for (double diagonal : {-1.0, 1.0}) {
    builder.Tube(
        frame,
        [&](double t) {
          const auto [cosine, sine] = AtTurn((2 * t - 1) / 4);
          return V3d(half_x * sine, rise * cosine - kRib / 2, diagonal * half_z * sine);
        },
        [&](double) { return kRib; }, V3d(half_z, 0, -diagonal * half_x), builder.Cells(40, 8),
        builder.Cells(12, 5));
  }
  builder.Revolve(frame.At(0, rise - kRib, 0),
                  {{0.34, 0.1, kCorner},
                   {0.32, -0.02},
                   {0.26, -0.08, kCorner},
                   {0.2, -0.07},
                   {0.16, -0.13},
                   {0.08, -0.18},
                   {0, -0.19}},
                  24, 1);
  const int leaves = builder.Pieces(8);
  for (int leaf = 0; leaf < leaves; ++leaf) {
    Acanthus(builder,
             frame.At(0, rise - 0.14, 0)
                 .TurnedAboutY(double(leaf) / leaves)
                 .At(0, 0, 0.16)
                 .TurnedAboutX(0.2),
             0.2, 0.06);
  }
}

// The arch between two bays, across the nave or an aisle.
void TransverseRib(MeshBuilder& builder, const Frame& frame, double half_z, double rise) {
  builder.Tube(
      frame,
      [&](double t) {
        const auto [cosine, sine] = AtTurn((2 * t - 1) / 4);
        return V3d(0, rise * cosine - 0.04, half_z * sine);
      },
      [](double) { return 0.16; }, V3d(1, 0, 0), builder.Cells(40, 8), builder.Cells(12, 5));
}

// The nave wall's cornice, on a row of dentils.
void Cornice(MeshBuilder& builder, const Frame& side) {
  const Frame frame = side.At(-kHallHalfLength, kCorniceHeight, kNaveWall);
  builder.Extrude(frame,
                  {{0, -0.42, kCorner},
                   {-0.05, -0.4},
                   {-0.06, -0.34, kCorner},
                   {-0.06, -0.1, kCorner},
                   {-0.2, -0.1, kCorner},
                   {-0.22, -0.04},
                   {-0.3, 0.02},
                   {-0.32, 0.1, kCorner},
                   {0, 0.16}},
                  2 * kHallHalfLength, 2);
  const int dentils = builder.Pieces(144);
  const double spacing = 2 * kHallHalfLength / dentils;
  for (int dentil = 0; dentil < dentils; ++dentil) {
    const double x = dentil * spacing;
    builder.Box(frame, {x, -0.24, -0.16}, {x + 0.6 * spacing, -0.11, -0.05});
  }
}

// A row of turned balusters along x, between two rails.
void Balustrade(MeshBuilder& builder, const Frame& frame, double length) {
  constexpr double kSpacing = 0.26;
  constexpr double kTop = 0.95;
  builder.Box(frame, {0, 0, -0.1}, {length, 0.1, 0.1});
  builder.Extrude(frame,
                  {{-0.08, kTop - 0.1, kCorner},
                   {-0.12, kTop - 0.07},
                   {-0.09, kTop - 0.01},
                   {0, kTop},
                   {0.09, kTop - 0.01},
                   {0.12, kTop - 0.07},
                   {0.08, kTop - 0.1, kCorner},
                   {-0.08, kTop - 0.1}},
                  length, 1);
  const int balusters = builder.Pieces(int(length / kSpacing));
  for (int baluster = 0; baluster < balusters; ++baluster) {
    builder.Revolve(frame.At((baluster + 0.5) * length / balusters, 0, 0),
                    {{0.07, 0.1, kCorner},
                     {0.07, 0.16, kCorner},
                     {0.045, 0.18},
                     {0.085, 0.34},
                     {0.06, 0.48},
                     {0.034, 0.7},
                     {0.05, 0.75},
                     {0.034, 0.78, kCorner},
                     {0.065, 0.86}},
                    12, 1);
  }
}

void Newel(MeshBuilder& builder, const Frame& frame) {
  builder.Box(frame, {-0.17, 0, -0.17}, {0.17, 1.05, 0.17});
  builder.Box(frame, {-0.21, 1.05, -0.21}, {0.21, 1.12, 0.21});
  builder.Revolve(frame, {{0.12, 1.12, kCorner}, {0.06, 1.17}, {0.07, 1.2}}, 16, 2);
  builder.Ellipsoid(frame.At(0, 1.36, 0), {0.18, 0.18, 0.18}, 28);
}

// Fourteen steps up to a platform as wide as the nave.
void Staircase(MeshBuilder& builder) {
  constexpr int kSteps = 14;
  constexpr double kRise = kPlatform / kSteps;
  constexpr double kRun = (kPlatformFront - kStairFoot) / kSteps;
  constexpr double kHalfWidth = 2.6;
  constexpr double kRail = kHalfWidth + 0.2;  // z of the balustrade
  const Frame foot = Frame().At(kStairFoot, 0, 0);
  for (int step = 0; step < kSteps; ++step) {
    const double x = step * kRun;
    const double top = (step + 1) * kRise;
    builder.Box(foot, {x, 0, -kHalfWidth}, {x + kRun, top - 0.04, kHalfWidth});
    builder.Box(foot, {x - 0.03, top - 0.04, -kHalfWidth}, {x + kRun, top, kHalfWidth});
  }
  const Frame platform = Frame().At(kPlatformFront, kPlatform, 0);
  const double depth = kHallHalfLength - kPlatformFront;
  builder.Box(platform, {0, -kPlatform, -kNaveWall}, {depth, -0.16, kNaveWall});
  builder.Box(platform, {-0.05, -0.16, -kNaveWall - 0.05}, {depth, 0, kNaveWall + 0.05});

  for (int sign : {-1, 1}) {
    const Frame side = Side(sign);
    // Everything on the ramp rises with x and stays upright.
    Frame ramp = side.At(kStairFoot, kRise, kRail);
    ramp.x.y = kRise / kRun;
    const double run = kPlatformFront - kStairFoot;
    builder.Box(ramp, {0, -0.5, -0.2}, {run, 0, 0.2});
    Balustrade(builder, ramp, run);
    Newel(builder, side.At(kStairFoot - 0.17, 0, kRail));

    const Frame landing = side.At(kPlatformFront + 0.17, kPlatform, kRail);
    Newel(builder, landing);
    Balustrade(builder, landing.At(0, 0, 0.17).TurnedAboutY(-0.25), kNaveWall - kRail - 0.51);
    const Frame corner = landing.At(0, 0, kNaveWall - kRail - 0.17);
    Newel(builder, corner);
    Balustrade(builder, corner.At(0.17, 0, 0), depth - 0.8);
  }
}

// Planks, iron bands, nails and two rings, behind the opening.
void Door(MeshBuilder& builder, const Frame& frame, double half_width, double height) {
  constexpr double kPlank = 0.22;
  const int planks = int(2 * half_width / kPlank);
  for (int plank = 0; plank < planks; ++plank) {
    const double x = plank * kPlank - half_width;
    builder.Box(frame, {x + 0.004, 0, -0.1}, {x + kPlank - 0.004, height, 0});
  }
  for (double y : {0.5, 1.5, 2.5}) {
    builder.Box(frame, {-half_width, y, 0}, {half_width, y + 0.11, 0.02});
    for (int plank = 0; plank < planks; ++plank) {
      builder.Ellipsoid(frame.At((plank + 0.5) * kPlank - half_width, y + 0.055, 0.02),
                        {0.03, 0.03, 0.03}, 8);
    }
  }
  for (double side : {-1.0, 1.0}) {
    builder.Ring(frame.At(side * 0.25, 1.2, 0.04).TurnedAboutX(0.22), 0.12, 0.014, 20, 6);
  }
}

void NaveAndAisles(MeshBuilder& builder) {
  constexpr double kAisleCentre = (kColumnLine + kArcadeThickness / 2 + kAisleWall) / 2;
  constexpr double kAisleHalfWidth = kAisleWall - kAisleCentre;
  constexpr ArchedPanel kArcade{.half_width = kBay / 2,
                                .low = kCapitalTop,
                                .high = kCorniceHeight,
                                .thickness = kArcadeThickness,
                                .opening = 2.5,
                                .sill = kCapitalTop,
                                .spring = kCapitalTop};
  constexpr ArchedPanel kClerestory{.half_width = kBay / 2,
                                    .low = kCorniceHeight,
                                    .high = kRoof,
                                    .thickness = kArcadeThickness,
                                    .opening = 0.8,
                                    .sill = 7.7,
                                    .spring = 9.4};
  constexpr ArchedPanel kOuter{.half_width = kBay / 2,
                               .low = -0.1,
                               .high = kCorniceHeight,
                               .thickness = 0.6,
                               .opening = 0.9,
                               .sill = 1.7,
                               .spring = 3.7};
  for (int sign : {-1, 1}) {
    const Frame side = Side(sign);
    for (int bay = 0; bay < kBays; ++bay) {
      const Frame middle = side.At(BayCentre(bay), 0, 0);
      const Frame arcade = middle.At(0, 0, kColumnLine);
      ArchedWall(builder, arcade, kArcade);
      for (double face : {-0.5, 0.5}) {
        const Frame plane = arcade.At(0, kCapitalTop, face * kArcadeThickness);
        Archivolt(builder, plane, kArcade.opening, 0.06, 0.06);
        Archivolt(builder, plane, kArcade.opening, 0.24, 0.035);
      }
      ArchedWall(builder, arcade, kClerestory);
      Grille(builder, arcade, kClerestory.opening, kClerestory.sill, kClerestory.spring);
      Archivolt(builder, middle.At(0, kClerestory.spring, kNaveWall), kClerestory.opening, 0.08,
                0.05);

      const Frame outer = middle.At(0, 0, kAisleWall + kOuter.thickness / 2);
      ArchedWall(builder, outer, kOuter);
      Grille(builder, outer, kOuter.opening, kOuter.sill, kOuter.spring);
      builder.Box(middle, {-1.1, kOuter.sill - 0.08, kAisleWall - 0.12},
                  {1.1, kOuter.sill, kAisleWall + 0.05});
      GroinVault(builder, middle.At(0, kCapitalTop, kAisleCentre), kBay / 2, kAisleHalfWidth,
                 kAisleVaultRise);
    }
    for (int bay = 0; bay <= kBays; ++bay) {
      const Frame start = side.At(BayStart(bay), 0, 0);
      Column(builder, start.At(0, 0, kColumnLine));
      Respond(builder, start.At(0, 0, kNaveWall - 0.02));
      Pilaster(builder, start.At(0, 0, kAisleWall));
      TransverseRib(builder, start.At(0, kCapitalTop, kAisleCentre), kAisleHalfWidth,
                    kAisleVaultRise);
    }
    Cornice(builder, side);
  }
  for (int bay = 0; bay < kBays; ++bay) {
    GroinVault(builder, Frame().At(BayCentre(bay), kNaveVaultSpring, 0), kBay / 2, kNaveWall,
               kNaveVaultRise);
  }
  for (int bay = 0; bay <= kBays; ++bay) {
    TransverseRib(builder, Frame().At(BayStart(bay), kNaveVaultSpring, 0), kNaveWall,
                  kNaveVaultRise);
  }
}

void EndWalls(MeshBuilder& builder) {
  constexpr double kThickness = 0.6;
  constexpr double kOutside = kAisleWall + kThickness;  // half of the width over all
  // Local x runs across the hall, local z out of it.
  const Frame entrance = Frame().At(-kHallHalfLength - kThickness / 2, 0, 0).TurnedAboutY(-0.25);
  constexpr ArchedPanel kPortal{.half_width = kOutside,
                                .low = -0.1,
                                .high = kRoof,
                                .thickness = kThickness,
                                .opening = 1.5,
                                .sill = -0.1,
                                .spring = 2.6};
  ArchedWall(builder, entrance, kPortal);
  Door(builder, entrance.At(0, 0, kThickness / 2 + 0.02).TurnedAboutY(0.5), 1.76, 4.3);
  for (int order = 0; order < 3; ++order) {
    Archivolt(builder, entrance.At(0, kPortal.spring, -kThickness / 2), kPortal.opening,
              0.08 + 0.17 * order, 0.07);
  }

  const Frame choir = Frame().At(kHallHalfLength + kThickness / 2, 0, 0).TurnedAboutY(0.25);
  constexpr double kLancet = 1.5;  // half of the width of the wall round one window
  for (int window : {-1, 0, 1}) {
    const ArchedPanel panel{.half_width = kLancet,
                            .low = -0.1,
                            .high = kRoof,
                            .thickness = kThickness,
                            .opening = window == 0 ? 1.1 : 0.9,
                            .sill = 4.2,
                            .spring = window == 0 ? 9.2 : 8.0};
    const Frame frame = choir.At(2 * kLancet * window, 0, 0);
    ArchedWall(builder, frame, panel);
    Tracery(builder, frame, panel.opening, panel.sill, panel.spring);
    Grille(builder, frame, panel.opening, panel.sill, panel.spring);
    Archivolt(builder, frame.At(0, panel.spring, -kThickness / 2), panel.opening, 0.1, 0.07);
  }
  for (double side : {-1.0, 1.0}) {
    const double inner = side * 3 * kLancet;
    const double outer = side * kOutside;
    for (double z : {-kThickness / 2, kThickness / 2}) {
      builder.Quad(choir, {inner, -0.1, z}, {outer, -0.1, z}, {outer, kRoof, z}, {inner, kRoof, z});
    }
  }
}

}  // namespace

void BuildArchitecture(MeshBuilder& builder) {
  Floor(builder);
  NaveAndAisles(builder);
  EndWalls(builder);
  Staircase(builder);
}

}  // namespace scenes

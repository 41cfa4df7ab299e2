#include "scenes/furniture.h"

#include <utility>

namespace scenes {
namespace {

// A leaf that grows out along z from its stalk at the origin, and droops.
void Leaf(MeshBuilder& builder, const Frame& frame, double length, double width, double droop) {
  builder.Patch(frame,
                {.across = builder.Cells(4, 2),
                 .along = builder.Cells(8, 4),
                 .start_pole = true,
                 .end_pole = true},
                [&](double u, double v) {
                  const double s = 2 * u - 1;
                  const double breadth = 4 * v * (1 - v) * (1.3 - 0.6 * v);
                  return V3d(width * s * breadth,
                             length * (0.6 * v - droop * v * v) + 0.3 * width * breadth * s * s,
                             length * v);
                });
}

}  // namespace

void Banner(MeshBuilder& builder, const Frame& frame, uint32_t seed) {
  constexpr double kPole = 1.15;
  constexpr double kCloth = 0.8;
  constexpr double kLength = 2.1;
  const Frame pole = frame.TurnedAboutX(-0.06);
  builder.Rod(pole, {0, 0, 0}, {0, 0, kPole}, 0.018, 8);
  builder.Ellipsoid(pole.At(0, 0, kPole + 0.03), {0.04, 0.04, 0.055}, 14);
  Random random(seed);
  const double phase = random.Between(0, 1);
  const double folds = random.Between(1.6, 2.2);
  // The cloth hangs plumb from the pole and ends in two points.
  builder.Patch(frame, {.across = builder.Cells(24, 8), .along = builder.Cells(36, 8)},
                [&](double u, double v) {
                  const double z = Mix(0.28, 0.28 + kCloth, u);
                  const V3d top = V3d(0, -Sin(-0.06) * z, z);
                  const double notch = 0.25 * std::abs(2 * u - 1);
                  const double fall = (kLength + notch) * v;
                  const double wave = Sin(folds * u + phase + 0.15 * v);
                  return top + V3d(0.075 * v * wave, -fall, -0.03 * v * Sin(2 * folds * u + phase));
                });
}

void PottedPlant(MeshBuilder& builder, const Frame& frame, uint32_t seed) {
  builder.Revolve(frame,
                  {{0, 0},
                   {0.2, 0, kCorner},
                   {0.2, 0.05, kCorner},
                   {0.12, 0.09},
                   {0.1, 0.14},
                   {0.24, 0.3},
                   {0.31, 0.48},
                   {0.3, 0.58},
                   {0.35, 0.66, kCorner},
                   {0.33, 0.67, kCorner},
                   {0.27, 0.58},
                   {0, 0.6}},
                  32, 2);
  Random random(seed);
  const int stems = builder.Pieces(34);
  for (int stem = 0; stem < stems; ++stem) {
    const double lean = random.Between(0.02, 1);
    const double height = Mix(1.0, 0.25, lean * lean) * random.Between(0.8, 1.1);
    const double reach = 0.5 * lean;
    const Frame turned =
        frame.At(0, 0.58, 0).TurnedAboutY((stem + random.Between(0, 0.8)) * 0.618034);
    const auto curve = [&](double t) {
      return V3d(0, height * t * (1.5 - 0.5 * t), 0.1 * lean + reach * t * t);
    };
    builder.Tube(
        turned, curve, [](double t) { return 0.008 - 0.005 * t; }, V3d(1, 0, 0),
        builder.Cells(6, 3), builder.Cells(5, 3));
    for (double t : {0.55, 0.78, 1.0}) {
      const V3d joint = curve(t);
      const Frame node = turned.At(joint.x, joint.y, joint.z);
      if (t < 1) {
        for (double side : {-0.2, 0.2}) {
          Leaf(builder, node.TurnedAboutY(side + random.Between(-0.06, 0.06)), 0.2, 0.05, 0.7);
        }
      } else {
        Leaf(builder, node, 0.26, 0.06, 0.8);
      }
    }
  }
}

void ArmillarySphere(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0.3, 0, kCorner},
                   {0.29, 0.04},
                   {0.2, 0.07, kCorner},
                   {0.06, 0.12},
                   {0.045, 0.3},
                   {0.09, 0.42},
                   {0.04, 0.55},
                   {0.03, 0.68},
                   {0.05, 0.72},
                   {0.03, 0.76}},
                  24, 2);
  constexpr double kRadius = 0.42;
  const Frame centre = frame.At(0, 0.76 + kRadius, 0);
  const Frame axis = centre.TurnedAboutZ(0.065);
  builder.Ring(centre, kRadius + 0.03, 0.016, 64, 8);
  builder.Ring(centre.TurnedAboutX(0.25), kRadius + 0.01, 0.014, 64, 8);
  for (int meridian = 0; meridian < 6; ++meridian) {
    builder.Ring(axis.TurnedAboutY(meridian / 12.0).TurnedAboutX(0.25), kRadius - 0.03, 0.009, 64,
                 6);
  }
  for (double height : {-0.2, 0.0, 0.2}) {
    const double radius = kRadius - 0.03;
    builder.Ring(axis.At(0, height, 0), std::sqrt(radius * radius - height * height), 0.011, 64, 6);
  }
  builder.Rod(axis, {0, -kRadius, 0}, {0, kRadius, 0}, 0.008, 8);
  builder.Ellipsoid(axis, {0.11, 0.11, 0.11}, 28);
}

void KnotSculpture(MeshBuilder& builder, const Frame& frame) {
  builder.Box(frame, {-0.55, 0, -0.55}, {0.55, 0.16, 0.55});
  builder.Revolve(frame,
                  {{0.5, 0.16, kCorner},
                   {0.48, 0.24},
                   {0.4, 0.3, kCorner},
                   {0.38, 0.95, kCorner},
                   {0.44, 1.0},
                   {0.48, 1.06, kCorner},
                   {0.48, 1.12, kCorner},
                   {0, 1.12}},
                  40, 2);
  // A trefoil, upright.
  builder.Tube(
      frame.At(0, 2.02, 0).TurnedAboutX(0.25).TurnedAboutY(0.083),
      [](double t) {
        const Direction twice = AtTurn(2 * t);
        const Direction thrice = AtTurn(3 * t);
        const double radius = 0.52 + 0.25 * thrice.cosine;
        return V3d(radius * twice.cosine, 0.25 * thrice.sine, radius * twice.sine);
      },
      [](double) { return 0.13; }, V3d(0, 1, 0), builder.Cells(180, 48), builder.Cells(24, 8),
      /*closed=*/true);
}

void Vase(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0, 0},
                   {0.13, 0, kCorner},
                   {0.14, 0.03},
                   {0.24, 0.25},
                   {0.29, 0.45},
                   {0.24, 0.64},
                   {0.12, 0.78},
                   {0.11, 0.86},
                   {0.18, 0.95, kCorner},
                   {0.165, 0.95, kCorner},
                   {0.09, 0.85},
                   {0.1, 0.77},
                   {0, 0.7}},
                  28, 1);
}

void Carpet(MeshBuilder& builder, const Frame& frame, double length, double width) {
  constexpr double kPile = 0.016;
  const double half = width / 2;
  // The top is not quite flat, least of all near the edges.
  const auto height = [&](double x, double z) {
    const double edge = std::abs(z) / half;
    return kPile + 0.006 * edge * edge * (1 + Sin(0.31 * x + 0.7 * z)) +
           0.002 * Sin(0.83 * x - 0.4 * z);
  };
  builder.Patch(frame, {.across = builder.Cells(10, 4), .along = builder.Cells(120, 30)},
                [&](double u, double v) {
                  const double x = length * v;
                  const double z = Mix(-half, half, u);
                  return V3d(x, height(x, z), z);
                });
  for (double z : {-half, half}) {
    builder.Patch(frame, {.across = 1, .along = builder.Cells(120, 30)}, [&](double u, double v) {
      return V3d(length * v, u * height(length * v, z), z);
    });
  }
  // Cords, sewn on: a border, and lozenges between.
  constexpr double kCord = 0.013;
  constexpr double kY = kPile + 0.006;
  const double border = 0.8 * half;
  for (double z : {-border, border}) {
    builder.Rod(frame, {0.1, kY, z}, {length - 0.1, kY, z}, kCord, 8);
  }
  const int lozenges = builder.Pieces(int(length / 1.2));
  const double step = (length - 0.2) / lozenges;
  for (int lozenge = 0; lozenge < lozenges; ++lozenge) {
    const Frame middle = frame.At(0.1 + (lozenge + 0.5) * step, kY, 0);
    for (double scale : {1.0, 0.45}) {
      const double x = 0.5 * step * scale;
      const double z = 0.9 * border * scale;
      for (const auto& [from, to] : {std::pair{V3d(-x, 0, 0), V3d(0, 0, z)},
                                     {V3d(0, 0, z), V3d(x, 0, 0)},
                                     {V3d(x, 0, 0), V3d(0, 0, -z)},
                                     {V3d(0, 0, -z), V3d(-x, 0, 0)}}) {
        builder.Rod(middle, from, to, kCord, 8);
      }
    }
  }
  const int tassels = builder.Pieces(60);
  for (int tassel = 0; tassel < tassels; ++tassel) {
    const double z = Mix(-half, half, (tassel + 0.5) / tassels);
    for (double x : {0.0, length}) {
      const double out = x == 0 ? -0.09 : 0.09;
      builder.Rod(frame, {x, 0.012, z}, {x + out, 0.006, z + 0.004 * (tassel % 3 - 1)}, 0.006, 5);
    }
  }
}

}  // namespace scenes

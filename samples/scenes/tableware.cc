#include "scenes/tableware.h"

namespace scenes {
namespace {

void Candle(MeshBuilder& builder, const Frame& frame, double height) {
  builder.Revolve(
      frame,
      {{0.012, 0, kCorner}, {0.011, height, kCorner}, {0.009, height + 0.002}, {0, height - 0.003}},
      10, 1);
  // The flame.
  builder.Revolve(frame.At(0, height + 0.006, 0),
                  {{0, 0}, {0.007, 0.012}, {0.004, 0.03}, {0, 0.045}}, 8, 1);
}

void Saucer(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0, 0},
                   {0.014, 0, kCorner},
                   {0.02, 0.016},
                   {0.042, 0.024, kCorner},
                   {0.04, 0.028, kCorner},
                   {0.018, 0.022},
                   {0, 0.02}},
                  14, 1);
}

}  // namespace

void Plate(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(
      frame,
      {{0, 0.008}, {0.075, 0.008, kCorner}, {0.1, 0.018}, {0.135, 0.024, kCorner}, {0.08, 0.002}},
      28, 1);
}

void Goblet(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0.034, 0, kCorner},
                   {0.03, 0.006},
                   {0.007, 0.02},
                   {0.011, 0.06},
                   {0.008, 0.08},
                   {0.036, 0.12},
                   {0.032, 0.165, kCorner},
                   {0.03, 0.165, kCorner},
                   {0.032, 0.12},
                   {0, 0.09}},
                  16, 1);
}

void Cutlery(MeshBuilder& builder, const Frame& frame) {
  builder.Box(frame, {-0.006, 0, -0.1}, {0.006, 0.004, 0.02});
  builder.Box(frame, {-0.009, 0, 0.02}, {0.007, 0.002, 0.12});
}

// An arm that swings out along z and down, then up to a saucer with its candle.
void CandleArm(MeshBuilder& builder, const Frame& frame, double reach, double rise) {
  builder.Tube(
      frame,
      [&](double t) { return V3d(0, Mix(0, rise, t * t) - 0.22 * reach * Sin(t / 2), reach * t); },
      [](double t) { return 0.016 - 0.006 * t; }, V3d(1, 0, 0), builder.Cells(14, 5),
      builder.Cells(7, 4));
  const Frame tip = frame.At(0, rise - 0.004, reach);
  Saucer(builder, tip);
  Candle(builder, tip.At(0, 0.02, 0), 0.12);
}

void Candelabrum(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0.085, 0, kCorner},
                   {0.08, 0.014},
                   {0.035, 0.03},
                   {0.014, 0.06},
                   {0.022, 0.085},
                   {0.012, 0.11},
                   {0.011, 0.24},
                   {0.024, 0.27},
                   {0.012, 0.3},
                   {0.011, 0.34}},
                  18, 1);
  Saucer(builder, frame.At(0, 0.34, 0));
  Candle(builder, frame.At(0, 0.36, 0), 0.14);
  for (int arm = 0; arm < 4; ++arm) {
    CandleArm(builder, frame.At(0, 0.27, 0).TurnedAboutY(arm / 4.0), 0.17, 0.06);
  }
}

void FruitBowl(MeshBuilder& builder, const Frame& frame, uint32_t seed) {
  builder.Revolve(frame,
                  {{0.09, 0, kCorner},
                   {0.085, 0.012},
                   {0.03, 0.03},
                   {0.035, 0.045},
                   {0.12, 0.065},
                   {0.19, 0.12, kCorner},
                   {0.184, 0.122, kCorner},
                   {0.11, 0.074},
                   {0, 0.06}},
                  32, 1);
  Random random(seed);
  // A layer of fruit round the rim, one on top of it, and the last one in the middle.
  constexpr struct {
    int count;
    double ring;
    double height;
  } kLayers[] = {{8, 0.118, 0.118}, {4, 0.06, 0.17}, {1, 0, 0.225}};
  for (const auto& layer : kLayers) {
    for (int fruit = 0; fruit < layer.count; ++fruit) {
      const double radius = random.Between(0.036, 0.043);
      const Frame place = frame.TurnedAboutY((fruit + random.Between(-0.12, 0.12)) / layer.count)
                              .At(0, layer.height, layer.ring)
                              .TurnedAboutX(random.Between(-0.1, 0.1));
      builder.Ellipsoid(place, {radius, radius * random.Between(0.85, 1.05), radius}, 18);
      builder.Rod(place, {0, 0.9 * radius, 0}, {0.006, 1.3 * radius, 0.004}, 0.0018, 4);
    }
  }
  // Grapes hang over the rim.
  const int grapes = builder.Pieces(40);
  for (int grape = 0; grape < grapes; ++grape) {
    const double along = random.Between(0, 1);
    const double spread = 0.035 * (1 - 0.6 * along);
    builder.Ellipsoid(frame.At(0.17 + 0.06 * along + random.Between(-spread, spread),
                               0.145 - 0.11 * along * along + random.Between(0, spread),
                               random.Between(-spread, spread)),
                      {0.0105, 0.012, 0.0105}, 8);
  }
}

void Jug(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0, 0},
                   {0.055, 0, kCorner},
                   {0.06, 0.012},
                   {0.085, 0.08},
                   {0.075, 0.14},
                   {0.04, 0.2},
                   {0.038, 0.24},
                   {0.052, 0.27, kCorner},
                   {0.048, 0.27, kCorner},
                   {0.034, 0.235},
                   {0.036, 0.2},
                   {0, 0.15}},
                  24, 1);
  builder.Tube(
      frame,
      [](double t) {
        const auto [cosine, sine] = AtTurn(0.3 - 0.6 * t);
        return V3d(0, 0.175 + 0.075 * sine, 0.052 + 0.06 * cosine);
      },
      [](double) { return 0.008; }, V3d(1, 0, 0), builder.Cells(16, 6), builder.Cells(8, 4));
}

void OpenBook(MeshBuilder& builder, const Frame& frame) {
  for (double side : {-1.0, 1.0}) {
    builder.Patch(frame, {.across = builder.Cells(8, 3), .along = 1}, [&](double u, double v) {
      return V3d(side * 0.16 * u, 0.008 + 0.03 * Sin(0.42 * std::sqrt(u)), Mix(-0.12, 0.12, v));
    });
    builder.Box(frame, {side * 0.165, 0, -0.125}, {0, 0.008, 0.125});
  }
}

}  // namespace scenes

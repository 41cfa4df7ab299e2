#include "scenes/furniture.h"

#include "scenes/tableware.h"

namespace scenes {
namespace {

constexpr double kTableHeight = 0.76;

// Closed, upright, its spine towards z.
void Book(MeshBuilder& builder, const Frame& frame, double thickness, double height, double depth) {
  const int spine = builder.Cells(4, 1);
  const double middle = thickness / 2;
  // Along the left cover, round the spine and back along the right cover.
  const auto outline = [&](int point) {
    if (point == 0) return V3d(0, 0, 0);
    if (point == spine + 2) return V3d(thickness, 0, 0);
    const auto [cosine, sine] = AtTurn((1 - (point - 1.0) / spine) / 2);
    return V3d(middle * (1 + cosine), 0, depth + 0.5 * middle * sine);
  };
  const int cells = spine + 2;
  builder.Patch(frame, {.across = cells, .along = 1}, [&](double u, double v) {
    return outline(int(u * cells + 0.5)) + V3d(0, height * v, 0);
  });
  builder.Patch(frame, {.across = cells, .along = 1, .end_pole = true}, [&](double u, double v) {
    return (outline(int(u * cells + 0.5)) - V3d(middle, 0, 0)) * (1 - v) + V3d(middle, height, 0);
  });
}

void TableLeg(MeshBuilder& builder, const Frame& frame) {
  builder.Revolve(frame,
                  {{0.05, 0, kCorner},
                   {0.065, 0.03},
                   {0.035, 0.1},
                   {0.08, 0.26},
                   {0.085, 0.36},
                   {0.04, 0.54},
                   {0.06, 0.57, kCorner},
                   {0.06, 0.71}},
                  18, 1);
}

// A strip of linen along the middle of the table that hangs over both ends.
void TableRunner(MeshBuilder& builder, const Frame& frame, double length) {
  constexpr double kHalfWidth = 0.17;
  constexpr double kHang = 0.3;
  const double run = length + 2 * kHang;
  builder.Patch(frame, {.across = builder.Cells(32, 6), .along = builder.Cells(60, 24)},
                [&](double u, double v) {
                  const double s = run * v - kHang;  // along the table top
                  const double over = std::max({0.0, -s, s - length});
                  const double x = Mix(0, length, std::clamp(s / length, 0.0, 1.0)) - length / 2;
                  const double fold = over * (0.1 + 0.3 * Sin(2.5 * u));
                  return V3d(x + std::copysign(over > 0 ? 0.006 + fold : 0, x),
                             kTableHeight + 0.003 - over, Mix(-kHalfWidth, kHalfWidth, u));
                });
}

}  // namespace

void Chair(MeshBuilder& builder, const Frame& frame) {
  constexpr double kSeat = 0.46;
  constexpr double kBack = 1.12;
  for (double side : {-1.0, 1.0}) {
    builder.Revolve(frame.At(0.2 * side, 0, 0.2),
                    {{0.017, 0, kCorner},
                     {0.024, 0.03},
                     {0.014, 0.07},
                     {0.03, 0.24},
                     {0.017, 0.36, kCorner},
                     {0.026, kSeat - 0.04}},
                    12, 1);
    builder.Tube(
        frame.At(0.19 * side, 0, -0.19),
        [](double t) { return V3d(0, kBack * t, -0.16 * t * t + 0.05 * Sin(t / 2)); },
        [](double t) { return 0.022 - 0.007 * t; }, V3d(1, 0, 0), builder.Cells(10, 4),
        builder.Cells(8, 4));
    builder.Ellipsoid(frame.At(0.19 * side, kBack + 0.015, -0.35), {0.024, 0.03, 0.024}, 10);
    builder.Rod(frame, {0.2 * side, 0.17, 0.2}, {0.19 * side, 0.17, -0.16}, 0.012, 6);
    builder.Box(frame, {0.2 * side - 0.012, kSeat - 0.08, -0.17},
                {0.2 * side + 0.012, kSeat - 0.02, 0.2});
  }
  builder.Rod(frame, {-0.2, 0.17, 0.03}, {0.2, 0.17, 0.03}, 0.012, 6);
  builder.Box(frame, {-0.2, kSeat - 0.08, 0.188}, {0.2, kSeat - 0.02, 0.212});
  builder.Box(frame, {-0.23, kSeat - 0.025, -0.2}, {0.23, kSeat, 0.235});
  builder.Cushion(frame.At(0, kSeat + 0.015, 0.02), {0.2, 0.03, 0.2}, 16);

  // Two rails, bowed backwards, and the spindles between them.
  constexpr struct {
    double y;
    double z;
    double height;
  } kRails[] = {{0.62, -0.195, 0.025}, {1.05, -0.31, 0.05}};
  for (const auto& rail : kRails) {
    builder.Patch(
        frame, {.across = builder.Cells(8, 4), .along = builder.Cells(8, 3), .closed = true},
        [&](double u, double v) {
          const auto [cosine, sine] = AtTurn(u);
          const double bow = Sin(v / 2);
          return V3d(Mix(-0.19, 0.19, v), rail.y + 0.3 * rail.height * bow + rail.height * sine,
                     rail.z - 0.03 * bow + 0.011 * cosine);
        });
  }
  for (int spindle = -2; spindle <= 2; ++spindle) {
    const double x = 0.066 * spindle;
    const double bow = 0.03 * Cos(spindle / 12.0);
    builder.Rod(frame, {x, kRails[0].y, kRails[0].z - bow}, {x, kRails[1].y, kRails[1].z - bow},
                0.009, 6);
  }
}

void BanquetTable(MeshBuilder& builder, const Frame& frame, double length, uint32_t seed) {
  constexpr double kHalfWidth = 0.55;
  const int seats = builder.Pieces(int(length / 0.8));
  const double spacing = (length - 0.3) / seats;
  Random random(seed);

  const Frame start = frame.At(-length / 2, 0, 0);
  builder.Extrude(start,
                  {{-kHalfWidth + 0.05, kTableHeight - 0.05, kCorner},
                   {-kHalfWidth, kTableHeight - 0.04},
                   {-kHalfWidth - 0.012, kTableHeight - 0.015},
                   {-kHalfWidth, kTableHeight, kCorner},
                   {kHalfWidth, kTableHeight, kCorner},
                   {kHalfWidth + 0.012, kTableHeight - 0.015},
                   {kHalfWidth, kTableHeight - 0.04},
                   {kHalfWidth - 0.05, kTableHeight - 0.05, kCorner},
                   {-kHalfWidth + 0.05, kTableHeight - 0.05}},
                  length, 2);
  for (double x : {0.0, length}) {
    builder.Quad(start, {x, kTableHeight - 0.05, -kHalfWidth}, {x, kTableHeight, -kHalfWidth},
                 {x, kTableHeight, kHalfWidth}, {x, kTableHeight - 0.05, kHalfWidth});
  }
  for (double x : {0.35, length / 2, length - 0.35}) {
    for (double z : {-0.38, 0.38}) TableLeg(builder, start.At(x, 0, z));
    builder.Box(start, {x - 0.03, 0.1, -0.38}, {x + 0.03, 0.16, 0.38});
  }
  builder.Box(start, {0.35, 0.115, -0.03}, {length - 0.35, 0.155, 0.03});
  TableRunner(builder, frame, length);

  for (int sign : {-1, 1}) {
    const Frame side = frame.TurnedAboutY(sign > 0 ? 0 : 0.5);
    for (int seat = 0; seat < seats; ++seat) {
      const Frame place = side.At((seat + 0.5 - seats / 2.0) * spacing, 0, kHalfWidth);
      const Frame setting = place.At(0, kTableHeight, -0.17);
      Plate(builder, setting);
      Cutlery(builder, setting.At(0.19, 0, 0));
      Cutlery(builder, setting.At(-0.19, 0, 0));
      Goblet(builder, setting.At(0.24 + random.Between(-0.02, 0.02), 0,
                                 -0.14 + random.Between(-0.02, 0.02)));
      // Most chairs stand at the table; some were pushed back.
      const double pushed = random.Between(0, 1) < 0.25 ? random.Between(0.2, 0.4) : 0;
      Chair(builder, place.At(random.Between(-0.04, 0.04), 0, 0.22 + pushed)
                         .TurnedAboutY(0.5 + random.Between(-0.02, 0.02) * (1 + 4 * pushed)));
    }
  }

  const Frame top = frame.At(0, kTableHeight + 0.003, 0);
  for (int gap = 1; gap < seats; ++gap) {
    const Frame place = top.At((gap - seats / 2.0) * spacing, 0, 0);
    switch (gap % 3) {
      case 0:
        Candelabrum(builder, place.TurnedAboutY(random.Between(0, 1)));
        break;
      case 1:
        FruitBowl(builder, place.TurnedAboutY(random.Between(0, 1)), seed + gap);
        break;
      default:
        Jug(builder, place.TurnedAboutY(random.Between(0, 1)));
        Goblet(builder, place.At(0.17, 0, 0.05));
    }
  }
  OpenBook(builder, top.At(length / 2 - 0.45, 0, 0.1).TurnedAboutY(0.05));
}

void Chandelier(MeshBuilder& builder, const Frame& frame, double drop) {
  // The chain, every other link turned.
  constexpr double kLink = 0.11;  // metres of chain
  const double chain = drop - 0.75;
  const int links = builder.Pieces(int(chain / kLink));
  for (int link = 0; link < links; ++link) {
    builder.Ring(frame.At(0, -(link + 0.5) * chain / links, 0)
                     .TurnedAboutY(link % 2 * 0.25)
                     .TurnedAboutX(0.25)
                     .Scaled(0.6, 1, 1),
                 0.055, 0.011, 14, 6);
  }

  const Frame hub = frame.At(0, -drop, 0);
  builder.Revolve(hub,
                  {{0, -0.22},
                   {0.03, -0.19},
                   {0.015, -0.15},
                   {0.06, -0.1},
                   {0.1, 0},
                   {0.05, 0.1},
                   {0.03, 0.2},
                   {0.06, 0.28},
                   {0.09, 0.36},
                   {0.04, 0.46},
                   {0.02, 0.6},
                   {0.04, 0.66},
                   {0, 0.75}},
                  24, 2);
  constexpr struct {
    int arms;
    double reach;
    double height;
  } kTiers[] = {{12, 1.05, 0}, {8, 0.62, 0.36}};
  for (const auto& tier : kTiers) {
    const int arms = builder.Pieces(tier.arms);
    builder.Ring(hub.At(0, tier.height - 0.02, 0), 0.72 * tier.reach, 0.03, 80, 12);
    for (int arm = 0; arm < arms; ++arm) {
      const Frame turned = hub.TurnedAboutY(double(arm) / arms);
      CandleArm(builder, turned.At(0, tier.height, 0), tier.reach, 0.16);
      // Glass drops on a string from this arm to the next.
      const int drops = builder.Pieces(8);
      for (int glass = 0; glass < drops; ++glass) {
        const double t = double(glass) / drops;
        const double sag = 0.16 * 4 * t * (1 - t);
        builder.Ellipsoid(
            hub.TurnedAboutY((arm + t) / arms).At(0, tier.height - 0.06 - sag, 0.72 * tier.reach),
            {0.014, 0.02, 0.014}, 6);
      }
    }
  }
}

void Bookcase(MeshBuilder& builder, const Frame& frame, uint32_t seed) {
  constexpr double kHalfWidth = 0.66;
  constexpr double kDepth = 0.34;
  constexpr double kHeight = 2.4;
  constexpr double kBoard = 0.03;
  constexpr double kPlinth = 0.14;
  constexpr int kShelves = 5;
  constexpr double kShelf = (kHeight - kPlinth) / kShelves;
  constexpr double kBooks = 16;  // about as many on a shelf
  const double stoutness = kBooks / builder.Pieces(kBooks);
  Random random(seed);
  builder.Box(frame, {-kHalfWidth, 0, 0}, {kHalfWidth, kHeight, 0.015});
  for (double x : {-kHalfWidth, kHalfWidth - kBoard}) {
    builder.Box(frame, {x, 0, 0.015}, {x + kBoard, kHeight, kDepth});
  }
  builder.Box(frame, {-kHalfWidth, 0, 0.3}, {kHalfWidth, kPlinth - kBoard, kDepth - 0.01});
  builder.Extrude(frame.At(-kHalfWidth - 0.05, kHeight, 0),
                  {{kDepth, -0.05, kCorner},
                   {kDepth + 0.02, 0},
                   {kDepth + 0.06, 0.05, kCorner},
                   {kDepth + 0.06, 0.08, kCorner},
                   {0, 0.08}},
                  2 * kHalfWidth + 0.1, 2);

  const double left = -kHalfWidth + kBoard;
  const double right = kHalfWidth - kBoard;
  for (int shelf = 0; shelf < kShelves; ++shelf) {
    const double y = kPlinth + shelf * kShelf;
    builder.Box(frame, {left, y - kBoard, 0.015}, {right, y, kDepth - 0.01});
    double x = left + random.Between(0, 0.03);
    while (x < right - 0.09 * stoutness) {
      constexpr double kWide = 0.28;  // needed by what is not a book
      const double choice = x + kWide < right ? random.Between(0, 1) : 1;
      if (choice < 0.05) {  // a gap with a vase
        Vase(builder, frame.At(x + 0.12, y, 0.18).Scaled(0.32));
        x += kWide;
      } else if (choice < 0.1) {  // a stack
        double top = y;
        for (int book = 0; book < 4; ++book) {
          const double thickness = random.Between(0.025, 0.05);
          builder.Box(frame.At(x + 0.13, top, 0.16).TurnedAboutY(random.Between(-0.03, 0.03)),
                      {-0.11, 0, -0.1}, {0.11, thickness, 0.14});
          top += thickness;
        }
        x += kWide;
      } else {
        const double thickness = stoutness * random.Between(0.04, 0.085);
        const double height = random.Between(0.24, 0.36);
        const double lean = choice < 0.15 ? 0.02 : 0;
        Book(builder, frame.At(x + height * Sin(lean), y, 0.05).TurnedAboutZ(lean), thickness,
             height, random.Between(0.2, 0.24));
        x += thickness + 0.002 + height * Sin(lean);
      }
    }
  }
}

void Chest(MeshBuilder& builder, const Frame& frame) {
  constexpr double kHalfWidth = 0.6;
  constexpr double kRadius = 0.26;
  constexpr double kLid = 0.4;
  const Frame middle = frame.At(0, 0, kRadius + 0.02);
  builder.Box(middle, {-kHalfWidth, 0.05, -kRadius}, {kHalfWidth, kLid - 0.01, kRadius});
  const auto lid = [&](double from, double to, double radius) {
    builder.Patch(middle.At(0, kLid, 0), {.across = 1, .along = builder.Cells(20, 6)},
                  [&](double u, double v) {
                    const auto [cosine, sine] = AtTurn(v / 2);
                    return V3d(Mix(from, to, u), 0.7 * radius * sine, radius * cosine);
                  });
    for (double x : {from, to}) {
      builder.Patch(middle.At(x, kLid, 0),
                    {.across = builder.Cells(20, 6), .along = 1, .start_pole = true},
                    [&](double u, double v) {
                      const auto [cosine, sine] = AtTurn(u / 2);
                      return V3d(0, 0.7 * radius * sine * v, radius * cosine * v);
                    });
    }
  };
  lid(-kHalfWidth, kHalfWidth, kRadius);
  for (double x : {-0.5, -0.03, 0.44}) {
    lid(x, x + 0.06, kRadius + 0.008);
    builder.Box(middle, {x, 0.05, kRadius}, {x + 0.06, kLid, kRadius + 0.008});
    for (double y : {0.12, 0.22, 0.32}) {
      builder.Ellipsoid(middle.At(x + 0.03, y, kRadius + 0.008), {0.012, 0.012, 0.012}, 6);
    }
  }
  for (double x : {-0.5, 0.5}) {
    for (double z : {-0.18, 0.18}) {
      builder.Ellipsoid(middle.At(x, 0.04, z), {0.05, 0.04, 0.05}, 12);
    }
  }
}

}  // namespace scenes

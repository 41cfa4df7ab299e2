#include "scenes/hall.h"

#include "scenes/architecture.h"
#include "scenes/furniture.h"

namespace scenes {
namespace {

void FurnishNave(MeshBuilder& builder) {
  constexpr double kCarpetWidth = 1.7;
  Carpet(builder, Frame().At(-14.5, 0, 0), kStairFoot - 0.3 + 14.5, kCarpetWidth);
  for (double x : {-8.6, 0.2}) {
    for (int sign : {-1, 1}) {
      BanquetTable(builder, Frame().At(x, 0, 2.45 * sign), 6.7, uint32_t(100 + x + sign));
    }
  }
  for (int bay = 1; bay < kBays; bay += 2) {
    constexpr double kCrown = kNaveVaultSpring + kNaveVaultRise - 0.2;
    Chandelier(builder, Frame().At(BayCentre(bay), kCrown, 0).Scaled(1.3), 4.6);
  }
  for (int sign : {-1, 1}) {
    for (int column = 2; column < kBays; ++column) {
      Banner(builder,
             Frame().At(BayStart(column), 6.3, kNaveWall * sign).TurnedAboutY(sign > 0 ? 0.5 : 0),
             uint32_t(column * 2 + sign));
    }
    PottedPlant(builder, Frame().At(kStairFoot - 0.9, 0, 3.5 * sign), 40 + sign);
    Vase(builder, Frame().At(kPlatformFront + 1.2, kPlatform, 3.2 * sign).Scaled(1.2));
  }
  KnotSculpture(builder, Frame().At(15.4, kPlatform, 0).TurnedAboutY(-0.25));
}

void FurnishAisles(MeshBuilder& builder) {
  for (int sign : {-1, 1}) {
    // Along the wall, local z into the hall.
    const auto wall = [&](double x) {
      return Frame().At(x, 0, kAisleWall * sign).TurnedAboutY(sign > 0 ? 0.5 : 0);
    };
    for (int bay = 0; bay < kBays; ++bay) {
      const double centre = BayCentre(bay);
      for (double side : {-1.0, 1.0}) {
        const uint32_t seed = uint32_t(1000 + 10 * bay + 3 * side + sign);
        if ((bay + (side > 0)) % 3 != 0) {
          Bookcase(builder, wall(centre + 1.82 * side), seed);
        } else {
          PottedPlant(builder, wall(centre + 1.75 * side).At(0, 0, 0.55), seed);
        }
      }
      if (bay % 2 == 0) {
        Chest(builder, wall(centre));
      } else {
        for (double x : {-0.4, 0.4}) Chair(builder, wall(centre + x).At(0, 0, 0.45));
      }
    }
    for (int bay = 1; bay < kBays; bay += 2) {
      ArmillarySphere(builder, Frame().At(BayCentre(bay), 0, 6.2 * sign));
    }
  }
}

void BuildHall(MeshBuilder& builder) {
  BuildArchitecture(builder);
  FurnishNave(builder);
  FurnishAisles(builder);
}

uint64_t CountTriangles(double detail) {
  MeshBuilder counter(detail, nullptr);
  BuildHall(counter);
  return counter.triangle_count();
}

// The detail at which the hall comes closest to the number of triangles, by bisection: the number
// grows with the detail, in small steps.
double DetailFor(uint32_t triangles) {
  double low = 0;
  double high = 1;
  while (CountTriangles(high) < triangles) high *= 2;
  for (int step = 0; step < 24; ++step) {
    const double middle = (low + high) / 2;
    (CountTriangles(middle) < triangles ? low : high) = middle;
  }
  return high;
}

}  // namespace

Mesh MakeHall(uint32_t triangles) {
  const double detail = DetailFor(std::clamp(triangles, kHallLeastTriangles, kHallMostTriangles));
  MeshBuilder counter(detail, nullptr);
  BuildHall(counter);

  Mesh mesh;
  mesh.positions.reserve(3 * counter.vertex_count());
  mesh.indices.reserve(3 * counter.triangle_count());
  MeshBuilder builder(detail, &mesh);
  BuildHall(builder);
  return mesh;
}

Camera HallCamera() {
  return {.eye = {-16.2f, 2.3f, -1.1f},
          .look_at = {0.0f, 3.35f, 0.35f},
          .up = {0, 1, 0},
          .vertical_fov = 62};
}

}  // namespace scenes

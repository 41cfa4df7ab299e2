// The parts that need no second rank: pieces of views, messages that are cut, routes, names of
// arrays, greetings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "greeting.h"
#include "link_speed.h"
#include "pieces.h"
#include "route.h"
#include "scene_message.h"
#include "shared_array.h"
#include "view_piece.h"
#include "wire.h"

namespace dacrt::mpi {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Rays with hits in structure of arrays: packets of `lanes`.
struct Batch {
  static constexpr std::size_t kComponents = 20;

  Batch(std::size_t count, std::size_t lanes)
      : count(count), lanes(lanes), values((count + lanes - 1) / lanes * lanes * kComponents) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 1013) + 1;
  }
  RayView View() {
    RayView view;
    view.count = count;
    view.lanes = lanes;
    view.lane_stride = 4;
    view.packet_stride = 4 * lanes * kComponents;
    std::size_t place = 0;
    for (auto* component :
         {&view.org_x, &view.org_y, &view.org_z, &view.tnear, &view.dir_x, &view.dir_y, &view.dir_z,
          &view.time, &view.tfar, &view.mask, &view.ng_x, &view.ng_y, &view.ng_z, &view.u, &view.v,
          &view.primitive_id, &view.geometry_id, &view.instance_id}) {
      *component = reinterpret_cast<RayView::Component>(values.data() + lanes * place++);
    }
    return view;
  }
  const std::size_t count, lanes;
  std::vector<float> values;
};

TEST(ViewPiece, PiecesAreTheWhole) {
  for (const std::size_t lanes : {1, 4, 7, 16, 100}) {
    for (const std::size_t wanted : {1, 3, 16, 33, 1000}) {
      Batch batch(100, lanes);
      const RayView view = batch.View();
      for (std::size_t first = 0; first < view.count;) {
        const std::size_t count = PieceLength(view, first, wanted);
        ASSERT_GE(count, 1u);
        ASSERT_LE(first + count, view.count);
        const RayView piece = Piece(view, first, count);
        for (std::size_t i = 0; i < count; ++i) {
          EXPECT_EQ(piece.Address(piece.u, i), view.Address(view.u, first + i));
        }
        first += count;
      }
    }
  }
}

/// A piece whose every third ray the worker found a hit for.
Message Answered(const Message& piece, Query query) {
  Reader reader(piece);
  reader.Take<Command>();
  UnpackedPiece unpacked(reader);
  const RayView view = unpacked.view();
  for (std::size_t i = 0; i < view.count; i += 3) {
    const auto number = static_cast<uint32_t>(i);
    query == Query::kAny
        ? WriteOccluded(view, i)
        : WriteHit(view, i, {0.5f, {1, 2, static_cast<float>(i)}, 3, 4, number, 7, 9});
  }
  return unpacked.PackHits();
}

TEST(Pieces, HitsComeBackWhereTheyBelong) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    for (const std::size_t count : {1, 31, 32, 33, 100}) {
      Batch batch(count, 4), expected(count, 4);
      const Message piece = PackPiece(5, 6, query, batch.View());
      const Message answer = Answered(piece, query);
      Reader reader(answer);
      ASSERT_EQ(reader.Take<Answer>(), Answer::kHits);
      EXPECT_EQ(PieceOf(reader), 6u);
      UnpackHits(reader, query, batch.View());
      for (std::size_t i = 0; i < count; i += 3) {
        const auto number = static_cast<uint32_t>(i);
        query == Query::kAny ? WriteOccluded(expected.View(), i)
                             : WriteHit(expected.View(), i,
                                        {0.5f, {1, 2, static_cast<float>(i)}, 3, 4, number, 7, 9});
      }
      EXPECT_EQ(std::memcmp(batch.values.data(), expected.values.data(),
                            batch.values.size() * sizeof(float)),
                0);
    }
  }
}

TEST(Pieces, SameValuesTravelOnce) {
  Batch batch(1000, 1);
  RayView view = batch.View();
  view.org_x = view.org_y = view.org_z = view.tnear = view.time = view.mask = RayView::kAbsent;
  EXPECT_LT(PackPiece(1, 1, Query::kAny, view).size(), 1000 * 16 + 200u);
}

TEST(Pieces, CutMessagesChangeNothing) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    Batch batch(50, 1);
    const std::vector<float> before = batch.values;
    const Message piece = PackPiece(5, 6, query, batch.View());
    for (std::size_t bytes = sizeof(Command); bytes < piece.size(); ++bytes) {
      Message cut = piece.Copy();
      cut.Shrink(bytes);
      Reader reader(cut);
      reader.Take<Command>();
      EXPECT_THROW(UnpackedPiece{reader}, CutMessage) << bytes;
    }
    const Message answer = Answered(piece, query);
    for (std::size_t bytes = sizeof(Answer); bytes < answer.size(); ++bytes) {
      Message cut = answer.Copy();
      cut.Shrink(bytes);
      Reader reader(cut);
      reader.Take<Answer>();
      EXPECT_THROW(UnpackHits(reader, query, batch.View()), CutMessage) << bytes;
    }
    EXPECT_EQ(std::memcmp(batch.values.data(), before.data(), before.size() * 4), 0);
  }
}

TEST(Arrays, NamesSayWhatIsInThem) {
  std::vector<uint32_t> tight(30), loose(50, 99);
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      tight[3 * i + k] = loose[5 * i + k] = static_cast<uint32_t>(i * k);
    }
  }
  const ArraySource tight_source{{tight.data(), 12}, 10, 12};
  const ArraySource loose_source{{loose.data(), 20}, 10, 12};
  const ArrayName name = NameOf(tight_source);
  EXPECT_EQ(name, NameOf(loose_source));
  std::vector<uint32_t> copy(30);
  CopyItems(loose_source, 0, 10, reinterpret_cast<std::byte*>(copy.data()));
  EXPECT_EQ(copy, tight);
  for (std::size_t word = 0; word < tight.size(); ++word) {
    for (int bit = 0; bit < 32; ++bit) {
      tight[word] ^= 1u << bit;
      EXPECT_NE(NameOf(tight_source), name);
      tight[word] ^= 1u << bit;
    }
  }
}

TEST(Scenes, CutMessagesAreRefused) {
  const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint32_t triangle[3] = {0, 1, 2};
  Geometry geometry;
  geometry.geometry_id = 17;
  geometry.primitive_count = 1;
  geometry.vertex_count = 3;
  geometry.vertices = {{vertices, 12}};
  geometry.primitives = {triangle, 12};
  const auto no_scene = [](const Scene*) { return std::optional<uint64_t>(); };
  const auto packed = PackScene(3, {}, {&geometry, 1}, {}, no_scene);
  ASSERT_TRUE(packed);
  EXPECT_EQ(packed->arrays.size(), 2u);
  const auto find = [](const ArrayName& name) {
    return std::shared_ptr<const std::byte[]>(new std::byte[name.bytes]);
  };
  const auto unpack = [&](const Message& message) {
    Reader reader(message);
    return UnpackScene(reader, find, [](uint64_t) { return nullptr; });
  };
  const UnpackedScene scene = unpack(packed->message);
  ASSERT_EQ(scene.geometries.size(), 1u);
  EXPECT_EQ(scene.geometries[0].geometry_id, 17u);
  EXPECT_EQ(scene.geometries[0].vertex_count, 3u);
  for (std::size_t bytes = 0; bytes < packed->message.size(); ++bytes) {
    Message cut = packed->message.Copy();
    cut.Shrink(bytes);
    EXPECT_THROW(unpack(cut), CutMessage) << bytes;
  }
}

TEST(Scenes, WithCallbacksStay) {
  Geometry user;
  user.shape = Shape::kUser;
  EXPECT_FALSE(CanTravel(user));
  Geometry filtered;
  EXPECT_TRUE(CanTravel(filtered));
  filtered.any_filter.function = [](void*, const CallbackArguments&) {};
  EXPECT_FALSE(CanTravel(filtered));
}

/// Unit boxes in a row along x.
std::vector<Bounds> Row(int count) {
  std::vector<Bounds> boxes;
  for (int i = 0; i < count; ++i) {
    const auto x = static_cast<float>(2 * i);
    boxes.push_back({{x, 0, 0}, {x + 1, 1, 1}});
  }
  return boxes;
}

struct Segment {
  float org[3], dir[3];
  float tnear, tfar;
};

std::vector<int> RouteOf(const std::vector<Bounds>& boxes, const Segment& segment, int home) {
  const auto& [org, dir, tnear, tfar] = segment;
  const RouteRay ray{{org[0], org[1], org[2]}, {dir[0], dir[1], dir[2]}, tnear, home};
  std::vector<int> ranks;
  const RouteBoxes route_boxes(boxes);
  Routes routes(route_boxes);
  routes.Add(ray);
  routes.Find();
  for (int rank = kNew; (rank = routes.Next(0, rank).RankWithin(tfar)) != kNowhere;) {
    ranks.push_back(rank);
    if (ranks.size() > boxes.size()) break;
  }
  return ranks;
}

TEST(Routes, GoToWhatIsEnteredNearestFirst) {
  const std::vector<Bounds> row = Row(4);
  EXPECT_EQ(RouteOf(row, {{-1, .5f, .5f}, {1, 0, 0}, 0, kInfinity}, 2),
            (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(RouteOf(row, {{9, .5f, .5f}, {-1, 0, 0}, 0, kInfinity}, 0),
            (std::vector<int>{3, 2, 1, 0}));
  EXPECT_EQ(RouteOf(row, {{-1, .5f, .5f}, {1, 0, 0}, 0, 4}, 0), (std::vector<int>{0, 1}));
  EXPECT_EQ(RouteOf(row, {{-1, .5f, .5f}, {1, 0, 0}, 2.5f, kInfinity}, 0),
            (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(RouteOf(row, {{-1, 5, .5f}, {1, 0, 0}, 0, kInfinity}, 0), std::vector<int>());
  // The edge of a box counts: a triangle may lie in it.
  EXPECT_EQ(RouteOf(row, {{-1, 1, .5f}, {1, 0, 0}, 0, 2}, 0), (std::vector<int>{0}));
}

TEST(Routes, BeginAtHomeWhereAllAreEnteredAtOnce) {
  const std::vector<Bounds> same(4, Bounds{{0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(RouteOf(same, {{.5f, .5f, .5f}, {0, 1, 0}, 0, kInfinity}, 2),
            (std::vector<int>{2, 3, 0, 1}));
}

TEST(Routes, PassByWhereNothingIs) {
  std::vector<Bounds> row = Row(3);
  row[1] = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  EXPECT_EQ(RouteOf(row, {{-1, .5f, .5f}, {1, 0, 0}, 0, kInfinity}, 0), (std::vector<int>{0, 2}));
}

/// Where a ray enters a box, in double precision and without any slack; infinity if it does not.
double EntryOf(const Bounds& box, const Segment& ray) {
  double first = ray.tnear, last = std::min(ray.tfar, std::numeric_limits<float>::max());
  for (int axis = 0; axis < 3; ++axis) {
    const double org = ray.org[axis], dir = ray.dir[axis];
    const double low = box.lower[axis] - org, high = box.upper[axis] - org;
    if (dir == 0) {
      if (low > 0 || high < 0) return INFINITY;
      continue;
    }
    first = std::max(first, std::min(low / dir, high / dir));
    last = std::min(last, std::max(low / dir, high / dir));
  }
  return first <= last ? first : INFINITY;
}

TEST(Routes, MissNoBoxThatIsEntered) {
  std::mt19937 random(5);
  const auto uniform = [&](float from, float to) {
    return std::uniform_real_distribution<float>(from, to)(random);
  };
  std::size_t visits = 0, detours = 0;
  for (int round = 0; round < 3000; ++round) {
    const float size = std::exp2(uniform(-60, 60)), away = round % 3 == 0 ? 1000 * size : 0;
    std::vector<Bounds> boxes(5);
    for (Bounds& box : boxes) {
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = away + size * uniform(-1, 1);
        box.upper[axis] = box.lower[axis] + size * uniform(0, 1);
      }
    }
    // Towards one of them; some so short that their reciprocal is no number.
    const bool is_short = round % 4 == 0;
    const float length = is_short ? 1e-39f : std::exp2(uniform(-20, 20));
    Segment ray{};
    for (int axis = 0; axis < 3; ++axis) {
      const float centre = boxes[0].lower[axis] / 2 + boxes[0].upper[axis] / 2;
      ray.org[axis] = away + size * uniform(-2, 2);
      ray.dir[axis] = length * ((centre - ray.org[axis]) / size + uniform(-.2f, .2f));
      if (round % 5 == axis) ray.org[axis] = centre, ray.dir[axis] = 0;
    }
    ray.tfar = round % 2 == 0 ? kInfinity : size / length * uniform(0, 4);
    const std::vector<int> route = RouteOf(boxes, ray, round % 5);
    double latest = 0;
    for (const int rank : route) {
      const double entry = EntryOf(boxes[static_cast<std::size_t>(rank)], ray);
      if (entry == INFINITY) {
        detours += !is_short;
        continue;
      }
      // Next to each other where they are entered at about the same distance.
      EXPECT_TRUE(is_short || entry >= latest - .02 * size / length) << round;
      latest = entry;
      ++visits;
    }
    for (int rank = 0; rank < 5; ++rank) {
      if (std::find(route.begin(), route.end(), rank) != route.end()) continue;
      EXPECT_EQ(EntryOf(boxes[static_cast<std::size_t>(rank)], ray), INFINITY) << round;
    }
  }
  EXPECT_GT(visits, 2000u);
  EXPECT_LT(detours, visits / 20);
}

TEST(Routes, OfManyRaysAreThoseOfEach) {
  const std::vector<Bounds> row = Row(3);
  const RouteBoxes boxes(row);
  Routes routes(boxes);
  const auto ray_of = [](std::size_t i) {
    const auto x = static_cast<float>(i) / 8 - 1;
    return Segment{{x, .5f, .5f}, {i % 2 ? 1.0f : -1.0f, 0, 0}, 0, 3};
  };
  for (std::size_t i = 0; i < Routes::kMost; ++i) {
    const Segment ray = ray_of(i);
    routes.Add({{ray.org[0], ray.org[1], ray.org[2]}, {ray.dir[0], 0, 0}, 0, 1});
  }
  routes.Find();
  for (std::size_t i = 0; i < Routes::kMost; ++i) {
    std::vector<int> ranks;
    for (int rank = kNew; (rank = routes.Next(i, rank).RankWithin(3)) != kNowhere;) {
      ranks.push_back(rank);
    }
    EXPECT_EQ(ranks, RouteOf(row, ray_of(i), 1)) << i;
  }
}

TEST(Routes, AreOnesOwnForRaysThatAreNoRays) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {nan, kInfinity, -kInfinity}) {
    EXPECT_LE(RouteOf(Row(3), {{bad, 0, 0}, {1, bad, 0}, 0, kInfinity}, 0).size(), 3u);
    EXPECT_LE(RouteOf(Row(3), {{0, 0, 0}, {1, 0, 0}, bad, nan}, 0).size(), 3u);
  }
}

TEST(Greetings, RefuseInASentence) {
  const Greeting own = MakeGreeting(Role::kProgram);
  Greeting other = MakeGreeting(Role::kWorker);
  EXPECT_EQ(Refusal(own, other, Role::kWorker, 3), "");
  EXPECT_NE(Refusal(own, other, Role::kMember, 3).find("rank 3"), std::string::npos);
  std::strcpy(other.version, "0.0.9");
  EXPECT_NE(Refusal(own, other, Role::kWorker, 3).find("runs dacrt 0.0.9"), std::string::npos);
  other.byte_order = __builtin_bswap32(other.byte_order);
  EXPECT_NE(Refusal(own, other, Role::kWorker, 3).find("byte order"), std::string::npos);
  EXPECT_NE(Refusal(own, Greeting{}, Role::kWorker, 3).find("does not run"), std::string::npos);
}

TEST(Greetings, SayWhoHasEnded) {
  const Greeting own = MakeGreeting(Role::kProgram);
  Greeting other = own;
  EXPECT_FALSE(HasEnded(own, other));
  other.process = 0x3fffffff;  // above the system's largest number
  EXPECT_TRUE(HasEnded(own, other));
  std::strcpy(other.host, "elsewhere");
  EXPECT_FALSE(HasEnded(own, other));
}

TEST(LinkSpeeds, SayFromWhichSizeOnSharingPays) {
  const LinkSpeed fast{4e-6, 5e9}, slow{1e-3, 5e9}, narrow{4e-6, 1e8};
  EXPECT_LT(LeastRays(fast, 2), LeastRays(slow, 2));
  EXPECT_LT(LeastRays(slow, 4), LeastRays(slow, 2));
  EXPECT_EQ(LeastRays(narrow, 2), SIZE_MAX);
  EXPECT_EQ(LeastRays(fast, 1), SIZE_MAX);
}

}  // namespace
}  // namespace dacrt::mpi

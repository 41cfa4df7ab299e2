// Filter functions of geometries and of contexts, in every form of a call, on both libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "filter_tower.h"

namespace dacrt::tests {
namespace {

/// The hits of `rays` are among `offers`.
void ExpectAreOffered(const std::vector<RTCRayHit>& rays, const std::vector<Offer>& offers) {
  for (int i = 0; i < kRays; ++i) {
    if (!MeetsSquare(i)) continue;
    EXPECT_TRUE(std::any_of(
        offers.begin(), offers.end(),
        [&](const Offer& offer) { return offer.ray == i && offer.t == rays[i].ray.tfar; }))
        << "ray " << i;
  }
}

class Filters : public FilterTest {};

TEST_F(Filters, AreOfferedEachHitOnceIfTheyRejectAll) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, Reject);
    const Outcome actual = TraceTower(ours, form, query, Reject);
    const std::vector<RTCRayHit> before = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) {
      SCOPED_TRACE("ray " + std::to_string(i));
      EXPECT_TRUE(AreSame(actual.rays[i], before[i]));
      EXPECT_TRUE(AreSame(expected.rays[i], before[i]));
      const auto offers = std::count_if(actual.offers.begin(), actual.offers.end(),
                                        [&](const Offer& offer) { return offer.ray == i; });
      // One a floor, and the far side of the sphere.
      EXPECT_EQ(offers, MeetsSquare(i) ? std::ssize(kTypes) + 1 : 0);
    }
    ExpectSameOffers(actual.offers, expected.offers);
  });
}

TEST_F(Filters, ThatAcceptAllChangeNothing) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, Accept);
    const Outcome actual = TraceTower(ours, form, query, Accept);
    ExpectSameRays(actual.rays, expected.rays);
    for (int i = 0; i < kRays; ++i) {
      if (!MeetsSquare(i)) continue;
      EXPECT_FLOAT_EQ(actual.rays[i].ray.tfar, query == Query::kAny ? -kInfinity : 10);
    }
    // Whatever is seen behind the hit, the hit itself is seen.
    if (query == Query::kClosest) ExpectAreOffered(actual.rays, actual.offers);
  });
}

TEST_F(Filters, LetRaysThroughWhatTheyReject) {
  for (unsigned int first = kFirstId; first <= kInstanceId; ++first) {
    const Judge judge = [=](const Offer& offer) { return TopId(offer.hit) >= first; };
    ForEachCall([&](const Form& form, Query query) {
      const Outcome expected = TraceTower(real, form, query, judge);
      const Outcome actual = TraceTower(ours, form, query, judge);
      ExpectSameRays(actual.rays, expected.rays);
      for (int i = 0; i < kRays; ++i) {
        if (!MeetsSquare(i)) continue;
        if (query == Query::kAny) {
          EXPECT_EQ(actual.rays[i].ray.tfar, -kInfinity);
          continue;
        }
        EXPECT_EQ(actual.rays[i].hit.geomID, first == kInstanceId ? kInnerId : first);
      }
    });
  }
}

TEST_F(Filters, DecideForEachRay) {
  const Judge judge = [](const Offer& offer) {
    return offer.ray % 4 != 0 && static_cast<int>(TopId(offer.hit)) % 4 == offer.ray % 4;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
    const std::vector<RTCRayHit> before = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) {
      const bool is_hit = MeetsSquare(i) && i % 4 != 0;
      EXPECT_EQ(AreSame(actual.rays[i], before[i]), !is_hit) << "ray " << i;
    }
  });
}

TEST_F(Filters, MayChangeTheHit) {
  const Judge judge = [](Offer& offer) {
    offer.hit.u = 0.25f;
    offer.hit.v += 0.5f;
    offer.hit.Ng_x = 3;
    offer.hit.primID += 100;
    offer.hit.geomID += 1000;
    return true;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
    for (int i = 0; i < kRays && query == Query::kClosest; ++i) {
      if (!MeetsSquare(i)) continue;
      EXPECT_EQ(actual.rays[i].hit.u, 0.25f);
      EXPECT_EQ(actual.rays[i].hit.primID, 100u);
      EXPECT_EQ(actual.rays[i].hit.geomID, 1000 + kFirstId);
    }
  });
}

// What lies behind the shortened ray is not hit, though it is before the surface.
TEST_F(Filters, MayShortenTheRay) {
  const Judge judge = [](Offer& offer) {
    if (TopId(offer.hit) % 2 == 0) return false;
    offer.t -= 5;
    return true;
  };
  ForEachCall([&](const Form& form, Query query) {
    if (query == Query::kAny) return;
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
  });
}

TEST_F(Filters, OfGeometriesAreForOneKindOfQuery) {
  for (const bool is_committed : {false, true}) {
    for (const Query filtered : {Query::kClosest, Query::kAny}) {
      for (Tower* const tower : {&real, &ours}) {
        tower->SetFilters(filtered);
        if (is_committed) tower->Commit();
      }
      ForEachCall([&](const Form& form, Query query) {
        for (Tower* const tower : {&real, &ours}) {
          const Outcome outcome = TraceTower(*tower, form, query, Reject);
          EXPECT_EQ(outcome.offers.empty(), query != filtered);
          EXPECT_EQ(AreSame(outcome.rays[0], RowOfRays(form)[0]), query == filtered);
        }
      });
    }
  }
}

// Packets that are not full, and streams of few rays.
TEST_F(Filters, SeeNoRaysThatAreNotThere) {
  for (const int count : {1, 3, 9}) {
    SCOPED_TRACE(count);
    ForEachCall([&](const Form& form, Query query) {
      const auto trace = [&](Tower& tower) {
        return TraceRow(tower.s, tower.scene, form, query, Reject, nullptr, count);
      };
      const Outcome actual = trace(ours);
      ExpectSameOffers(actual.offers, trace(real).offers);
      EXPECT_EQ(actual.idle_calls, 0);
    });
  }
}

// As with the real library, but for three things: its streams of a single record call with N = 1,
// its calls for 16 rays are made of 8 without AVX-512, and so are its streams.
TEST_F(Filters, AreCalledForAsManyRaysAsTheFormHas) {
  Tower avx2(DropIn(), RTC_SCENE_FLAG_NONE, "isa=avx2");
  ForEachCall([&](const Form& form, Query query) {
    const auto widths_of = [&](Tower& tower) {
      return TraceTower(tower, form, query, Reject).filter_widths;
    };
    if (IsStream(form)) {
      EXPECT_EQ(widths_of(real), std::set{8u});
      EXPECT_EQ(widths_of(avx2), std::set{8u});
      EXPECT_FALSE(widths_of(ours).contains(1));
    } else {
      EXPECT_EQ(widths_of(real), std::set{std::min(form.lanes, 8u)});
      EXPECT_EQ(widths_of(avx2), std::set{form.lanes});
      EXPECT_EQ(widths_of(ours), std::set{form.lanes});
    }
  });
}

TEST_F(Filters, OfStreamsNeverSeeOneRayAlone) {
  for (const Form& form : StreamForms()) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      SCOPED_TRACE(Name(form) + ", " + Name(query));
      const auto widths =
          TraceRow(ours.s, ours.scene, form, query, Reject, nullptr, 1).filter_widths;
      EXPECT_FALSE(widths.empty());
      EXPECT_FALSE(widths.contains(1));
    }
  }
}

// Where the real library stops the program, or, if the other query had one, asks the new one.
TEST(DropInFilters, FirstOnesOfAQueryWaitForACommitOfTheGeometry) {
  const RTCFilterFunctionN reject = [](const RTCFilterFunctionNArguments* args) {
    std::fill_n(args->valid, args->N, 0);
  };
  for (const bool other_has_one : {false, true}) {
    SCOPED_TRACE(other_has_one);
    Session s(DropIn());
    const RTCGeometry geometry = s.UncommittedTriangle();
    if (other_has_one) s.api.rtcSetGeometryOccludedFilterFunction(geometry, reject);
    s.api.rtcCommitGeometry(geometry);
    const RTCScene scene = s.SceneOf(geometry);
    s.api.rtcSetGeometryIntersectFilterFunction(geometry, reject);
    EXPECT_EQ(s.HitGeometry(scene), 0u);
    s.api.rtcCommitGeometry(geometry);
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.HitGeometry(scene), RTC_INVALID_GEOMETRY_ID);
  }
}

class ContextFilters : public FilterTest {
 protected:
  ContextFilters()
      : real_with_flag(RealEmbree(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION),
        ours_with_flag(DropIn(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) {}

  Tower real_with_flag, ours_with_flag;
};

// The real library stops a program that forgets the flag.
TEST_F(ContextFilters, NeedTheFlagOfTheScene) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome outcome = TraceTower(ours, form, query, Accept, Reject);
    EXPECT_TRUE(outcome.context_offers.empty());
    EXPECT_FALSE(AreSame(outcome.rays[0], RowOfRays(form)[0]));
  });
}

// A scene with the flag in one without.
TEST_F(ContextFilters, NeedTheFlagOfAnInstancesScene) {
  RTCScene scenes[2];
  for (Tower* const tower : {&real_with_flag, &ours_with_flag}) {
    const RTCGeometry instance = Instance(tower->s, tower->SceneOfInstance());
    tower->s.api.rtcCommitGeometry(instance);
    scenes[tower == &ours_with_flag] = tower->s.SceneOf(instance);
  }
  ForEachCall([&](const Form& form, Query query) {
    const auto is_odd = [](const Offer& offer) { return offer.ray % 2 != 0; };
    const Outcome expected = TraceRow(real_with_flag.s, scenes[0], form, query, Accept, is_odd);
    const Outcome actual = TraceRow(ours_with_flag.s, scenes[1], form, query, Accept, is_odd);
    ExpectSameOffers(actual.context_offers, expected.context_offers);
    EXPECT_FALSE(actual.context_offers.empty());
    ExpectSameRays(actual.rays, expected.rays);
  });
}

TEST_F(ContextFilters, AreAskedAboutWhatTheGeometrysAccepts) {
  const auto is_odd = [](const Offer& offer) { return TopId(offer.hit) % 2 != 0; };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real_with_flag, form, query, is_odd, Reject);
    const Outcome actual = TraceTower(ours_with_flag, form, query, is_odd, Reject);
    ExpectSameOffers(actual.offers, expected.offers);
    ExpectSameOffers(actual.context_offers, expected.context_offers);
    EXPECT_TRUE(std::all_of(actual.context_offers.begin(), actual.context_offers.end(), is_odd));
    EXPECT_TRUE(AreSame(actual.rays[0], RowOfRays(form)[0]));
  });
}

TEST_F(ContextFilters, SeeWhatTheGeometrysChanged) {
  const Judge geometry_judge = [](Offer& offer) {
    offer.hit.u = 0.25f;
    offer.t -= 0.5f;
    return true;
  };
  const Judge context_judge = [](Offer& offer) {
    EXPECT_EQ(offer.hit.u, 0.25f);
    offer.hit.v = 0.75f;
    return TopId(offer.hit) > kFirstId + 2;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real_with_flag, form, query, geometry_judge, context_judge);
    const Outcome actual = TraceTower(ours_with_flag, form, query, geometry_judge, context_judge);
    ExpectSameRays(actual.rays, expected.rays);
    if (query == Query::kAny) return;
    EXPECT_EQ(TopId(actual.rays[0].hit), kFirstId + 3);
    EXPECT_EQ(actual.rays[0].hit.u, 0.25f);
    EXPECT_EQ(actual.rays[0].hit.v, 0.75f);
  });
}

}  // namespace
}  // namespace dacrt::tests

// The tunables of the recursion over the kept partition, in one place. None of them changes a hit.
//
// Measured on an AMD EPYC (Zen 4), Sponza and the halls; see tests/bench.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dacrt::policy {

/// Rays up to which each of a list goes its own way. With 1, 2, 3 and 4, 64K ambient rays took 145,
/// 147, 151 and 154 ns a ray of a hall, 124, 126, 126 and 128 of Sponza.
inline constexpr std::size_t kFewRays = 1;

/// And of a group, where each can be tested against all children at once: none, so that a lone one
/// stays with it. On a processor with AVX2 only (Zen 3), with 1 and 0, calls of 64 diffuse rays
/// took 363 and 333 ns a ray of the kitchen, 708 and 702 of Sponza, 550 and 508 of Sibenik, of 256
/// rays 327 and 297, 855 and 737, 518 and 435; with AVX-512 (Sapphire Rapids) they took the same.
/// Where they run close together, in vectors of eight (Zen 1), packets of 16 primary and shadow
/// rays took 322 and 316, 242 and 236 of Sponza, 292 and 286, 251 and 250 of the dragon.
inline constexpr std::size_t kFewOfGroup = 0;

/// Rays of a packet of closest hits in a small scene up to which they may go otherwise than as a
/// group; and in a larger one, if they run in several octants, but where a vector holds the
/// children of a node and no packet of 16; of any hits, where it holds one (see
/// trace_packet-inl.h).
inline constexpr std::size_t kFewInSmallScene = 4, kFewApart = 8, kFewOfAnyInVector = 4;

/// How many runs of how many rays of a call are looked at to see whether its rays run close
/// together, and how far the directions of a run may differ, relative to the longest component, and
/// its origins, relative to the scene. One run of so many that is narrow suffices: of shadow rays
/// in five scenes half and more are, of ambient and diffuse ones none, whose directions differ by
/// 0.9 and more; and where lists turn out to be quicker after all, most rays go by lists (see
/// walk_choice.h).
inline constexpr std::size_t kCoherenceLooks = 16;
inline constexpr std::size_t kNeighbours = 16;
inline constexpr float kNarrowDirections = 0.15f;
inline constexpr float kNarrowOrigins = 0.05f;
inline constexpr std::size_t kRunsWithOneNarrow = 3;

/// The same for a group that has been made: beyond, every ray is asked at every child.
inline constexpr float kGroupDirections = 0.8f;
inline constexpr float kGroupOrigins = 0.1f;

/// What part of the rays of a group takes part in its visits, on average over some groups, above
/// which groups of twice as many rays are made, and below which of half as many. With groups of 16,
/// 32 and 64 rays Sponza took 5.5, 5.4, 5.1 million primary rays a second where 0.48 of 32 took
/// part, 10.7, 11.6, 11.8 where 0.72 did, 12.4, 13.9, 15.0 where 0.82 did; shadow
/// rays 10.4, 10.0, 9.7 where 0.64 of 32 did, 12.3, 13.1, 13.0 where 0.76 did.
struct GroupShares {
  float crowded, sparse;
};
inline constexpr GroupShares kClosestShares{0.73f, 0.53f}, kAnyShares{0.82f, 0.66f};
inline constexpr std::size_t kGroupsToLearnFrom = 8;

/// Rays that go by lists at first, to see what they cost, and at most before groups are asked
/// again. See walk_choice.h.
inline constexpr std::size_t kFewestByLists = 512, kMostByLists = 8192;

/// Samples of groups, of kGroupsToLearnFrom each, that are asked before rays go by lists again.
inline constexpr std::size_t kSamplesOfGroups = 4;

/// What is kept of costs that have been seen, from one sample of groups or some rays in lists to
/// the next; and how much less lists are taken to cost with each sample of groups.
inline constexpr float kKeptOfGroups = 0.75f, kKeptOfLists = 0.5f, kForgottenOfLists = 0.001f;

/// Of the mean cost, what a sample counts at most.
inline constexpr float kMostOfMean = 4;

/// Lanes of a group up to which their rays are tested one by one against the triangles of a leaf
/// side by side, instead of the triangles one by one: where rays run close together, those of the
/// triangles that none of them meets are left out; and these in vectors of eight, which hold half
/// as many rays. With 3, 5 and 6 of these (Zen 1), packets of 16 primary rays took 304, 297 and 294
/// ns a ray of the dragon, 210, 206 and 206 of Sibenik, 74, 76 and 76 of a Cornell box with water.
inline constexpr std::size_t kFewInLeaf = 6, kFewTogetherInLeaf = 3, kFewOfEightInLeaf = 5;

/// Rays that run close together, of each vector of eight in which there are any, up to which each
/// is tested by itself against the children of a node. Never, up to 3, 4 and 6 (Zen 1), packets of
/// 16 primary rays took 326, 307, 301 and 295 ns a ray of the dragon, 155, 143, 143 and 142 of the
/// kitchen, 220, 211, 209 and 208 of Sibenik; 64K shadow rays 88, 88, 87 and 84 of the kitchen,
/// 138, 136, 136 and 138 of Sibenik.
inline constexpr std::size_t kFewOfVector = 4;

/// Nodes and leaves that one ray of a group is taken to visit when it goes its own way.
inline constexpr uint32_t kVisitsAlone = 3;

/// The ratio of the reciprocals of a group's directions up to which its interval alone decides
/// about inner nodes that are as wide as the group. Where it decided about all of them, the dragon
/// of 871,000 triangles took 1.2 million shadow rays a second in calls of 64K, and the kitchen 8.8;
/// so 15.9 and 19.0. Where all rays were asked at all nodes, Sponza took 11.5 million primary rays
/// instead of 13.1 in calls of a million.
inline constexpr float kTightReciprocals = 2;

/// Rays of a list of `rays` that are asked for the order of a node's children: the order costs a
/// short list as much as the test of its rays.
constexpr std::size_t SampleRays(std::size_t rays) { return rays < 8 ? 1 : rays < 64 ? 2 : 4; }

/// Rays ahead of which the next ones are fetched.
inline constexpr std::size_t kFetchAhead = 6;

/// Rays for which a subset is split whose nodes are forgotten afterwards: to test fewer against all
/// of its triangles costs less.
inline constexpr std::size_t kRaysToSplitFor = 64;

/// Rays of calls that go the short way, on the stack of the caller.
inline constexpr std::size_t kShortCall = 256;

/// Rays of calls on several threads that are asked whether they run close together, which takes a
/// few microseconds, so that their pieces may be smaller (see CallPlan::MakeEven).
inline constexpr std::size_t kEvenCall = 4096;

/// Triangles of scenes of which rays of any kind go by groups: before they come apart, they have
/// their hits.
inline constexpr std::size_t kSmallScene = 512;

/// Triangles of scenes whose leaves repeat the vertices that triangles share, and of those whose
/// leaves are prepared as well: there is memory enough, and to load all that is quicker than to
/// look it up and compute it. In a Cornell box with water, of 7,088 triangles, single rays became
/// 1.08 to 1.24 times as fast by repeated vertices, with AVX2; in a scan of 70,000 1.04 to 1.19
/// times, and calls of 64K rays .91 to .97 times.
inline constexpr std::size_t kRepeatingScene = 16384, kPreparedScene = 4096;

/// Bytes a triangle of which those have room that repeat vertices and are not prepared.
inline constexpr std::size_t kRepeatingBytes = 112;

/// Those of all scenes of a device with prepared leaves: 140 bytes a triangle, in about the second
/// level of a core's caches. Where all of a thousand scenes of 270 triangles had such leaves, a
/// stream of rays took 1.1 (10,000 and 100,000 rays) to 1.2 times as long (1,000).
inline constexpr std::size_t kPreparedTogether = 2 * kPreparedScene;

}  // namespace dacrt::policy

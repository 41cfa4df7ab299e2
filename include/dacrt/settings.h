// Settings of a device: which instruction set, and the constants of the method.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dacrt/export.h"

namespace dacrt {

/// What a batch asks of every ray.
enum class Query {
  kClosest,  ///< the nearest hit
  kAny,      ///< whether there is a hit at all (occlusion)
};

/// Upper limit for the instruction set. The engine takes the best one that is compiled in, that
/// the processor has, and that is not above the limit.
enum class InstructionSet {
  kScalar,  ///< portable code, no vector instructions
  kNeon,    ///< of 64-bit ARM processors
  kSse4,
  kAvx2,
  kAvx512,
  kBest,  ///< no limit
};

/// The instruction sets that this build can run on this processor, worst first. Never empty,
/// never contains kBest.
DACRT_API std::vector<InstructionSet> AvailableInstructionSets();

/// Whether this processor has the instruction set, be it compiled in or not. It has kScalar and
/// kBest.
DACRT_API bool ProcessorHas(InstructionSet instruction_set);

/// Names as `SetByName` takes them: "scalar", "avx2", "best" ...; "nabata2013" ...
DACRT_API std::string_view Name(InstructionSet instruction_set);

/// The published methods that the engine can follow. They share the kernels, the compaction of rays
/// and the direct solve, and differ in the steps named here.
enum class Algorithm {
  /// Nabata, Iwasaki, Dobashi, Nishita, "Efficient Divide-And-Conquer Ray Tracing using Ray
  /// Sampling", HPG 2013. Sample rays choose the partition (see `sampled_cost`), the order of the
  /// children (`sampled_order`) and whether rays are filtered at all (`skip_filtering`).
  kNabata2013,
  /// Afra, "Incoherent ray tracing without acceleration structures", EG 2012 short papers. The
  /// partition follows the surface area heuristic, the order the rays' directions, and rays are
  /// always filtered.
  kAfra2012,
  /// Mora, "Naive ray-tracing: a divide-and-conquer approach", ACM TOG 30(5), 2011. Space is
  /// partitioned, and a triangle that straddles the cut goes to both sides; front to back along the
  /// cut axis; rays from one point are filtered in conic packets; rays are always filtered.
  kMora2011,
};

/// Settings::budget: 32 bytes a triangle in whole pages, which hold the whole partition of most
/// scenes, with a copy of the triangles in its leaves; in scenes of less than 250,000 triangles 64
/// bytes, which hold that of any scene, 48 more for each of the first 16,384, and 64 KiB, but not
/// more than 8,000,000; of up to 4,096 triangles 192, and 16 to 64 KiB, for all that their test
/// wants, or, where a device has many such scenes, 72 and 3.5 KiB for each of the later ones.
/// Quads and cells of grids count as two triangles; those with up to nine time steps half as often
/// again for each one beyond the first; user primitives as three and instances as four.
inline constexpr uint64_t kDefaultBudget = UINT64_MAX - 1;
/// Settings::budget: whatever the whole partition takes.
inline constexpr uint64_t kUnlimitedBudget = UINT64_MAX;

/// The constants of the method and the limits of one call.
/// None of them changes a hit: they change time and memory only. Those from `sampled_cost` to
/// `leaf_rays`, except `instruction_set`, describe the published methods, and count where nothing
/// is kept between calls; see `budget`.
struct Settings {
  /// The method. The three switches that follow belong to kNabata2013; the others ignore them.
  Algorithm algorithm = Algorithm::kNabata2013;

  /// Choose the partition by sample rays; else by the surface area heuristic.
  bool sampled_cost = true;

  /// Solve first the child that more sample rays enter first; else go by the rays' directions.
  bool sampled_order = true;

  /// Let a child take over its parent's rays where the sample says that filtering does not pay;
  /// else always filter.
  bool skip_filtering = true;

  /// Limit for the instruction set.
  InstructionSet instruction_set = InstructionSet::kBest;

  /// Bins per axis in which the triangles' centres are counted (Wald 2007); 2 to 32.
  uint32_t bins = 16;

  /// Rays that are traced against the candidate child volumes; 1 to 1024. Of more than 512 times as
  /// many active rays, one in 512 is taken, up to 1024: where there are so many, the better choice
  /// of the partition outweighs the larger sample.
  uint32_t sample_rays = 100;

  /// A subproblem with more active rays than this is sampled; one with fewer uses the surface
  /// area heuristic. At least 1.
  uint32_t sample_threshold = 1000;

  /// A subproblem with at most this many triangles is solved directly; 1 to 64.
  uint32_t leaf_triangles = 8;

  /// A subproblem with at most this many active rays is solved directly; 1 to 1024.
  uint32_t leaf_rays = 8;

  /// A batch is cut into pieces of at most this many rays, which bounds the workspace;
  /// 64 to 2^30. With a kept partition pieces are smaller still, so that they stay in the cache.
  uint32_t piece_rays = 4u << 20;

  /// Threads that work on calls at once, those that call included, and never more than the machine
  /// has, which is also what 0 means; at most 1024. Calls that run at once share them. Where
  /// nothing is kept, and in scenes with callbacks, a call uses the thread that makes it.
  uint32_t threads = 0;

  /// Bytes that a scene may keep between calls: the partition of its triangles, which grows where
  /// rays go and serves all later calls until the scene is gone. A smaller budget than five bytes a
  /// triangle and a little more counts as that much. With 0 nothing is kept, and each call
  /// partitions anew, as published; so does each call with a method other than kNabata2013.
  uint64_t budget = kDefaultBudget;
};

DACRT_API std::string_view Name(Algorithm algorithm);

/// Sets the member called `name` from its text form, e.g. ("bins", "8"). Switches take 0 and 1, the
/// budget a number of bytes, "default" or "unlimited".
/// Throws Error (error.h) that names the setting, the value and what is legal; `settings` is then
/// unchanged.
DACRT_API void SetByName(Settings& settings, std::string_view name, std::string_view value);

/// Throws Error, naming the member and its range, unless every member is legal.
DACRT_API void Validate(const Settings& settings);

}  // namespace dacrt

// The recursion over a kept partition, on lists and on single rays: through nodes made by hand, so
// deep that every stack and every memory of lists is used up, and through partitions of any budget.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "trace_list_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "leaf/finish_hit-inl.h"
#include "partition/list_triangles-inl.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Float3;
using unit::kInfinity;
using unit::Mesh;
using unit::Random;

/// What a ray has found.
struct Answer {
  float t;
  uint32_t primitive;

  bool operator==(const Answer&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Answer& answer) {
  return out << "t " << answer.t << " primitive " << answer.primitive;
}

RayRecord RecordOf(const Float3& org, const Float3& dir) {
  RayRecord ray{};
  std::copy(org.begin(), org.end(), ray.org);
  std::copy(dir.begin(), dir.end(), ray.dir);
  ray.tfar = kInfinity;
  ray.mask = UINT32_MAX;
  EXPECT_TRUE(FinishRecord(ray));
  return ray;
}

/// How rays go through a partition.
struct Way {
  size_t list_bytes = 0;  ///< 0: each ray goes its own way
  bool keeps_leaf_hits = true;
  bool has_scratch = true;  ///< to split in
};

/// Lets rays through a partition.
class Tracer {
 public:
  Tracer(const SceneParts& scene, PartitionView partition, ChildWord root)
      : scene_(scene),
        partition_(partition),
        root_(root),
        scratch_(std::make_unique<SubsetScratch>()) {}

  template <Query kQuery>
  std::vector<Answer> Trace(std::vector<RayRecord> rays, const Way& way) {
    const size_t count = rays.size();
    rays.resize(count + 8);  // those behind the end may be asked for
    std::vector<FullHit> hits(count);
    const CallOptions options;
    const RayView view;
    const CallFrame frame{&view, nullptr, 0, options, UINT32_MAX};
    WorkspacePool pool(no_memory_);
    SplitMemory own(*scratch_), none(pool);
    SplitMemory& split_memory = way.has_scratch ? own : none;
    const TraceTask task{
        scene_, partition_,   rays.data(), hits.data(), false,     way.keeps_leaf_hits,
        frame,  split_memory, {},          nullptr,     FinishHit, UINT32_MAX};
    // The memory of lists ends at a page that may not be touched.
    const unit::GuardedArray<std::byte> bytes(way.list_bytes, 64);
    const ListMemory memory{bytes.begin(), bytes.end()};
    TraceRaysFrom<kQuery>(task, root_, count, memory);
    std::vector<Answer> answers;
    for (size_t i = 0; i < count; ++i) {
      if (kQuery == Query::kAny) {
        answers.push_back({rays[i].tfar < 0 ? -1.0f : 1.0f, 0});
      } else if (rays[i].state & RayRecord::kHasHit) {
        uint32_t geometry;
        const FullHit hit = task.HitOf(static_cast<RayNumber>(i), geometry);
        answers.push_back({hit.t, hit.primitive_id});
      } else {
        answers.push_back({kInfinity, UINT32_MAX});
      }
    }
    return answers;
  }

 private:
  const SceneParts& scene_;
  const PartitionView partition_;
  const ChildWord root_;
  std::unique_ptr<SubsetScratch> scratch_;
  const MemoryAccount no_memory_{[](std::ptrdiff_t) { return false; }};
};

/// A chain of nodes, each of which has seven leaves, and the next node in front of them: a ray
/// keeps seven open children at every level. The triangles are halves of squares across the x axis,
/// at whole numbers, so that a ray enters every box, and t is exact.
class DeepChain {
 public:
  static constexpr size_t kLevels = 200;

  explicit DeepChain(Random& random) {
    // The first leaves lie farthest away.
    const size_t leaves = 7 * kLevels + 1;
    for (size_t i = 0; i < leaves; ++i) {
      const float x = static_cast<float>(leaves - i);
      // Rays run through the lower half, of which there are few.
      is_lower_.push_back(random.Below(150) == 0);
      if (is_lower_.back()) {
        mesh_.Add({x, 0, 0}, {x, 1, 0}, {x, 0, 1});
      } else {
        mesh_.Add({x, 1, 1}, {x, 1, 0}, {x, 0, 1});
      }
    }
    const TriangleMesh view = mesh_.View();
    scene = std::make_unique<SceneParts>(SceneParts{GeometryTable({&view, 1})});
    for (uint32_t i = 0; i < leaves; ++i) order_.push_back(i | KeptOrder::kLastOfLeaf);
    nodes_.resize(kLevels);
    for (size_t level = 0; level < kLevels; ++level) {
      const bool is_last = level + 1 == kLevels;
      Box boxes[8];
      const Box* children[8];
      ChildWord words[8];
      for (size_t k = 0; k < 8; ++k) {
        children[k] = &boxes[k];
        const size_t leaf = 7 * level + k;
        const bool is_leaf = k < 7 || is_last;
        boxes[k] = BoxOf(leaf, is_leaf ? leaf : leaves - 1);
        words[k] = is_leaf ? ChildWord::Range(static_cast<uint32_t>(leaf))
                           : ChildWord::Inner(static_cast<uint32_t>(level + 1));
      }
      EncodeChildren(children, 8, nodes_[level]);
      for (size_t k = 0; k < 8; ++k) nodes_[level].SetChild(k, words[k]);
      nodes_[level].SetLeavesDone();
    }
  }

  PartitionView View() { return {nodes_.data(), order_.data(), nullptr}; }
  size_t leaves() const { return order_.size(); }

  /// By the loop over all triangles.
  Answer Expected(const RayRecord& ray) const {
    const float org = ray.org[0];
    Answer nearest{kInfinity, UINT32_MAX};
    for (size_t i = 0; i < leaves(); ++i) {
      const float x = static_cast<float>(leaves() - i);
      const bool is_lower = ray.org[1] + ray.org[2] < 1;
      if (is_lower != is_lower_[i]) continue;
      const float t = (x - org) * ray.dir[0];
      if (t > 0 && t < nearest.t) nearest = {t, static_cast<uint32_t>(i)};
    }
    return nearest;
  }

  std::unique_ptr<SceneParts> scene;

 private:
  Box BoxOf(size_t first, size_t last) const {
    Box box = Box::Empty();
    for (const size_t i : {first, last}) {
      for (int corner = 0; corner < 3; ++corner) box.Extend(mesh_.Corner(i, corner).data());
      box.lower[1] = box.lower[2] = 0;
      box.upper[1] = box.upper[2] = 1;
    }
    return box;
  }

  Mesh mesh_;
  std::vector<bool> is_lower_;
  std::vector<uint32_t> order_;
  std::vector<WideNode> nodes_;
};

// Each ray alone has more open children than its stack holds, and goes on below, on another one;
// what stays open is looked at afterwards. Lists have room for no level, some levels, or all.
void DeeperThanAnyStack() {
  Random random(1);
  for (int round = 0; round < 6; ++round) {
    DeepChain chain(random);
    static_assert(7 * DeepChain::kLevels > 4 * OpenChildren::kMost);
    std::vector<RayRecord> rays;
    std::vector<Answer> expected, expected_any;
    for (int i = 0; i < 60; ++i) {
      // From the near end, from the far one, and from between.
      const float end = static_cast<float>(chain.leaves() + 10);
      const float y = random.Uniform(0.05f, 0.4f), z = random.Uniform(0.05f, 0.4f);
      Float3 org = {0, y, z}, dir = {1, 0, 0};
      if (i % 3 == 1) {
        org[0] = end;
        dir = {-1, 0, 0};
      }
      if (i % 3 == 2) org[0] = static_cast<float>(random.Below(1400)) + 0.5f;
      if (i % 7 == 0) org[1] += 0.5f, org[2] += 0.5f;  // through the other halves
      rays.push_back(RecordOf(org, dir));
      expected.push_back(chain.Expected(rays.back()));
      const bool is_hit = expected.back().primitive != UINT32_MAX;
      expected_any.push_back({is_hit ? -1.0f : 1.0f, 0});
    }
    Tracer tracer(*chain.scene, chain.View(), ChildWord::Inner(0));
    for (const size_t bytes : {size_t{0}, size_t{64}, ListBytes(60) - 1, ListBytes(60),
                               3 * ListBytes(60), 20 * ListBytes(60), 300 * ListBytes(60)}) {
      for (const bool keeps : {true, false}) {
        const Way way{bytes, keeps};
        ASSERT_EQ(tracer.Trace<Query::kClosest>(rays, way), expected) << bytes << " bytes";
        ASSERT_EQ(tracer.Trace<Query::kAny>(rays, way), expected_any) << bytes << " bytes";
      }
    }
    // Alone, which is how single rays come.
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(tracer.Trace<Query::kClosest>({rays[i]}, {0, true})[0], expected[i]) << "ray " << i;
      ASSERT_EQ(tracer.Trace<Query::kAny>({rays[i]}, {0, true})[0], expected_any[i]) << "ray " << i;
    }
  }
}

/// A soup, of which something may be kept.
struct Soup {
  Soup(Random& random, size_t count) {
    mesh = unit::MakeSoup(random, count, 1, 0.15f);
    const TriangleMesh view = mesh.View();
    scene = std::make_unique<SceneParts>(SceneParts{GeometryTable({&view, 1})});
  }

  /// With a partition of `budget` bytes.
  void Keep(size_t budget) {
    tasks = std::make_unique<TaskPool>(1);
    scene->kept = std::make_unique<KeptPartition>(scene->geometries, budget, kFirstLook, *tasks);
  }

  Mesh mesh;
  std::unique_ptr<TaskPool> tasks;
  std::unique_ptr<SceneParts> scene;
};

/// By a loop over all triangles, each of which is a leaf.
std::vector<Answer> ByBruteForce(const Soup& soup, const std::vector<RayRecord>& rays) {
  std::vector<Answer> nearest(rays.size(), {kInfinity, UINT32_MAX});
  std::vector<uint32_t> order(soup.mesh.triangles.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i | KeptOrder::kLastOfLeaf;
  for (uint32_t i = 0; i < order.size(); ++i) {
    Tracer tracer(*soup.scene, {nullptr, order.data(), nullptr}, ChildWord::Range(i));
    const auto answers = tracer.Trace<Query::kClosest>(rays, {0, false});
    for (size_t k = 0; k < rays.size(); ++k) {
      if (answers[k].t < nearest[k].t) nearest[k] = answers[k];
    }
  }
  return nearest;
}

// Through partitions of any budget, with any memory of lists, with and without memory to split in:
// what a loop over all triangles finds.
void EveryBudgetAndEveryMemory() {
  Random random(2);
  Soup soup(random, 2500);
  std::vector<RayRecord> rays;
  for (int i = 0; i < 60; ++i)
    rays.push_back(RecordOf(random.InCube(-1.2f, 1.2f), random.Direction()));
  const auto expected = ByBruteForce(soup, rays);
  std::vector<Answer> expected_any;
  size_t hits = 0;
  for (const Answer& answer : expected) {
    expected_any.push_back({answer.primitive != UINT32_MAX ? -1.0f : 1.0f, 0});
    hits += answer.primitive != UINT32_MAX;
  }
  ASSERT_GT(hits, 10u);
  const size_t least = KeptPartition::LeastBytes(2500);
  for (const size_t budget : {least, least + 4000, size_t{8 * 2500}, size_t{32 * 2500}}) {
    for (const size_t bytes : {size_t{0}, 2 * ListBytes(20), 20 * ListBytes(60)}) {
      for (const bool has_scratch : {false, true}) {
        for (const bool keeps : {true, false}) {
          SCOPED_TRACE(std::to_string(budget) + " bytes kept, " + std::to_string(bytes) +
                       " of lists" + (has_scratch ? "" : ", no scratch"));
          soup.Keep(budget);
          // Twice: through what the first call has left.
          for (int call = 0; call < 2; ++call) {
            Tracer tracer(*soup.scene, soup.scene->partition(), soup.scene->kept->root());
            const Way way{bytes, keeps, has_scratch};
            ASSERT_EQ(tracer.Trace<Query::kClosest>(rays, way), expected);
            ASSERT_EQ(tracer.Trace<Query::kAny>(rays, way), expected_any);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(TraceListTest);
HWY_EXPORT_AND_TEST_P(TraceListTest, DeeperThanAnyStack);
HWY_EXPORT_AND_TEST_P(TraceListTest, EveryBudgetAndEveryMemory);

}  // namespace dacrt
#endif  // HWY_ONCE

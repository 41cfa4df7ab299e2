// The memory of one call: one block whose size is known before the call, cut into arrays.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "geometry/triangle_refs.h"
#include "paper/ray_batch.h"
#include "rays/ray_lists.h"
#include "rays/ray_record.h"
#include "runtime/memory_account.h"
#include "runtime/pages.h"
#include "runtime/scratch.h"

namespace dacrt {

/// What of a scene decides how much memory its calls need, beside its triangles.
struct SceneTraits {
  bool is_plain = true;  ///< nothing but still triangles
  bool has_instances = false;
  bool has_callbacks = false;
};

/// The formula: what a thread needs for pieces of R rays of a call.
///
/// With a kept partition
///   bytes = kRecordBytes * R + kListLevels * ListBytes(R)
///           + kTagBytes * tags + kInstanceRayBytes * instance_rays + kConstantBytes
///
/// records: each has one, a full hit, and its number.
///
/// tags: one a ray in scenes with functions of the program's, which see them.
///
/// instance_rays: in scenes with instances, those that go down one together, at most R; each has
/// a record, a full hit, and its number outside.
///
/// lists: a visit of a node takes three bytes for each of its rays (trace/trace_task.h). The lists
/// of kListLevels levels fit if every ray were in each; as a rule they get shorter from level to
/// level. Where they do not fit, rays go on one by one, which takes none.
///
/// Where nothing is kept
///   bytes = kRefBytes * refs + (kSlotBytes + 1/8) * slots + kRayBytes * rays
///           + kConeBytes * cones + kFullHitBytes * full_hits + kConstantBytes
///
/// refs: one for each triangle. Space partition (mora2011) has as many again for the triangles that
/// straddle a cut; where they do not suffice, objects are partitioned instead.
///
/// slots: places for rays, one each in the piece itself, and more in the blocks of its survivors,
/// which are stacked. A child of which more than half would survive shares its parent's block, so
/// each block is at most half of the one below it, and one more a ray suffices (nabata2013).
/// Methods that always filter get nine. Copies that do not fit are not made, and the child is
/// solved with its parent's rays. Each slot has nine fields of four bytes, and a bit that says
/// whether the ray survived.
///
/// rays: each has a hit and a mask.
///
/// cones: for space partition; one for 64 rays, and its place in stacked lists.
///
/// full_hits: one a ray for scenes of more than still triangles.
struct WorkspaceShape {
  /// How many lists of all packets the stack of lists can hold.
  static constexpr std::size_t kPacketLists = 48;

  static constexpr std::size_t kRefBytes = sizeof(TriangleRef);
  static constexpr std::size_t kSlotBytes = RayBatch::kFields * sizeof(float);
  static constexpr std::size_t kConeBytes = 6 * sizeof(float) + kPacketLists * sizeof(RayBlock);
  static constexpr std::size_t kFullHitBytes = sizeof(FullHit);
  static constexpr std::size_t kRayBytes = sizeof(PaperHit) + sizeof(uint32_t);
  static constexpr std::size_t kRecordBytes =
      sizeof(RayRecord) + sizeof(FullHit) + sizeof(uint32_t);
  static constexpr std::size_t kInstanceRayBytes =
      sizeof(RayRecord) + sizeof(FullHit) + sizeof(RayNumber);
  static constexpr std::size_t kTagBytes = sizeof(RayTag);
  static constexpr std::size_t kListLevels = 16;
  /// Slots that rounding every block of a deep recursion up to whole vectors can take.
  static constexpr std::size_t kSpareSlots = 128 * kMaxLanes;
  /// Scratch, and what aligning the arrays takes.
  static constexpr std::size_t kConstantBytes = sizeof(Scratch) + 16 * 1024;

  /// Scratch alone.
  WorkspaceShape() = default;

  /// For pieces of `piece_rays` rays over a kept partition.
  static WorkspaceShape ForKept(std::size_t piece_rays, const SceneTraits& scene);

  /// For pieces of `rays` rays by the published methods.
  static WorkspaceShape ForPaper(std::size_t triangles, std::size_t rays, bool is_plain,
                                 const Settings& settings);

  std::size_t Bytes() const {
    return kRefBytes * refs + kSlotBytes * slots + slots / 8 + kRayBytes * rays +
           kConeBytes * cones + kFullHitBytes * full_hits + kRecordBytes * records + list_bytes +
           kTagBytes * tags + kInstanceRayBytes * instance_rays + kConstantBytes;
  }

  std::size_t records = 0;
  std::size_t list_bytes = 0;
  std::size_t tags = 0;
  std::size_t instance_rays = 0;

  std::size_t refs = 0;
  std::size_t slots = 0;
  std::size_t rays = 0;
  std::size_t cones = 0;
  std::size_t full_hits = 0;
};

/// One block of memory, kept between calls and grown when a call needs more.
class Workspace {
 public:
  /// Makes room for `shape` and lays the arrays out; their contents are undefined.
  /// Throws std::bad_alloc; the workspace is then empty.
  void Reserve(const WorkspaceShape& shape);

  std::size_t bytes() const { return memory_.bytes(); }
  Scratch& scratch() const { return *scratch_; }

  RayRecord* rays() const { return records_; }
  FullHit* hits() const { return hits_; }
  uint32_t* callers() const { return callers_; }
  RayTag* tags() const { return tags_; }
  ListMemory lists() const { return lists_; }
  InstanceMemory instance_memory() const { return instance_memory_; }

  std::span<TriangleRef> refs() const { return refs_; }
  /// The empty batch.
  const RayBatch& batch() const { return batch_; }

 private:
  Pages memory_;
  Scratch* scratch_ = nullptr;
  RayRecord* records_ = nullptr;
  FullHit* hits_ = nullptr;
  uint32_t* callers_ = nullptr;
  RayTag* tags_ = nullptr;
  ListMemory lists_{};
  InstanceMemory instance_memory_{};
  std::span<TriangleRef> refs_;
  RayBatch batch_{};
};

/// The workspaces of a device. Threads: any number may use a pool at once.
class WorkspacePool {
 public:
  /// `memory` is told of all workspaces, and must outlive the pool.
  explicit WorkspacePool(const MemoryAccount& memory) : memory_(memory) {}
  ~WorkspacePool() { ReleaseIdle(); }

  /// A workspace on loan; goes back when this is destroyed.
  class Loan {
   public:
    explicit Loan(WorkspacePool& pool);
    ~Loan();
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    Workspace* operator->() const { return workspace_.get(); }
    Workspace& operator*() const { return *workspace_; }

    /// Workspace::Reserve, counted by the pool.
    void Reserve(const WorkspaceShape& shape);

   private:
    WorkspacePool& pool_;
    std::unique_ptr<Workspace> workspace_;
  };

  /// Sees to it that there is a workspace for `shape`, which calls find when there is no more
  /// memory. Throws std::bad_alloc.
  void KeepFloor(const WorkspaceShape& shape);

  std::size_t BytesHeld() const;
  /// All of them, the floor included: the next call takes memory anew.
  void ReleaseIdle();
  /// Those that are not the largest, so that the floor stays.
  void ReleaseSpare();

 private:
  /// Gives back all idle ones but the largest `kept`.
  void ReleaseAllBut(std::size_t kept);

  const MemoryAccount& memory_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> idle_;  ///< smallest first; with room for those on loan
  std::size_t workspaces_ = 0;                    ///< idle or on loan
  std::size_t bytes_held_ = 0;                    ///< idle or on loan
};

}  // namespace dacrt

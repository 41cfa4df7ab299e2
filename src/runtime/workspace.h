// The memory of one call: one block whose size is known before the call, cut into arrays.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "geometry/triangle_refs.h"
#include "rays/ray_batch.h"
#include "runtime/memory_account.h"
#include "runtime/pages.h"
#include "runtime/scratch.h"

namespace dacrt {

/// The formula: what a call with `triangles` triangles and pieces of `rays` rays needs.
///
///   bytes = kRefBytes * refs + (kSlotBytes + 1/8) * slots + kRayBytes * rays
///           + kConeBytes * cones + (kPacketSlotBytes + 1/8) * packet_slots
///           + kFullHitBytes * full_hits + 4 * outer_slots + kConstantBytes
///
/// refs: one for each triangle, unless the partition is kept. Space partition (mora2011) has as
/// many again for the triangles that straddle a cut; where they do not suffice, objects are
/// partitioned instead.
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
/// packet_slots: places for packets of 16 coherent rays, where the partition is kept: six a packet.
/// Packets are always filtered in front of leaves, so that blocks do not halve as those of rays do.
///
/// full_hits: one a ray for scenes of more than still triangles.
///
/// outer_slots: one a ray for rays in the space of an instance.
struct WorkspaceShape {
  /// How many lists of all packets the stack of lists can hold.
  static constexpr std::size_t kPacketLists = 48;

  static constexpr std::size_t kRefBytes = sizeof(TriangleRef);
  static constexpr std::size_t kSlotBytes = RayBatch::kFields * sizeof(float);
  static constexpr std::size_t kConeBytes = 6 * sizeof(float) + kPacketLists * sizeof(RayBlock);
  static constexpr std::size_t kPacketSlotBytes = PacketBatch::kFields * sizeof(float);
  static constexpr std::size_t kFullHitBytes = sizeof(FullHit);
  static constexpr std::size_t kRayBytes = sizeof(Hit) + sizeof(uint32_t);
  /// Slots that rounding every block of a deep recursion up to whole vectors can take.
  static constexpr std::size_t kSpareSlots = 128 * kMaxLanes;
  /// Scratch, and what aligning the arrays takes.
  static constexpr std::size_t kConstantBytes = sizeof(Scratch) + 16 * 1024;

  /// For pieces of `rays` rays. `keeps`: the partition is kept elsewhere, whatever the settings
  /// say.
  WorkspaceShape(std::size_t triangles, std::size_t rays, bool keeps, const Settings& settings);

  std::size_t Bytes() const {
    return kRefBytes * refs + kSlotBytes * slots + slots / 8 + kRayBytes * rays +
           kConeBytes * cones + kPacketSlotBytes * packet_slots + packet_slots / 8 +
           kFullHitBytes * full_hits + sizeof(uint32_t) * outer_slots + kConstantBytes;
  }

  std::size_t refs;
  std::size_t slots;
  std::size_t rays;
  std::size_t cones;
  std::size_t packet_slots;
  std::size_t full_hits = 0;
  std::size_t outer_slots = 0;
};

/// One block of memory, kept between calls and grown when a call needs more.
class Workspace {
 public:
  /// Makes room for `shape` and lays the arrays out; their contents are undefined.
  /// Throws std::bad_alloc; the workspace is then empty.
  void Reserve(const WorkspaceShape& shape);

  std::size_t bytes() const { return memory_.bytes(); }
  std::span<TriangleRef> refs() const { return refs_; }
  /// The empty batch.
  const RayBatch& batch() const { return batch_; }
  const PacketBatch& packets() const { return packets_; }
  /// Where the rays of an instance stand in the batch of the scene that it is in.
  std::span<uint32_t> outer_slots() const { return outer_slots_; }
  Scratch& scratch() const { return *scratch_; }

 private:
  Pages memory_;
  std::span<TriangleRef> refs_;
  std::span<uint32_t> outer_slots_;
  Scratch* scratch_ = nullptr;
  RayBatch batch_{};
  PacketBatch packets_{};
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

  /// Sees to it that there is a workspace for `shape`, which calls find when no more memory can be
  /// had. Throws std::bad_alloc.
  void KeepFloor(const WorkspaceShape& shape);

  std::size_t BytesHeld() const;
  /// All of them, the floor included: the next call takes memory anew.
  void ReleaseIdle();
  /// Those that are not the largest, so that the floor stays.
  void ReleaseSpare();

 private:
  std::vector<std::unique_ptr<Workspace>> TakeIdle(std::size_t count);
  void Release(std::vector<std::unique_ptr<Workspace>> workspaces);

  const MemoryAccount& memory_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> idle_;  ///< smallest first; with room for those on loan
  std::size_t workspaces_ = 0;                    ///< idle or on loan
  std::size_t bytes_held_ = 0;                    ///< idle or on loan
};

}  // namespace dacrt

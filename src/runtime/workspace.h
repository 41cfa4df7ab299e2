// The memory of one call: one block whose size is known before the call, cut into arrays.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "geometry/triangle_refs.h"
#include "rays/ray_batch.h"
#include "solve/scratch.h"

namespace dacrt {

/// The formula. `triangles` counts all triangles of a scene, `rays` those of a piece:
///   kTriangleBytes * triangles + kRayBytes * rays + kConstantBytes.
///
/// A triangle needs its reference. A ray needs its hit (16), its mask (4), and twice nine fields of
/// four bytes: once in the piece itself, once in the blocks of its survivors. Those are stacked, and
/// a child of which more than half would survive shares its parent's block, so each block is at
/// most half of the one below it. (Where the sample misjudged a child, its block may not fit; then
/// that child is not filtered either.) One bit a slot says which rays of a block survived.
struct WorkspaceSize {
  static constexpr std::size_t kTriangleBytes = sizeof(TriangleRef);
  static constexpr std::size_t kFields = 9;
  static constexpr std::size_t kRayBytes =
      2 * kFields * sizeof(float) + 1 + sizeof(Hit) + sizeof(uint32_t);
  /// Slots that rounding every block of a deep recursion up to whole vectors can take.
  static constexpr std::size_t kSpareSlots = 128 * kMaxLanes;
  static constexpr std::size_t kConstantBytes =
      kSpareSlots * (kFields * sizeof(float) + 1) + sizeof(Scratch) + 64 * 1024;

  static constexpr std::size_t Bytes(std::size_t triangles, std::size_t rays) {
    return kTriangleBytes * triangles + kRayBytes * rays + kConstantBytes;
  }
};

/// One block of memory, kept between calls and grown when a call needs more.
class Workspace {
 public:
  Workspace() = default;
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  /// Makes room for `triangles` and `rays` and lays the arrays out; their contents are undefined.
  /// Throws std::bad_alloc; the workspace is then empty.
  void Reserve(std::size_t triangles, std::size_t rays);

  std::size_t bytes() const { return bytes_; }
  TriangleRef* refs() const { return refs_; }
  /// The empty batch.
  const RayBatch& batch() const { return batch_; }
  Scratch& scratch() const { return *scratch_; }

 private:
  void Free();

  std::byte* memory_ = nullptr;
  std::size_t bytes_ = 0;
  TriangleRef* refs_ = nullptr;
  Scratch* scratch_ = nullptr;
  RayBatch batch_{};
};

/// The workspaces of a device. Threads: any number may use a pool at once.
class WorkspacePool {
 public:
  /// A workspace on loan; goes back when this is destroyed.
  class Loan {
   public:
    explicit Loan(WorkspacePool& pool);
    ~Loan();
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    Workspace* operator->() const { return workspace_.get(); }

    /// Workspace::Reserve, counted by the pool.
    void Reserve(std::size_t triangles, std::size_t rays);

   private:
    WorkspacePool& pool_;
    std::unique_ptr<Workspace> workspace_;
  };

  std::size_t BytesHeld() const;
  void ReleaseIdle();

 private:
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> idle_;
  std::size_t bytes_held_ = 0;  ///< idle or on loan
};

}  // namespace dacrt

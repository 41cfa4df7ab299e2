#include "runtime/workspace.h"

#include <algorithm>
#include <utility>

#include "runtime/assert.h"

namespace dacrt {
namespace {

constexpr std::size_t kAlignment = 64;

constexpr std::size_t RoundUp(std::size_t value, std::size_t multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

/// Cuts arrays off the front of a block.
class Cutter {
 public:
  explicit Cutter(std::byte* memory) : next_(memory) {}

  template <class T>
  T* Cut(std::size_t count) {
    T* array = reinterpret_cast<T*>(next_);
    next_ += RoundUp(count * sizeof(T), kAlignment);
    return array;
  }

  /// Moves on by some cache lines.
  void Skip(std::size_t lines) { next_ += lines * kAlignment; }

  std::byte* next() const { return next_; }

 private:
  std::byte* next_;
};

}  // namespace

WorkspaceShape WorkspaceShape::ForKept(std::size_t piece_rays, const SceneTraits& scene) {
  WorkspaceShape shape;
  shape.records = piece_rays;
  shape.list_bytes = kListLevels * ListBytes(piece_rays);
  shape.tags = scene.has_callbacks ? piece_rays : 0;
  shape.instance_rays = scene.has_instances ? std::min(piece_rays, InstanceMemory::kRays) : 0;
  return shape;
}

WorkspaceShape WorkspaceShape::ForPaper(std::size_t triangles, std::size_t rays, bool is_plain,
                                        const Settings& settings) {
  // Copies of a ray that methods without skipping get. With four, a million diffuse rays in an
  // atrium took 2.3 (afra2012) and 1.8 (mora2011) times the box tests, because children had to do
  // with their parents' rays; with eighteen no test less.
  constexpr std::size_t kCopiesOfUnskipped = 9;
  const bool skips = settings.algorithm == Algorithm::kNabata2013 && settings.skip_filtering;
  const bool cuts_space = settings.algorithm == Algorithm::kMora2011;
  WorkspaceShape shape;
  shape.rays = rays;
  shape.refs = cuts_space ? 2 * triangles : triangles;
  shape.cones = cuts_space ? (rays + ConicPackets::kRays - 1) / ConicPackets::kRays : 0;
  shape.slots = RoundUp((1 + (skips ? 1 : kCopiesOfUnskipped)) * rays + kSpareSlots, kMaxLanes);
  shape.full_hits = is_plain ? 0 : rays;
  return shape;
}

void Workspace::Reserve(const WorkspaceShape& shape) {
  const std::size_t bytes = shape.Bytes();
  if (bytes > memory_.bytes()) {
    memory_ = Pages();  // first, so that there are never two
    memory_ = Pages(bytes);
  }
  Cutter cutter(memory_.data());
  scratch_ = cutter.Cut<Scratch>(1);
  records_ = cutter.Cut<RayRecord>(shape.records);
  callers_ = cutter.Cut<uint32_t>(shape.records);
  tags_ = cutter.Cut<RayTag>(shape.tags);
  lists_.top = cutter.Cut<std::byte>(shape.list_bytes);
  lists_.end = lists_.top + shape.list_bytes;
  instance_memory_.count = shape.instance_rays;
  instance_memory_.rays = cutter.Cut<RayRecord>(shape.instance_rays);
  instance_memory_.hits = cutter.Cut<FullHit>(shape.instance_rays);
  instance_memory_.outer_rays = cutter.Cut<RayNumber>(shape.instance_rays);
  // Behind all that calls write to: where scenes are plain nobody does, and no page is taken.
  hits_ = cutter.Cut<FullHit>(shape.records);
  refs_ = {cutter.Cut<TriangleRef>(shape.refs), shape.refs};
  // The fields are read and written side by side; at equal offsets in their pages they would
  // compete for the same lines of the cache, so each begins five lines further into its page.
  const auto cut_field = [&]<class T>(T*& field) {
    field = cutter.Cut<T>(shape.slots);
    cutter.Skip(5);
  };
  for (float*& field : batch_.org) cut_field(field);
  for (float*& field : batch_.dir) cut_field(field);
  cut_field(batch_.tnear);
  cut_field(batch_.tfar);
  cut_field(batch_.index);
  batch_.capacity = shape.slots;
  batch_.top = 0;
  batch_.bits_capacity = shape.slots / 8;
  batch_.lane_bits = cutter.Cut<uint8_t>(batch_.bits_capacity);
  batch_.bits_top = 0;
  batch_.hits = cutter.Cut<PaperHit>(shape.rays);
  batch_.full_hits = cutter.Cut<FullHit>(shape.full_hits);
  for (float*& axis : batch_.cones.axis) axis = cutter.Cut<float>(shape.cones);
  batch_.cones.tangent = cutter.Cut<float>(shape.cones);
  batch_.cones.longest = cutter.Cut<float>(shape.cones);
  batch_.cones.reach = cutter.Cut<float>(shape.cones);
  const std::size_t listed = WorkspaceShape::kPacketLists * shape.cones;
  batch_.packets = {cutter.Cut<RayBlock>(listed), listed};
  batch_.ray_masks = cutter.Cut<uint32_t>(shape.rays);
  DACRT_ASSERT(cutter.next() <= memory_.data() + bytes);
}

WorkspacePool::Loan::Loan(WorkspacePool& pool) : pool_(pool) {
  const std::lock_guard lock(pool_.mutex_);
  if (pool_.idle_.empty()) {
    // Room for its return, which must not fail.
    pool_.idle_.reserve(pool_.workspaces_ + 1);
    workspace_ = std::make_unique<Workspace>();
    ++pool_.workspaces_;
  } else {
    workspace_ = std::move(pool_.idle_.back());
    pool_.idle_.pop_back();
  }
}

WorkspacePool::Loan::~Loan() {
  const std::lock_guard lock(pool_.mutex_);
  DACRT_ASSERT(pool_.idle_.size() < pool_.idle_.capacity());  // room that the loan made
  // The largest one is lent next.
  const auto place = std::find_if(pool_.idle_.begin(), pool_.idle_.end(), [&](const auto& other) {
    return other->bytes() > workspace_->bytes();
  });
  pool_.idle_.insert(place, std::move(workspace_));
}

void WorkspacePool::Loan::Reserve(const WorkspaceShape& shape) {
  const std::size_t before = workspace_->bytes();
  const std::size_t more = shape.Bytes() > before ? shape.Bytes() - before : 0;
  // Outside the lock: a monitor may call us.
  pool_.memory_.Take(more);
  const auto count = [&] {
    const std::lock_guard lock(pool_.mutex_);
    pool_.bytes_held_ += workspace_->bytes() - before;
  };
  try {
    workspace_->Reserve(shape);
  } catch (...) {
    count();
    pool_.memory_.Give(before + more);
    throw;
  }
  count();
}

void WorkspacePool::KeepFloor(const WorkspaceShape& shape) {
  Loan loan(*this);
  loan.Reserve(shape);
}

std::size_t WorkspacePool::BytesHeld() const {
  const std::lock_guard lock(mutex_);
  return bytes_held_;
}

void WorkspacePool::ReleaseIdle() { ReleaseAllBut(0); }

void WorkspacePool::ReleaseSpare() { ReleaseAllBut(1); }

/// One after the other, which takes no memory: it is called where there is none, and at the end.
void WorkspacePool::ReleaseAllBut(std::size_t kept) {
  for (;;) {
    std::unique_ptr<Workspace> smallest;
    {
      const std::lock_guard lock(mutex_);
      if (idle_.size() <= kept) return;
      smallest = std::move(idle_.front());
      idle_.erase(idle_.begin());  // which leaves the room for those on loan
      bytes_held_ -= smallest->bytes();
      --workspaces_;
    }
    const std::size_t bytes = smallest->bytes();
    smallest.reset();
    memory_.Give(bytes);
  }
}

}  // namespace dacrt

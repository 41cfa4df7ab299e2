// The closest hit of a call of one ray, on its way, and what may become it.

#if defined(DACRT_TRACE_LONE_HIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_LONE_HIT_INL_H_
#undef DACRT_TRACE_LONE_HIT_INL_H_
#else
#define DACRT_TRACE_LONE_HIT_INL_H_
#endif

#include "leaf/found_in_part-inl.h"
#include "leaf/own_box-inl.h"
#include "rays/write_record-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Either among the triangles of a leaf, with what the triangle test has found, because a nearer
/// one may follow; or as it is.
class LoneHit {
 public:
  LoneHit() {}  // nothing is cleared

  /// The triangle in a lane of a part of a block.
  HWY_INLINE void Keep(const SceneParts& scene, uint32_t instance_id, const LeafBlock& block,
                       size_t part, size_t lane, const FacetCrossing& crossing,
                       const EightPart* normals) {
    scene_ = &scene;
    instance_id_ = instance_id;
    block_ = &block;
    part_ = part;
    lane_ = lane;
    hwy::Prefetch(scene.kept->triangles().data() + block.first);  // for its name, wanted last
    found_.Keep(crossing, normals);
  }

  HWY_INLINE void Set(const FullHit& hit, uint32_t geometry) {
    block_ = nullptr;
    hit_ = hit;
    geometry_ = geometry;
  }

  /// The same to be looked at in its place; computed once.
  HWY_INLINE const FullHit& Full() {
    if (block_ != nullptr) Set(OfLane(lane_), geometry());
    return hit_;
  }

  HWY_INLINE FullHit Get() const { return HWY_LIKELY(block_ != nullptr) ? OfLane(lane_) : hit_; }

  /// Writes it to a record that the caller will look at at once. What was just computed goes from
  /// registers there.
  HWY_INLINE void Write(float* record) const {
    if (HWY_LIKELY(block_ != nullptr)) {
      WriteRecordAtOnce(OfLane(lane_), record);
    } else {
      WriteRecordAtOnce(hit_, record);
    }
  }

  /// What a hit of another lane of the triangles that were kept last would be.
  HWY_INLINE FullHit OfLane(size_t lane) const {
    const size_t block_lane = part_ * kPartLanes + lane;
    return found_.Hit(lane, *scene_, instance_id_, NameOf(lane), block_->second >> block_lane & 1);
  }

  HWY_INLINE GeometryTable::Name NameOf(size_t lane) const {
    return NameOfLane(scene_->geometries, scene_->kept->triangles().data(), *block_,
                      part_ * kPartLanes + lane);
  }

  HWY_INLINE uint32_t NumberOf(size_t lane) const {
    return NumberOfLane(scene_->kept->triangles().data(), *block_, part_ * kPartLanes + lane);
  }
  uint32_t number() const { return NumberOf(lane_); }

  /// Whether it is among the triangles of a leaf of this scene, in this instance.
  bool IsIn(const SceneParts& scene, uint32_t instance_id) const {
    return block_ != nullptr && scene_ == &scene && instance_id_ == instance_id;
  }

  /// Whether it is among the triangles of a block.
  bool IsIn(const LeafBlock* block) const { return block_ == block; }

  /// Another lane of the triangles that were kept last.
  void SetLane(size_t lane) { lane_ = lane; }

  /// The geometry that was hit, of the scene in which it stands.
  uint32_t geometry() const { return block_ != nullptr ? NameOf(lane_).geometry : geometry_; }

 private:
  const SceneParts* scene_;
  uint32_t instance_id_;
  const LeafBlock* block_ = nullptr;
  size_t part_, lane_;
  FoundInPart found_;
  FullHit hit_;
  uint32_t geometry_;
};

/// Triangles of a part of a block that a ray meets, of which others say whether they are its hits.
class LoneCandidates {
 public:
  LoneCandidates() {}  // nothing is cleared but what says that there are none

  HWY_INLINE void Keep(const SceneParts& scene, uint32_t instance_id, const LeafBlock& block,
                       size_t part, const FacetCrossing& crossing, EightPart key,
                       const EightPart* normals) {
    hits_.Keep(scene, instance_id, block, part, 0, crossing, normals);
    hn::Store(key, kEightTag, keys_);
    lanes_ = crossing.lanes;
    within_limit_ = crossing.within_limit;
  }

  bool is_empty() const { return lanes_ == 0; }
  void Clear() { lanes_ = 0; }

  /// The lane of the nearest, which is none of them any more.
  HWY_INLINE size_t TakeNearest() {
    const size_t nearest = NearestLane(lanes_, keys_);
    lanes_ &= ~(uint64_t{1} << nearest);
    return nearest;
  }

  /// Any lane, which is none of them any more.
  HWY_INLINE size_t TakeAny() {
    const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes_);
    lanes_ &= lanes_ - 1;
    return lane;
  }

  float key(size_t lane) const { return keys_[lane]; }
  bool within_limit(size_t lane) const { return (within_limit_ >> lane & 1) != 0; }
  uint32_t geometry(size_t lane) const { return hits_.NameOf(lane).geometry; }
  uint32_t number(size_t lane) const { return hits_.NumberOf(lane); }
  HWY_INLINE FullHit Hit(size_t lane) const { return hits_.OfLane(lane); }
  void CopyHit(size_t lane, LoneHit& hit) const {
    hit = hits_;
    hit.SetLane(lane);
  }

 private:
  LoneHit hits_;
  HWY_ALIGN float keys_[kPartLanes];
  uint64_t lanes_ = 0;
  uint64_t within_limit_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_LONE_HIT_INL_H_

// A geometry as the program describes it, call by call.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "callbacks.h"
#include "dacrt/dacrt.h"
#include "geometry_buffers.h"

namespace dacrt::compat {

/// Changes mark a geometry modified until the program commits it, except where Embree does not ask
/// for a commit either: user data, enabling, callbacks, transforms, buffers with as many primitives
/// as before, and counts that stay as they are.
///
/// Threads: like the API, one at a time for one geometry; reading is safe from any number.
class Geometry : public std::enable_shared_from_this<Geometry> {
 public:
  /// Throws RTC_ERROR_INVALID_OPERATION for types that are not supported and RTC_ERROR_UNKNOWN for
  /// numbers that are no type, as Embree does.
  Geometry(std::shared_ptr<Device> device, RTCGeometryType type);
  ~Geometry();
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;

  const std::shared_ptr<Device>& device() const { return device_; }
  RTCGeometryType type() const { return type_; }
  bool IsUser() const { return type_ == RTC_GEOMETRY_TYPE_USER; }
  bool IsInstance() const { return type_ == RTC_GEOMETRY_TYPE_INSTANCE; }

  /// Throws RTC_ERROR_INVALID_OPERATION if the description is not one of a geometry.
  void Commit();
  bool is_modified() const { return is_modified_; }

  /// Grows whenever a scene that holds this geometry needs another commit.
  uint64_t version() const;

  /// Grows whenever Describe would say something else, but for where an instance stands, also where
  /// that alone asks for no commit.
  uint64_t description_version() const;
  /// The same for where an instance stands.
  uint64_t placement_version() const { return placements_; }

  void SetEnabled(bool enabled);
  bool is_enabled() const { return is_enabled_; }

  void SetMask(uint32_t mask);
  void SetBuildQuality(RTCBuildQuality quality);
  RTCBuildQuality build_quality() const { return build_quality_; }
  void SetTimeStepCount(unsigned int count);
  void SetTimeRange(float start, float end);
  void SetVertexAttributeCount(unsigned int count);

  void* user_data() const { return user_data_; }
  void set_user_data(void* data) { user_data_ = data; }

  const GeometryBuffers& buffers() const { return buffers_; }

  /// `change(GeometryBuffers&)` sets a buffer.
  template <class Change>
  void ChangeBuffers(const Change& change) {
    const std::size_t primitives_before = buffers_.PrimitiveCount();
    change(buffers_);
    ++changes_;
    if (buffers_.PrimitiveCount() != primitives_before) SetModified();
  }

  /// Says that the program has changed the contents of a buffer.
  void UpdateBuffer(RTCBufferType type, unsigned int slot);

  // Callbacks. A null function means none.
  void SetClosestFilter(RTCFilterFunctionN filter);
  void SetAnyFilter(RTCFilterFunctionN filter);
  void SetUserPrimitiveCount(unsigned int count);
  void SetBoundsFunction(RTCBoundsFunction function);
  void SetIntersectFunction(RTCIntersectFunctionN function);
  void SetOccludedFunction(RTCOccludedFunctionN function);
  void SetPointQueryFunction(RTCPointQueryFunction function);
  const GeometryCallbacks& callbacks() const { return callbacks_; }

  // Instances.
  /// Throws RTC_ERROR_INVALID_OPERATION if the geometry is in `scene`, or in one that this has an
  /// instance of.
  void SetInstancedScene(std::shared_ptr<Scene> scene);
  void SetTransform(unsigned int time_step, const TransformStep& transform);
  AffineTransform TransformAt(float time) const;
  const std::vector<TransformStep>& transforms() const { return transforms_; }
  const std::shared_ptr<Scene>& instanced_scene() const { return instanced_scene_; }

  /// What a scene cannot do without, and the geometry does not have; null if there is no such
  /// thing.
  const char* Lack() const;

  /// The geometry as it is now, for the engine. Without primitives until all that it needs is set.
  /// `context_filter` says that the context's filter function counts.
  dacrt::Geometry Describe(uint32_t geometry_id, bool context_filter);

  /// Adds what must stay alive beside this while Describe's result is used.
  void AddUsedBuffers(std::vector<std::shared_ptr<const void>>& used) const {
    buffers_.AddUsed(used);
  }

 private:
  void SetModified() {
    is_modified_ = true;
    ++changes_;
  }
  void CheckIsUser() const;
  void CheckIsInstance() const;
  void CheckMayFilter() const;

  // What a commit of the scene asks of each geometry stands together.
  const std::shared_ptr<Device> device_;
  const RTCGeometryType type_;
  RTCBuildQuality build_quality_ = RTC_BUILD_QUALITY_MEDIUM;
  std::shared_ptr<Scene> instanced_scene_;
  uint64_t version_ = 0;
  uint64_t changes_ = 0;     ///< calls that changed the description but for the transforms
  uint64_t placements_ = 0;  ///< calls that changed these
  bool is_enabled_ = true;
  bool is_modified_ = true;
  uint32_t mask_ = UINT32_MAX;
  std::vector<TransformStep> transforms_ = std::vector<TransformStep>(1);
  unsigned int time_steps_ = 1;
  TimeRange time_range_;
  unsigned int user_primitives_ = 0;
  uint64_t revision_ = 0;  ///< of what was committed: no two are the same, whatever geometry's
  void* user_data_ = nullptr;
  GeometryBuffers buffers_;
  GeometryCallbacks callbacks_;
};

inline Device& DeviceOf(Geometry& geometry) { return *geometry.device(); }

}  // namespace dacrt::compat

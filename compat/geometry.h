// A triangle mesh as the program describes it, buffer by buffer.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "buffer.h"
#include "dacrt/dacrt.h"

namespace dacrt::compat {

/// Changes mark a geometry modified until the program commits it, except where Embree does not ask
/// for a commit either: user data, enabling, and setting a buffer.
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

  void Commit();
  bool is_modified() const { return is_modified_; }

  /// Grows whenever a scene that holds this geometry needs another commit.
  uint64_t version() const { return version_; }

  void SetEnabled(bool enabled);
  bool is_enabled() const { return is_enabled_; }

  void SetMask(uint32_t mask);
  void SetBuildQuality(RTCBuildQuality quality);
  void SetTimeStepCount(unsigned int count);
  void SetTimeRange(float start, float end);
  void SetVertexAttributeCount(unsigned int count);

  void* user_data() const { return user_data_; }
  void set_user_data(void* data) { user_data_ = data; }

  /// Makes part of a buffer the one of this type and slot.
  void SetBuffer(RTCBufferType type, unsigned int slot, RTCFormat format, BufferView view);

  /// Makes the program's memory at `data` the buffer of this type and slot.
  void SetSharedBuffer(RTCBufferType type, unsigned int slot, RTCFormat format, void* data,
                       std::size_t stride, std::size_t count);

  /// Makes newly allocated memory, which is returned, the buffer of this type and slot.
  void* SetNewBuffer(RTCBufferType type, unsigned int slot, RTCFormat format, std::size_t stride,
                     std::size_t count);

  /// Where the buffer of this type and slot stands; null if it was not set.
  void* BufferData(RTCBufferType type, unsigned int slot);

  /// Says that the program has changed the contents of a buffer.
  void UpdateBuffer(RTCBufferType type, unsigned int slot);

  /// The mesh as it is now, for the engine. It has no triangles until both buffers are set.
  dacrt::TriangleMesh Mesh(uint32_t geometry_id) const;

  /// What must stay alive while Mesh()'s result is used.
  std::vector<std::shared_ptr<const Buffer>> MeshBuffers() const;

 private:
  BufferView& View(RTCBufferType type, unsigned int slot);
  void CheckBuffer(RTCBufferType type, unsigned int slot, RTCFormat format, const void* data,
                   std::size_t stride, std::size_t count) const;

  const std::shared_ptr<Device> device_;
  BufferView indices_;
  std::vector<BufferView> vertices_ = std::vector<BufferView>(1);  ///< one a time step
  std::vector<BufferView> attributes_;
  void* user_data_ = nullptr;
  uint64_t version_ = 0;
  uint32_t mask_ = UINT32_MAX;
  bool is_enabled_ = true;
  bool is_modified_ = true;
};

inline Device& DeviceOf(Geometry& geometry) { return *geometry.device(); }

}  // namespace dacrt::compat

// The buffers of a geometry: which there are, of what format, and the checks of the API.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "buffer.h"
#include "dacrt/geometry.h"

namespace dacrt::compat {

class GeometryBuffers {
 public:
  GeometryBuffers(std::shared_ptr<Device> device, RTCGeometryType type);

  /// Makes part of a buffer the one of this type and slot.
  void Set(RTCBufferType type, unsigned int slot, RTCFormat format, BufferView view);

  /// Makes the program's memory at `data` the buffer of this type and slot.
  void SetShared(RTCBufferType type, unsigned int slot, RTCFormat format, void* data,
                 std::size_t stride, std::size_t count);

  /// Makes newly allocated memory, which is returned, the buffer of this type and slot.
  void* SetNew(RTCBufferType type, unsigned int slot, RTCFormat format, std::size_t stride,
               std::size_t count);

  /// The buffer of this type and slot, empty if it was not set. Throws RTC_ERROR_INVALID_ARGUMENT
  /// if the geometry has none such, RTC_ERROR_INVALID_OPERATION if it has no buffers at all.
  const BufferView& View(RTCBufferType type, unsigned int slot) const;

  /// By the buffer that makes primitives: indices, grids, or the vertices of points.
  std::size_t PrimitiveCount() const;

  /// Vertices and normals for each time step.
  void SetTimeStepCount(unsigned int count);
  void SetVertexAttributeCount(unsigned int count);

  /// Throws RTC_ERROR_INVALID_OPERATION if the strides of the time steps differ, or if normals are
  /// missing.
  void CheckForCommit() const;

  /// Puts arrays and counts into `geometry`, which has no primitives until all buffers are set.
  void Describe(dacrt::Geometry& geometry) const;

  /// Adds what must stay alive while the arrays are used.
  void AddUsed(std::vector<std::shared_ptr<const void>>& used) const;

 private:
  BufferView& Place(RTCBufferType type, unsigned int slot);
  void Check(RTCBufferType type, unsigned int slot, RTCFormat format, const void* data,
             std::size_t stride, std::size_t count) const;
  void CheckHasAny() const;
  void CheckFormat(RTCBufferType type, RTCFormat format) const;
  bool Has(RTCBufferType type) const;
  std::size_t ItemBytes(RTCBufferType type, RTCFormat format) const;

  const std::shared_ptr<Device> device_;
  const RTCGeometryType geometry_type_;
  BufferView primitives_;                                          ///< indices, or grids
  std::vector<BufferView> vertices_ = std::vector<BufferView>(1);  ///< one a time step
  std::vector<BufferView> normals_ = std::vector<BufferView>(1);   ///< one a time step
  std::vector<BufferView> attributes_;
};

}  // namespace dacrt::compat

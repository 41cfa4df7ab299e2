#include "transform_format.h"

#include "boundary.h"

namespace dacrt::compat {
namespace {

/// Calls `visit(column, row, place)` for each number of a matrix, where it stands in `format`.
template <class Visit>
void ForEachPlace(RTCFormat format, const Visit& visit) {
  int column_stride, row_stride;
  switch (format) {
    case RTC_FORMAT_FLOAT3X4_ROW_MAJOR:
      column_stride = 1;
      row_stride = 4;
      break;
    case RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR:
      column_stride = 3;
      row_stride = 1;
      break;
    case RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR:
      column_stride = 4;
      row_stride = 1;
      break;
    default:
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "format = 0x", std::hex, static_cast<int>(format),
                     " is none of a transform");
  }
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) visit(column, row, column * column_stride + row * row_stride);
  }
}

}  // namespace

TransformStep ReadTransform(RTCFormat format, const float* values) {
  TransformStep step;
  ForEachPlace(format, [&](int column, int row, int place) {
    step.matrix.column[column][row] = values[place];
  });
  return step;
}

void WriteTransform(const AffineTransform& transform, RTCFormat format, float* values) {
  ForEachPlace(format, [&](int column, int row, int place) {
    values[place] = transform.column[column][row];
  });
  if (format != RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR) return;
  for (int column = 0; column < 4; ++column) values[4 * column + 3] = column == 3 ? 1.0f : 0.0f;
}

TransformStep ReadTransform(const RTCQuaternionDecomposition& d) {
  TransformStep step;
  step.in_parts = true;
  step.parts = {{d.scale_x, d.scale_y, d.scale_z},
                d.skew_xy,
                d.skew_xz,
                d.skew_yz,
                {d.shift_x, d.shift_y, d.shift_z},
                {d.quaternion_r, d.quaternion_i, d.quaternion_j, d.quaternion_k},
                {d.translation_x, d.translation_y, d.translation_z}};
  return step;
}

}  // namespace dacrt::compat

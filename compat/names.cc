#include "names.h"

namespace dacrt::compat {

const char* Name(RTCGeometryType type) {
  switch (type) {
    case RTC_GEOMETRY_TYPE_TRIANGLE:
      return "triangle mesh";
    case RTC_GEOMETRY_TYPE_QUAD:
      return "quad mesh";
    case RTC_GEOMETRY_TYPE_GRID:
      return "grid mesh";
    case RTC_GEOMETRY_TYPE_SUBDIVISION:
      return "subdivision surface";
    case RTC_GEOMETRY_TYPE_CONE_LINEAR_CURVE:
    case RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE:
    case RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE:
      return "linear curve";
    case RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE:
    case RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE:
    case RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE:
      return "Bezier curve";
    case RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE:
    case RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE:
    case RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BSPLINE_CURVE:
      return "B-spline curve";
    case RTC_GEOMETRY_TYPE_ROUND_HERMITE_CURVE:
    case RTC_GEOMETRY_TYPE_FLAT_HERMITE_CURVE:
    case RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_HERMITE_CURVE:
      return "Hermite curve";
    case RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE:
    case RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE:
    case RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_CATMULL_ROM_CURVE:
      return "Catmull-Rom curve";
    case RTC_GEOMETRY_TYPE_SPHERE_POINT:
    case RTC_GEOMETRY_TYPE_DISC_POINT:
    case RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT:
      return "point";
    case RTC_GEOMETRY_TYPE_USER:
      return "user geometry";
    case RTC_GEOMETRY_TYPE_INSTANCE:
      return "instance";
  }
  return nullptr;
}

const char* Name(RTCBufferType type) {
  switch (type) {
    case RTC_BUFFER_TYPE_INDEX:
      return "INDEX";
    case RTC_BUFFER_TYPE_VERTEX:
      return "VERTEX";
    case RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE:
      return "VERTEX_ATTRIBUTE";
    case RTC_BUFFER_TYPE_NORMAL:
      return "NORMAL";
    case RTC_BUFFER_TYPE_TANGENT:
      return "TANGENT";
    case RTC_BUFFER_TYPE_NORMAL_DERIVATIVE:
      return "NORMAL_DERIVATIVE";
    case RTC_BUFFER_TYPE_GRID:
      return "GRID";
    case RTC_BUFFER_TYPE_FACE:
      return "FACE";
    case RTC_BUFFER_TYPE_LEVEL:
      return "LEVEL";
    case RTC_BUFFER_TYPE_EDGE_CREASE_INDEX:
      return "EDGE_CREASE_INDEX";
    case RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT:
      return "EDGE_CREASE_WEIGHT";
    case RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX:
      return "VERTEX_CREASE_INDEX";
    case RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT:
      return "VERTEX_CREASE_WEIGHT";
    case RTC_BUFFER_TYPE_HOLE:
      return "HOLE";
    case RTC_BUFFER_TYPE_FLAGS:
      return "FLAGS";
  }
  return "unknown";
}

}  // namespace dacrt::compat

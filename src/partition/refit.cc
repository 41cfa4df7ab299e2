#include "partition/refit.h"

#include <algorithm>

namespace dacrt {
namespace {

bool IsSame(const Array& a, const Array& b) { return a.data == b.data && a.stride == b.stride; }

bool AreSame(const std::vector<Array>& a, const std::vector<Array>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), IsSame);
}

}  // namespace

bool BeginsWithSameItems(const GeometryTable& before, const GeometryTable& now) {
  const Shapes &a = before.shapes(), &b = now.shapes();
  if (a.size() > b.size()) return false;
  for (uint32_t i = 0; i < a.size(); ++i) {
    if (a[i].shape != b[i].shape || a[i].geometry_id != b[i].geometry_id ||
        a.ItemCount(i) != b.ItemCount(i) || a.StepCount(i) != b.StepCount(i) ||
        !IsSame(a[i].primitives, b[i].primitives)) {
      return false;
    }
  }
  return true;
}

bool IsChanged(const Geometry& before, const Geometry& now) {
  return now.revision == 0 || before.revision != now.revision ||
         before.instanced_scene != now.instanced_scene || before.vertex_count != now.vertex_count ||
         !AreSame(before.vertices, now.vertices) || !AreSame(before.normals, now.normals);
}

std::vector<bool> ChangedGeometries(const GeometryTable& before, const GeometryTable& now) {
  std::vector<bool> changed(now.shapes().size());
  for (uint32_t i = 0; i < before.shapes().size(); ++i) {
    changed[i] = IsChanged(before.shapes()[i], now.shapes()[i]);
  }
  return changed;
}

}  // namespace dacrt

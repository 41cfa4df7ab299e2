#include "leaf/make_leaf.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"

namespace dacrt {
namespace {

/// What one block can hold.
struct BlockKind {
  LeafKind kind;
  bool is_timed;

  bool operator==(const BlockKind&) const = default;
};

BlockKind KindOf(const MeshTable& meshes, uint32_t geometry) {
  const Shapes& shapes = meshes.shapes();
  const bool is_timed = shapes.IsMoving(geometry);
  switch (shapes[geometry].shape) {
    case Shape::kSpheres:
      return {LeafKind::kSpheres, is_timed};
    case Shape::kDiscs:
      return {LeafKind::kDiscs, is_timed};
    case Shape::kOrientedDiscs:
      return {LeafKind::kOrientedDiscs, is_timed};
    case Shape::kUser:
      return {LeafKind::kUser, true};
    case Shape::kInstance:
      return {LeafKind::kInstances, true};
    default:
      return {LeafKind::kFacets, is_timed};
  }
}

/// The distinct vertices of some facets, told apart by their bits.
class VertexSet {
 public:
  uint8_t Add(const float* vertex) {
    uint32_t bits[3];
    std::memcpy(bits, vertex, sizeof(bits));
    const uint64_t key = (uint64_t{bits[0]} << 32 | bits[1]) ^ std::rotl(uint64_t{bits[2]}, 17);
    for (uint8_t i = 0; i < count_; ++i) {
      if (keys_[i] == key && std::memcmp(vertices_[i], vertex, sizeof(bits)) == 0) return i;
    }
    keys_[count_] = key;
    std::memcpy(vertices_[count_], vertex, sizeof(bits));
    return count_++;
  }

  uint8_t count() const { return count_; }
  /// All x, then all y, then all z.
  void Write(float* out) const {
    for (int axis = 0; axis < 3; ++axis) {
      for (uint8_t i = 0; i < count_; ++i) *out++ = vertices_[i][axis];
    }
  }

 private:
  uint64_t keys_[3 * kLeafLanes];
  float vertices_[3 * kLeafLanes][3];
  uint8_t count_ = 0;
};

/// The items of a leaf that go into one block, with their places behind the first of the leaf.
struct BlockItems {
  MeshTable::Name names[kLeafLanes];
  uint32_t places[kLeafLanes];
  std::size_t count = 0;
};

void WriteFacets(const MeshTable& meshes, const BlockItems& items, LeafBlock& block) {
  const Shapes& shapes = meshes.shapes();
  VertexSet vertices;
  uint8_t indices[3][kLeafLanes] = {};
  std::size_t lane = 0;
  const auto place = [&](const float* v0, const float* v1, const float* v2, std::size_t item) {
    indices[0][lane] = vertices.Add(v0);
    indices[1][lane] = vertices.Add(v1);
    indices[2][lane] = vertices.Add(v2);
    block.items |= items.places[item] << (4 * lane++);
  };
  for (std::size_t i = 0; i < items.count; ++i) {
    const MeshTable::Name name = items.names[i];
    if (meshes.HasTriangles(name.mesh)) {
      // One whose indices are no longer legal has no area, and nothing hits it.
      Corners corners;
      if (!meshes.ReadCorners(name.mesh, name.primitive, corners)) corners = {};
      place(corners.v[0], corners.v[1], corners.v[2], i);
      continue;
    }
    Facet facet;
    if (!shapes.ReadFacet(name.mesh, name.primitive, Moment{}, facet)) facet = {};
    const auto& corner = facet.corner;
    if (shapes[name.mesh].shape == Shape::kTriangles) {
      place(corner[0], corner[1], corner[2], i);
      continue;
    }
    place(corner[0], corner[1], corner[3], i);
    block.second |= static_cast<uint8_t>(1u << lane);
    place(corner[2], corner[3], corner[1], i);
  }
  block.lanes = static_cast<uint8_t>(lane);
  block.vertices = vertices.count();
  std::memcpy(const_cast<uint8_t*>(block.indices()), indices, sizeof(indices));
  vertices.Write(const_cast<float*>(block.vertex_data()));
}

void WritePoints(const MeshTable& meshes, const BlockItems& items, LeafBlock& block) {
  float* const data = const_cast<float*>(block.point_data());
  for (std::size_t i = 0; i < items.count; ++i) {
    Point point;
    meshes.shapes().ReadPoint(items.names[i].mesh, items.names[i].primitive, Moment{}, point);
    for (std::size_t axis = 0; axis < 3; ++axis) data[axis * items.count + i] = point.center[axis];
    data[3 * items.count + i] = point.radius;
    if (block.kind != LeafKind::kOrientedDiscs) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      data[(4 + axis) * items.count + i] = point.normal[axis];
    }
  }
}

void WriteBlock(const MeshTable& meshes, const BlockKind& kind, const BlockItems& items,
                uint32_t first, bool is_last, LeafBlock& block) {
  block = {};
  block.kind = kind.kind;
  block.is_timed = kind.is_timed;
  block.is_last = is_last;
  block.first = first;
  block.geometry = items.names[0].mesh;
  for (std::size_t i = 1; i < items.count; ++i) {
    if (items.names[i].mesh != block.geometry) block.geometry = LeafBlock::kSeveral;
  }
  if (kind == BlockKind{LeafKind::kFacets, false}) return WriteFacets(meshes, items, block);
  block.lanes = static_cast<uint8_t>(items.count);
  for (std::size_t i = 0; i < items.count; ++i) block.items |= items.places[i] << (4 * i);
  if (!kind.is_timed) WritePoints(meshes, items, block);
}

}  // namespace

std::size_t MakeLeaf(const MeshTable& meshes, const uint32_t* order, uint32_t first,
                     std::size_t most, std::byte* blocks) {
  MeshTable::Name names[kLeafLanes];
  std::size_t count = 0;
  for (bool is_last = false; !is_last && count < most; ++count) {
    const uint32_t entry = order[first + count];
    names[count] = meshes.Locate(KeptOrder::NumberOf(entry));
    is_last = (entry & KeptOrder::kLastOfLeaf) != 0;
  }
  std::size_t bytes = 0;
  for (uint32_t left = (1u << count) - 1; left != 0;) {
    const BlockKind kind = KindOf(meshes, names[std::countr_zero(left)].mesh);
    BlockItems items;
    for (std::size_t i = 0; i < count; ++i) {
      if (!(left >> i & 1) || KindOf(meshes, names[i].mesh) != kind) continue;
      left &= ~(1u << i);
      items.names[items.count] = names[i];
      items.places[items.count++] = static_cast<uint32_t>(i);
    }
    auto& block = *reinterpret_cast<LeafBlock*>(blocks + bytes);
    WriteBlock(meshes, kind, items, first, left == 0, block);
    bytes += block.Bytes();
  }
  return bytes;
}

}  // namespace dacrt

#include "leaf/make_leaf.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "geometry/fetch_corners.h"
#include "leaf/instance_leaf.h"
#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "runtime/assert.h"

namespace dacrt {
namespace {

/// What one block can hold.
struct BlockKind {
  LeafKind kind;
  bool is_timed;
  uint32_t geometry = 0;  ///< of facets between time steps, which are there at the same times

  bool operator==(const BlockKind&) const = default;
};

BlockKind KindOf(const GeometryTable& geometries, uint32_t geometry) {
  const Shapes& shapes = geometries.shapes();
  const bool is_timed = shapes.IsMoving(geometry);
  switch (shapes[geometry].shape) {
    case Shape::kSpheres:
      return {LeafKind::kSpheres, is_timed};
    case Shape::kDiscs:
      return {LeafKind::kDiscs, is_timed};
    case Shape::kOrientedDiscs:
      return {LeafKind::kOrientedDiscs, is_timed};
    case Shape::kUser:
      return {LeafKind::kUser, is_timed};
    case Shape::kInstance:
      return {LeafKind::kInstances, is_timed};
    default:
      if (is_timed && shapes.StepCount(geometry) <= kMostLeafSteps) {
        return {LeafKind::kMovingFacets, false, geometry};
      }
      return {LeafKind::kFacets, is_timed};
  }
}

/// The vertices of some facets, at one or more time steps; where shared ones are looked for they
/// are told apart by their bits.
class VertexSet {
 public:
  VertexSet(SharedVertices shared, uint32_t steps)
      : shared_(shared),
        components_(3 * steps),
        count_(shared == SharedVertices::kRepeat ? LeafBlock::kByLane : 0) {
    // Lanes without a facet have no area.
    std::fill_n(values_, count_ * components_, 0.0f);
  }

  /// Corner `corner` of the facet in a lane, which is corner `of_facet` of `facets`, one a time
  /// step. Returns its place.
  uint8_t Add(std::size_t corner, std::size_t lane, const Facet* facets, int of_facet) {
    const auto write = [&](std::size_t place) {
      float* const values = values_ + place * components_;
      for (std::size_t i = 0; i < components_; i += 3) {
        std::memcpy(values + i, facets[i / 3].corner[of_facet], 3 * sizeof(float));
      }
      return values;
    };
    if (shared_ == SharedVertices::kRepeat) {
      const std::size_t place = corner * kLeafLanes + lane;
      write(place);
      return static_cast<uint8_t>(place);
    }
    DACRT_ASSERT(count_ < LeafBlock::kByLane);
    const float* const values = write(count_);
    uint32_t bits[3];
    std::memcpy(bits, values, sizeof(bits));
    const uint64_t key = (uint64_t{bits[0]} << 32 | bits[1]) ^ std::rotl(uint64_t{bits[2]}, 17);
    for (uint8_t i = 0; i < count_; ++i) {
      if (keys_[i] == key &&
          std::memcmp(values_ + i * components_, values, components_ * sizeof(float)) == 0) {
        return i;
      }
    }
    keys_[count_] = key;
    return count_++;
  }

  uint8_t count() const { return count_; }
  /// All x, then all y, then all z; then the same of the next time step.
  void Write(float* out) const {
    for (std::size_t component = 0; component < components_; ++component) {
      for (uint8_t i = 0; i < count_; ++i) *out++ = values_[i * components_ + component];
    }
  }

 private:
  const SharedVertices shared_;
  const std::size_t components_;
  uint8_t count_;
  uint64_t keys_[LeafBlock::kByLane];
  float values_[LeafBlock::kByLane * 3 * kMostLeafSteps];  ///< of each vertex together
};

/// The items of a leaf that go into one block, with their places behind the first of the leaf.
struct BlockItems {
  GeometryTable::Name names[kLeafLanes] = {};
  uint32_t places[kLeafLanes];
  std::size_t count = 0;
};

void WriteFacets(const GeometryTable& geometries, const BlockItems& items, SharedVertices shared,
                 LeafBlock& block) {
  const Shapes& shapes = geometries.shapes();
  const bool is_moving = block.kind == LeafKind::kMovingFacets;
  const uint32_t steps = is_moving ? shapes.StepCount(block.geometry) : 1;
  block.steps = static_cast<uint8_t>(steps);
  VertexSet vertices(shared, steps);
  uint8_t indices[3][kLeafLanes] = {};
  std::size_t lane = 0;
  block.items = block.second = 0;
  for (std::size_t i = 0; i < items.count; ++i) {
    const GeometryTable::Name name = items.names[i];
    // One whose indices are no longer legal has no area, and nothing hits it.
    Facet facet[kMostLeafSteps];
    for (uint32_t step = 0; step < steps; ++step) {
      if (!shapes.ReadFacet(name.geometry, name.primitive, step, facet[step])) facet[step] = {};
    }
    const auto place = [&](int v0, int v1, int v2) {
      const int corners[3] = {v0, v1, v2};
      for (int k = 0; k < 3; ++k) {
        indices[k][lane] = vertices.Add(static_cast<std::size_t>(k), lane, facet, corners[k]);
      }
      block.items |= items.places[i] << (4 * lane++);
    };
    if (shapes[name.geometry].shape == Shape::kTriangles) {
      place(0, 1, 2);
      continue;
    }
    place(0, 1, 3);
    block.second |= static_cast<uint8_t>(1u << lane);
    place(2, 3, 1);
  }
  DACRT_ASSERT(lane <= kLeafLanes);
  if (shared == SharedVertices::kFind && vertices.count() == LeafBlock::kByLane) {
    return WriteFacets(geometries, items, SharedVertices::kRepeat, block);
  }
  block.lanes = static_cast<uint8_t>(lane);
  block.vertices = vertices.count();
  std::memcpy(block.indices(), indices, sizeof(indices));
  vertices.Write(block.vertex_data());
}

void WritePoints(const GeometryTable& geometries, const BlockItems& items, LeafBlock& block) {
  float* const data = block.point_data();
  for (std::size_t i = 0; i < items.count; ++i) {
    Point point;
    geometries.shapes().ReadPoint(items.names[i].geometry, items.names[i].primitive, Moment{},
                                  point);
    for (std::size_t axis = 0; axis < 3; ++axis) data[axis * items.count + i] = point.center[axis];
    data[3 * items.count + i] = point.radius;
    if (block.kind != LeafKind::kOrientedDiscs) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      data[(4 + axis) * items.count + i] = point.normal[axis];
    }
  }
}

void WriteBounds(const GeometryTable& geometries, const BlockItems& items, LeafBlock& block) {
  float* const data = const_cast<float*>(block.bounds_data());
  for (std::size_t i = 0; i < items.count; ++i) {
    const Box& bounds =
        geometries.shapes().StillBounds(items.names[i].geometry, items.names[i].primitive);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      data[axis * items.count + i] = bounds.lower[axis];
      data[(3 + axis) * items.count + i] = bounds.upper[axis];
    }
  }
}

void WriteBlock(const GeometryTable& geometries, const BlockKind& kind, const BlockItems& items,
                uint32_t first, bool is_last, SharedVertices shared, LeafBlock& block) {
  block = {};
  block.kind = kind.kind;
  block.is_timed = kind.is_timed;
  block.is_last = is_last;
  block.first = first;
  block.geometry = items.names[0].geometry;
  for (std::size_t i = 1; i < items.count; ++i) {
    if (items.names[i].geometry != block.geometry) block.geometry = LeafBlock::kSeveral;
  }
  if (kind.kind == LeafKind::kMovingFacets || kind == BlockKind{LeafKind::kFacets, false}) {
    return WriteFacets(geometries, items, shared, block);
  }
  block.lanes = static_cast<uint8_t>(items.count);
  for (std::size_t i = 0; i < items.count; ++i) block.items |= items.places[i] << (4 * i);
  if (kind.is_timed) return;
  if (kind.kind == LeafKind::kUser) return WriteBounds(geometries, items, block);
  if (kind.kind == LeafKind::kInstances) {
    DACRT_ASSERT(items.count == 1);
    const InstanceLeaf leaf = InstanceLeaf::Of(geometries.shapes(), block.geometry);
    std::memcpy(block.point_data(), &leaf, sizeof(leaf));
    return;
  }
  WritePoints(geometries, items, block);
}

/// The geometry of all items, or LeafBlock::kSeveral.
uint32_t GeometryOf(const LeafItems& items) {
  const uint32_t geometry = items.names[0].geometry;
  for (std::size_t i = 1; i < items.count; ++i) {
    if (items.names[i].geometry != geometry) return LeafBlock::kSeveral;
  }
  return geometry;
}

/// Begins the block of a leaf that holds nothing but still triangles, as nearly all do.
void BeginTriangles(std::size_t count, uint32_t geometry, uint32_t first, LeafBlock& block) {
  block = {};
  block.kind = LeafKind::kFacets;
  block.is_last = true;
  block.first = first;
  block.geometry = geometry;
  block.lanes = static_cast<uint8_t>(count);
  block.items = 0x76543210u & static_cast<uint32_t>((uint64_t{1} << (4 * count)) - 1);
}

/// WriteBlock for them, with a place for each corner.
void WriteTrianglesByLane(const GeometryTable& geometries, const LeafItems& items, uint32_t first,
                          LeafBlock& block) {
  BeginTrianglesByLane(items.count, GeometryOf(items), first, block);
  float* const data = block.vertex_data();
  if (items.count < kLeafLanes) std::memset(data, 0, 3 * LeafBlock::kByLane * sizeof(float));
  for (std::size_t lane = 0; lane < items.count; ++lane) {
    const GeometryTable::Name name = items.names[lane];
    Corners corners;
    // One whose indices are no longer legal has no area, and nothing hits it.
    if (!geometries.ReadCorners(name.geometry, name.primitive, corners)) corners = {};
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        data[axis * LeafBlock::kByLane + k * kLeafLanes + lane] = corners.v[k][axis];
      }
    }
  }
}

/// WriteBlock for them, with each vertex once; with a place for each corner if that saves nothing.
void WriteTriangles(const GeometryTable& geometries, const LeafItems& items, uint32_t first,
                    LeafBlock& block) {
  BeginTriangles(items.count, GeometryOf(items), first, block);
  uint8_t indices[3][kLeafLanes] = {};
  float vertices[LeafBlock::kByLane][3];
  uint32_t keys[LeafBlock::kByLane];
  uint32_t distinct = 0;
  for (std::size_t lane = 0; lane < items.count; ++lane) {
    const GeometryTable::Name name = items.names[lane];
    Corners corners;
    if (!geometries.ReadCorners(name.geometry, name.primitive, corners)) corners = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const float* const corner = corners.v[k];
      uint32_t bits[3];
      std::memcpy(bits, corner, sizeof(bits));
      const uint32_t key = bits[0] ^ std::rotl(bits[1], 11) ^ std::rotl(bits[2], 22);
      // Triangles share corners with those right before them.
      uint32_t place = distinct;
      while (place > 0 && (keys[place - 1] != key ||
                           std::memcmp(vertices[place - 1], corner, sizeof(bits)) != 0)) {
        --place;
      }
      if (place == 0) {
        keys[distinct] = key;
        std::memcpy(vertices[distinct], corner, sizeof(bits));
        place = ++distinct;
      }
      indices[k][lane] = static_cast<uint8_t>(place - 1);
    }
  }
  if (distinct == LeafBlock::kByLane) {
    return WriteTrianglesByLane(geometries, items, first, block);
  }
  block.vertices = static_cast<uint8_t>(distinct);
  std::memcpy(block.indices(), indices, sizeof(indices));
  float* out = block.vertex_data();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (uint32_t i = 0; i < distinct; ++i) *out++ = vertices[i][axis];
  }
}

/// Renews the vertices of still triangles, of which some may be hidden now. False if that is not
/// all that a leaf holds, or corners have come apart.
bool RenewTriangles(const GeometryTable& geometries, const LeafItems& items, LeafBlock& block) {
  if (!items.is_plain) return false;
  DACRT_ASSERT(block.IsPlain() && block.second == 0 && block.lanes == items.count);
  const std::size_t vertices = block.vertices;
  float* const data = block.vertex_data();
  uint32_t written = 0;
  for (std::size_t lane = 0; lane < block.lanes; ++lane) {
    const GeometryTable::Name name = items.names[lane];
    Corners corners;
    if (!geometries.ReadCorners(name.geometry, name.primitive, corners)) {
      // Of a geometry that is hidden: it has no area, and leaves the block its room to come back.
      auto* const indices = const_cast<uint8_t*>(block.indices());
      for (std::size_t k = 1; k < 3; ++k) {
        if (vertices < LeafBlock::kByLane) {
          indices[k * kLeafLanes + lane] = indices[lane];
          continue;
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
          data[axis * vertices + k * kLeafLanes + lane] = data[axis * vertices + lane];
        }
      }
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t vertex = block.indices()[k * kLeafLanes + lane];
      float* const place = data + vertex;
      const float* const from = corners.v[k];
      if (written >> vertex & 1) {
        const float before[3] = {place[0], place[vertices], place[2 * vertices]};
        if (std::memcmp(before, from, sizeof(before)) != 0) return false;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) place[axis * vertices] = from[axis];
      written |= 1u << vertex;
    }
  }
  return true;
}

}  // namespace

LeafItems FindItems(const GeometryTable& geometries, const uint32_t* order, uint32_t first,
                    std::size_t most) {
  LeafItems items;
  std::size_t lanes = 0, lanes_each = 0;
  uint32_t geometry = 0, begin = 0;
  std::size_t size = 0;
  bool is_plain = true;
  while (!items.is_last && items.count < most) {
    const uint32_t entry = order[first + items.count];
    const uint32_t number = KeptOrder::NumberOf(entry);
    // Nearly always of the same geometry as the one before it.
    if (number - begin >= size) {
      geometry = geometries.Locate(number).geometry;
      begin = geometries.Number(geometry, 0);
      size = geometries[geometry].triangle_count;
      lanes_each = geometries.LanesOf(geometry);
      is_plain = geometries.HasTriangles(geometry);
    }
    lanes += lanes_each;
    if (items.count > 0 && lanes > kLeafLanes) break;
    items.names[items.count++] = {geometry, number - begin};
    items.is_plain &= is_plain;
    items.is_last = (entry & KeptOrder::kLastOfLeaf) != 0;
  }
  return items;
}

void FetchIndices(const GeometryTable& geometries, const LeafItems& items) {
  for (std::size_t i = 0; i < items.count && items.is_plain; ++i) {
    FetchIndices(geometries, items.names[i]);
  }
}

void FetchVertices(const GeometryTable& geometries, const LeafItems& items) {
  for (std::size_t i = 0; i < items.count && items.is_plain; ++i) {
    FetchCorners(geometries, items.names[i]);
  }
}

bool RenewLeaf(const GeometryTable& geometries, const LeafItems& items, std::size_t room,
               std::byte* blocks) {
  auto& block = *reinterpret_cast<LeafBlock*>(blocks);
  if (RenewTriangles(geometries, items, block)) return true;
  alignas(LeafBlock) std::byte made[kMostLeafBytes];
  const MadeLeaf leaf = MakeLeaf(geometries, items, block.first, SharedVertices::kFind, made);
  if (!leaf.is_whole || leaf.bytes > room) return false;
  std::memcpy(blocks, made, leaf.bytes);
  return true;
}

void BeginTrianglesByLane(std::size_t count, uint32_t geometry, uint32_t first, LeafBlock& block) {
  static constexpr auto kPlaces = [] {
    std::array<uint8_t, LeafBlock::kByLane> places{};
    for (uint8_t i = 0; i < LeafBlock::kByLane; ++i) places[i] = i;
    return places;
  }();
  BeginTriangles(count, geometry, first, block);
  block.vertices = LeafBlock::kByLane;
  std::memcpy(block.indices(), kPlaces.data(), sizeof(kPlaces));
}

MadeLeaf MakeLeaf(const GeometryTable& geometries, const LeafItems& all, uint32_t first,
                  SharedVertices shared, std::byte* blocks) {
  const GeometryTable::Name* const names = all.names;
  const std::size_t count = all.count;
  if (all.is_plain) {
    auto& block = *reinterpret_cast<LeafBlock*>(blocks);
    if (shared == SharedVertices::kRepeat) {
      WriteTrianglesByLane(geometries, all, first, block);
    } else {
      WriteTriangles(geometries, all, first, block);
    }
    return {block.Bytes(), count, all.is_last};
  }
  std::size_t bytes = 0;
  // Blocks with a place for each corner are large: there is room for one.
  const BlockKind first_kind = KindOf(geometries, names[0].geometry);
  const bool is_one_block = std::all_of(names, names + count, [&](const GeometryTable::Name& name) {
    return KindOf(geometries, name.geometry) == first_kind;
  });
  if (!is_one_block) shared = SharedVertices::kFind;
  for (uint32_t left = (1u << count) - 1; left != 0;) {
    const BlockKind kind = KindOf(geometries, names[std::countr_zero(left)].geometry);
    BlockItems items;
    for (std::size_t i = 0; i < count; ++i) {
      if (!(left >> i & 1) || KindOf(geometries, names[i].geometry) != kind) continue;
      left &= ~(1u << i);
      items.names[items.count] = names[i];
      items.places[items.count++] = static_cast<uint32_t>(i);
    }
    auto& block = *reinterpret_cast<LeafBlock*>(blocks + bytes);
    WriteBlock(geometries, kind, items, first, left == 0, shared, block);
    bytes += block.Bytes();
    DACRT_ASSERT(bytes + KeptPartition::kReadBehind <= kMostLeafBytes);
  }
  return {bytes, count, all.is_last};
}

}  // namespace dacrt

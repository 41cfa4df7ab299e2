// The geometries of a scene that holds more than still triangle meshes.
//
// What the engine partitions is an item: a primitive, or of a grid one of its cells. An item has
// bounds over all times, and a name of two numbers, (geometry, item), as a triangle has.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dacrt/geometry.h"
#include "dacrt/settings.h"
#include "geometry/box.h"
#include "geometry/time_steps.h"

namespace dacrt {

struct SceneParts;

/// Three or four corners: of a triangle, or of two, (0, 1, 3) and (2, 3, 1).
struct Facet {
  float corner[4][3];
};

/// A sphere or a disc.
struct Point {
  float center[3];
  float radius;
  float normal[3];  ///< of an oriented disc
};

/// A cell of a grid primitive.
struct GridCell {
  uint32_t primitive;
  uint32_t x, y;
  uint32_t columns, rows;  ///< of the grid
};

inline Bounds ToBounds(const Box& box) {
  return {{box.lower[0], box.lower[1], box.lower[2]}, {box.upper[0], box.upper[1], box.upper[2]}};
}

class Shapes {
 public:
  /// `geometries` are in the order in which equal distances are decided; `scenes` are those that
  /// instances show, null for other geometries. Calls the bounds functions of user geometries, and
  /// forgets them.
  /// Throws as Scene's constructor does.
  Shapes(std::vector<Geometry> geometries, std::vector<const SceneParts*> scenes, bool robust);

  std::size_t size() const { return geometries_.size(); }
  const Geometry& operator[](uint32_t geometry) const { return geometries_[geometry]; }
  bool robust() const { return robust_; }
  std::size_t ItemCount(uint32_t geometry) const { return derived_[geometry].item_count; }
  uint32_t StepCount(uint32_t geometry) const { return derived_[geometry].steps; }
  bool IsMoving(uint32_t geometry) const { return derived_[geometry].steps > 1; }
  const SceneParts* InstancedScene(uint32_t geometry) const { return derived_[geometry].scene; }

  bool IsHidden(uint32_t geometry) const { return derived_[geometry].is_hidden; }

  /// Bounds over all times. False if the item can not be hit.
  bool BoundItem(uint32_t geometry, uint32_t item, Box& bounds) const {
    if (IsHidden(geometry)) return false;
    return BoundItem(geometry, item, 0, derived_[geometry].steps, bounds);
  }

  /// Bounds of a user primitive or an instance that does not move and can be hit.
  const Box& StillBounds(uint32_t geometry, uint32_t item) const {
    return derived_[geometry].bounds[item];
  }

  /// Bounds at a moment, of an item that can be hit.
  Box BoundItemAt(uint32_t geometry, uint32_t item, Moment moment) const;

  /// Bounds of what can be hit at the times 0 and 1. What lies between them, interpolated, holds
  /// what can be hit at other times.
  LinearBounds BoundLinearly() const;

  TimeSteps StepsOf(uint32_t geometry) const {
    return {derived_[geometry].steps, geometries_[geometry].time_range};
  }
  /// Nothing if the geometry is not there at `time`.
  std::optional<Moment> MomentAt(uint32_t geometry, float time) const {
    return StepsOf(geometry).At(time);
  }

  /// False if an index is outside the vertices.
  bool ReadFacet(uint32_t geometry, uint32_t item, Moment moment, Facet& facet) const;
  /// The same at a time step.
  bool ReadFacet(uint32_t geometry, uint32_t item, uint32_t step, Facet& facet) const;
  void ReadPoint(uint32_t geometry, uint32_t item, Moment moment, Point& point) const;

  GridCell CellOf(uint32_t geometry, uint32_t item) const;

  /// From a cell to the whole grid: turns u and v into those of the grid, and returns its number.
  uint32_t PlaceInGrid(uint32_t geometry, uint32_t item, float& u, float& v) const {
    const GridCell cell = CellOf(geometry, item);
    u = (u + static_cast<float>(cell.x)) / static_cast<float>(cell.columns);
    v = (v + static_cast<float>(cell.y)) / static_cast<float>(cell.rows);
    return cell.primitive;
  }

  /// The primitive that an item belongs to.
  uint32_t PrimitiveOf(uint32_t geometry, uint32_t item) const {
    return geometries_[geometry].shape == Shape::kGrids ? CellOf(geometry, item).primitive : item;
  }

  /// From the scene's space to the instanced one's, of an instance that does not move.
  const AffineTransform& ToStillInstance(uint32_t geometry) const {
    return derived_[geometry].to_instance;
  }
  /// The same. `time` matters to moving instances.
  AffineTransform ToInstance(uint32_t geometry, float time) const;

  /// Whether a call needs callbacks; those of instanced scenes are not looked at.
  bool has_callbacks() const {
    return has_closest_filters_ || has_any_filters_ || has_user_primitives_;
  }
  bool has_user_primitives() const { return has_user_primitives_; }
  /// Whether hits that a query finds may have to be shown to a filter function.
  bool has_filters(Query query) const {
    return query == Query::kAny ? has_any_filters_ : has_closest_filters_;
  }

 private:
  /// What is known of a geometry beside its description.
  struct Derived {
    /// Throws as Scene's constructor does.
    Derived(const Geometry& geometry, const SceneParts* instanced_scene);

    std::size_t item_count = 0;
    uint32_t steps = 1;
    bool is_hidden = false;
    Array primitives;                   ///< of the geometry, also while it is hidden
    std::vector<uint32_t> first_cells;  ///< of each grid
    std::vector<Box> bounds;            ///< of user primitives or an instance, at each time step
    AffineTransform to_instance;        ///< of a still instance
    const SceneParts* scene = nullptr;  ///< of an instance

   private:
    void CallBoundsFunction(const Geometry& geometry);
    void CountCells(const Geometry& geometry);
    void PlaceInstance(const Geometry& geometry);
  };

 public:
  /// A geometry as it will be: to be exchanged for the one that stands in its place.
  class Successor {
   public:
    /// Throws as Scene's constructor does.
    Successor(Geometry geometry, const SceneParts* instanced_scene)
        : geometry_(std::move(geometry)), derived_(geometry_, instanced_scene) {
      geometry_.bounds = {};
    }

    const Geometry& geometry() const { return geometry_; }

   private:
    friend Shapes;
    Successor(Geometry geometry, const Derived& derived)
        : geometry_(std::move(geometry)), derived_(derived) {}

    Geometry geometry_;
    Derived derived_;
  };

  /// The same geometry, hidden: its indices lead nowhere, its points are not numbers, user
  /// primitives have no functions, and an instance shows one point, where rays find nothing. A box
  /// that is inside out or not of numbers would not do: slab tests meet those.
  Successor Hidden(uint32_t geometry) const;

  /// Instances as they will stand, to be exchanged for how they stand. In rows, where each would
  /// have memory of its own, for there may be thousands.
  class Places {
   public:
    explicit Places(std::size_t instances) {
      places_.reserve(instances);
      transforms_.reserve(instances);
      bounds_.reserve(instances);
    }

   private:
    friend Shapes;
    struct Place {
      uint32_t geometry;
      AffineTransform to_instance;
    };
    std::vector<Place> places_;
    std::vector<TransformStep> transforms_;  ///< of all, those of the same one in a row
    std::vector<Box> bounds_;                ///< at these time steps
  };

  /// Adds where an instance will stand. False, and nothing is added, if it is not an instance with
  /// as many time steps, or is hidden.
  bool AddPlace(uint32_t geometry, std::span<const TransformStep> transforms, Places& places) const;

  /// Each instance must be there once.
  void Exchange(Places& places) noexcept;

  /// Whether both may stand in one place: only where they are, which rays meet them, and what
  /// instances show differs.
  bool CanExchange(uint32_t geometry, const Successor& successor) const;

  /// Whether both are user primitives in the same places. There is no other way to know: their
  /// bounds are asked for each time.
  bool StandAsBefore(uint32_t geometry, const Successor& successor) const;
  void Exchange(uint32_t geometry, Successor& successor) noexcept {
    std::swap(geometries_[geometry], successor.geometry_);
    std::swap(derived_[geometry], successor.derived_);
  }

 private:
  /// Bounds at the time steps [begin, end).
  bool BoundItem(uint32_t geometry, uint32_t item, uint32_t begin, uint32_t end, Box& bounds) const;

  bool FacetIndices(uint32_t geometry, uint32_t item, uint32_t* index, std::size_t& corners) const;

  std::vector<Geometry> geometries_;
  std::vector<Derived> derived_;
  bool robust_;
  bool has_user_primitives_ = false;
  bool has_closest_filters_ = false;
  bool has_any_filters_ = false;
};

}  // namespace dacrt

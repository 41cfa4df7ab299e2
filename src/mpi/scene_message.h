// A scene as it travels: the description of its geometries, which name their arrays.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dacrt/mpi.h"
#include "message.h"
#include "shared_array.h"

namespace dacrt::mpi {

/// Whether a geometry can be copied to another process: it is not known by callbacks only, and has
/// no filter functions.
bool CanTravel(const Geometry& geometry);

/// The number under which workers know an instanced scene; none if they do not.
using SceneNumber = std::function<std::optional<uint64_t>(const Scene*)>;

/// What Command::kScene is followed by, and the arrays that it names.
struct PackedScene {
  Message message;
  std::vector<ArraySource> arrays;
  std::vector<ArrayName> names;  ///< of these
};

/// None if a geometry cannot travel.
std::optional<PackedScene> PackScene(uint64_t number, const LocalScene& local,
                                     std::span<const Geometry> geometries,
                                     const SceneOptions& options, const SceneNumber& number_of);

/// A scene as it arrived.
struct UnpackedScene {
  uint64_t number;
  Settings settings;
  SceneOptions options;
  std::vector<Geometry> geometries;
  std::vector<std::shared_ptr<const void>> used;  ///< the arrays that they refer to
};

/// What the receiver holds.
using FindArray = std::function<std::shared_ptr<const std::byte[]>(const ArrayName&)>;
using FindScene = std::function<std::shared_ptr<const Scene>(uint64_t)>;

/// `reader` stands behind the command. Throws CutMessage.
UnpackedScene UnpackScene(Reader& reader, const FindArray& find_array, const FindScene& find_scene);

}  // namespace dacrt::mpi

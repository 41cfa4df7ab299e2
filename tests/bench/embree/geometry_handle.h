// Geometries as a library holds them.
#pragma once

#include <span>

#include "embree_library.h"
#include "scene_content.h"

namespace dacrt::bench {

/// Not committed; the caller releases it. `instanced` are the committed scenes that the content's
/// instances are of.
RTCGeometry MakeGeometry(const EmbreeLibrary& library, const GeometryContent& content,
                         std::span<const RTCScene> instanced);

/// Hands over the primitives of the content, to be committed.
void SetPrimitives(const EmbreeLibrary& library, RTCGeometry geometry,
                   const GeometryContent& content);

/// Hands over the transform of an instance, to be committed.
void SetTransform(const EmbreeLibrary& library, RTCGeometry geometry,
                  const GeometryContent& content);

}  // namespace dacrt::bench

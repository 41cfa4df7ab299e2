// A scene of next to nothing: what a call costs beside its rays shows here.
#pragma once

#include "bench_scene.h"

namespace dacrt::bench {

/// "box-36": a room of two by two by two that is open to the front, a lamp's panel, and two blocks,
/// as in the Cornell box: 36 triangles.
BenchScene MakeBox();

}  // namespace dacrt::bench

// A view and a lamp for a mesh of which nothing is known.
#pragma once

#include "bench_scene.h"

namespace dacrt::bench {

/// Sets the view and the lamp of `scene`: within its widest room if it has rooms, else obliquely
/// from above.
void ChooseViewAndLamp(BenchScene& scene);

}  // namespace dacrt::bench

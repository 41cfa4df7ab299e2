// The camera, and where to put it when nobody says.
#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathVec.h>

#include "ambient_occlusion/embree_scene.h"
#include "ambient_occlusion/options.h"

namespace ao {

struct View {
  Imath::V3f eye;
  Imath::V3f look_at;
  Imath::V3f up;
  float vertical_fov;  // degrees
};

// The view that the options ask for. What they leave open: the hall is seen from its entrance. A
// mesh with rooms, whose walls face inwards, is seen from the place in them from which the view is
// widest and deepest; any other mesh obliquely from above, as large as it fits.
View ChooseView(const Options& options, const Scene& scene);

// Makes rays through points of the picture.
class Camera {
 public:
  // Throws Error with kUsage if the view has no direction.
  Camera(const View& view, uint32_t width, uint32_t height);

  const Imath::V3f& eye() const { return eye_; }

  // The normalized direction through a point of the picture, in pixels, from its upper left corner.
  Imath::V3f DirectionThrough(float x, float y) const;

 private:
  Imath::V3f eye_;
  Imath::V3f corner_;  // from the eye to the upper left corner of the picture
  Imath::V3f right_;   // to the next pixel
  Imath::V3f down_;    // to the next row
};

}  // namespace ao

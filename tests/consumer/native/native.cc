// One ray, one triangle: succeeds if they meet.
#include <dacrt/dacrt.h>

#include <cstdint>
#include <iostream>

int main() {
  const float vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint32_t triangles[] = {0, 1, 2};
  const dacrt::TriangleMesh mesh{vertices, 12, 3, triangles, 12, 1};
  const dacrt::Scene scene(std::make_shared<dacrt::Device>(), {&mesh, 1});

  struct {
    float org[3] = {0.25f, 0.25f, -1}, dir[3] = {0, 0, 1}, tfar = 10;
  } ray;
  const auto at = [](float& value) { return reinterpret_cast<std::uintptr_t>(&value); };
  dacrt::RayView rays;
  rays.count = 1;
  rays.org_x = at(ray.org[0]), rays.org_y = at(ray.org[1]), rays.org_z = at(ray.org[2]);
  rays.dir_x = at(ray.dir[0]), rays.dir_y = at(ray.dir[1]), rays.dir_z = at(ray.dir[2]);
  rays.tfar = at(ray.tfar);
  scene.Trace(dacrt::Query::kClosest, rays);

  std::cout << "dacrt " << dacrt::Version() << ": t = " << ray.tfar << "\n";
  return ray.tfar == 1 ? 0 : 1;
}

#include "mtled/bench/bench_body.h"

#include <Eigen/Geometry>
#include <cmath>

namespace palpate::tools {
namespace {

const Vec3 box_size(0.10, 0.10, 0.06);  // m

}  // namespace

std::vector<BenchSize> benchSizes(bool quick) {
  std::vector<BenchSize> sizes = {{"1k", 0.0105, 1.69}, {"5k", 0.0059, 1.65}};
  if (!quick) sizes.push_back({"33k", 0.00305, 1.63});
  return sizes;
}

Scene benchScene(const BenchSize& size) {
  Scene scene;
  scene.name = "bench " + size.name;
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = box_size;
  scene.discretization.spacing = size.spacing;
  scene.discretization.support_factor = size.support_factor;
  scene.discretization.formulation.consistent_gradients = false;
  scene.discretization.formulation.floor = false;  // the plain kernel beside it has none
  scene.materials.emplace_back();
  scene.materials[0].material.set("poisson", 0.49);
  BoundarySpec base;
  base.region.kind = Region::Kind::NearPlane;
  base.region.distance = 1e-9;
  scene.boundaries.push_back(base);
  scene.dynamics.damping = 60;
  scene.tools[0].shape.radius = 0.01;
  scene.tools[0].max_speed = 0.1;  // m/s: the tissue follows, so that it stays in contact
  scene.tools[0].position = Vec3(0, 0, box_size.z() + 0.001);
  return scene;
}

std::vector<Vec3> benchDisplacement(const std::vector<Vec3>& X) {
  constexpr double turn = 0.5, bend = 0.03;  // rad; of the box's length
  std::vector<Vec3> u;
  for (const Vec3& x : X) {
    const Vec3 s = 3 / box_size.x() * x;
    const Vec3 turned = Eigen::AngleAxisd(turn * x.z() / box_size.z(), Vec3::UnitZ()) * x;
    const Vec3 bent = bend * box_size.x() * Vec3(std::sin(s.y()), std::sin(s.z()), std::sin(s.x()));
    u.push_back((turned - x + bent).cast<float>().cast<double>());
  }
  return u;
}

}  // namespace palpate::tools

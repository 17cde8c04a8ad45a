#include "mtled/atlas/atlas_block.h"

#include <cmath>

#include "mtled/verify/verification_case.h"

namespace palpate::tools {

Scene blockScene(BlockFaces faces, double young, double poisson, double stretch) {
  constexpr double width = 0.03, height = 0.03;
  Scene scene = caseScene(young, poisson);
  scene.name = "atlas block";
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(width, width, height);
  scene.discretization.spacing = 0.0055;
  scene.dynamics.damping = 60;
  scene.dynamics.threads = 1;
  const bool bonded = faces == BlockFaces::Bonded;
  BoundarySpec top = planeBoundary("top", Vec3(0, 0, height), Vec3::UnitZ(), {bonded, bonded, true});
  top.translation = Vec3(0, 0, (stretch - 1) * height);
  top.duration = 0.5;
  scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ(), {bonded, bonded, true}), top};
  if (bonded) return scene;
  for (int c = 0; c < 2; ++c)
    for (const double side : {-1.0, 1.0}) {
      if (side > 0 && faces == BlockFaces::Free) continue;  // one of two opposite sides holds it in its place
      const Vec3 normal = Vec3::Unit(c);
      scene.boundaries.push_back(planeBoundary("side", side * width / 2 * normal, normal, {c == 0, c == 1, false}));
    }
  return scene;
}

AtlasDrive blockDrive() {
  AtlasDrive drive;
  drive.seconds = 1.0;
  drive.still_from = 0.55;
  return drive;
}

double blockForce(BlockFaces faces, double young, double poisson, double stretch, double area) {
  const double mu = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));
  const auto stress = [&](double along, double other1, double other2) {
    const double J = along * other1 * other2, I1 = along * along + other1 * other1 + other2 * other2;
    return mu * std::pow(J, -2.0 / 3) * (along - I1 / (3 * along)) + K * (J - 1) * J / along;
  };
  double side = 1;
  if (faces == BlockFaces::Free) {
    double low = 0.1, high = 10;  // the stress on the side rises with its stretch
    for (int k = 0; k < 200; ++k) {
      side = (low + high) / 2;
      (stress(side, side, stretch) > 0 ? high : low) = side;
    }
  }
  return area * stress(stretch, side, side);
}

}  // namespace palpate::tools

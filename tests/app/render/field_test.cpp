#include "app/render/field.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

using namespace palpate;
using namespace palpate::app;

namespace {

/// One linear tetrahedron with a single integration point: F is exact. A fifth node is seen by nothing.
Model tetrahedron() {
  Model model;
  model.X = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 5, 5}};
  model.point_X = {{0.25, 0.25, 0.25}};
  model.point_volume = {1.0 / 6};
  model.point_material = {0};
  model.point_shape = {{0, 4}, {0, 1, 2, 3}, {0.25, 0.25, 0.25, 0.25}, {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  model.materials = {Material::neoHookean(3000, 0.45, 1000)};
  model.skin.surface.vertices = {{0, 0, 0}, {0.5, 0.5, 0}};
  setRows({{0, 2, 4}, {0, 4, 1, 2}, {0.5, 0.5, 0.5, 0.5}, {}}, model.skin);
  return model;
}

Displacements affine(const Model& model, const Mat3& F) {
  Displacements u;
  for (const Vec3& X : model.X) u.push_back(toFloat4(F * X - X));
  return u;
}

}  // namespace

TEST_CASE("J of an affine deformation is its determinant", "[field]") {
  const Model model = tetrahedron();
  const Mat3 F = Vec3(1.2, 0.9, 1.1).asDiagonal();
  CHECK(pointValues(model, affine(model, F), ColourMap::J)[0] == Approx(1.2 * 0.9 * 1.1));
  CHECK(pointValues(model, {}, ColourMap::J)[0] == 1);  // no displacements: at rest
}

TEST_CASE("Von Mises stress of simple shear is the closed form, and none under rotation", "[field]") {
  const Model model = tetrahedron();
  // Neo-Hookean in simple shear g, J = 1: the Cauchy deviator is mu dev(F F^T), with
  // F F^T = [1 + g^2, g; g, 1], so the equivalent stress is mu sqrt(g^4 + 3 g^2).
  const double g = 0.4, mu = 3000 / (2 * 1.45);
  Mat3 F = Mat3::Identity();
  F(0, 1) = g;
  CHECK(pointValues(model, affine(model, F), ColourMap::VonMises)[0] ==
        Approx(mu * std::sqrt(g * g * g * g + 3 * g * g)).epsilon(1e-5));
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  CHECK(pointValues(model, affine(model, turn), ColourMap::VonMises)[0] < 1e-2);  // Pa; float32 of u over 3 kPa
  CHECK(pointValues(model, affine(model, turn), ColourMap::J)[0] == Approx(1).epsilon(1e-6));
}

TEST_CASE("Averages are convex, and nodes that nothing sees don't count", "[field]") {
  const Model model = tetrahedron();
  const std::vector<float> nodes = nodeAverages(model, {7.0F});
  for (int i = 0; i < 4; ++i) CHECK(nodes[i] == 7.0F);
  CHECK(std::isnan(nodes[4]));
  const std::vector<float> skin = skinAverages(model, {2, 4, 8, 0, std::nanf("")});
  CHECK(skin[0] == 2.0F);  // nodes 0 and 4, the latter without a value
  CHECK(skin[1] == 6.0F);  // halfway between nodes 1 and 2
}

TEST_CASE("Positions follow the shape functions - a blown-up state is drawn at rest", "[field]") {
  const Model model = tetrahedron();
  Displacements u(5);
  u[1].z = 0.2F;
  CHECK(deformed(model.skin.surface.vertices, model.skin, u)[1].isApprox(Vec3f(0.5F, 0.5F, 0.1F)));
  CHECK(skinValues(model, u, deformed(model.skin.surface.vertices, model.skin, u), ColourMap::Displacement)[1] ==
        Approx(0.1));
  u[1].z = std::nanf("");
  CHECK(deformed(model.skin.surface.vertices, model.skin, u)[1].isApprox(Vec3f(0.5F, 0.5F, 0)));
}

TEST_CASE("Scales fit their values and never shrink to noise", "[field]") {
  const ColourScale J = automaticScale({0.95F, 1.02F}, ColourMap::J);
  CHECK(J.min == Approx(0.95));
  CHECK(J.max == Approx(1.05));
  CHECK(automaticScale({0.0F, 0.004F}, ColourMap::Displacement).max == Approx(0.004));
  CHECK(automaticScale({0.0F}, ColourMap::Displacement).max == 1e-4);
  CHECK(automaticScale({0.0F}, ColourMap::VonMises).max == 10);
  CHECK(automaticScale({1.0F}, ColourMap::J).min == Approx(0.99));
}

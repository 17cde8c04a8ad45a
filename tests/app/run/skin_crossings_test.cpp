#include "app/run/skin_crossings.h"

#include <catch2/catch.hpp>

#include "io/load_model.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("Skin crosses itself where one side is pushed through the other, and nowhere at rest or turned inside out",
          "[skin_crossings][whole]") {
  const Model model = test::blockModel(test::blockScene());
  SkinCrossings crossings(model.skin);
  AlignedVector<Float4> u = initialState(model).u;
  CHECK(crossings.count(u.data()) == 0);
  double top = 0;
  for (const Vec3& X : model.X) top = std::max(top, X.z());
  const auto moveUp = [&](auto&& way) {
    for (std::size_t i = 0; i < model.X.size(); ++i) u[i].z = static_cast<float>(way(model.X[i]));
    return crossings.count(u.data());
  };
  CHECK(moveUp([&](const Vec3& X) { return 0.5 * X.z(); }) == 0);
  CHECK(moveUp([&](const Vec3& X) { return -2 * X.z(); }) == 0);
  // Turned, faces of one plane are so to rounding.
  for (int k = 0; k < 40; ++k) {
    const Eigen::AngleAxisd turn(0.1 + 0.15 * k, Vec3(1, 2 - 0.1 * k, 3).normalized());
    for (std::size_t i = 0; i < model.X.size(); ++i) u[i] = toFloat4(turn * model.X[i] - model.X[i]);
    CHECK(crossings.count(u.data()) == 0);
  }
  u = initialState(model).u;
  // The middle of the base goes up through the top.
  const int through = moveUp([&](const Vec3& X) { return 1.5 * (top - X.z()) * (X.head<2>().norm() < 0.012); });
  CHECK(through > 0);
  CHECK(moveUp([&](const Vec3& X) { return -1.5 * X.z() * (X.head<2>().norm() < 0.012); }) > 0);
}

TEST_CASE("Two organs cross where one is deeper in the other than contact may leave it", "[skin_crossings]") {
  Scene scene = test::blockScene(0.01);
  scene.organs[0].size = Vec3::Constant(0.03);
  scene.organs.push_back(scene.organs[0]);
  constexpr double gap = 0.001;  // m
  scene.organs[1].position = Vec3(0.004, 0.003, 0.03 + gap);
  scene.tools[0].position = Vec3(0, 0, 0.2);
  const Model model = buildModel(scene, organSurface(scene));
  SkinCrossings crossings(model.skin);
  const auto lowered = [&](double by) {
    AlignedVector<Float4> u = initialState(model).u;
    for (std::size_t i = 0; i < model.X.size(); ++i)
      if (model.X[i].z() > 0.03 + gap / 2) u[i].z = static_cast<float>(-by);
    return crossings.count(u.data());
  };
  CHECK(lowered(0) == 0);
  CHECK(lowered(gap + 5e-5) == 0);
  CHECK(lowered(gap + 5e-4) > 0);
}

#include "app/panels/reference_curve.h"

#include <catch2/catch.hpp>

#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;
using Catch::Contains;

TEST_CASE("A reference is read with or without a header, in m or mm, and from force.csv", "[reference_curve]") {
  const TempFolder folder;
  const ReferenceCurve plain = readReferenceCurve(folder.write("a.csv", "0,0\n1.5, 0.25\n\n"));
  REQUIRE(plain.curve.size() == 2);
  CHECK(plain.curve[1].x == 1.5F);
  CHECK(plain.curve[1].y == 0.25F);
  CHECK(plain.label == "a.csv");
  const ReferenceCurve metres = readReferenceCurve(folder.write("b.csv", "force_N,depth_m\r\n0,0\r\n2,0.004\r\n"));
  CHECK(metres.curve[1].x == Approx(4));
  CHECK(metres.curve[1].y == 2.0F);
  const ReferenceCurve raw = readReferenceCurve(folder.write(
      "force.csv", "time_s,depth_m,force_raw_N_x,force_raw_N_y,force_raw_N_z\n0,0,0,0,0\n1,0.001,3,0,4\n"));
  CHECK(raw.curve[1].y == Approx(5));
}

TEST_CASE("What is no reference is refused with its place", "[reference_curve]") {
  const TempFolder folder;
  const auto problem = [&](const std::string& text) {
    return refusal([&] { readReferenceCurve(folder.write("x.csv", text)); });
  };
  CHECK_THAT(problem(""), Contains("an empty file"));
  CHECK_THAT(problem("0,0\n"), Contains("fewer than two points"));
  CHECK_THAT(problem("time,N\n1,2\n"), Contains("x.csv:1: there is no column depth_m"));
  CHECK_THAT(problem("depth_mm,N\n1,2\n"), Contains("x.csv:1: there is no column force_N"));
  CHECK_THAT(problem("0,0\n1,x\n"), Contains("x.csv:2:3: \"x\" is not a number"));
  CHECK_THAT(problem("0,0\n1\n"), Contains("x.csv:2: 1 fields, but 2 columns"));
  CHECK_THAT(problem("0,0,0\n"), Contains("x.csv:1: 3 fields, but 2 columns"));
}

TEST_CASE("Hertz's force is the closed form's, for a sphere on one material alone", "[reference_curve]") {
  Body model;
  model.scene.materials.resize(1);
  model.scene.tools[0].shape.radius = 0.01;
  const Material soft = Material::neoHookean(3000, 0.45, 1000);
  const auto hertz = hertzCurve(model, soft, 4);
  REQUIRE(hertz);
  // 4/3 x 3000 / (1 - 0.45^2) x sqrt(0.01 x 0.004) x 0.004 N
  CHECK(static_cast<double>(hertz->curve.back().y) == Approx(0.126888).epsilon(1e-4));
  CHECK(hertz->curve.front().y == 0);
  model.scene.materials.resize(2);
  CHECK_FALSE(hertzCurve(model, soft, 4));
}

#include "app/render/skin_mesh.h"

#include <catch2/catch.hpp>
#include <set>

#include "snapshots/hand_made_model.h"
#include "support/cubes.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("A cube keeps its edges: three normals at each corner", "[skin]") {
  const Model model = handMadeModel(test::cubes({1, 1, 1}, 1, [](const Vec3&) { return true; }), 0.5, ToolShape{}, 2);
  SkinMesh skin(model);
  skin.update(restSnapshot(model, Vec3(0, 0, 2)), View{});
  CHECK(skin.vertices().size() == 24);
  CHECK(skin.triangles().size() == 12);
  for (const SkinVertex& v : skin.vertices()) {
    CHECK(v.normal.cwiseAbs().maxCoeff() == Approx(1));                      // along an axis
    CHECK(v.normal.dot(v.position - Vec3f::Constant(0.5F)) == Approx(0.5));  // outward
  }
}

TEST_CASE("A ball stays smooth: radial normals and the curvature of its radius", "[skin]") {
  ToolShape tool;
  tool.radius = 0.01;
  const Model model = handMadeModel(ellipsoidSurface(Vec3::Constant(0.05), 3), 0.02, tool);
  SkinMesh skin(model);
  skin.update(restSnapshot(model, Vec3(0, 0, 0.1)), View{});
  CHECK(skin.vertices().size() == model.skin.surface.vertices.size());  // nothing split
  for (const SkinVertex& v : skin.vertices()) {
    CHECK(v.normal.dot(v.position.normalized()) > 0.9995F);
    CHECK(v.cavity == Approx(-0.01 / 0.05).epsilon(0.02));  // convex: minus tool radius over ball radius
  }
}

TEST_CASE("The skin shows where it is held and pressed", "[skin]") {
  const Model model = handMadeModel(ellipsoidSurface(Vec3(0.07, 0.05, 0.035), 3), 0.012, ToolShape{});
  SkinMesh skin(model);
  Snapshot snapshot = restSnapshot(model, Vec3(0, 0, 0.035));
  pressDent(model, Vec3(0, 0, 0.035), 0.01, 0.025, snapshot);
  View view;
  view.colour_map = ColourMap::Displacement;
  const ColourScale scale = skin.update(snapshot, view);
  CHECK(scale.max < 0.01);
  CHECK(scale.max > 0.005);
  for (const SkinVertex& v : skin.vertices()) {
    const float height = v.reference.z(), aside = v.reference.head<2>().norm();
    if (height < -0.034F) CHECK(v.fixed > 0.6F);
    if (height > 0) CHECK(v.fixed == 0);
    if (height > 0 && aside < 0.004F) {
      CHECK(v.contact > 0.1F);
      CHECK(v.value > 0.8F);
      CHECK(v.position.z() < height - 0.005F);
    }
    if (height < 0) CHECK(v.contact == 0);
  }

  view.colour_auto = false;
  view.colour_min = 0;
  view.colour_max = 0.1;
  CHECK(skin.update(snapshot, view).max == 0.1);
  CHECK_FALSE(skin.update(snapshot, view).above);
  view.colour_min = 0.001;
  view.colour_max = 0.002;
  const ColourScale narrow = skin.update(snapshot, view);
  CHECK(narrow.below);
  CHECK(narrow.above);
  int over = 0, under = 0;
  for (const SkinVertex& v : skin.vertices()) {
    over += v.value > 1 ? 1 : 0;
    under += v.value < 0 ? 1 : 0;
  }
  CHECK(over > 0);
  CHECK(under > 0);

  std::vector<float> pressure(model.skin.surface.vertices.size(), 500.0F);
  pressure[0] = 3000;
  View peak;
  peak.colour_map = ColourMap::Pressure;
  CHECK(skin.update(snapshot, peak).max == 1000);  // nothing was given
  peak.skin_values = &pressure;
  CHECK(skin.update(snapshot, peak).max == 3000);
  pressure.pop_back();
  CHECK(skin.update(snapshot, peak).max == 1000);  // another body's
}

#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "model/solution_fields.h"
#include "support/small_scene.h"

using namespace palpate;
using test::blockModel;
using test::blockScene;

TEST_CASE("A model says what it is made of", "[build_model]") {
  const Model model = blockModel();
  double mass = 0, volume = 0;
  for (double m : model.mass) {
    REQUIRE(m > 0);
    mass += m;
  }
  for (double v : model.point_volume) volume += v;
  const double box = 0.06 * 0.06 * 0.03;
  CHECK(volume == Approx(box).epsilon(1e-12));  // flat faces: nothing is lost
  CHECK(mass == Approx(1000 * box).epsilon(1e-12));
  CHECK(model.tools.first().first_contact_travel == Approx(0.002).epsilon(1e-6));
  CHECK(model.dt <= model.scene.dynamics.step_safety * model.dt_critical);
  CHECK(model.dt * model.substeps_per_tick == Approx(1 / model.scene.dynamics.rate_hz).epsilon(1e-14));
  CHECK(model.dt_proven < model.dt_critical);
  CHECK(model.point_shape.meanSupport() > 15);
}

TEST_CASE("Supports are a partition of unity that reproduces linear fields, at points and on the skin",
          "[build_model]") {
  const Model model = blockModel();
  const auto worst = [&](const auto& rows, const std::vector<Vec3>& at) {
    double most = 0;
    for (std::size_t r = 0; r < at.size(); ++r) {
      double one = 0;
      Vec3 x = Vec3::Zero();
      for (int e = rows.begin[r]; e < rows.begin[r + 1]; ++e) {
        one += rows.N[e];
        x += rows.N[e] * model.X[rows.node[e]];
      }
      most = std::max({most, std::abs(one - 1), (x - at[r]).norm() / 0.06});
    }
    return most;
  };
  CHECK(worst(model.point_shape, model.point_X) < 1e-9);
  CHECK(worst(model.skin, model.skin.surface.vertices) < 3e-7);  // as floats
}

TEST_CASE("What can't be used is refused with the place that says so", "[build_model]") {
  const auto refuse = [](Scene scene, const char* place, const char* problem) {
    scene.places["dynamics.time_step"] = {"block.toml", 21, 3};
    scene.tools[0].place = {"block.toml", 30, 1};
    scene.places["discretization.support_factor"] = {"block.toml", 12, 1};
    for (auto& b : scene.boundaries) b.place = {"block.toml", 17, 1};
    CHECK_THROWS_WITH(blockModel(scene), Catch::Contains(place) && Catch::Contains(problem));
  };
  Scene scene = blockScene();
  scene.dynamics.rate_hz = 100;
  scene.dynamics.time_step = 1.0 / 100;  // one step a tick: far beyond the limit
  refuse(scene, "block.toml:21:3", "exceeds the critical");
  scene.dynamics.rate_hz = 500;
  scene.dynamics.time_step = 0.0003;
  refuse(scene, "block.toml:21:3", "not a whole number");
  scene = blockScene();
  scene.boundaries[0].region.point = Vec3(0, 0, 1);
  refuse(scene, "block.toml:17:1", "no node");
  scene = blockScene();
  scene.tools[0].position = Vec3(0, 0, 0.02);
  refuse(scene, "block.toml:30:1", "inside the organ");
  scene = blockScene();
  scene.discretization.support_factor = 0.1;  // no node reaches another, not even after enlargement
  refuse(scene, "block.toml:12:1", "inadmissible");
  scene = blockScene();
  scene.boundaries.push_back(scene.boundaries[0]);
  scene.boundaries[1].translation = Vec3(0, 0, 1e-3);
  scene.boundaries[1].duration = 1;
  refuse(scene, "block.toml:17:1", "another motion");
}

TEST_CASE("A material region changes the points inside it alone", "[build_model]") {
  Scene scene = blockScene();
  MaterialSpec stiff = scene.materials[0];
  stiff.everywhere = false;
  stiff.material.set("young", 9000);
  stiff.material.set("density", 2000);
  stiff.region.kind = Region::Kind::HalfSpace;
  stiff.region.point = Vec3(0.01, 0, 0);
  stiff.region.normal = -Vec3::UnitX();  // x >= 0.01
  scene.materials.push_back(stiff);
  const Model model = blockModel(scene);
  for (int q = 0; q < model.pointCount(); ++q) CHECK((model.point_material[q] == 1) == (model.point_X[q].x() >= 0.01));
  double mass = 0;
  for (double m : model.mass) mass += m;
  const double box = 0.06 * 0.06 * 0.03;
  CHECK(mass > 1.2 * 1000 * box);
  CHECK(mass < 1.5 * 1000 * box);
}

namespace {

/// The block with its top, too, imposed.
Scene gripped(const Vec3& travel) {
  Scene scene = blockScene();
  scene.boundaries[0].place = {"block.toml", 17, 1};
  scene.boundaries.push_back(scene.boundaries[0]);
  BoundarySpec& top = scene.boundaries[1];
  top.region.point = Vec3(0, 0, 0.03);
  top.translation = travel;
  top.duration = 1;
  top.place = {"block.toml", 25, 1};
  return scene;
}

int imposedCount(const Model& model) {
  return static_cast<int>(
      std::count_if(model.imposed.begin(), model.imposed.end(), [](auto bits) { return bits != 0; }));
}

}  // namespace

TEST_CASE("Motions that contradict each other are refused with both places", "[build_model]") {
  const auto refuse = [](const BoundarySpec& more) {
    Scene scene = gripped(Vec3(0, 0, -0.003));
    scene.boundaries.push_back(more);
    scene.boundaries[2].place = {"block.toml", 33, 1};
    CHECK_THROWS_WITH(blockModel(scene), Catch::Contains("block.toml:25:1") && Catch::Contains("block.toml:33:1") &&
                                             Catch::Contains("another motion"));
  };
  const BoundarySpec top = gripped(Vec3(0, 0, -0.003)).boundaries[1];
  BoundarySpec other = top;
  other.translation.z() = -0.004;
  refuse(other);
  other = top;
  other.duration = 2;  // ends alike, but goes another way
  refuse(other);
  other = top;
  other.curve.kind = LoadCurve::Kind::Linear;
  refuse(other);
  other = top;
  other.angle = 0.1;
  refuse(other);
  other.region.kind = Region::Kind::Sphere;  // they share a corner only
  other.region.point = Vec3(0.03, 0.03, 0.03);
  other.region.radius = 1e-3;
  refuse(other);
}

TEST_CASE("Motions that agree may share nodes - the first has them", "[build_model]") {
  const Scene once = gripped(Vec3(0, 0, -0.003));
  Scene scene = once;
  scene.boundaries.push_back(scene.boundaries[1]);  // the same again
  scene.boundaries.push_back(scene.boundaries[1]);  // another way to say it: a turn by nothing
  scene.boundaries[3].axis_point = Vec3(1, 2, 3);
  BoundarySpec side = scene.boundaries[1];  // unlike, but in a component that the top's corner nodes leave free
  side.region.point = Vec3(0.03, 0, 0);
  side.region.normal = Vec3::UnitX();
  side.component[2] = false;
  side.component[1] = false;
  side.translation = Vec3(0.002, 0, 0);
  for (auto& b : scene.boundaries) b.component[0] = false;
  scene.boundaries.push_back(side);
  const Model model = blockModel(scene);
  for (const auto& node : model.essential.nodes)
    for (int c = 0; c < 3; ++c)
      CHECK((node.boundary[c] < 0 || node.boundary[c] == 0 || node.boundary[c] == 1 || node.boundary[c] == 4));
  CHECK(imposedCount(model) > imposedCount(blockModel(once)));
}

TEST_CASE("A shell holds the nodes near the surface, and no others", "[build_model][whole]") {
  for (const double distance : {0.0, 0.006}) {
    Scene scene = blockScene(0.008);
    scene.boundaries[0].region = {};
    scene.boundaries[0].region.kind = Region::Kind::Shell;
    scene.boundaries[0].region.distance = distance;
    const Model model = blockModel(scene);
    int inside = 0;
    for (int i = 0; i < model.nodeCount(); ++i) {
      const Vec3& x = model.X[i];
      const double to_surface = std::min({0.03 - std::abs(x.x()), 0.03 - std::abs(x.y()), x.z(), 0.03 - x.z()});
      if (std::abs(to_surface - distance) < 2e-9) continue;  // on the shell's own edge
      CHECK((model.imposed[i] != 0) == (to_surface < distance));
      inside += to_surface > distance ? 1 : 0;
    }
    CHECK(inside > 0);
    CHECK(imposedCount(model) > 100);
  }
}

TEST_CASE("A cylindrical region ends at nodes on its rim", "[build_model]") {
  Scene scene = blockScene();
  BoundarySpec punch = scene.boundaries[0];
  punch.region.kind = Region::Kind::Cylinder;
  punch.region.point = Vec3(0.002, -0.003, 0.025);
  punch.region.radius = 0.02;
  punch.region.height = 0.01;
  punch.surface_only = true;
  punch.translation = Vec3(0, 0, -0.002);
  punch.duration = 1;
  scene.boundaries.push_back(punch);
  const Model model = blockModel(scene);
  int on_rim = 0;
  for (const auto& node : model.essential.nodes) {
    if (node.boundary[2] != 1) continue;
    const Vec3 arm = model.X[node.node] - Vec3(0.002, -0.003, 0.03);
    const double r = std::hypot(arm.x(), arm.y());
    CHECK(r < 0.02 + 1e-9);
    // The rim is drawn as a polygon of 8 sides a spacing, 84 here: their middles are 14 um inside the circle.
    const double sagitta = 0.02 * (1 - std::cos(M_PI / 84));
    on_rim += r > 0.02 - sagitta - 1e-9 && std::abs(arm.z()) < 1e-9 ? 1 : 0;
  }
  CHECK(on_rim >= 8);  // a circumference of 126 mm at a spacing of 12 mm
}

TEST_CASE("Adaptive quadrature adds points where it is asked to, and keeps the volume", "[build_model][whole]") {
  Scene scene = blockScene();
  const Model plain = blockModel(scene);
  CHECK(plain.pointCount() == static_cast<int>(plain.cells.size()));
  int before = plain.pointCount();
  for (const double accuracy : {0.1, 0.03}) {
    scene.discretization.quadrature.accuracy = accuracy;
    scene.discretization.quadrature.max_depth = 2;
    const Model model = blockModel(scene);
    INFO("accuracy " << accuracy << " points " << model.pointCount());
    CHECK(model.pointCount() > before);
    before = model.pointCount();
    std::vector<double> in_cell(model.cells.size(), 0);
    for (int q = 0; q < model.pointCount(); ++q) in_cell[model.point_cell[q]] += model.point_volume[q];
    double volume = 0;
    for (std::size_t c = 0; c < in_cell.size(); ++c) {
      const auto& n = model.cells[c];
      const double exact =
          std::abs(
              (model.X[n[1]] - model.X[n[0]]).cross(model.X[n[2]] - model.X[n[0]]).dot(model.X[n[3]] - model.X[n[0]])) /
          6;
      CHECK(in_cell[c] == Approx(exact).epsilon(1e-12));
      volume += in_cell[c];
    }
    CHECK(volume == Approx(0.06 * 0.06 * 0.03).epsilon(1e-12));
  }
}

TEST_CASE("A box that leaves two nodes beside full blocks of the gradients' system is set up like any other",
          "[build_model][whole]") {
  Scene scene = blockScene(0.0042);
  scene.organs[0].size = Vec3(0.03, 0.03, 0.03);
  scene.tools[0].shape.radius = 0.006;
  int two_over = 0;
  for (const unsigned seed : {2u, 3u, 16u}) {
    scene.discretization.seed = seed;
    const Model model = blockModel(scene);
    INFO("seed " << seed << ", " << model.nodeCount() << " nodes");
    two_over += model.nodeCount() % 64 == 2;  // the block's coarse functions are dependent
    CHECK(std::isfinite(model.dt_critical));
    CHECK(model.dt_critical > 0);
    CHECK(std::all_of(model.point_shape.gradN.begin(), model.point_shape.gradN.end(),
                      [](const Vec3& g) { return g.allFinite(); }));
  }
  CHECK(two_over > 0);
}

TEST_CASE("A body of so few nodes that the gradients' system is one block is set up like any other", "[build_model]") {
  Scene scene = blockScene(0.02);
  for (unsigned seed = 1; seed <= 12; ++seed) {
    scene.discretization.seed = seed;
    const Model model = blockModel(scene);
    INFO("seed " << seed << ", " << model.nodeCount() << " nodes");
    REQUIRE(model.nodeCount() < 64);
    CHECK(model.dt_critical > 0);
    CHECK(std::all_of(model.point_shape.gradN.begin(), model.point_shape.gradN.end(),
                      [](const Vec3& g) { return g.allFinite(); }));
  }
}

TEST_CASE("Cells that share a point keep the volume and see a uniform strain exactly, in every cell", "[build_model]") {
  Scene scene = blockScene();
  const int cells = static_cast<int>(blockModel(scene).cells.size());
  Mat3 A;
  A << 0.01, 0.02, 0, -0.03, 0.04, 0.01, 0, 0.02, -0.05;
  for (const double cells_per_point : {1.5, 2.0}) {
    scene.discretization.quadrature.cells_per_point = cells_per_point;
    const Model model = blockModel(scene);
    INFO(cells_per_point << " cells per point, " << model.pointCount() << " points");
    CHECK(static_cast<int>(model.cells.size()) == cells);
    CHECK(model.pointCount() < 0.7 * cells);
    double volume = 0;
    for (const double V : model.point_volume) volume += V;
    CHECK(volume == Approx(0.06 * 0.06 * 0.03).epsilon(1e-12));
    std::vector<Vec3> u;
    for (const Vec3& X : model.X) u.push_back(A * X);
    const SolutionFields fields = solutionFields(model, u);
    const double J = (Mat3::Identity() + A).determinant();
    for (const double in_cell : fields.J) CHECK(in_cell == Approx(J).epsilon(1e-9));
  }
}

TEST_CASE("EBCIEM is chosen by the scene and holds the base as exactly", "[build_model]") {
  Scene scene = gripped(Vec3(0.001, 0, -0.003));
  CHECK(blockModel(scene).essential.facets.empty());
  scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  const Model model = blockModel(scene);
  REQUIRE_FALSE(model.essential.facets.empty());
  CHECK(model.essential.facet_weight.size() ==
        model.essential.facets.size() * static_cast<std::size_t>(model.essential.facet_points));
  double area = 0;
  for (const auto& w : model.essential.facet_weight) area += w.sum();
  CHECK(area == Approx(2 * 0.06 * 0.06).epsilon(1e-12));  // base and top
  const auto boundary = makeEssentialBoundary<double>(model.essential, model.mass);
  REQUIRE(boundary.sets.size() == 1);
  CHECK_FALSE(boundary.sets[0].v.column.empty());
  double share = 0;
  for (const double s : boundary.sets[0].share) share += s;
  CHECK(share == Approx(area).epsilon(1e-12));
}

TEST_CASE("Mass is added where it spares a step, and never more than the scene grants",
          "[build_model][mass_scaling][whole]") {
  Scene scene = blockScene();
  scene.dynamics.rate_hz = 200;
  scene.tools[0].max_speed = 0.1;  // else the contact asks for short steps
  const Model own = blockModel(scene);
  REQUIRE(own.substeps_per_tick > 1);
  CHECK(own.addedMass() == 0);
  scene.dynamics.mass_scaling = 1e-9;
  const Model same = blockModel(scene);
  CHECK(same.mass == own.mass);
  CHECK(same.dt == own.dt);

  scene.dynamics.mass_scaling = 10;
  const Model one = blockModel(scene);
  CHECK(one.substeps_per_tick < own.substeps_per_tick);
  CHECK(one.dt <= scene.dynamics.step_safety * one.dt_critical);
  CHECK(one.addedMass() > 0);
  CHECK(one.addedMass() <= 10);
  scene.dynamics.mass_scaling = 0.9 * one.addedMass();
  const Model less = blockModel(scene);
  CHECK(less.substeps_per_tick == one.substeps_per_tick + 1);
  CHECK(less.addedMass() < one.addedMass());

  // A step that the scene names becomes stable, or is refused.
  scene.dynamics.mass_scaling = 10;
  scene.dynamics.time_step = one.dt;
  scene.places["dynamics.time_step"] = {"block.toml", 21, 3};
  CHECK(blockModel(scene).addedMass() == Approx(one.addedMass()).epsilon(1e-12));
  scene.dynamics.mass_scaling = 1e-3;
  CHECK_THROWS_WITH(blockModel(scene), Catch::Contains("block.toml:21:3") && Catch::Contains("raise mass_scaling"));
}

TEST_CASE("What counts as a blow-up is the coarse spacing in a step, a finer place or not", "[build_model][whole]") {
  Scene scene = blockScene();
  scene.dynamics.mass_scaling = 1000;  // long steps, in which sound would go further
  scene.tools[0].max_speed = 0.2;
  CHECK(blockModel(scene).max_increment == Approx(scene.discretization.spacing));
  scene.discretization.refine.push_back({Vec3(0, 0, 0.03), 0.01, 0.25 * scene.discretization.spacing, 0, {}});
  CHECK(blockModel(scene).max_increment == Approx(scene.discretization.spacing));
}

TEST_CASE("Cells keep the volume of what is pressed flat or by tools, not where a moving face curves the flow",
          "[build_model][whole]") {
  Scene scene = blockScene();
  CHECK(blockModel(scene).hasCellVolume());  // a tool, a base that stands still
  const auto plate = [&](int axis, double at, bool bonded) {
    BoundarySpec face = scene.boundaries.front();
    face.region.point = at * Vec3::Unit(axis);
    face.region.normal = Vec3::Unit(axis);
    for (int c = 0; c < 3; ++c) face.component[c] = bonded || c == axis;
    return face;
  };
  scene.boundaries.push_back(plate(2, 0.03, false));
  BoundarySpec& top = scene.boundaries.back();
  top.translation = Vec3(0, 0, -0.003);
  top.duration = 1;
  CHECK(blockModel(scene).hasCellVolume());  // slides
  top.angle = 0.1;
  CHECK_FALSE(blockModel(scene).hasCellVolume());
  top.angle = 0;
  top.component[0] = top.component[1] = true;  // bonded
  CHECK_FALSE(blockModel(scene).hasCellVolume());
  for (const double side : {-0.03, 0.03}) {
    scene.boundaries.push_back(plate(0, side, false));
    scene.boundaries.push_back(plate(1, side, false));
  }
  CHECK(blockModel(scene).hasCellVolume());  // held all around
  scene.discretization.formulation = Formulation::paper();
  CHECK_FALSE(blockModel(scene).hasCellVolume());
}

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "api/pressed_block.h"
#include "support/realtime_guard.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;
using Eigen::Vector3d;

namespace {

struct PointsDeleter {
  void operator()(palpate_points* points) const { palpate_points_destroy(points); }
};
using PointsHandle = std::unique_ptr<palpate_points, PointsDeleter>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

PointsHandle pointsOf(const ModelHandle& model, std::int32_t kind) {
  palpate_points* points = nullptr;
  REQUIRE(palpate_points_of(model.get(), kind, &points, nullptr) == PALPATE_OK);
  return PointsHandle(points);
}

PointsHandle pointsAt(const ModelHandle& model, const Rows& X) {
  palpate_points* points = nullptr;
  auto error = sized<palpate_error>();
  palpate_points_create(model.get(), X.data(), static_cast<int>(X.rows()), &points, &error);
  INFO(error.text);
  REQUIRE(points != nullptr);
  return PointsHandle(points);
}

Rows displacements(const SimulationHandle& simulation, const PointsHandle& points, int count) {
  Rows u(count, 3);
  REQUIRE(palpate_displacements(simulation.get(), points.get(), u.data(), count) == PALPATE_OK);
  return u;
}

Rows velocities(const SimulationHandle& simulation, const PointsHandle& points, int count) {
  Rows v(count, 3);
  REQUIRE(palpate_velocities(simulation.get(), points.get(), v.data(), count) == PALPATE_OK);
  return v;
}

Rows rest(const PointsHandle& points, int count) {
  Rows X(count, 3);
  REQUIRE(palpate_points_rest(points.get(), X.data(), nullptr, count) == PALPATE_OK);
  return X;
}

Rows skin(const SimulationHandle& simulation, const palpate_model_info& info) {
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> x(info.skin_vertex_count, 3);
  REQUIRE(palpate_skin_positions(simulation.get(), x.data(), info.skin_vertex_count) == PALPATE_OK);
  return x.cast<double>();
}

struct Stresses {
  Stresses(const SimulationHandle& simulation, const PointsHandle& points, int count)
      : stress(static_cast<std::size_t>(count)), J(static_cast<std::size_t>(count)) {
    REQUIRE(palpate_stresses(simulation.get(), points.get(), stress[0].data(), J.data(), count) == PALPATE_OK);
  }
  std::vector<Eigen::Matrix3d> stress;
  std::vector<double> J;
};

Eigen::Matrix<double, 2, 3> reactions(const SimulationHandle& simulation) {
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> force;
  REQUIRE(palpate_reactions(simulation.get(), force.data(), nullptr, 2) == PALPATE_OK);
  return force;
}

palpate_skin_point ray(const SimulationHandle& simulation, const Vector3d& from, const Vector3d& along) {
  auto place = sized<palpate_skin_point>();
  REQUIRE(palpate_ray(simulation.get(), from.data(), along.data(), &place) == PALPATE_OK);
  return place;
}

palpate_skin_point closest(const SimulationHandle& simulation, const Vector3d& x) {
  auto place = sized<palpate_skin_point>();
  REQUIRE(palpate_closest(simulation.get(), x.data(), &place) == PALPATE_OK);
  return place;
}

/// A bar that is pulled by 2 % at its upper end, whose cross-section is free to shrink.
const std::string bar_text =
    replaced(replaced(block_text, "[0.06, 0.06, 0.03]", "[0.02, 0.02, 0.06]"), "0.012", "0.005") + R"([[prescribed]]
name = "top"
shape = "near-plane"
point = [0, 0, 0.06]
normal = [0, 0, 1]
distance = 1e-6
translation = [0, 0, 0.0012]
duration = 0.2
[dynamics]
damping = 100
[tool]
shape = "sphere"
radius = 0.01
position = [0, 0, 0.1]
)";

}  // namespace

TEST_CASE("A pulled bar's stress is its reaction over its cross-section, with the materials in force",
          "[api][fields][whole]") {
  const ModelHandle model = loadBlock(bar_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  CHECK(reactions(simulation).isZero(0));
  const PointsHandle points = pointsOf(model, PALPATE_INTEGRATION_POINTS);
  const Rows X = rest(points, info.point_count);
  REQUIRE(palpate_step(simulation.get(), 600, nullptr, nullptr) == PALPATE_OK);

  constexpr double area = 0.02 * 0.02, strain = 0.02;
  const auto checkStress = [&](double young) {
    const Eigen::Matrix<double, 2, 3> force = reactions(simulation);
    CHECK(force(1, 2) == Approx(young * strain * area).epsilon(0.05));  // the ends are bonded, and large strains
    CHECK(force(0, 2) == Approx(-force(1, 2)).epsilon(0.01));
    const Stresses all(simulation, points, info.point_count);
    double stress = 0, sideways = 0, volume = 0;
    int count = 0;
    for (int q = 0; q < info.point_count; ++q) {
      if (std::abs(X(q, 2) - 0.03) > 0.01) continue;
      stress += all.stress[static_cast<std::size_t>(q)](2, 2);
      sideways += all.stress[static_cast<std::size_t>(q)](0, 0);
      volume += all.J[static_cast<std::size_t>(q)];
      ++count;
    }
    REQUIRE(count > 20);
    const double thinner = 1 - 0.9 * strain;  // (1 - nu strain)^2
    CHECK(stress / count == Approx(force(1, 2) / (area * thinner)).epsilon(0.02));
    CHECK(std::abs(sideways / count) < 0.03 * stress / count);
    CHECK(volume / count == Approx(1 + 0.1 * strain).margin(3e-4));
  };
  checkStress(3000);
  const double softer = 1500;
  const palpate_parameter young{"young", &softer, 1};
  REQUIRE(palpate_set_material(simulation.get(), 0, &young, 1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 600, nullptr, nullptr) == PALPATE_OK);
  checkStress(1500);

  // A material point has the stress of the integration point that is nearest.
  const PointsHandle one = pointsAt(model, X.row(7));
  const Stresses at_one(simulation, one, 1), all(simulation, points, info.point_count);
  CHECK(at_one.stress[0] == all.stress[7]);
  CHECK(at_one.J[0] == all.J[7]);
  CHECK(all.stress[7] == all.stress[7].transpose());

  REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
  CHECK(reactions(simulation).isZero(0));
}

TEST_CASE("The stresses of a body at rest are in balance with what presses it", "[api][fields][whole]") {
  const std::string incompressible = replaced(touched_block_text, "poisson = 0.45", "poisson = 0.49");
  const std::string relaxing =
      replaced(touched_block_text, "poisson = 0.45", "poisson = 0.45\nrelaxation = [[0.4, 0.05]]");
  for (const std::string& text : {touched_block_text, incompressible, relaxing}) {
    const ModelHandle model = loadBlock(text);
    const palpate_model_info info = describe(model);
    const SimulationHandle simulation = create(model);
    const PointsHandle points = pointsOf(model, PALPATE_INTEGRATION_POINTS);
    std::vector<double> volume(static_cast<std::size_t>(info.point_count));
    REQUIRE(palpate_points_rest(points.get(), nullptr, volume.data(), info.point_count) == PALPATE_OK);
    CHECK(std::accumulate(volume.begin(), volume.end(), 0.0) == Approx(0.06 * 0.06 * 0.03).epsilon(0.01));
    press(simulation, info, 0, 60);
    const double stiffer = 3500;
    const palpate_parameter young{"young", &stiffer, 1};
    REQUIRE(palpate_set_material(simulation.get(), 0, &young, 1, nullptr) == PALPATE_OK);
    for (const int ticks : {20, 1500}) {  // it still relaxes, and does no longer
      REQUIRE(palpate_step(simulation.get(), ticks, nullptr, nullptr) == PALPATE_OK);
      // int sigma_zz dv = sum z f_z over the forces from outside; at the base z is 0.
      const Stresses all(simulation, points, info.point_count);
      double inside = 0, outside = 0;
      for (std::size_t q = 0; q < volume.size(); ++q) inside += volume[q] * all.J[q] * all.stress[q](2, 2);
      std::int32_t count = 0;
      Rows position(4096, 3), force(4096, 3);
      REQUIRE(palpate_contact_points(simulation.get(), position.data(), nullptr, force.data(), nullptr, 4096, &count) ==
              PALPATE_OK);
      for (int k = 0; k < count; ++k) outside += position(k, 2) * force(k, 2);
      CHECK(outside < 0);
      CHECK(inside == Approx(outside).epsilon(ticks > 20 ? 0.01 : 0.1));
    }
  }
}

TEST_CASE("Displacements at nodes, material points and the skin are one field, and velocities its change",
          "[api][fields]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const PointsHandle nodes = pointsOf(model, PALPATE_NODES);
  const Rows X = rest(nodes, info.node_count), skin_rest = skin(simulation, info);
  const PointsHandle given = pointsAt(model, X), on_skin = pointsAt(model, skin_rest);
  CHECK(displacements(simulation, nodes, info.node_count).isZero(0));
  CHECK(velocities(simulation, nodes, info.node_count).isZero(0));
  CHECK(rest(given, info.node_count) == X);

  press(simulation, info, 0, 60);
  const Rows before = displacements(simulation, nodes, info.node_count);
  const Rows v_before = velocities(simulation, nodes, info.node_count);
  press(simulation, info, 60, 61);
  const Rows u = displacements(simulation, nodes, info.node_count);
  const Rows v = velocities(simulation, nodes, info.node_count);
  CHECK(u.rowwise().norm().maxCoeff() > 0.001);
  CHECK((displacements(simulation, given, info.node_count) - u).norm() < 1e-6 * u.norm());
  CHECK((displacements(simulation, on_skin, info.skin_vertex_count) - (skin(simulation, info) - skin_rest)).norm() <
        1e-5 * u.norm());
  const Rows mean = info.rate_hz * (u - before);
  CHECK((0.5 * (v + v_before) - mean).norm() < 0.2 * mean.norm());
  CHECK(mean.norm() > 0);
}

TEST_CASE("Contact points carry the tool's force along their normals, on the skin", "[api][fields]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  std::int32_t count = -1;
  REQUIRE(palpate_contact_points(simulation.get(), nullptr, nullptr, nullptr, nullptr, 0, &count) == PALPATE_OK);
  CHECK(count == 0);
  const palpate_state state = press(simulation, info, 0, 100);
  REQUIRE(palpate_contact_points(simulation.get(), nullptr, nullptr, nullptr, nullptr, 0, &count) == PALPATE_OK);
  REQUIRE(count > 3);
  CHECK(count == state.contact_count);
  Rows position(count, 3), normal(count, 3), force(count, 3);
  std::vector<std::int32_t> tool(static_cast<std::size_t>(count), -1);
  REQUIRE(palpate_contact_points(simulation.get(), position.data(), normal.data(), force.data(), tool.data(), count,
                                 &count) == PALPATE_OK);
  const Vector3d on_tool(state.force[0], state.force[1], state.force[2]);
  CHECK((force.colwise().sum().transpose() + on_tool).norm() < 1e-5 * on_tool.norm());
  for (int k = 0; k < count; ++k) {
    CHECK(normal.row(k).norm() == Approx(1));
    CHECK(force.row(k).dot(normal.row(k)) < -0.99 * force.row(k).norm());  // no friction
    CHECK(std::abs(closest(simulation, position.row(k)).distance) < 1e-6);
    CHECK(tool[static_cast<std::size_t>(k)] == 0);
  }
  double first[3] = {0, 0, 0};
  REQUIRE(palpate_contact_points(simulation.get(), first, nullptr, nullptr, nullptr, 1, &count) == PALPATE_OK);
  CHECK(count == force.rows());
  CHECK(first[2] == position(0, 2));
}

TEST_CASE("The closest place of the skin and a ray's first are on the skin as it is now", "[api][fields]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  palpate_skin_point place = closest(simulation, {0.001, 0.002, 0.05});
  CHECK(place.distance == Approx(0.02));
  CHECK(place.normal[2] == Approx(1));
  CHECK(Vector3d(place.point[0], place.point[1], place.point[2]).isApprox(Vector3d(0.001, 0.002, 0.03)));
  CHECK(closest(simulation, {0, 0.001, 0.026}).distance == Approx(-0.004));
  place = ray(simulation, {0.001, 0.002, 0.1}, {0, 0, -3});
  CHECK(place.distance == Approx(0.07));
  CHECK(ray(simulation, {0.001, 0.002, 0.1}, {0, 0, 1}).triangle == -1);

  const palpate_state state = press(simulation, info, 0, 100);
  const Rows now = skin(simulation, info);
  std::vector<std::int32_t> corners(3 * static_cast<std::size_t>(info.skin_triangle_count));
  REQUIRE(palpate_skin_triangles(model.get(), corners.data(), info.skin_triangle_count) == PALPATE_OK);
  const Vector3d above(state.pose[0], state.pose[1], 0.1);
  const palpate_skin_point under = ray(simulation, above, {0, 0, -1});
  CHECK(under.point[2] == Approx(state.pose[2]).margin(2e-4));  // the tip stands there
  CHECK(0.1 - under.distance == Approx(under.point[2]));
  for (const palpate_skin_point& found : {under, closest(simulation, {0.002, 0.003, 0.05})}) {
    REQUIRE(found.triangle >= 0);
    Vector3d x = Vector3d::Zero();
    for (std::size_t c = 0; c < 3; ++c)
      x += found.barycentric[c] * now.row(corners[3 * static_cast<std::size_t>(found.triangle) + c]).transpose();
    CHECK((x - Vector3d(found.point[0], found.point[1], found.point[2])).norm() < 1e-7);
    CHECK(Vector3d(found.normal[0], found.normal[1], found.normal[2]).norm() == Approx(1));
  }
}

TEST_CASE("Displacements of points take no lock and allocate nothing", "[api][fields]") {
  if (!guardAvailable()) return;
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const PointsHandle nodes = pointsOf(model, PALPATE_NODES);
  Rows u(info.node_count, 3);
  startGuard();
  const std::int32_t code = palpate_displacements(simulation.get(), nodes.get(), u.data(), info.node_count);
  const GuardCounts counts = stopGuard();
  CHECK(code == PALPATE_OK);
  CHECK(counts.total() == 0);
}

TEST_CASE("A question that can't be meant is refused and changes nothing", "[api][fields]") {
  const ModelHandle model = loadBlock(), other = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model);
  press(handle, info, 0, 30);
  palpate_simulation* const simulation = handle.get();
  const std::uint64_t before = hashOf(handle);
  const PointsHandle nodes = pointsOf(model, PALPATE_NODES), foreign = pointsOf(other, PALPATE_NODES);
  std::vector<double> out(3 * static_cast<std::size_t>(info.node_count));
  auto error = sized<palpate_error>();
  palpate_points* none = nullptr;
  const auto refused = [&](const Rows& X, const char* text) {
    CHECK(palpate_points_create(model.get(), X.data(), static_cast<int>(X.rows()), &none, &error) ==
          PALPATE_BAD_ARGUMENT);
    CHECK(none == nullptr);
    CHECK_THAT(error.text, Catch::Contains(text));
  };
  Rows X(3, 3);
  X << 0, 0, 0.01, 0.001, 0, 0.02, 0, 0, 0.033;
  refused(X, "point 2 at ");
  X.row(1) = Vector3d(1e9, 0, 0);
  refused(X, "point 1 at ");
  X(0, 1) = std::nan("");
  refused(X, "point 0 is not finite");
  refused(Rows(0, 3), "count");
  CHECK(palpate_points_of(model.get(), 2, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_points_of(nullptr, 0, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_points_rest(nodes.get(), out.data(), nullptr, 1) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_points_rest(nodes.get(), nullptr, out.data(), info.node_count) == PALPATE_BAD_ARGUMENT);
  const int n = info.node_count;
  CHECK(palpate_displacements(simulation, nodes.get(), out.data(), n - 1) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_displacements(simulation, nodes.get(), nullptr, n) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_displacements(simulation, foreign.get(), out.data(), n) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_velocities(simulation, foreign.get(), out.data(), n) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_stresses(simulation, nullptr, nullptr, out.data(), n) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_reactions(simulation, out.data(), nullptr, 2) == PALPATE_BAD_ARGUMENT);
  std::int32_t count = 0;
  CHECK(palpate_contact_points(simulation, nullptr, nullptr, nullptr, nullptr, -1, &count) == PALPATE_BAD_ARGUMENT);
  auto place = sized<palpate_skin_point>();
  const double zero[3] = {0, 0, 0}, endless[3] = {0, HUGE_VAL, 0};
  CHECK(palpate_closest(simulation, endless, &place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_ray(simulation, zero, zero, &place) == PALPATE_BAD_ARGUMENT);
  place.size = 0;
  CHECK(palpate_closest(simulation, zero, &place) == PALPATE_BAD_ARGUMENT);
  CHECK(hashOf(handle) == before);

  REQUIRE(palpate_start(simulation, PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  place.size = sizeof place;
  CHECK(palpate_displacements(simulation, nodes.get(), out.data(), n) == PALPATE_OK);
  CHECK(palpate_closest(simulation, zero, &place) == PALPATE_OK);
  CHECK(palpate_velocities(simulation, nodes.get(), out.data(), n) == PALPATE_BUSY);
  CHECK(palpate_stresses(simulation, nodes.get(), nullptr, out.data(), n) == PALPATE_BUSY);
  CHECK(palpate_reactions(simulation, nullptr, nullptr, 1) == PALPATE_BUSY);
  CHECK(palpate_contact_points(simulation, nullptr, nullptr, nullptr, nullptr, 0, &count) == PALPATE_BUSY);
  REQUIRE(palpate_stop(simulation) == PALPATE_OK);
}

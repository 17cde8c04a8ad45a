#include "mechanics/cell_volume.h"
#include "mechanics/bounded_pressure.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <random>

#include "support/kernel_forces.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// A body with the shape functions at its nodes and all that the cells' volume needs.
struct PressedBody : TestBody {
  ShapeTable node_shape;
  NodePatches node_patches;
  std::vector<std::uint8_t> imposed;
  AlignedVector<float> friction;  // (node_count) Pa

  explicit PressedBody(int nodes_per_edge, const Material& material = Material::neoHookean(3000, 0.49, 1000),
                       bool two_materials = false)
      : TestBody(nodes_per_edge, 0.1, 1, 1.8, 0.1, 0.2, material) {
    if (two_materials) {
      materials.push_back(Material::neoHookean(9000, 0.49, 1000));
      for (std::size_t q = 0; q < point_X.size(); ++q) point_material[q] = point_X[q].y() > 0.05 ? 1 : 0;
    }
    std::vector<InadmissibleSupport> failed;
    node_shape = shapeFunctions(X, X, radius, Neighbours(X, radius), {2, 0.1}, failed);
    REQUIRE(failed.empty());
    node_patches = patches();
    imposed.assign(X.size(), 0);
    friction.assign(X.size(), 0);
  }
  CellVolumeSpec spec() const { return {X, cells, nodeCount(), node_shape, node_patches, imposed}; }
  /// Its nodes at this x are held.
  void hold(double x) {
    for (std::size_t a = 0; a < X.size(); ++a)
      if (std::abs(X[a].x() - x) < 1e-9) imposed[a] = 7;
  }

  std::vector<Vec3> fieldPositions(const std::vector<Vec3>& u) const {
    std::vector<Vec3> x = X;
    for (int a = 0; a < nodeCount(); ++a)
      for (int e = node_shape.begin[a]; e < node_shape.begin[a + 1]; ++e)
        x[a] += node_shape.N[e] * u[node_shape.node[e]];
    return x;
  }
  double pointVolume(const std::vector<Vec3>& u) const {
    double sum = 0;
    for (int q = 0; q < shape.rowCount(); ++q) sum += volume[q] * deformationGradient(shape, q, u).determinant();
    return sum;
  }
  double cellVolume(const std::vector<Vec3>& u) const {
    const auto x = fieldPositions(u);
    double sum = 0;
    for (const auto& c : cells) {
      const double rest = (X[c[1]] - X[c[0]]).cross(X[c[2]] - X[c[0]]).dot(X[c[3]] - X[c[0]]);
      sum += (rest < 0 ? -1 : 1) * (x[c[1]] - x[c[0]]).cross(x[c[2]] - x[c[0]]).dot(x[c[3]] - x[c[0]]) / 6;
    }
    return sum;
  }

  /// A displacement whose field is zero at all nodes of the surface: random parameters of about `size`, less what the
  /// surface sees of them.
  std::vector<Vec3> innerDisplacement(double size, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-size, size);
    std::vector<int> surface;
    for (int a = 0; a < nodeCount(); ++a)
      if ((X[a].array() == 0 || X[a].array() > 0.1 - 1e-9).any()) surface.push_back(a);
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(surface.size()), nodeCount()),
                    u(nodeCount(), 3);
    for (std::size_t k = 0; k < surface.size(); ++k)
      for (int e = node_shape.begin[surface[k]]; e < node_shape.begin[surface[k] + 1]; ++e)
        N(static_cast<Eigen::Index>(k), node_shape.node[e]) = node_shape.N[e];
    for (Eigen::Index i = 0; i < u.size(); ++i) u(i) = any(random);
    u -= N.transpose() * (N * N.transpose()).ldlt().solve(N * u);
    std::vector<Vec3> result;
    for (int a = 0; a < nodeCount(); ++a) result.emplace_back(u.row(a));
    return result;
  }

  /// Friction holds its nodes from this x on, but the first of them half.
  void holdByFriction(double x) {
    const double holds = held_from * materials[0].shear_modulus;
    for (std::size_t a = 0; a < X.size(); ++a)
      if (X[a].x() > x - 1e-9) friction[a] = static_cast<float>(X[a].x() < x + 1e-9 ? 0.5 * holds : 2 * holds);
  }

  /// A body pressed along x, the more the further: `most` at its end.
  std::vector<Vec3> pressedAtOneEnd(double most) const {
    std::vector<Vec3> u;
    for (const Vec3& at : X)
      u.emplace_back(-most * std::pow(at.x(), 4) / 4e-3, 1e-4 * std::sin(30 * at.z()), 0.03 * at.x());
    return u;
  }
};

std::vector<Vec3> times(double factor, std::vector<Vec3> u) {
  for (Vec3& a : u) a *= factor;
  return u;
}

template <class Real>
struct Evaluated {
  std::vector<Vec3> f;
  ForceReport report;
};

/// The fast kernel with or without the cells' volume.
template <class Real>
Evaluated<Real> evaluate(const PressedBody& body, const std::vector<Vec3>& u, bool cells = true, int threads = 1) {
  auto layout = makeKernelLayout<Real>(body.shape, body.point_X, body.volume, body.point_material, body.materials,
                                       body.nodeCount(), body.node_patches);
  if (cells) layout.cell_volume = makeCellVolume<Real>(body.spec());
  auto scratch = makeKernelScratch(layout);
  if (cells) scratch.cell_volume.friction = body.friction;
  SpinTeam team(threads);
  AlignedVector<Real4<Real>> u4, f(body.X.size());
  for (const auto& a : u) u4.push_back(toReal4<Real>(a));
  Evaluated<Real> result;
  result.report = internalForces(layout, makeKernelMaterials(layout, body.materials), u4.data(), scratch, team);
  sumForces(layout, scratch, 0, body.nodeCount(), f.data());
  for (const auto& a : f) result.f.push_back(toVec3(a));
  return result;
}

CellVolumeReference reference(const PressedBody& body, const std::vector<Vec3>& u) {
  std::vector<double> change;
  for (int q = 0; q < body.shape.rowCount(); ++q)
    change.push_back(deformationGradient(body.shape, q, u).determinant() - 1);
  return referenceCellVolume(body.spec(), body.volume, change,
                             patchShear(body.node_patches, body.point_material, body.materials), u, body.friction);
}

/// w_a of the nodes.
std::vector<double> weights(const PressedBody& body, const std::vector<Vec3>& u) {
  const auto shear = patchShear(body.node_patches, body.point_material, body.materials);
  std::vector<double> weight(body.X.size(), 0);
  for (int q = 0; q < body.shape.rowCount(); ++q) {
    const double change = deformationGradient(body.shape, q, u).determinant() - 1;
    for (const int a : body.node_patches.node[q])
      weight[a] =
          std::max(weight[a], pressedShare(body.node_patches.bulk_modulus[a] * change, pressure_limit * shear[a]));
  }
  return weight;
}

/// Forces of points and cells, plainly.
std::vector<Vec3> referenceForces(const PressedBody& body, const std::vector<Vec3>& u) {
  const CellVolumeReference cells = reference(body, u);
  const auto pressure = pointPressure(body.node_patches, cells.patch_pressure);
  std::vector<Vec3> f = cells.force;
  for (int q = 0; q < body.shape.rowCount(); ++q) {
    const Mat3 PV = body.volume[q] * body.materials[body.point_material[q]].firstPiola(
                                         deformationGradient(body.shape, q, u), pressure[q]);
    for (int e = body.shape.begin[q]; e < body.shape.begin[q + 1]; ++e)
      f[body.shape.node[e]] -= PV * body.shape.gradN[e];
  }
  return f;
}

}  // namespace

TEST_CASE("Inner displacements change the volume of the points to second order, but not that of the cells",
          "[cell_volume]") {
  // Why tissue under pressure gives way: sum_q w_q J_q is to depend on the boundary alone.
  const PressedBody body(5);
  const std::vector<Vec3> zero(body.X.size(), Vec3::Zero());
  double points_most = 0;
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto u = body.innerDisplacement(0.01, seed);
    double size = 0;  // m^3, of the second-order terms
    for (int q = 0; q < body.shape.rowCount(); ++q)
      size += body.volume[q] * (deformationGradient(body.shape, q, u) - Mat3::Identity()).squaredNorm();
    const auto second = [&](auto volume) { return volume(u) + volume(times(-1, u)) - 2 * volume(zero); };
    const double points = second([&](const auto& v) { return body.pointVolume(v); });
    const double cells = second([&](const auto& v) { return body.cellVolume(v); });
    points_most = std::max(points_most, std::abs(points) / size);
    INFO("points " << points / size << ", cells " << cells / size << " of sum V |H|^2");
    CHECK(std::abs(cells) < 1e-9 * size);  // rounding
    CHECK(std::abs(body.cellVolume(u) - 1e-3) < 1e-12 * 1e-3);
  }
  CHECK(points_most > 0.01);
}

TEST_CASE("Forces of patches and cells are minus the derivative of their energy", "[cell_volume]") {
  for (const auto& [two_materials, rubs] : {std::pair(false, false), {true, false}, {false, true}}) {
    PressedBody body(4, Material::neoHookean(3000, 0.49, 1000), two_materials);
    if (two_materials) body.hold(0.1);
    if (rubs) body.holdByFriction(0.1);
    const auto shear = patchShear(body.node_patches, body.point_material, body.materials);
    int checked = 0;
    for (const double most : {0.3, 0.4, 0.5, 0.6, 0.7}) {
      const auto u = body.pressedAtOneEnd(most);
      const CellVolumeReference at = reference(body, u);
      const auto weight = weights(body, u);
      int above = 0, below = 0, between = 0;
      for (std::size_t a = 0; a < body.X.size(); ++a) {
        above += at.cell_pressure[a] != 0 ? 1 : 0;
        below += std::abs(at.patch_pressure[a]) < 0.7 * pressure_limit * shear[a] ? 1 : 0;
        between += at.cell_pressure[a] != 0 && weight[a] < 1 ? 1 : 0;
      }
      if (above < 8 || below < 8 || between > 0) continue;
      ++checked;
      const auto f = evaluate<double>(body, u).f;
      const double e = 1e-6;
      for (int i = 0; i < body.nodeCount(); i += 3)
        for (int c = 0; c < 3; ++c) {
          const auto energyAt = [&](double way) {
            auto moved = u;
            moved[i][c] += way;
            return evaluate<double>(body, moved).report.strain_energy;
          };
          CHECK(-(energyAt(e) - energyAt(-e)) / (2 * e) == Approx(f[i][c]).epsilon(1e-5).margin(1e-6 * norm(f)));
        }
    }
    CHECK(checked > 0);  // with a node between the two, the change of its weight is left out
  }
}

TEST_CASE("The fast passes equal the plain formulas, the same bits for any number of threads",
          "[cell_volume][determinism]") {
  for (const bool two_materials : {false, true}) {
    PressedBody body(6, Material::neoHookean(3000, 0.49, 1000), two_materials);
    if (two_materials)
      body.hold(0.1);
    else
      body.holdByFriction(0.08);
    const Mat3 turn = Eigen::AngleAxisd(M_PI / 2, Vec3(0, 0.6, 0.8)).toRotationMatrix();
    auto turned = body.pressedAtOneEnd(0.5);
    for (std::size_t i = 0; i < turned.size(); ++i) turned[i] = turn * (body.X[i] + turned[i]) - body.X[i];
    for (const auto& u : {body.pressedAtOneEnd(0.5), turned, body.displacement(0.8 * Mat3::Identity())}) {
      const auto exact = referenceForces(body, u);
      const auto one = evaluate<double>(body, u);
      CHECK(distance(one.f, exact) < 1e-12 * norm(exact));
      CHECK(distance(one.f, evaluate<double>(body, u, false).f) > 1e-3 * norm(exact));  // cells have a part in it
      const auto in_float = evaluate<float>(body, u);
      CHECK(distance(in_float.f, exact) < 5e-5 * norm(exact));  // float's 1e-6 of J times K/mu
      CHECK(in_float.report.strain_energy == Approx(one.report.strain_energy).epsilon(1e-5));
      for (const int threads : {2, 3}) {
        CHECK(evaluate<double>(body, u, true, threads).f == one.f);
        CHECK(evaluate<float>(body, u, true, threads).f == in_float.f);
      }
    }
  }
}

TEST_CASE("Below the limit the cells change no bit, and under pressure a live material moves the limit",
          "[cell_volume]") {
  const PressedBody body(5);
  // K / mu is 50: 0.02 of the volume make 1 shear modulus, below 0.8 times the limit of 1.5.
  const auto u = body.pressedAtOneEnd(0.02);
  const auto with = evaluate<float>(body, u), without = evaluate<float>(body, u, false);
  CHECK(with.f == without.f);
  CHECK(with.report.strain_energy == without.report.strain_energy);
  auto softer = body;
  softer.materials[0].set("young", 1000);
  softer.materials[0].set("poisson", 0.498);  // five times K / mu
  CHECK(evaluate<float>(softer, u).f != evaluate<float>(softer, u, false).f);
}

TEST_CASE("A uniform dilatation beyond the limit costs what it would cost without one", "[cell_volume]") {
  const PressedBody body(5);
  for (const double stretch : {0.95, 1.05}) {
    const auto u = body.displacement(stretch * Mat3::Identity());
    const double theta = std::pow(stretch, 3) - 1, K = body.materials[0].bulk_modulus;
    const ForceReport report = evaluate<double>(body, u).report;
    CHECK(report.strain_energy == Approx(0.5 * K * theta * theta * 1e-3).epsilon(1e-9));
    if (stretch > 1) {
      CHECK(report.max_cell_pressure == 0);
      continue;
    }
    const double pressure = -K * theta / body.materials[0].shear_modulus;
    CHECK(report.max_cell_pressure == Approx(pressure).epsilon(1e-9));
    CHECK(report.max_patch_pressure == Approx(pressure_limit).epsilon(1e-9));
    CHECK(evaluate<double>(body, u, false).report.max_patch_pressure == Approx(pressure).epsilon(1e-9));
  }
}

TEST_CASE("On bonded faces patches keep their pressure, but where the body is held all around", "[cell_volume]") {
  PressedBody body(5);
  body.hold(0);
  body.hold(0.1);
  const auto limit = pressureLimits(body.spec());
  for (std::size_t a = 0; a < limit.size(); ++a)
    CHECK(limit[a] == (body.imposed[a] == 7 ? std::numeric_limits<double>::infinity() : pressure_limit));
  const double theta = std::pow(0.95, 3) - 1;
  CHECK(evaluate<double>(body, body.displacement(0.95 * Mat3::Identity())).report.strain_energy ==
        Approx(0.5 * body.materials[0].bulk_modulus * theta * theta * 1e-3).epsilon(1e-9));
  body.imposed.assign(body.X.size(), 7);
  for (const double everywhere : pressureLimits(body.spec())) CHECK(everywhere == pressure_limit);
}

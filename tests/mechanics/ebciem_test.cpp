#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "discretization/cells/background_cells.h"
#include "discretization/surface/facet_rule.h"
#include "mechanics/essential_boundary.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

// EBCIEM, paper eqs. 14-17, and what both methods share in float and double.

namespace {

SpinTeam team(2);

constexpr double edge = 0.1;  // m

/// A cube whose base is held, whose top is turned and shifted, and one of whose sides is held in x alone: two
/// component sets of unlike nodes.
struct Gripped {
  TestBody body{6, edge, 1};
  EssentialNodes essential;

  explicit Gripped(bool integrated) {
    for (int i = 0; i < body.nodeCount(); ++i) {
      const Vec3& x = body.X[i];
      ImposedNode node;
      node.node = i;
      if (x.z() == 0)
        node.boundary = {0, 0, 0};
      else if (x.z() > 0.9999 * edge)
        node.boundary = {1, 1, 1};
      else if (x.x() == 0)
        node.boundary = {2, -1, -1};
      else
        continue;
      essential.nodes.push_back(node);
      essential.X.push_back(x);
    }
    essential.phi = shape(essential.X);
    essential.motions.resize(3);
    BoundaryMotion& motion = essential.motions[1];
    motion.translation = Vec3(0.001, 0, -0.02);
    motion.axis_point = Vec3(0.05, 0.04, 0);
    motion.axis = Vec3(0, 0.6, 0.8);
    motion.angle = 0.3;
    motion.duration = 0.5;
    if (integrated) addFacets();
  }

  ShapeTable shape(const std::vector<Vec3>& at) const {
    std::vector<InadmissibleSupport> failed;
    ShapeTable table = shapeFunctions(at, body.X, body.radius, Neighbours(body.X, body.radius), {2, 0.1}, failed);
    REQUIRE(failed.empty());
    return table;
  }

  void addFacets() {
    std::vector<bool> imposed(body.X.size(), false);
    for (const auto& node : essential.nodes) imposed[node.node] = true;
    essential.facet_points = FacetRule::size;
    std::vector<Vec3> points;
    for (const auto& f : boundaryFacets(body.cells)) {
      if (!imposed[f[0]] || !imposed[f[1]] || !imposed[f[2]]) continue;
      essential.facets.push_back(f);
      const double area = (body.X[f[1]] - body.X[f[0]]).cross(body.X[f[2]] - body.X[f[0]]).norm() / 2;
      for (int k = 0; k < FacetRule::size; ++k) {
        points.push_back(FacetRule::point(k, body.X[f[0]], body.X[f[1]], body.X[f[2]]));
        essential.facet_weight.push_back(area * FacetRule::weight(k) * FacetRule::corners(k));
      }
    }
    essential.facet_phi = shape(points);
  }

  template <class Real>
  AlignedVector<Real> inverseMass() const {
    AlignedVector<Real> m;
    for (const double a : body.mass) m.push_back(static_cast<Real>(1 / a));
    return m;
  }

  /// The displacement field at imposed node k.
  template <class Real>
  Vec3 field(int k, const AlignedVector<Real4<Real>>& u) const {
    Vec3 v = Vec3::Zero();
    const ShapeTable& phi = essential.phi;
    for (int e = phi.begin[k]; e < phi.begin[k + 1]; ++e) v += phi.N[e] * toVec3(u[phi.node[e]]);
    return v;
  }

  /// Largest departure of the field from the motions at `time`, m.
  template <class Real>
  double departure(const AlignedVector<Real4<Real>>& u, double time, double since) const {
    double worst = 0;
    for (std::size_t k = 0; k < essential.nodes.size(); ++k)
      for (int c = 0; c < 3; ++c) {
        const int b = essential.nodes[k].boundary[c];
        if (b < 0) continue;
        const Vec3& X = essential.X[k];
        const double target = (essential.motions[b].at(X, time) - essential.motions[b].at(X, since))[c];
        worst = std::max(worst, std::abs(field(static_cast<int>(k), u)[c] - target));
      }
    return worst;
  }

  /// Phi or V of component c, dense (imposed node, node); rows of nodes without the component are absent.
  Eigen::MatrixXd dense(const ShapeTable& table) const {
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(table.rowCount(), body.nodeCount());
    for (int k = 0; k < table.rowCount(); ++k)
      for (int e = table.begin[k]; e < table.begin[k + 1]; ++e) m(k, table.node[e]) = table.N[e];
    return m;
  }
};

template <class Real>
AlignedVector<Real4<Real>> randomIncrement(int n, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-size, size);
  AlignedVector<Real4<Real>> du(n);
  for (auto& a : du) {
    const double x = unit(random), y = unit(random), z = unit(random);
    a = toReal4<Real>(Vec3(x, y, z));
  }
  return du;
}

/// Rows of the dense matrix of eq. 17 for the imposed nodes that a set names: V_jk over the facets all of whose
/// nodes are in the set, with hat functions and shape functions evaluated here.
Eigen::MatrixXd bruteForceV(const Gripped& g, const std::vector<int>& set_nodes, const Eigen::MatrixXd& phi_rows) {
  std::vector<int> row_of(g.body.X.size(), -1);
  for (std::size_t k = 0; k < set_nodes.size(); ++k) row_of[set_nodes[k]] = static_cast<int>(k);
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(set_nodes.size()), g.body.nodeCount());
  for (const auto& f : boundaryFacets(g.body.cells)) {
    if (row_of[f[0]] < 0 || row_of[f[1]] < 0 || row_of[f[2]] < 0) continue;
    const Vec3 &a = g.body.X[f[0]], &b = g.body.X[f[1]], &c = g.body.X[f[2]];
    const double area = (b - a).cross(c - a).norm() / 2;
    std::vector<Vec3> samples;
    for (int k = 0; k < FacetRule::size; ++k) samples.push_back(FacetRule::point(k, a, b, c));
    const Eigen::MatrixXd N = g.dense(g.shape(samples));
    for (int k = 0; k < FacetRule::size; ++k) {
      const Vec3& s = samples[k];
      const double hat[3] = {(b - s).cross(c - s).norm() / (2 * area), (c - s).cross(a - s).norm() / (2 * area),
                             (a - s).cross(b - s).norm() / (2 * area)};
      for (int v = 0; v < 3; ++v) V.row(row_of[f[v]]) += area * FacetRule::weight(k) * hat[v] * N.row(k);
    }
  }
  for (Eigen::Index k = 0; k < V.rows(); ++k)
    if (V.row(k).isZero(0)) V.row(k) = phi_rows.row(k);  // no facet of its own: lumped
  return V;
}

template <class Rows>
Eigen::MatrixXd denseOf(const Rows& rows, Eigen::Index columns) {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.begin.size()) - 1, columns);
  for (Eigen::Index k = 0; k < m.rows(); ++k)
    for (int e = rows.begin[k]; e < rows.begin[k + 1]; ++e) m(k, rows.column[e]) = rows.value[e];
  return m;
}

}  // namespace

TEST_CASE("EBCIEM imposes the field exactly, jointly over unlike component sets", "[essential_boundary][ebciem]") {
  const Gripped g(true);
  REQUIRE(g.essential.facets.size() > 100);
  const auto boundary = makeEssentialBoundary<double>(g.essential, g.body.mass);
  REQUIRE(boundary.sets.size() == 2);  // x; y and z
  auto scratch = makeBoundaryScratch(boundary);
  const auto inverse_mass = g.inverseMass<double>();
  const double alpha = 1e-7, time = 0.25;
  const auto u = randomIncrement<double>(g.body.nodeCount(), 1e-2, 5);
  auto du = randomIncrement<double>(g.body.nodeCount(), 1e-4, 3);
  imposeBoundary(boundary, time, 0.0, alpha, inverse_mass.data(), u.data(), du.data(), scratch, team);
  AlignedVector<Double4> all(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) all[i] = toReal4<double>(toVec3(u[i]) + toVec3(du[i]));
  double largest = 0;
  for (const auto& a : du) largest = std::max(largest, toVec3(a).norm());
  INFO("departure " << g.departure(all, time, 0) << " largest correction " << largest);
  CHECK(g.departure(all, time, 0) < 1e-14 * largest);  // rounding times the condition of A, about 100; the drift test
                                                       // below shows that a second correction removes it

  du = randomIncrement<double>(g.body.nodeCount(), 1e-4, 3);
  imposeBoundary(boundary, time, 1e-3, alpha, inverse_mass.data(), nullptr, du.data(), scratch, team);
  largest = 0;
  for (const auto& a : du) largest = std::max(largest, toVec3(a).norm());
  INFO("departure " << g.departure(du, time, time - 1e-3) << " largest correction " << largest);
  CHECK(g.departure(du, time, time - 1e-3) <
        1e-15 * edge);  // the motion's difference over the step rounds as its whole
}

TEST_CASE("V of EBCIEM is the integral of eq. 17, and its rows share out the facets' area",
          "[essential_boundary][ebciem]") {
  const Gripped g(true);
  const auto boundary = makeEssentialBoundary<double>(g.essential, g.body.mass);
  for (const auto& set : boundary.sets) {
    const Eigen::MatrixXd phi = denseOf(set.phi, g.body.nodeCount()), v = denseOf(set.v, g.body.nodeCount());
    const Eigen::MatrixXd expected = bruteForceV(g, set.node, phi);
    // Barycentric coordinates of coordinates of 0.1 m and facets of 0.02 m: some roundings each.
    CHECK((v - expected).norm() < 1e-13 * expected.norm());
    double area = 0;
    for (std::size_t k = 0; k < set.node.size(); ++k) {
      CHECK(set.share[k] == Approx(v.row(static_cast<Eigen::Index>(k)).sum()).epsilon(1e-13));
      area += set.share[k];
    }
    // Partition of unity: the shares sum to the area of the faces all of whose nodes are imposed.
    double expected_area = 0;
    for (const auto& f : g.essential.facets) {
      const auto in = [&](int node) { return std::find(set.node.begin(), set.node.end(), node) != set.node.end(); };
      if (!in(f[0]) || !in(f[1]) || !in(f[2])) continue;
      expected_area += (g.body.X[f[1]] - g.body.X[f[0]]).cross(g.body.X[f[2]] - g.body.X[f[0]]).norm() / 2;
    }
    CHECK(area == Approx(expected_area).epsilon(1e-12));
    CHECK(expected_area >= (set.mask[0] == 1 ? 3 : 2) * edge * edge * (1 - 1e-12));  // base and top, in x the side
  }
}

TEST_CASE("L U of EBCIEM is Phi M^-1 V, which is not symmetric, and solves as the dense matrix does",
          "[essential_boundary][ebciem]") {
  const Gripped g(true);
  const auto boundary = makeEssentialBoundary<double>(g.essential, g.body.mass);
  auto scratch = makeBoundaryScratch(boundary);
  const auto inverse_mass = g.inverseMass<double>();
  const int n = g.body.nodeCount();
  Eigen::VectorXd w(n);
  for (int i = 0; i < n; ++i) w[i] = 1 / g.body.mass[i];

  const double time = 0.3, alpha = 1e-7;
  const auto before = randomIncrement<double>(n, 1e-4, 3);
  auto du = before;
  imposeBoundary(boundary, time, 1e-3, alpha, inverse_mass.data(), nullptr, du.data(), scratch, team);
  for (const auto& set : boundary.sets) {
    const auto rows = static_cast<Eigen::Index>(set.node.size());
    const Eigen::MatrixXd phi = denseOf(set.phi, n), MV = w.asDiagonal() * bruteForceV(g, set.node, phi).transpose();
    const Eigen::MatrixXd A = phi * MV;
    CHECK((A - A.transpose()).norm() > 1e-3 * A.norm());  // or this test says nothing beyond SEBCIEM's
    Eigen::MatrixXd L = denseOf(set.l, rows), U = denseOf(set.u, rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      L(k, k) = 1;
      U(k, k) = 1 / set.inverse_pivot[k];
    }
    CHECK((L * U - A).norm() < 1e-13 * A.norm());  // no pivoting, no growth

    for (int c = 0; c < 3; ++c) {
      if (set.mask[c] == 0) continue;
      Eigen::VectorXd r(rows), u(n);
      for (int i = 0; i < n; ++i) u[i] = toVec3(before[i])[c];
      for (Eigen::Index k = 0; k < rows; ++k) {
        const auto& motion = g.essential.motions[set.boundary[k][c]];
        r[k] = (motion.at(set.X[k], time) - motion.at(set.X[k], time - 1e-3))[c];
      }
      const Eigen::VectorXd expected = u + MV * A.partialPivLu().solve(r - phi * u);  // eqs. 24-25
      double worst = 0;
      for (int i = 0; i < n; ++i) worst = std::max(worst, std::abs(toVec3(du[i])[c] - expected[i]));
      CHECK(worst < 1e-12 * 1e-4 * 100);  // rounding times the condition of A, about 100, of increments of 1e-4 m
    }
  }
}

TEST_CASE("Reactions of the nodes sum to the boundaries', which are the momentum that was added",
          "[essential_boundary][ebciem]") {
  for (const bool integrated : {false, true}) {
    const Gripped g(integrated);
    const auto boundary = makeEssentialBoundary<double>(g.essential, g.body.mass);
    auto scratch = makeBoundaryScratch(boundary);
    const auto inverse_mass = g.inverseMass<double>();
    const double alpha = 1e-7;
    const auto before = randomIncrement<double>(g.body.nodeCount(), 1e-4, 3);
    auto du = before;
    const Vec3 held =
        imposeBoundary(boundary, 0.3, 1e-3, alpha, inverse_mass.data(), nullptr, du.data(), scratch, team);

    Vec3 momentum = Vec3::Zero(), total = Vec3::Zero();
    for (std::size_t i = 0; i < du.size(); ++i) momentum += g.body.mass[i] * (toVec3(du[i]) - toVec3(before[i]));
    for (const auto& r : scratch.reaction) total += r.force;
    double size = 0;
    for (const auto& r : scratch.reaction) size += r.force.norm();
    CHECK((total - momentum / alpha).norm() < 1e-11 * size);
    CHECK((held - scratch.reaction[0].force - scratch.reaction[2].force).norm() < 1e-14 * size);

    std::vector<Vec3> node_force(g.body.X.size(), Vec3::Zero());
    addNodeReactions(boundary, scratch, alpha, node_force);
    std::vector<Vec3> force(3, Vec3::Zero()), moment(3, Vec3::Zero());
    for (std::size_t k = 0; k < g.essential.nodes.size(); ++k) {
      const auto& node = g.essential.nodes[k];
      for (int c = 0; c < 3; ++c)
        if (node.boundary[c] >= 0) force[node.boundary[c]][c] += node_force[node.node][c];
    }
    for (int b = 0; b < 3; ++b) CHECK((force[b] - scratch.reaction[b].force).norm() < 1e-12 * size);
    for (int i = 0; i < g.body.nodeCount(); ++i) {
      bool imposed = false;
      for (const auto& node : g.essential.nodes) imposed = imposed || node.node == i;
      if (!imposed) CHECK(node_force[i].norm() == 0);
    }
  }
}

TEST_CASE("A turning boundary's force and moment do its work", "[essential_boundary][ebciem]") {
  // Virtual work: sum_k F_k . d(u_bar at k) = F . d(shift) + M . axis d(angle) for nodes that all turn with the
  // boundary.
  for (const bool integrated : {false, true}) {
    const Gripped g(integrated);
    const auto boundary = makeEssentialBoundary<double>(g.essential, g.body.mass);
    auto scratch = makeBoundaryScratch(boundary);
    const auto inverse_mass = g.inverseMass<double>();
    const double alpha = 1e-7, time = 0.3, e = 1e-5;
    auto du = randomIncrement<double>(g.body.nodeCount(), 1e-4, 3);
    imposeBoundary(boundary, time, 1e-3, alpha, inverse_mass.data(), nullptr, du.data(), scratch, team);
    const BoundaryMotion& motion = g.essential.motions[1];
    double work = 0, scale = 0;
    for (std::size_t s = 0; s < boundary.sets.size(); ++s) {
      const auto& set = boundary.sets[s];
      for (std::size_t k = 0; k < set.node.size(); ++k)
        for (int c = 0; c < 3; ++c) {
          if (set.boundary[k][c] != 1) continue;
          const Vec3& X = set.centre[k];  // where V lets the traction act
          const double force = set.share[k] * toVec3(scratch.rhs[s][k])[c] / alpha;
          const double velocity = (motion.at(X, time + e) - motion.at(X, time - e))[c] / (2 * e);
          work += force * velocity;
          scale += std::abs(force * velocity);
        }
    }
    const double rate =
        (motion.curve.at(time + e, motion.duration) - motion.curve.at(time - e, motion.duration)) / (2 * e);
    const Reaction& r = scratch.reaction[1];
    // The arm counts from the axis as it stands; the shift, on top, moves it along.
    const Vec3 shift = motion.curve.at(time, motion.duration) * motion.translation;
    const double power =
        rate * (r.force.dot(motion.translation) + (r.moment - shift.cross(r.force)).dot(motion.axis) * motion.angle);
    CHECK(work == Approx(power).epsilon(1e-7).margin(1e-8 * scale));  // e^2 times the curve's third derivative
    CHECK(std::abs(r.moment.dot(motion.axis)) > 1e-3 * scale * edge / 1.0);
  }
}

TEST_CASE("The boundaries' moments are those of what was added", "[essential_boundary][ebciem]") {
  // At rest sum_j V_jk X_j is where the traction of node k acts: the moments are those of the momentum, to rounding.
  for (const bool integrated : {false, true}) {
    Gripped g(integrated);
    const Vec3 about(0.05, 0.04, 0);
    for (auto& motion : g.essential.motions) {
      motion = {};
      motion.axis_point = about;
    }
    const auto boundary = makeEssentialBoundary<double>(g.essential, g.body.mass);
    auto scratch = makeBoundaryScratch(boundary);
    const auto inverse_mass = g.inverseMass<double>();
    const double alpha = 1e-7;
    // A twist of the whole body that the boundaries undo.
    AlignedVector<Double4> before, du;
    for (const auto& x : g.body.X) before.push_back(toReal4<double>(1e-3 * Vec3::UnitZ().cross(x - about)));
    du = before;
    imposeBoundary(boundary, 0.3, 1e-3, alpha, inverse_mass.data(), nullptr, du.data(), scratch, team);
    Vec3 added = Vec3::Zero(), moment = Vec3::Zero();
    double size = 0;
    for (std::size_t i = 0; i < du.size(); ++i)
      added += (g.body.X[i] - about).cross(g.body.mass[i] * (toVec3(du[i]) - toVec3(before[i]))) / alpha;
    for (const auto& r : scratch.reaction) {
      moment += r.moment;
      size += r.moment.norm();
    }
    INFO("integrated " << integrated << ": added " << added.transpose() << " reported " << moment.transpose());
    CHECK((moment - added).norm() < 1e-11 * size);
  }
}

TEST_CASE("Imposing the whole displacement leaves no drift - increments in float drift little",
          "[essential_boundary][ebciem]") {
  constexpr int steps = 1000;
  const double dt = 1e-3, alpha = 1e-7;  // to 1 s, twice the motion's duration
  for (const bool integrated : {false, true}) {
    const Gripped g(integrated);
    const int n = g.body.nodeCount();
    AlignedVector<Double4> u(n), summed(n);
    const auto exact = makeEssentialBoundary<double>(g.essential, g.body.mass);
    const auto fast = makeEssentialBoundary<float>(g.essential, g.body.mass);
    auto exact_scratch = makeBoundaryScratch(exact);
    auto fast_scratch = makeBoundaryScratch(fast);
    const auto inverse_mass = g.inverseMass<double>();
    const auto inverse_mass_float = g.inverseMass<float>();
    for (int k = 1; k <= steps; ++k) {
      auto du = randomIncrement<double>(n, 1e-5, static_cast<unsigned>(k));
      AlignedVector<Float4> du_float(n);
      for (int i = 0; i < n; ++i) du_float[i] = toFloat4(toVec3(du[i]));
      imposeBoundary(exact, k * dt, 0.0, alpha, inverse_mass.data(), u.data(), du.data(), exact_scratch, team);
      imposeBoundary(fast, k * dt, dt, alpha, inverse_mass_float.data(), nullptr, du_float.data(), fast_scratch, team);
      for (int i = 0; i < n; ++i) {
        u[i] = toReal4<double>(toVec3(u[i]) + toVec3(du[i]));
        summed[i] = toReal4<double>(toVec3(summed[i]) + toVec3(du_float[i]));  // u's own rounding is not this test's
      }
    }
    const double absolute = g.departure(u, steps * dt, 0), incremental = g.departure(summed, steps * dt, 0);
    INFO("integrated " << integrated << " absolute " << absolute << " incremental " << incremental);
    CHECK(absolute < 1e-15 * edge);
    // Each step leaves float rounding, 6e-8 times the condition of A, about 100, of increments of 1e-5 m, which
    // nothing corrects later; a random walk of 1000 such steps is 30 times one.
    CHECK(incremental < 1e-8);
    CHECK(incremental > 1e-13);  // or the float path was not what ran
  }
}

#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "mechanics/essential_boundary.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

namespace {

SpinTeam team(2);

struct Clamped {
  TestBody body{6, 0.1, 1};
  EssentialNodes essential;

  template <class Choose>
  explicit Clamped(Choose choose) {
    for (int i = 0; i < body.nodeCount(); ++i) {
      ImposedNode node;
      node.node = i;
      node.boundary = {0, 0, 0};
      if (choose(body.X[i], node)) {
        essential.nodes.push_back(node);
        essential.X.push_back(body.X[i]);
      }
    }
    const Neighbours neighbours(body.X, body.radius);
    std::vector<InadmissibleSupport> failed;
    essential.phi = shapeFunctions(essential.X, body.X, body.radius, neighbours, {2, 0.1}, failed);
    REQUIRE(failed.empty());
    essential.motions.resize(1);
  }
  AlignedVector<float> inverseMass() const {
    AlignedVector<float> m;
    for (double a : body.mass) m.push_back(static_cast<float>(1 / a));
    return m;
  }
  Vec3 field(int row, const AlignedVector<Float4>& du) const {
    Vec3 v = Vec3::Zero();
    const ShapeTable& phi = essential.phi;
    for (int e = phi.begin[row]; e < phi.begin[row + 1]; ++e) v += phi.N[e] * toVec3(du[phi.node[e]]);
    return v;
  }
};

AlignedVector<Float4> randomIncrement(int n, double size) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-static_cast<float>(size), static_cast<float>(size));
  AlignedVector<Float4> du(n);
  for (auto& a : du) a = {unit(random), unit(random), unit(random), 0};
  return du;
}

}  // namespace

TEST_CASE("The field, not the parameters, is imposed at every boundary node", "[essential_boundary]") {
  // Bottom held, top moved along the 3-4-5 polynomial, one side held in x alone.
  Clamped c([](const Vec3& x, ImposedNode& n) {
    if (x.z() == 0) return true;
    if (x.z() > 0.0999) {
      n.boundary = {1, 1, 1};
      return true;
    }
    n.boundary = {0, -1, -1};
    return x.x() == 0;
  });
  BoundaryMotion motion;
  motion.translation = Vec3(0.001, 0, -0.02);
  motion.axis_point = Vec3(0.05, 0.05, 0);
  motion.angle = 0.3;
  motion.duration = 0.5;
  c.essential.motions.push_back(motion);
  const auto boundary = makeEssentialBoundary(c.essential, c.body.mass);
  auto scratch = makeBoundaryScratch(boundary);
  const auto inverse_mass = c.inverseMass();
  auto du = randomIncrement(c.body.nodeCount(), 1e-4);
  const auto before = du;
  const double alpha = 1e-7, time = 0.25, dt = 1e-3;
  imposeBoundary(boundary, time, dt, alpha, inverse_mass.data(), nullptr, du.data(), scratch, team);

  double worst = 0;
  for (std::size_t k = 0; k < c.essential.nodes.size(); ++k) {
    const Vec3 v = c.field(static_cast<int>(k), du), X = c.essential.X[k];
    const Vec3 target =
        c.essential.nodes[k].boundary[0] == 0 ? Vec3(0, 0, 0) : Vec3(motion.at(X, time) - motion.at(X, time - dt));
    for (int d = 0; d < 3; ++d)
      if (c.essential.nodes[k].boundary[d] >= 0) worst = std::max(worst, std::abs(v[d] - target[d]));
  }
  CHECK(worst < 1e-9);  // float32 of increments of 1e-4 with a condition of about 1e2

  // Without motions the reaction is the momentum that was added: sum m_i (du - du~) / alpha.
  c.essential.motions[1] = {};
  const auto held = makeEssentialBoundary(c.essential, c.body.mass);
  auto held_scratch = makeBoundaryScratch(held);
  du = before;
  const Vec3 reaction =
      imposeBoundary(held, time, dt, alpha, inverse_mass.data(), nullptr, du.data(), held_scratch, team);
  Vec3 momentum = Vec3::Zero();
  for (std::size_t i = 0; i < du.size(); ++i) momentum += c.body.mass[i] * (toVec3(du[i]) - toVec3(before[i]));
  CHECK((reaction - momentum / alpha).norm() < 1e-4 * reaction.norm());
}

TEST_CASE("SEBCIEM in sparse factors equals the dense matrix of the paper", "[essential_boundary]") {
  Clamped c([](const Vec3& x, ImposedNode&) { return x.z() == 0; });
  const auto boundary = makeEssentialBoundary(c.essential, c.body.mass);
  auto scratch = makeBoundaryScratch(boundary);
  const auto inverse_mass = c.inverseMass();
  auto du = randomIncrement(c.body.nodeCount(), 1e-4);

  // eq. 24-25 with dense matrices, z component
  const int n = c.body.nodeCount(), rows = c.essential.phi.rowCount();
  Eigen::MatrixXd phi = Eigen::MatrixXd::Zero(rows, n);
  for (int k = 0; k < rows; ++k)
    for (int e = c.essential.phi.begin[k]; e < c.essential.phi.begin[k + 1]; ++e)
      phi(k, c.essential.phi.node[e]) = c.essential.phi.N[e];
  Eigen::VectorXd u(n), w(n);
  for (int i = 0; i < n; ++i) {
    u[i] = du[i].z;
    w[i] = 1 / c.body.mass[i];
  }
  const Eigen::MatrixXd MV = w.asDiagonal() * phi.transpose();
  const Eigen::VectorXd expected = u - MV * (phi * MV).ldlt().solve(phi * u);

  imposeBoundary(boundary, 0.1, 1e-3, 1e-7, inverse_mass.data(), nullptr, du.data(), scratch, team);
  double worst = 0;
  for (int i = 0; i < n; ++i) worst = std::max(worst, std::abs(du[i].z - expected[i]));
  CHECK(worst < 1e-9);
}

TEST_CASE("The 3-4-5 polynomial starts and ends at rest", "[essential_boundary]") {
  BoundaryMotion m;
  m.translation = Vec3(0, 0, 2);
  m.duration = 4;
  const auto z = [&](double time) { return m.at(Vec3(1, 2, 3), time).z(); };
  CHECK(z(-1) == 0);
  CHECK(z(0) == 0);
  CHECK(z(2) == Approx(1));
  CHECK(z(4) == Approx(2));
  CHECK(z(9) == Approx(2));
  CHECK(z(1e-3) < 1e-9);  // 20 t^3 with t = 2.5e-4
}

TEST_CASE("A rotation by a table turns about its axis, and a translation comes on top", "[essential_boundary]") {
  BoundaryMotion m;
  m.axis_point = Vec3(1, 0, 0);
  m.angle = M_PI;
  m.translation = Vec3(0, 0, 0.5);
  m.curve.kind = LoadCurve::Kind::Table;
  m.curve.time = {0, 1, 3};
  m.curve.fraction = {0, 0.5, 1};
  CHECK((m.at(Vec3(2, 0, 0), 0.5) - Vec3(std::cos(M_PI / 4) - 1, std::sin(M_PI / 4), 0.125)).norm() < 1e-15);
  CHECK((m.at(Vec3(2, 0, 0), 1) - Vec3(-1, 1, 0.25)).norm() < 1e-15);
  CHECK((m.at(Vec3(2, 0, 0), 7) - Vec3(-2, 0, 0.5)).norm() < 1e-15);
  CHECK(m.at(Vec3(1, 0, 9), 2).isApprox(Vec3(0, 0, 0.375)));  // on the axis
}

TEST_CASE("However many threads impose, the bits are the same", "[essential_boundary][determinism]") {
  Clamped c([](const Vec3& x, ImposedNode& n) {
    if (x.z() > 0.0999) n.boundary = {1, 1, -1};
    return x.z() == 0 || x.z() > 0.0999;
  });
  BoundaryMotion motion;
  motion.translation = Vec3(0.001, 0, -0.02);
  motion.duration = 0.5;
  c.essential.motions.push_back(motion);
  const auto boundary = makeEssentialBoundary(c.essential, c.body.mass);
  const auto inverse_mass = c.inverseMass();
  const auto before = randomIncrement(c.body.nodeCount(), 1e-4);
  std::vector<AlignedVector<Float4>> results;
  std::vector<Vec3> held, moment;
  for (const int threads : {1, 2, 3}) {
    SpinTeam members(threads);
    auto scratch = makeBoundaryScratch(boundary);
    AlignedVector<Float4> du(before.begin(), before.end());
    held.push_back(
        imposeBoundary(boundary, 0.25, 1e-3, 1e-7, inverse_mass.data(), nullptr, du.data(), scratch, members));
    moment.push_back(scratch.reaction[1].moment);
    results.push_back(du);
  }
  for (int k = 1; k < 3; ++k) {
    CHECK(std::memcmp(results[0].data(), results[k].data(), results[0].size() * sizeof(Float4)) == 0);
    CHECK(held[0] == held[k]);
    CHECK(moment[0] == moment[k]);
  }
  CHECK(held[0].norm() > 0);
}

TEST_CASE("Coincident imposed nodes are refused by name", "[essential_boundary]") {
  Clamped c([](const Vec3& x, ImposedNode&) { return x.z() == 0; });
  c.essential.nodes.push_back(c.essential.nodes[4]);
  c.essential.X.push_back(c.essential.X[4]);
  ShapeTable& phi = c.essential.phi;
  for (int e = phi.begin[4]; e < phi.begin[5]; ++e) {
    phi.node.push_back(int(phi.node[e]));  // a copy: push_back may move what a reference names
    phi.N.push_back(double(phi.N[e]));
  }
  phi.begin.push_back(static_cast<int>(phi.node.size()));
  CHECK_THROWS_WITH(makeEssentialBoundary(c.essential, c.body.mass), Catch::Contains("coincide"));
}

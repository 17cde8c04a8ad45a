#include <catch2/catch.hpp>
#include <random>

#include "mechanics/essential_boundary.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

namespace {

struct Clamped {
  TestBody body{6, 0.1, 1};
  std::vector<ImposedNode> imposed;
  ShapeTable shape;

  template <class Choose>
  explicit Clamped(Choose choose) {
    std::vector<Vec3> X;
    for (int i = 0; i < body.nodeCount(); ++i) {
      ImposedNode node;
      node.node = i;
      if (choose(body.X[i], node)) {
        imposed.push_back(node);
        X.push_back(body.X[i]);
      }
    }
    const Neighbours neighbours(body.X, body.radius);
    std::vector<InadmissibleSupport> failed;
    shape = shapeFunctions(X, body.X, body.radius, neighbours, {2, 0.1}, failed);
    REQUIRE(failed.empty());
  }
  AlignedVector<float> inverseMass() const {
    AlignedVector<float> m;
    for (double a : body.mass) m.push_back(static_cast<float>(1 / a));
    return m;
  }
  Vec3 field(int row, const AlignedVector<Float4>& du) const {
    Vec3 v = Vec3::Zero();
    for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e) v += shape.N[e] * toVec3(du[shape.node[e]]);
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
      n.motion = {0, 0, 0};
      return true;
    }
    n.component = {true, false, false};
    return x.x() == 0;
  });
  const BoundaryMotion motion{Vec3(0.001, 0, -0.02), 0.5};
  const auto boundary = makeEssentialBoundary(c.imposed, {motion}, c.shape, c.body.mass);
  auto scratch = makeBoundaryScratch(boundary);
  const auto inverse_mass = c.inverseMass();
  auto du = randomIncrement(c.body.nodeCount(), 1e-4);
  const auto before = du;
  const double alpha = 1e-7, time = 0.25, dt = 1e-3;
  imposeBoundary(boundary, time, dt, alpha, inverse_mass.data(), du.data(), scratch);

  double worst = 0;
  for (std::size_t k = 0; k < c.imposed.size(); ++k) {
    const Vec3 v = c.field(static_cast<int>(k), du);
    const Vec3 target = c.imposed[k].motion[0] < 0 ? Vec3(0, 0, 0) : Vec3(motionAt(motion, time) - motionAt(motion, time - dt));
    for (int d = 0; d < 3; ++d)
      if (c.imposed[k].component[d]) worst = std::max(worst, std::abs(v[d] - target[d]));
  }
  CHECK(worst < 1e-9);  // float32 of increments of 1e-4 with a condition of about 1e2

  // Without motions the reaction is the momentum that was added: sum m_i (du - du~) / alpha.
  for (auto& node : c.imposed) node.motion = {-1, -1, -1};
  const auto held = makeEssentialBoundary(c.imposed, {}, c.shape, c.body.mass);
  auto held_scratch = makeBoundaryScratch(held);
  du = before;
  const Vec3 reaction = imposeBoundary(held, time, dt, alpha, inverse_mass.data(), du.data(), held_scratch);
  Vec3 momentum = Vec3::Zero();
  for (std::size_t i = 0; i < du.size(); ++i) momentum += c.body.mass[i] * (toVec3(du[i]) - toVec3(before[i]));
  CHECK((reaction - momentum / alpha).norm() < 1e-4 * reaction.norm());
}

TEST_CASE("SEBCIEM in sparse factors equals the dense matrix of the paper", "[essential_boundary]") {
  Clamped c([](const Vec3& x, ImposedNode&) { return x.z() == 0; });
  const auto boundary = makeEssentialBoundary(c.imposed, {}, c.shape, c.body.mass);
  auto scratch = makeBoundaryScratch(boundary);
  const auto inverse_mass = c.inverseMass();
  auto du = randomIncrement(c.body.nodeCount(), 1e-4);

  // eq. 24-25 with dense matrices, z component
  const int n = c.body.nodeCount(), rows = c.shape.rowCount();
  Eigen::MatrixXd phi = Eigen::MatrixXd::Zero(rows, n);
  for (int k = 0; k < rows; ++k)
    for (int e = c.shape.begin[k]; e < c.shape.begin[k + 1]; ++e) phi(k, c.shape.node[e]) = c.shape.N[e];
  Eigen::VectorXd u(n), w(n);
  for (int i = 0; i < n; ++i) {
    u[i] = du[i].z;
    w[i] = 1 / c.body.mass[i];
  }
  const Eigen::MatrixXd MV = w.asDiagonal() * phi.transpose();
  const Eigen::VectorXd expected = u - MV * (phi * MV).ldlt().solve(phi * u);

  imposeBoundary(boundary, 0.1, 1e-3, 1e-7, inverse_mass.data(), du.data(), scratch);
  double worst = 0;
  for (int i = 0; i < n; ++i) worst = std::max(worst, std::abs(du[i].z - expected[i]));
  CHECK(worst < 1e-9);
}

TEST_CASE("The 3-4-5 polynomial starts and ends at rest", "[essential_boundary]") {
  const BoundaryMotion m{Vec3(0, 0, 2), 4};
  CHECK(motionAt(m, -1) == Vec3(0, 0, 0));
  CHECK(motionAt(m, 0) == Vec3(0, 0, 0));
  CHECK(motionAt(m, 2).z() == Approx(1));
  CHECK(motionAt(m, 4).z() == Approx(2));
  CHECK(motionAt(m, 9).z() == Approx(2));
  CHECK(motionAt(m, 1e-3).z() < 1e-9);  // 20 t^3 with t = 2.5e-4
}

TEST_CASE("Coincident imposed nodes are refused by name", "[essential_boundary]") {
  Clamped c([](const Vec3& x, ImposedNode&) { return x.z() == 0; });
  c.imposed.push_back(c.imposed[4]);
  ShapeTable doubled = c.shape;
  for (int e = c.shape.begin[4]; e < c.shape.begin[5]; ++e) {
    doubled.node.push_back(c.shape.node[e]);
    doubled.N.push_back(c.shape.N[e]);
  }
  doubled.begin.push_back(static_cast<int>(doubled.node.size()));
  CHECK_THROWS_WITH(makeEssentialBoundary(c.imposed, {}, doubled, c.body.mass), Catch::Contains("coincide"));
}

#include "mechanics/local_mass.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "mechanics/internal_forces.h"
#include "mechanics/lanczos.h"
#include "support/law_lanes.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

namespace {

/// What the law's lanes say of a point.
struct Tangent {
  float cof2, J, squeeze, other;
  Tangent(const Material& m, const Mat3& F) {
    SimdTensor<float> H, P;
    for (int k = 0; k < 9; ++k) H[k] = static_cast<float>((F - Mat3::Identity())(k / 3, k % 3));
    const auto state = test::lanesFirstPiola(m, H, P);
    cof2 = state.cof2.v[0], J = state.J.v[0], squeeze = state.squeeze.v[0], other = state.other.v[0];
  }
};

struct Means {
  KernelLayout layout;
  StiffnessMeans means;
  explicit Means(const TestBody& body)
      : layout(makeKernelLayout<float>(body.shape, body.point_X, body.volume, body.point_material, body.materials,
                                       body.nodeCount())) {
    std::vector<std::array<int, 4>> vertices;
    for (const int c : body.point_cell) vertices.push_back(body.cells[c]);
    means = makeStiffnessMeans(layout, body.shape, vertices, body.volume, body.point_material, body.materials, {});
  }

  /// r_i of the nodes at a displacement.
  std::vector<double> at(const TestBody& body, const std::vector<Vec3>& u) const {
    std::vector<float> norm2(layout.point.size(), 3), J(layout.point.size(), 1), c(layout.point.size());
    std::vector<float> squeeze(layout.point.size()), other(layout.point.size());
    const Material& m = body.materials[0];
    const auto note = [&](std::size_t p, const Mat3& F) {
      const Tangent tangent(m, F);
      norm2[p] = tangent.cof2;
      J[p] = tangent.J;
      squeeze[p] = static_cast<float>(static_cast<double>(tangent.squeeze) / m.waveModulus());
      other[p] = static_cast<float>(static_cast<double>(tangent.other) / m.waveModulus());
    };
    for (std::size_t p = 0; p < layout.point.size(); ++p)
      note(p, layout.point[p] >= 0 ? deformationGradient(body.shape, layout.point[p], u) : Mat3::Identity());
    for (std::size_t p = 0; p < c.size(); p += 16) squeezedModulus(&norm2[p], &J[p], &squeeze[p], &other[p], &c[p]);
    std::vector<float> around;
    std::vector<double> r;
    for (int i = 0; i < body.nodeCount(); ++i) around.push_back(means.points.mean(i, c.data()));
    for (int i = 0; i < body.nodeCount(); ++i) r.push_back(means.nodes.mean(i, around.data()));
    return r;
  }
};

/// The largest eigenvalue of the tangent at u with these masses, 1/s^2.
double largestAt(const TestBody& body, const NodePatches& patches, const std::vector<Vec3>& u,
                 const std::vector<double>& mass) {
  std::vector<Vec3> f, f_beside, beside(u.size());
  referenceInternalForces(body.shape, body.volume, body.point_material, body.materials, u, f, patches);
  const auto apply = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    constexpr double reach = 1e-9;  // m
    double largest = 0;
    const auto part = [&](std::size_t i) {
      return Vec3(x.segment<3>(static_cast<Eigen::Index>(3 * i)) / std::sqrt(mass[i]));
    };
    for (std::size_t i = 0; i < u.size(); ++i) largest = std::max(largest, part(i).norm());
    for (std::size_t i = 0; i < u.size(); ++i) beside[i] = u[i] + reach / largest * part(i);
    referenceInternalForces(body.shape, body.volume, body.point_material, body.materials, beside, f_beside, patches);
    for (std::size_t i = 0; i < u.size(); ++i)
      y.segment<3>(static_cast<Eigen::Index>(3 * i)) = -largest / reach / std::sqrt(mass[i]) * (f_beside[i] - f[i]);
  };
  const LargestEigenvalue found = largestEigenvalue(static_cast<Eigen::Index>(3 * u.size()), apply, 60, 0.005);
  return found.value + found.residual;
}

}  // namespace

TEST_CASE("The modulus across a squeeze is that of the acoustic tensor", "[local_mass]") {
  for (const double nu : {0.2, 0.45, 0.499}) {
    const Material material = Material::neoHookean(3000, nu, 1000);
    const auto modulusOf = [&](const Mat3& F) {
      std::array<float, 16> norm2{}, J{}, squeeze{}, other{}, c{};
      const Tangent tangent(material, F);
      norm2.fill(tangent.cof2);
      J.fill(tangent.J);
      squeeze.fill(tangent.squeeze);
      other.fill(tangent.other);
      squeezedModulus(norm2.data(), J.data(), squeeze.data(), other.data(), c.data());
      if (hardlySqueezed(norm2.data(), J.data())) CHECK(c[0] <= hardly_squeezed_s2 * tangent.squeeze + tangent.other);
      return c[0];
    };
    CHECK(modulusOf(Mat3::Identity()) == Approx(material.waveModulus()).epsilon(2e-3));  // the root of rounding
    for (const double J : {0.6, 0.98, 1.0, 1.02, 1.3})
      for (const double l : {0.98, 0.95, 0.7, 0.4, 0.1}) {
        if (l > std::cbrt(J)) continue;  // z is not squeezed most
        const Mat3 F = Vec3(std::sqrt(J / l), std::sqrt(J / l), l).asDiagonal();
        // d^2 W (v n) (v n) of n = v = z, by differences of the stress.
        const double h = 1e-6 * l;
        Mat3 above = F, below = F;
        above(2, 2) += h;
        below(2, 2) -= h;
        const double exact = (material.firstPiola(above)(2, 2) - material.firstPiola(below)(2, 2)) / (2 * h);
        CAPTURE(nu, J, l);
        CHECK(modulusOf(F) >= (1 - 3e-4) * exact);
        CHECK(modulusOf(F) <= 1.02 * exact);
      }
  }
}

TEST_CASE("The stiffness of a node is a mean of its neighbourhood's", "[local_mass]") {
  const TestBody body(5, 0.1, 1);
  const Means of(body);
  const StiffnessMeans::Rows &points = of.means.points, &nodes = of.means.nodes;
  for (int i = 0; i < body.nodeCount(); ++i) {
    float of_points = 0, of_nodes = 0;
    for (int e = points.begin[i]; e < points.begin[i + 1]; ++e) of_points += points.weight[e];
    for (int e = nodes.begin[i]; e < nodes.begin[i + 1]; ++e) {
      of_nodes += nodes.weight[e];
      CHECK((body.X[nodes.index[e]] - body.X[i]).norm() < 1.5 * (body.radius[i] + 0.025 * std::sqrt(3.0)));
    }
    CHECK(of_points == Approx(1).epsilon(1e-5));
    CHECK(of_nodes == Approx(1).epsilon(1e-5));
    // The lists by which quiet groups are skipped have all that a group's rows have.
    const auto lists = [&](const StiffnessMeans::Lists& l, int entry) {
      const int g = i / StiffnessMeans::group_size;
      return std::find(&l.index[l.begin[g]], l.index.data() + l.begin[g + 1], entry) != l.index.data() + l.begin[g + 1];
    };
    for (int e = points.begin[i]; e < points.begin[i + 1]; ++e) CHECK(lists(of.means.batches, points.index[e] / 16));
    for (int e = nodes.begin[i]; e < nodes.begin[i + 1]; ++e)
      CHECK(lists(of.means.groups, nodes.index[e] / StiffnessMeans::group_size));
  }
  const double l = 0.5;  // evenly squeezed: no mean differs from what it is of
  const Material& m = body.materials[0];
  const double c = m.bulk_modulus / (l * l) + m.shear_modulus * (5.0 / 9 * (1 + 2 / (l * l * l)) - 1.0 / 3);
  const Mat3 F = Vec3(1 / std::sqrt(l), 1 / std::sqrt(l), l).asDiagonal();
  for (const double r : of.at(body, body.displacement(F))) CHECK(r == Approx(c / m.waveModulus()).epsilon(0.01));
}

TEST_CASE("With mass that follows the stiffness, no squeeze shortens the stable step", "[local_mass]") {
  for (const double nu : {0.3, 0.45, 0.49})
    for (const bool patched : {false, true}) {
      const TestBody body(5, 0.1, 1, 1.8, 0.1, 0.2, Material::neoHookean(3000, nu, 1000));
      const NodePatches patches = patched ? body.patches() : NodePatches();
      const Means of(body);
      const double at_rest = largestAt(body, patches, std::vector<Vec3>(body.X.size(), Vec3::Zero()), body.mass);
      for (const double l : {0.8, 0.6, 0.4}) {
        // A free block between plates; the same where it is held at the middle, and not elsewhere.
        const Mat3 even = Vec3(1 / std::sqrt(l), 1 / std::sqrt(l), l).asDiagonal();
        std::vector<Vec3> uneven = body.displacement(even);
        for (std::size_t i = 0; i < body.X.size(); ++i) {
          const double s = body.X[i].z() / 0.1;
          uneven[i] = Vec3(0, 0, -(1 - l) * 0.05 * (s - std::sin(2 * M_PI * s) / (2 * M_PI))) +
                      s * (1 - s) * Vec3(uneven[i].x(), uneven[i].y(), 0);
        }
        for (const auto& u : {body.displacement(even), uneven}) {
          const std::vector<double> r = of.at(body, u);
          std::vector<double> mass = body.mass;
          for (std::size_t i = 0; i < mass.size(); ++i) mass[i] *= std::max(r[i], 1.0);
          const double own = largestAt(body, patches, u, body.mass), followed = largestAt(body, patches, u, mass);
          INFO("nu " << nu << ", patches " << patched << ", to " << l << ": " << std::sqrt(own / at_rest) << " -> "
                     << std::sqrt(followed / at_rest));
          CHECK(followed < (1 + 1e-3) * own);
          CHECK(followed < at_rest);
        }
      }
    }
}

#include "mtled/matrix/one_dimensional.h"

#include <algorithm>
#include <cmath>

#include "mtled/matrix/follow.h"

namespace palpate::tools {
namespace {

constexpr int pieces = 240;

/// A piece's strain and what follows from it.
struct Piece {
  double ds = 0, weight = 0;  // m; of an energy density
  Mat3 F = Mat3::Zero(), by_slope = Mat3::Zero(), by_r = Mat3::Zero();

  Piece(const OneDimensional& p, double load, double s0, double s1, double r0, double r1) : ds(s1 - s0) {
    const double s = (s0 + s1) / 2, r = (r0 + r1) / 2, slope = (r1 - r0) / ds;
    by_slope(0, 0) = 1;
    F = Mat3::Identity();
    F(0, 0) = slope;
    if (p.kind == OneDimensional::Kind::Beam) {
      weight = ds;
      by_r(1, 1) = load * p.turn;
    } else {
      weight = ds * M_PI * s * (p.kind == OneDimensional::Kind::Sphere ? 4 * s : 2);
      by_r(1, 1) = 1 / s;
    }
    if (p.kind == OneDimensional::Kind::Sphere) by_r(2, 2) = 1 / s;
    if (p.kind == OneDimensional::Kind::Sphere) F(2, 2) = r / s;
    if (p.kind == OneDimensional::Kind::Cylinder) {
      by_r(1, 2) = load * p.turn;
      F(1, 2) = load * p.turn * r;
      F(2, 2) = 1 + load * (p.stretch - 1);
    }
    F(1, 1) = r * by_r(1, 1);
  }
};

}  // namespace

double OneDimensional::Answer::at(double where) const {
  const auto after = std::clamp<std::ptrdiff_t>(std::upper_bound(s.begin(), s.end(), where) - s.begin(), 1,
                                                static_cast<std::ptrdiff_t>(s.size()) - 1);
  const auto k = static_cast<std::size_t>(after);
  return r[k - 1] + (where - s[k - 1]) / (s[k] - s[k - 1]) * (r[k] - r[k - 1]);
}

OneDimensional::Answer OneDimensional::solve() const {
  Answer answer;
  std::vector<const Material*> material;
  const double size = zones.back().end - begin;
  double from = begin, modulus = 0;
  answer.s.push_back(begin);
  for (const Zone& zone : zones) {
    const int count = std::max(8, static_cast<int>(std::lround(pieces * (zone.end - from) / size)));
    for (int k = 1; k <= count; ++k) {
      answer.s.push_back(from + (zone.end - from) * k / count);
      material.push_back(&zone.material);
    }
    from = zone.end;
    modulus = std::max(modulus, zone.material.waveModulus());
  }
  const std::vector<double>& s = answer.s;
  const auto rAt = [&](const Eigen::VectorXd& x, double load, std::size_t k) {
    const double rest = kind == Kind::Beam ? s[k] + 1 / (load * turn) : s[k];
    return rest + x[static_cast<Eigen::Index>(k)];
  };
  const auto pieceAt = [&](const Eigen::VectorXd& x, double load, std::size_t k) {
    return Piece(*this, load, s[k], s[k + 1], rAt(x, load, k), rAt(x, load, k + 1));
  };
  const auto forces = [&](const Eigen::VectorXd& x, double load) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
    for (std::size_t k = 0; k + 1 < s.size(); ++k) {
      const Piece piece = pieceAt(x, load, k);
      const Mat3 P = material[k]->firstPiola(piece.F);
      const double by_slope = piece.weight * P.cwiseProduct(piece.by_slope).sum() / piece.ds,
                   by_r = piece.weight * P.cwiseProduct(piece.by_r).sum() / 2;
      f[static_cast<Eigen::Index>(k)] += by_r - by_slope;
      f[static_cast<Eigen::Index>(k) + 1] += by_r + by_slope;
    }
    return f;
  };
  const double unit = modulus * (kind == Kind::Beam ? 1 : kind == Kind::Sphere ? size * size : size);
  const auto residual = [&](const Eigen::VectorXd& x, double load) {
    Eigen::VectorXd f = forces(x, load) / unit;
    if (kind != Kind::Beam) f[0] = x[0] / size;
    if (end_held) f[f.size() - 1] = (x[x.size() - 1] - load * (held - s.back())) / size;
    return f;
  };
  const Eigen::VectorXd x = follow(residual, static_cast<Eigen::Index>(s.size()), size, 1);
  for (std::size_t k = 0; k < s.size(); ++k) answer.r.push_back(rAt(x, 1, k));
  if (kind == Kind::Sphere) {
    answer.force = forces(x, 1)[x.size() - 1];
    return answer;
  }
  for (std::size_t k = 0; k + 1 < s.size(); ++k) {
    const Piece piece = pieceAt(x, 1, k);
    const Mat3 P = material[k]->firstPiola(piece.F);
    const double r = (answer.r[k] + answer.r[k + 1]) / 2;
    answer.force += piece.weight * P(2, 2);
    answer.moment += piece.weight * r * (kind == Kind::Beam ? P(1, 1) : P(1, 2));
  }
  return answer;
}

}  // namespace palpate::tools

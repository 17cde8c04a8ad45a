#include "contact/skull_layer.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// Of the tissue's stiffness at a point: the points are half a spacing apart, so that four share what a node has. More
/// asks for smaller steps, less for more updates.
constexpr double stiffness_share = 0.1;

/// Fictitious mass a spring brings, over its row of the stiffness: keeps its frequency below the tissue's highest.
constexpr double mass_share = 6;

}  // namespace

SkullLayer::SkullLayer(const Skull& skull, const SkinModel& skin, std::vector<double>& mass)
    : skull_(skull), skin_(skin), point_(skull.vertex.size()) {
  const std::vector<double> tissue = mass;
  std::vector<double> row(mass.size(), 0);
  for (std::size_t p = 0; p < point_.size(); ++p) {
    const int v = skull.vertex[p];
    double sum = 0;
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
      const double N = std::abs(static_cast<double>(skin.N[e]));
      point_[p].stiffness += stiffness_share * N * tissue[static_cast<std::size_t>(skin.node[e])];
      sum += N;
    }
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
      row[static_cast<std::size_t>(skin.node[e])] +=
          point_[p].stiffness * std::abs(static_cast<double>(skin.N[e])) * sum;
  }
  for (std::size_t i = 0; i < mass.size(); ++i) {
    mass[i] += mass_share * row[i];
    highest_ = std::max(highest_, row[i] / mass[i]);  // Gershgorin
  }
  restart({});
}

Vec3 SkullLayer::positionOf(std::size_t p, const AlignedVector<Double4>& u) const {
  const int v = skull_.vertex[p];
  Vec3 x = skin_.surface.vertices[static_cast<std::size_t>(v)];
  if (u.empty()) return x;
  GroupOf<double> sum{};
  for (int e = skin_.begin[v]; e < skin_.begin[v + 1]; ++e)
    sum += static_cast<double>(skin_.N[e]) * load(u[static_cast<std::size_t>(skin_.node[e])]);
  return x + Vec3(sum[0], sum[1], sum[2]);
}

/// The distance's mean slope over a cell around x, which has no jumps; beside an opening that of the cell itself.
Vec3 SkullLayer::normalAt(const Vec3& x, const Vec3& of_cell) const {
  Vec3 slope, unused;
  for (int a = 0; a < 3; ++a) {
    const Vec3 half = 0.5 * skull_.cell * Vec3::Unit(a);
    const double up = skull_.at(x + half, unused), down = skull_.at(x - half, unused);
    if (std::max(up, down) >= static_cast<double>(Skull::away)) return of_cell.normalized();
    slope[a] = up - down;
  }
  return slope.squaredNorm() > 1e-6 * skull_.cell * skull_.cell ? slope.normalized() : of_cell.normalized();
}

void SkullLayer::takePlane(std::size_t p, const Vec3& x) {
  Vec3 normal;
  const double gap = skull_.at(x, normal);
  if (!(gap < static_cast<double>(Skull::away))) return;
  point_[p].normal = normalAt(x, normal);
  point_[p].offset = gap + static_cast<double>(skull_.correction[p]) - point_[p].normal.dot(x);
}

void SkullLayer::restart(const AlignedVector<Double4>& u) {
  for (std::size_t p = 0; p < point_.size(); ++p) {
    point_[p].preload = 0;
    point_[p].normal.setZero();
    Vec3 normal;
    const Vec3 rest = positionOf(p, {});
    if (!(skull_.at(rest, normal) < static_cast<double>(Skull::away))) continue;
    takePlane(p, rest);
    if (!u.empty()) takePlane(p, positionOf(p, u));
  }
}

void SkullLayer::addForces(const AlignedVector<Double4>& u, AlignedVector<Double4>& force) {
  contact_ = {};
  for (std::size_t p = 0; p < point_.size(); ++p) {
    const Point& point = point_[p];
    if (point.normal.isZero(0)) continue;
    const double gap = point.normal.dot(positionOf(p, u)) + point.offset;
    const double size = point.preload - point.stiffness * gap;
    if (!(size > 0)) continue;
    const Vec3 f = size * point.normal;
    contact_.force += f;
    contact_.max_penetration = std::max(contact_.max_penetration, -gap);
    ++contact_.count;
    const int v = skull_.vertex[p];
    const GroupOf<double> lanes{f.x(), f.y(), f.z(), 0};
    for (int e = skin_.begin[v]; e < skin_.begin[v + 1]; ++e) {
      Double4& node = force[static_cast<std::size_t>(skin_.node[e])];
      store(node, load(node) + static_cast<double>(skin_.N[e]) * lanes);
    }
  }
}

void SkullLayer::follow(const AlignedVector<Double4>& u) {
  for (std::size_t p = 0; p < point_.size(); ++p)
    if (!point_[p].normal.isZero(0)) takePlane(p, positionOf(p, u));
}

double SkullLayer::update(const AlignedVector<Double4>& u) {
  double worst = 0;
  for (std::size_t p = 0; p < point_.size(); ++p) {
    Point& point = point_[p];
    if (point.normal.isZero(0)) continue;
    const Vec3 x = positionOf(p, u);
    point.preload = std::max(0.0, point.preload - point.stiffness * (point.normal.dot(x) + point.offset));
    takePlane(p, x);
    const double gap = point.normal.dot(x) + point.offset;
    worst = std::max(worst, std::abs(std::min(gap, point.preload / point.stiffness)));
  }
  return worst;
}

}  // namespace palpate

#include "contact/rigid_layer.h"

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

RigidLayer::RigidLayer(const RigidBodies& bodies, const SkinModel& skin, std::vector<double>& mass)
    : bodies_(bodies), skin_(skin), place_(bodies.body.size()), point_(bodies.vertex.size()) {
  const std::vector<double> tissue = mass;
  std::vector<double> row(mass.size(), 0);
  for (std::size_t p = 0; p < point_.size(); ++p) {
    const int v = bodies.vertex[p];
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
  moveTo(0);
  restart({});
}

/// Calls call(p, point, b, body) for all points.
template <class Call>
void RigidLayer::forEachPoint(Call call) {
  for (std::size_t b = 0; b < bodies_.body.size(); ++b)
    for (int p = bodies_.body[b].begin; p < bodies_.body[b].end; ++p) {
      const auto at = static_cast<std::size_t>(p);
      call(at, point_[at], b, bodies_.body[b]);
    }
}

void RigidLayer::moveTo(double time) {
  for (std::size_t b = 0; b < place_.size(); ++b)
    if (bodies_.body[b].motion.moves()) place_[b] = bodies_.body[b].at(time);
}

/// In the body's frame, m.
Vec3 RigidLayer::positionOf(std::size_t p, std::size_t body, const AlignedVector<Double4>& u) const {
  const int v = bodies_.vertex[p];
  Vec3 x = skin_.surface.vertices[static_cast<std::size_t>(v)];
  if (!u.empty()) {
    GroupOf<double> sum{};
    for (int e = skin_.begin[v]; e < skin_.begin[v + 1]; ++e)
      sum += static_cast<double>(skin_.N[e]) * load(u[static_cast<std::size_t>(skin_.node[e])]);
    x += Vec3(sum[0], sum[1], sum[2]);
  }
  return bodies_.body[body].motion.moves() ? place_[body].toLocal(x) : x;
}

void RigidLayer::takePlane(std::size_t p, const RigidBody& body, const Vec3& X) {
  Vec3 normal;
  const double gap = body.shape.gapAt(X, normal);
  if (!(gap < RigidShape::away)) return;
  point_[p].normal = body.shape.normalAt(X, normal);
  point_[p].offset = gap + static_cast<double>(bodies_.correction[p]) - point_[p].normal.dot(X);
}

void RigidLayer::restart(const AlignedVector<Double4>& u) {
  forEachPoint([&](std::size_t p, Point& point, std::size_t b, const RigidBody& body) {
    point.preload = 0;
    point.normal.setZero();
    Vec3 normal;
    const Vec3 rest = skin_.surface.vertices[static_cast<std::size_t>(bodies_.vertex[p])];
    if (body.encloses && !(body.shape.gapAt(rest, normal) < RigidShape::away)) return;
    takePlane(p, body, rest);
    takePlane(p, body, positionOf(p, b, u));
  });
}

void RigidLayer::addForces(const AlignedVector<Double4>& u, AlignedVector<Double4>& force) {
  loads_ = {};
  forEachPoint([&](std::size_t p, const Point& point, std::size_t b, const RigidBody& body) {
    if (point.normal.isZero(0)) return;
    const double gap = point.normal.dot(positionOf(p, b, u)) + point.offset;
    const double size = point.preload - point.stiffness * gap;
    if (!(size > 0)) return;
    const Vec3 f = size * (body.motion.moves() ? Vec3(place_[b].orientation * point.normal) : point.normal);
    RigidLoad& load = loads_[b];
    load.force += f;
    load.max_penetration = std::max(load.max_penetration, -gap);
    ++load.count;
    const int v = bodies_.vertex[p];
    const GroupOf<double> lanes{f.x(), f.y(), f.z(), 0};
    for (int e = skin_.begin[v]; e < skin_.begin[v + 1]; ++e) {
      Double4& node = force[static_cast<std::size_t>(skin_.node[e])];
      store(node, palpate::load(node) + static_cast<double>(skin_.N[e]) * lanes);
    }
  });
}

void RigidLayer::follow(const AlignedVector<Double4>& u) {
  forEachPoint([&](std::size_t p, const Point& point, std::size_t b, const RigidBody& body) {
    if (body.encloses && point.normal.isZero(0)) return;
    takePlane(p, body, positionOf(p, b, u));
  });
}

double RigidLayer::update(const AlignedVector<Double4>& u) {
  double worst = 0;
  forEachPoint([&](std::size_t p, Point& point, std::size_t b, const RigidBody& body) {
    if (point.normal.isZero(0)) return;
    const Vec3 X = positionOf(p, b, u);
    point.preload = std::max(0.0, point.preload - point.stiffness * (point.normal.dot(X) + point.offset));
    takePlane(p, body, X);
    const double gap = point.normal.dot(X) + point.offset;
    worst = std::max(worst, std::abs(std::min(gap, point.preload / point.stiffness)));
  });
  return worst;
}

}  // namespace palpate

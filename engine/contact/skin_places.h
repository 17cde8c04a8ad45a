#pragma once

#include <array>

#include "contact/skin_contact.h"

// Which places of skins may touch each other: what skin_bodies.cpp and skin_search.cpp share.
namespace palpate {

/// Spacings at rest, from which on two places of one body may touch. Those that look at each other across a gap, from
/// `across_gap` on; nearer ones only where they look straight at each other (`opposite`, cosine of their normals), as
/// on both sides of a slit: others are moved by the same nodes. Others only where skin folds, from `along_skin` on:
/// nearer ones bend with each other, and what crumples between nodes is no contact (at 1.5 a gel that is 4.4 spacings
/// wide, pressed roughly, locked itself into folds that it had not without). `opposite` from -0.4 to -0.95 gives slits
/// and flaps of 1 mm the same forces.
constexpr double across_gap = 0.5, along_skin = 4, opposite = -0.7;

inline Vec3 unit(const Vec3& a) {
  const double length = a.norm();
  return length > 0 ? Vec3(a / length) : Vec3::Zero();
}

/// Two vertices may touch: they are of two bodies, or were far enough from each other at rest.
inline bool mayTouch(const SkinBodies& bodies, const SkinModel& skin, int v, int w) {
  if (bodies.body[v] != bodies.body[w]) return true;
  const auto &X = skin.surface.vertices, &N = bodies.normal;
  const Vec3 way = X[w] - X[v];
  const double distance2 = way.squaredNorm() / (bodies.spacing * bodies.spacing);
  return distance2 > along_skin * along_skin ||
         (N[v].dot(N[w]) < (distance2 > across_gap * across_gap ? 0 : opposite) && way.dot(N[v]) > 0 &&
          way.dot(N[w]) < 0);
}

/// Two clusters have vertices of one and the same body.
inline bool areOfOne(const SkinBodies& bodies, int a, int b) {
  return bodies.cluster_body[a] >= 0 && bodies.cluster_body[a] == bodies.cluster_body[b];
}

/// m, at rest, between the vertices of two clusters: at least, and at most.
inline std::array<double, 2> distanceBetween(const SkinModel& skin, int a, int b) {
  const auto& X = skin.surface.vertices;
  const double centres = (X[skin.cluster_representative[a]] - X[skin.cluster_representative[b]]).norm();
  const auto radii = static_cast<double>(skin.cluster_radius[a] + skin.cluster_radius[b]);
  return {centres - radii, centres + radii};
}

}  // namespace palpate

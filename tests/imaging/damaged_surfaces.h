#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "discretization/surface/solids.h"
#include "discretization/surface/surface_geometry.h"
#include "imaging/isosurface.h"

namespace palpate::test {

/// A closed surface of a body about 2 across, and its volume.
struct NamedSurface {
  std::string name;
  TriangleSurface surface;
  double volume;
};

/// Does one kind of damage to a surface; size 0 little, 1 some, 2 much.
struct Damage {
  std::string name;
  std::function<void(TriangleSurface&, int size, std::mt19937&)> apply;
};

/// Appends `other`, moved by `by` and scaled.
inline void append(TriangleSurface& surface, const TriangleSurface& other, const Vec3& by, double scale = 1);

namespace damage {

using Random = std::mt19937;

inline double uniform(Random& random) { return static_cast<double>(random()) / 4294967296.0; }
inline int below(Random& random, std::size_t count) { return static_cast<int>(random() % count); }

inline Vec3 direction(Random& random) {
  const double z = 2 * uniform(random) - 1, angle = 2 * std::numbers::pi * uniform(random);
  return {std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z};
}

inline TriangleSurface ball(double radius, double edge) { return ellipsoidSurface(Vec3::Constant(radius), edge); }

inline TriangleSurface turned(TriangleSurface s) {
  for (auto& t : s.triangles) std::swap(t[1], t[2]);
  return s;
}

/// A flat square sheet of cells in the xy plane.
inline TriangleSurface sheet(double half, int cells) {
  TriangleSurface s;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      s.vertices.emplace_back(half * (2.0 * i / cells - 1), half * (2.0 * j / cells - 1),
                              0.1 * half * std::sin(3.0 * i / cells));
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = i + (cells + 1) * j;
      s.triangles.push_back({a, a + 1, a + cells + 2});
      s.triangles.push_back({a, a + cells + 2, a + cells + 1});
    }
  return s;
}

inline int share(const TriangleSurface& s, const double (&shares)[3], int size) {
  return std::max(1, static_cast<int>(shares[size] * static_cast<double>(s.triangles.size())));
}

inline void doubleFaces(TriangleSurface& s, int size, Random& random) {
  const auto given = s.triangles;
  if (size == 2) {
    s.triangles.insert(s.triangles.end(), given.begin(), given.end());
    return;
  }
  for (int k = share(s, {0, 0.05, 1}, size); k > 0; --k) {
    auto t = given[below(random, given.size())];
    if (k % 2) std::swap(t[0], t[1]);
    s.triangles.push_back(t);
  }
}

inline void turnFaces(TriangleSurface& s, int size, Random& random) {
  if (size == 2) {
    s = turned(s);
    return;
  }
  for (int k = share(s, {0, 0.2, 1}, size); k > 0; --k) {
    auto& t = s.triangles[below(random, s.triangles.size())];
    std::swap(t[1], t[2]);
  }
}

/// Each face gets vertices of its own, a little off.
inline void takeApart(TriangleSurface& s, int size, Random& random) {
  const double off[3] = {1e-8, 1e-5, 1e-3};
  TriangleSurface apart;
  for (const auto& t : s.triangles) {
    const int first = static_cast<int>(apart.vertices.size());
    for (const int v : t) apart.vertices.push_back(s.vertices[v] + off[size] * direction(random));
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  s = apart;
}

inline void removeNear(TriangleSurface& s, double radius, const Vec3& x) {
  std::erase_if(s.triangles, [&](const auto& t) {
    return ((s.vertices[t[0]] + s.vertices[t[1]] + s.vertices[t[2]]) / 3 - x).norm() < radius;
  });
}

inline void tearHoles(TriangleSurface& s, int size, Random& random) {
  const int count[3] = {1, 5, 2};
  const double radius[3] = {0, 0.12, 0.3};
  for (int k = 0; k < count[size]; ++k) {
    const int t = below(random, s.triangles.size());
    const Vec3 x = s.vertices[s.triangles[t][0]];
    s.triangles.erase(s.triangles.begin() + t);
    removeNear(s, radius[size], x);
  }
}

/// Splits an edge in one of its faces only.
inline void hangVertices(TriangleSurface& s, int size, Random& random) {
  for (int k = share(s, {0, 0.05, 0.3}, size); k > 0; --k) {
    const int t = below(random, s.triangles.size());
    const auto [a, b, c] = s.triangles[t];
    const double w = 0.3 + 0.4 * uniform(random);
    const int m = static_cast<int>(s.vertices.size());
    s.vertices.push_back(w * s.vertices[a] + (1 - w) * s.vertices[b]);
    s.triangles[t] = {a, m, c};
    s.triangles.push_back({m, b, c});
  }
}

/// A vertex on an edge, and a face without area between the edge's two halves and the whole.
inline void addFlatFaces(TriangleSurface& s, int size, Random& random) {
  for (int k = share(s, {0, 0.02, 0.1}, size); k > 0; --k) {
    const int t = below(random, s.triangles.size());
    const auto [a, b, c] = s.triangles[t];
    const int m = static_cast<int>(s.vertices.size());
    s.vertices.push_back(0.5 * (s.vertices[a] + s.vertices[b]));
    s.triangles[t] = {a, m, c};
    s.triangles.push_back({m, b, c});
    s.triangles.push_back({a, b, m});
  }
}

/// Vertices thrown off, as a scanner's noise does: their faces pierce others.
inline void addSpikes(TriangleSurface& s, int size, Random& random) {
  const double shares[3] = {0, 0.002, 0.02};
  for (int k = share(s, shares, size); k > 0; --k)
    s.vertices[below(random, s.vertices.size())] += 0.5 * (0.5 + uniform(random)) * direction(random);
}

inline Vec3 middleOf(const TriangleSurface& s) { return boundingBox(s).center(); }

/// A point well within a body's wall: behind the middle of a face.
inline Vec3 withinWall(const TriangleSurface& s, Random& random) {
  const int t = below(random, s.triangles.size());
  return (s.vertices[s.triangles[t][0]] + s.vertices[s.triangles[t][1]] + s.vertices[s.triangles[t][2]]) / 3 -
         0.08 * areaVector(s, t).normalized();
}

inline void addInnerSheet(TriangleSurface& s, int size, Random& random) {
  const double half[3] = {0.03, 0.05, 0.08};
  append(s, sheet(half[size], 4), withinWall(s, random));
}

inline void addInnerBall(TriangleSurface& s, int size, Random& random) {
  const double radius[3] = {0.02, 0.04, 0.06};
  append(s, ball(radius[size], 0.5 * radius[size]), withinWall(s, random));
}

inline void addDebris(TriangleSurface& s, int size, Random& random) {
  const int count[3] = {1, 5, 20};
  for (int k = 0; k < count[size]; ++k)
    append(s, ball(0.05, 0.04), middleOf(s) + (1.7 + 0.3 * uniform(random)) * direction(random));
}

inline void addLooseSheet(TriangleSurface& s, int size, Random& random) {
  const double half[3] = {0.1, 0.3, 0.7};
  append(s, sheet(half[size], 4), middleOf(s) + 2.2 * direction(random));
}

/// Another body through the surface.
inline void addOverlap(TriangleSurface& s, int size, Random& random) {
  const double radius[3] = {0.15, 0.3, 0.6};
  const Vec3 x = s.vertices[s.triangles[below(random, s.triangles.size())][0]];
  append(s, ball(radius[size], 0.3 * radius[size]), x);
}

/// A wall that shares an edge with the surface and stands off it.
inline void addFin(TriangleSurface& s, int size, Random& random) {
  const int count[3] = {1, 3, 10};
  for (int k = 0; k < count[size]; ++k) {
    const int t = below(random, s.triangles.size());
    const auto [a, b, c] = s.triangles[t];
    const int m = static_cast<int>(s.vertices.size());
    s.vertices.push_back((s.vertices[a] + s.vertices[b] + s.vertices[c]) / 3 + 0.2 * areaVector(s, t).normalized());
    s.triangles.push_back({a, b, m});
  }
}

}  // namespace damage

inline void append(TriangleSurface& surface, const TriangleSurface& other, const Vec3& by, double scale) {
  const int first = static_cast<int>(surface.vertices.size());
  for (const Vec3& x : other.vertices) surface.vertices.push_back(by + scale * x);
  for (const auto& [a, b, c] : other.triangles) surface.triangles.push_back({a + first, b + first, c + first});
}

/// A ball, a box, a ring, a shell of a sixth of its radius, two balls apart.
inline std::vector<NamedSurface> testBodies() {
  using namespace damage;
  std::vector<NamedSurface> bodies;
  const auto add = [&](const std::string& name, const TriangleSurface& s) {
    bodies.push_back({name, s, signedVolume(s)});
  };
  add("ball", ball(1, 0.2));
  add("box", boxSurface({1.6, 1.2, 1.0}, 0.2));
  const Field ring = [](const Vec3& p) {
    const double off = std::hypot(p.x(), p.y()) - 0.75;
    return std::hypot(off, p.z()) - 0.25;
  };
  add("ring", isosurface(sampleField(ring, {-1.2, -1.2, -0.5}, {1.2, 1.2, 0.5}, 0.13)));
  TriangleSurface shell = ball(1, 0.2);
  append(shell, turned(ball(0.83, 0.2)), Vec3::Zero());
  add("shell", shell);
  TriangleSurface two = ball(0.6, 0.12);
  append(two, ball(0.5, 0.12), {1.3, 0, 0});
  add("two balls", two);
  return bodies;
}

/// Each kind.
inline const std::vector<Damage>& allDamage() {
  using namespace damage;
  static const std::vector<Damage> all = {{"doubled faces", doubleFaces},
                                          {"turned faces", turnFaces},
                                          {"taken apart", takeApart},
                                          {"holes", tearHoles},
                                          {"hanging vertices", hangVertices},
                                          {"flat faces", addFlatFaces},
                                          {"spikes", addSpikes},
                                          {"inner sheet", addInnerSheet},
                                          {"inner ball", addInnerBall},
                                          {"debris", addDebris},
                                          {"loose sheet", addLooseSheet},
                                          {"overlap", addOverlap},
                                          {"fins", addFin}};
  return all;
}

}  // namespace palpate::test

#include "setup/make_surface_loads.h"

#include <algorithm>
#include <array>
#include <map>

#include "discretization/cells/background_cells.h"
#include "discretization/surface/facet_rule.h"
#include "scene/scene_messages.h"
#include "setup/body_points.h"
#include "setup/clip_to_region.h"

namespace palpate {
namespace {

using Facet = std::array<int, 3>;

/// What a load has of a facet: points with their shares of the facet's area.
struct LoadedFacet {
  int facet = 0;
  std::vector<Vec3> X;         // m
  std::vector<double> weight;  // sum: the share of the facet that is loaded
};

Vec3 at(const Body& body, const Facet& f, const Vec3& l) {
  return l[0] * body.X[f[0]] + l[1] * body.X[f[1]] + l[2] * body.X[f[2]];
}

/// n^2 equal triangles that a facet is divided into, and their corners in its linear shape functions.
struct EvenParts {
  std::vector<Vec3> place;
  std::vector<std::array<std::size_t, 3>> corner;  // (n^2) of each, indices into place

  explicit EvenParts(int n) {
    const auto number = [n](int i, int j) { return static_cast<std::size_t>(i * (2 * n + 3 - i) / 2 + j); };
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        place.emplace_back(1.0 * i / n, 1.0 * j / n, 1.0 * (n - i - j) / n);
        if (i + j < n) corner.push_back({number(i, j), number(i + 1, j), number(i, j + 1)});
        if (i + j < n - 1) corner.push_back({number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)});
      }
  }
};

/// All of a facet, by the rule at whose points gradients are consistent (boundary_points.h).
LoadedFacet wholeFacet(const Body& body, const Facet& f, int number) {
  LoadedFacet loaded{number, {}, {}};
  const bool by_nodes = body.scene.discretization.boundary_method == DiscretizationSpec::BoundaryMethod::Sebciem &&
                        std::all_of(f.begin(), f.end(), [&](int i) { return body.imposed[i] != 0; });
  for (int k = 0; k < (by_nodes ? 3 : FacetRule::size); ++k) {
    loaded.X.push_back(by_nodes ? body.X[f[k]] : at(body, f, FacetRule::corners(k)));
    loaded.weight.push_back(by_nodes ? 1.0 / 3 : FacetRule::weight(k));
  }
  return loaded;
}

/// What of a facet is in a region: parts small enough for the organ's surface, which the facet is a chord of, are cut
/// along the region's borders.
LoadedFacet partOfFacet(const Body& body, const Facet& f, int number, const Region& region, const SurfaceTree& organ) {
  constexpr int along = 8;  // an edge
  static const EvenParts parts(along);
  std::vector<Vec3> x;
  for (const Vec3& l : parts.place) x.push_back(organ.closest(at(body, f, l)).point);
  LoadedFacet loaded{number, {}, {}};
  const auto count = static_cast<double>(parts.corner.size());
  double whole = 0;
  for (const auto& [a, b, c] : parts.corner) {
    const ClippedTriangle part = clipToRegion(region, {x[a], x[b], x[c]});
    whole += part.share / count;
    if (!(part.share > 0)) continue;
    const Vec3& l = part.barycentric;
    loaded.X.push_back(at(body, f, l[0] * parts.place[a] + l[1] * parts.place[b] + l[2] * parts.place[c]));
    loaded.weight.push_back(part.share / count);
  }
  // A region that just holds a flat side has a thread of those beside it, which is none.
  constexpr double rounding = 1e-6, thread = 2e-6;  // a share; m
  const Vec3 edge = body.X[f[1]] - body.X[f[0]], other = body.X[f[2]] - body.X[f[0]];
  const double length = std::max(edge.norm(), other.norm()) * static_cast<double>(loaded.weight.size()) / along;
  if (whole * 0.5 * edge.cross(other).norm() < thread * length) return {number, {}, {}};
  return whole > 1 - rounding ? wholeFacet(body, f, number) : loaded;
}

/// The facets that a load is on, or parts of them.
std::vector<LoadedFacet> loadedFacets(const Body& body, const std::vector<Facet>& facets, const SurfaceTree& organ,
                                      const LoadSpec& spec) {
  const bool everywhere = spec.whole || spec.region.kind == Region::Kind::Shell;  // of the organ's surface
  std::vector<LoadedFacet> loaded;
  for (int t = 0; t < static_cast<int>(facets.size()); ++t) {
    const Facet& f = facets[t];
    const Vec3 middle = at(body, f, Vec3::Constant(1.0 / 3));
    const double to_corner =
        std::max({(body.X[f[0]] - middle).norm(), (body.X[f[1]] - middle).norm(), (body.X[f[2]] - middle).norm()});
    if (!everywhere && !spec.region.contains(middle, 2 * to_corner)) continue;
    const bool whole = everywhere || spec.region.contains(middle, -2 * to_corner);
    loaded.push_back(whole ? wholeFacet(body, f, t) : partOfFacet(body, f, t, spec.region, organ));
    if (loaded.back().weight.empty()) loaded.pop_back();
  }
  return loaded;
}

void check(const Body& body, const std::vector<Facet>& facets, const LoadSpec& spec,
           const std::vector<LoadedFacet>& loaded) {
  constexpr std::uint8_t all_components = 7;
  if (loaded.empty())
    throw InputError(
        spec.whole ? spec.place : spec.region.place,
        "the region of the load " + inQuotes(spec.name) + " holds no part of the organ's skin, or a thread of it",
        "move it or make it larger, so that skin lies in it");
  const auto held = [&](int i) { return body.imposed[i] == all_components; };
  if (std::all_of(loaded.begin(), loaded.end(), [&](const LoadedFacet& l) {
        return std::all_of(facets[l.facet].begin(), facets[l.facet].end(), held);
      }))
    throw InputError(
        spec.place,
        "the load " + inQuotes(spec.name) + " acts only where the organ is held or moved, and would move nothing",
        "give it a region with free skin, or leave it out");
}

/// R of each facet: node -> coefficient.
std::vector<std::map<int, double>> coefficients(const Body& body, const std::vector<Facet>& facets,
                                                const std::vector<LoadedFacet>& loaded) {
  std::vector<Vec3> points;
  std::vector<int> of;
  for (const LoadedFacet& l : loaded) {
    points.insert(points.end(), l.X.begin(), l.X.end());
    of.resize(points.size(), body.bodyOfNode(facets[l.facet][0]));
  }
  const ShapeTable shape = shapeAt(body, points, of);
  std::vector<std::map<int, double>> rows(loaded.size());
  int r = 0;
  for (std::size_t k = 0; k < loaded.size(); ++k)
    for (const double weight : loaded[k].weight) {
      for (int e = shape.begin[r]; e < shape.begin[r + 1]; ++e) rows[k][shape.node[e]] += weight * shape.N[e];
      ++r;
    }
  return rows;
}

/// The nodes' forces of a load of fixed direction.
void addDead(const Body& body, const std::vector<Facet>& facets, const LoadSpec& spec,
             const std::vector<LoadedFacet>& loaded, const std::vector<std::map<int, double>>& R, SurfaceLoads& loads) {
  std::vector<Vec3> force(body.X.size(), Vec3::Zero());
  for (std::size_t k = 0; k < loaded.size(); ++k) {
    const Facet& f = facets[loaded[k].facet];
    const Vec3 area = 0.5 * (body.X[f[1]] - body.X[f[0]]).cross(body.X[f[2]] - body.X[f[0]]);
    const bool traction = spec.kind == LoadSpec::Kind::Traction;
    const Vec3 g = traction ? Vec3(area.norm() * spec.traction) : Vec3(-spec.pressure * area);
    for (const auto& [node, coefficient] : R[k]) force[node] += coefficient * g;
    for (const double weight : loaded[k].weight) loads.dead_force.back() += weight * g;
  }
  for (const Vec3& f : force) loads.dead.back().push_back(toReal4<double>(f));
}

/// Faces under followers, as they are gathered.
struct PressedFaces {
  std::vector<int> number;                                  // (node_count) of a node among the vertices, or -1
  std::vector<std::vector<std::pair<int, float>>> of_node;  // (node_count) face, R
};

void addFollower(const Body& body, const std::vector<Facet>& facets, int load, const std::vector<LoadedFacet>& loaded,
                 const std::vector<std::map<int, double>>& R, PressedFaces& pressed, SurfaceLoads& loads) {
  for (std::size_t k = 0; k < loaded.size(); ++k) {
    SurfaceLoads::Face face{facets[loaded[k].facet], load, 0};
    double share = 0;
    for (const double weight : loaded[k].weight) share += weight;
    face.share = static_cast<float>(share);
    for (int& v : face.vertex) {
      const int node = v;
      if (pressed.number[node] < 0) {
        pressed.number[node] = static_cast<int>(loads.X.size());
        loads.X.push_back(body.X[node]);
        for (int e = body.node_shape.begin[node]; e < body.node_shape.begin[node + 1]; ++e) {
          loads.node.push_back(body.node_shape.node[e]);
          loads.N.push_back(static_cast<float>(body.node_shape.N[e]));
        }
        loads.begin.push_back(static_cast<int>(loads.node.size()));
      }
      v = pressed.number[node];
    }
    for (const auto& [node, coefficient] : R[k])
      pressed.of_node[node].emplace_back(static_cast<int>(loads.face.size()), static_cast<float>(coefficient));
    loads.face.push_back(face);
  }
}

}  // namespace

SurfaceLoads makeSurfaceLoads(const Body& body, const SurfaceTree& organ) {
  SurfaceLoads loads;
  if (body.scene.loads.empty()) return loads;
  const std::vector<Facet> facets = boundaryFacets(body.cells);
  PressedFaces pressed{std::vector<int>(body.X.size(), -1), {}};
  pressed.of_node.resize(body.X.size());
  loads.begin.assign(1, 0);
  for (const LoadSpec& spec : body.scene.loads) {
    const auto load = static_cast<int>(loads.course.size());
    const bool follows = spec.kind == LoadSpec::Kind::FollowerPressure;
    const std::vector<LoadedFacet> loaded = loadedFacets(body, facets, organ, spec);
    check(body, facets, spec, loaded);
    const auto R = coefficients(body, facets, loaded);
    loads.course.push_back({spec.curve, spec.duration});
    loads.pressure.push_back(follows ? spec.pressure : 0);
    loads.dead.emplace_back();
    loads.dead_force.emplace_back(Vec3::Zero());
    if (follows)
      addFollower(body, facets, load, loaded, R, pressed, loads);
    else
      addDead(body, facets, spec, loaded, R, loads);
  }
  if (loads.face.empty()) return loads;
  loads.node_begin.assign(1, 0);
  for (const auto& row : pressed.of_node) {
    for (const auto& [face, coefficient] : row) loads.node_face.push_back(face), loads.R.push_back(coefficient);
    loads.node_begin.push_back(static_cast<int>(loads.node_face.size()));
  }
  return loads;
}

}  // namespace palpate

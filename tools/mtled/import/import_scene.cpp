#include "mtled/import/import_scene.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"
#include "base/parallel_for.h"
#include "discretization/nodes/node_scatter.h"
#include "discretization/surface/surface_parts.h"
#include "imaging/surface_distance.h"

namespace palpate::tools {
namespace {

// Share of a part's surface that lies on what holds it.
constexpr double held_share = 0.12;
// Of the spacing: at least so thick is what is held, so that it holds nodes on irregular undersides, too.
constexpr double held_depth = 0.75;

// The tool's radius and its distance from the tissue, in spacings: of the liver's scene.
constexpr double tool_radius = 1.4, tool_clearance = 1.2;

// A tick of 2 ms is one step from this spacing on, with the material and the mass scaling of the text below; half of it
// takes two. Of cloud and step as they are made; whoever opens the scene finds out whether they hold.
constexpr double one_step_spacing = 0.0074;  // m
constexpr double tick = 0.002;               // s
// Points of a body and of its skin that are looked at.
constexpr int inside_points = 20'000, skin_points = 2000;

/// Height below which lies `held_share` of a surface's area.
double heldHeight(const TriangleSurface& part, double spacing) {
  std::vector<std::pair<double, double>> faces;  // height, area
  double area = 0;
  for (int t = 0; t < static_cast<int>(part.triangles.size()); ++t) {
    const auto& [a, b, c] = part.triangles[t];
    const double face = areaVector(part, t).norm();
    faces.emplace_back(std::max({part.vertices[a].z(), part.vertices[b].z(), part.vertices[c].z()}), face);
    area += face;
  }
  std::sort(faces.begin(), faces.end());
  const Box3 box = boundingBox(part);
  double height = box.min().z(), below = 0;
  for (const auto& [z, face] : faces) {
    below += face;
    height = z;
    if (below >= held_share * area) break;
  }
  const double least = box.min().z() + held_depth * spacing, most = box.min().z() + 0.5 * box.sizes().z();
  return std::max(least, std::min(height, most));
}

/// The highest point of the surface above the organ's middle; where there is none (a ring), above that point of the
/// upper side that is nearest to it.
Vec3 pointBelowTool(const SurfaceTree& organ, const Box3& box) {
  const Vec3 down = -Vec3::UnitZ();
  const Vec3 above(box.center().x(), box.center().y(), box.max().z() + box.diagonal().norm());
  if (const auto hit = organ.firstHit(above, down)) return hit->point;
  const TriangleSurface& surface = organ.surface();
  Vec3 best = Vec3(box.center().x(), box.center().y(), box.max().z());
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const Vec3 area = areaVector(surface, t);
    if (area.z() < 0.7 * area.norm()) continue;
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 x = (surface.vertices[a] + surface.vertices[b] + surface.vertices[c]) / 3;
    const double distance = std::hypot(x.x() - above.x(), x.y() - above.y());
    if (distance >= nearest) continue;
    if (const auto hit = organ.firstHit(Vec3(x.x(), x.y(), above.z()), down)) {
      nearest = distance;
      best = hit->point;
    }
  }
  return best;
}

double rounded(double value) { return std::abs(value) < 1e-9 ? 0.0 : value; }
std::string text(double value) { return format("%.5g", rounded(value)); }
std::string text(const Vec3& x) { return format("[%.5g, %.5g, %.5g]", rounded(x.x()), rounded(x.y()), rounded(x.z())); }

/// For a TOML string: what might end it goes.
std::string quotable(std::string words) {
  for (char& c : words)
    if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 32 || c == 127) c = '_';
  return words;
}

}  // namespace

BodyMeasures measuresOf(const SurfaceTree& organ) {
  const TriangleSurface& surface = organ.surface();
  BodyMeasures body;
  body.volume = signedVolume(surface);
  body.area = surfaceArea(surface);
  const Box3 box = boundingBox(surface);
  std::vector<double> depth(inside_points, -1);
  parallelFor(inside_points, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      // Three irrational steps spread the points over the box.
      const Vec3 at(std::fmod(0.5 + k * 0.8191725133961645, 1.0), std::fmod(0.5 + k * 0.6710436067037893, 1.0),
                    std::fmod(0.5 + k * 0.5497004779019703, 1.0));
      const Vec3 x = box.min() + at.cwiseProduct(box.sizes());
      if (organ.inside(x)) depth[k] = organ.closest(x).distance;
    }
  });
  for (const double d : depth)
    if (d >= 0) body.depth.push_back(d);
  std::sort(body.depth.begin(), body.depth.end());
  const SurfacePoints skin = pointsOn(surface, skin_points);
  const double off = 1e-5 * box.diagonal().norm();
  for (std::size_t k = 0; k < skin.x.size(); ++k) {
    const Vec3 n = areaVector(surface, skin.face[k]).stableNormalized();
    const auto hit = organ.firstHit(skin.x[k] - off * n, -n);
    body.wall.push_back(hit ? hit->distance + off : box.diagonal().norm());
  }
  std::sort(body.wall.begin(), body.wall.end());
  return body;
}

double nodesAt(const BodyMeasures& body, double spacing) {
  // As node_scatter.h places them. Nodes of both sides of a thin wall keep a distance, which costs few of them.
  constexpr double no_room = 0.15;
  const auto shareBelow = [](const std::vector<double>& sorted, double value) {
    if (sorted.empty()) return 0.0;
    return static_cast<double>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin()) /
           static_cast<double>(sorted.size());
  };
  const double thin = shareBelow(body.wall, closest_approach * spacing);
  const double on_skin = (1 - no_room * thin) * body.area / (area_per_node * spacing * spacing);
  const double below = 1 - shareBelow(body.depth, 0.408 * spacing);
  return on_skin + below * body.volume / (volume_per_node * std::pow(spacing, 3));
}

int stepsAt(const BodyMeasures& body, double spacing) {
  // Walls thinner than the spacing shorten the step like it, where a fifth of the skin has them: few get more mass.
  const double wall = body.wall.empty() ? spacing : body.wall[body.wall.size() / 5];
  return std::max(1, static_cast<int>(std::ceil(one_step_spacing / std::min(spacing, wall))));
}

double firstSpacing(const BodyMeasures& body) {
  // From far too coarse to far too fine.
  const double nodes = 0.02 * node_steps_budget;
  double spacing = std::max(std::cbrt(body.volume / nodes), std::sqrt(body.area / nodes));
  double best = spacing, most_nodes = 0;
  for (constexpr double finer = 0.98; nodesAt(body, spacing) < node_steps_budget; spacing *= finer) {
    const double made = nodesAt(body, spacing);
    if (made <= most_nodes || made * stepsAt(body, spacing) > 0.97 * node_steps_budget) continue;
    most_nodes = made;
    best = spacing;
  }
  return best;
}

ImportedScene chooseScene(const SurfaceTree& organ, double spacing) {
  ImportedScene scene;
  scene.spacing = spacing;
  const TriangleSurface& surface = organ.surface();
  for (const TriangleSurface& part : separateParts(surface, connectedParts(surface, faceEdges(surface)))) {
    if (signedVolume(part) < 0) continue;  // a cavity
    Box3 box = boundingBox(part);
    const Vec3 margin = Vec3::Constant(0.05 * spacing);
    const double height = heldHeight(part, spacing);
    scene.held.push_back({box.min() - margin, Vec3(box.max().x() + margin.x(), box.max().y() + margin.y(), height)});
  }
  const Box3 box = boundingBox(surface);
  scene.tool_radius = tool_radius * spacing;
  const double clearance = tool_clearance * spacing;
  scene.tool_tip = pointBelowTool(organ, box) + clearance * Vec3::UnitZ();
  // Beside higher ground the ball begins higher.
  const auto isFree = [&] {
    return organ.closest(scene.tool_tip + scene.tool_radius * Vec3::UnitZ()).distance >
           scene.tool_radius + 0.5 * clearance;
  };
  while (!isFree() && scene.tool_tip.z() < box.max().z() + clearance) scene.tool_tip.z() += 0.5 * clearance;
  scene.tool_max_speed = std::min(0.5, 0.5 * scene.tool_radius / tick);
  scene.camera_target = box.center();
  scene.camera_distance = 1.6 * box.diagonal().norm();
  return scene;
}

std::string sceneText(const ImportedScene& s) {
  std::string held;
  for (const HeldBox& box : s.held)
    held += "[[fixed]]\nshape = \"box\"\nmin = " + text(box.min) + "\nmax = " + text(box.max) + "\n\n";
  return "# Made by `mtled import` from " + quotable(s.source) +
         ". All but the surface is a guess: change what you know better.\n"
         "# Keys, units and defaults: assets/scenes/README.md.\n"
         "name = \"" +
         quotable(s.name) +
         "\"\n\n"
         "[organ]\nsurface = \"surface.obj\"\nunit = \"m\"\n\n" +
         (s.follows ? "# Nodes follow the tool; [discretization] spacing = number in m makes a cloud that stays.\n\n"
                    : "[discretization]\nspacing = " + text(s.spacing) +
                          "  # m; `mtled fit` finds the finest that holds the rate on your machine\n"
                          "cells_per_point = 1.32\n\n") +
         "[[material]]  # about a liver's\nmodel = \"neo-hookean\"\nyoung = 3000  # Pa\npoisson = 0.45\n"
         "density = 1060  # kg/m^3\n\n"
         "# It rests on its underside (z points up).\n" +
         held + "[dynamics]\nrate = 500  # Hz\nstep_safety = 0.55\n" +
         (s.slowed ? "mass_scaling = 1.25  # longer steps, but what moves fast is slower, and said so\n" : "") +
         (s.follows ? "" : "threads = 2\ngradient_precision = \"int16\"\n") +
         "damping = 20  # 1/s\n\n"
         "[tool]\nshape = \"sphere\"\nradius = " +
         text(s.tool_radius) + "\nposition = " + text(s.tool_tip) +
         "\ndirection = [0, 0, -1]\nmax_speed = " + text(s.tool_max_speed) +
         "\n\n"
         "[camera]\ntarget = " +
         text(s.camera_target) + "\ndistance = " + text(s.camera_distance) + "\nazimuth = -68\nelevation = 34\n";
}

}  // namespace palpate::tools

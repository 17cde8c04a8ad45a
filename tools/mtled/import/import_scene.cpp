#include "mtled/import/import_scene.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"
#include "discretization/surface/surface_parts.h"

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
constexpr double one_step_spacing = 0.007;  // m
// A node has so many cubes of the spacing in a compact body, and so many squares on a thin one.
constexpr double volume_of_node = 0.57, area_of_node = 1.1;
constexpr double tick = 0.002;  // s

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

double firstSpacing(double volume, double area) {
  double best = 0, most_nodes = 0;
  constexpr int max_steps = 20;
  for (int steps = 1; steps <= max_steps; ++steps) {
    const double nodes = 0.97 * node_steps_budget / steps;
    // Thin bodies have nearly all of their nodes on the skin, about one for each square of the spacing.
    const double spacing = std::max({std::cbrt(volume / (volume_of_node * nodes)),
                                     std::sqrt(area / (area_of_node * nodes)), one_step_spacing / steps});
    const double made = std::min(volume / (volume_of_node * std::pow(spacing, 3)), nodes);
    if (made <= most_nodes) continue;
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
         "[organ]\nsurface = \"surface.obj\"\nunit = \"m\"\n\n"
         "[discretization]\nspacing = " +
         text(s.spacing) +
         "  # m; `mtled fit` finds the finest that holds the rate on your machine\n"
         "cells_per_point = 1.32\n\n"
         "[[material]]  # about a liver's\nmodel = \"neo-hookean\"\nyoung = 3000  # Pa\npoisson = 0.45\n"
         "density = 1060  # kg/m^3\n\n"
         "# It rests on its underside (z points up).\n" +
         held +
         "[dynamics]\nrate = 500  # Hz\nstep_safety = 0.55\nmass_scaling = 1.25\nthreads = 2\n"
         "gradient_precision = \"int16\"\ndamping = 20  # 1/s\n\n"
         "[tool]\nshape = \"sphere\"\nradius = " +
         text(s.tool_radius) + "\nposition = " + text(s.tool_tip) +
         "\ndirection = [0, 0, -1]\nmax_speed = " + text(s.tool_max_speed) +
         "\n\n"
         "[camera]\ntarget = " +
         text(s.camera_target) + "\ndistance = " + text(s.camera_distance) + "\nazimuth = -68\nelevation = 34\n";
}

}  // namespace palpate::tools

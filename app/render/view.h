#pragma once

#include <optional>
#include <vector>

#include "app/render/camera.h"
#include "app/render/colour_map.h"
#include "base/types.h"

namespace palpate::app {

/// Something solid inside the body, e.g. a lump, as it lies now.
struct Ball {
  Vec3 centre = Vec3::Zero();  // m
  double radius = 0;           // m
};

/// Where the organ is cut open: a plane through the body at rest, which then deforms with it.
struct Section {
  bool on = false;
  Vec3 normal = -Vec3::UnitY();  // unit; what lies on its side is taken away
  float offset = 0;              // of the organ's radius, along the normal from its middle
};

/// What the viewer wants to see. The window edits it, the renderer reads it.
struct View {
  Camera camera;

  ColourMap colour_map = ColourMap::Tissue;
  bool colour_auto = true;  // range from the field's present values; else the two below
  double colour_min = 0;    // m, Pa or 1, as the map's quantity
  double colour_max = 1;
  const std::vector<float>* node_values =
      nullptr;  // (node_count) shown in place of the map's own field, in its colours

  const std::vector<float>* skin_values =
      nullptr;  // (skin vertex_count) Pa, what ColourMap::Pressure shows; another count, or null: nothing

  bool show_tool = true;
  bool show_nodes = false;
  bool show_points = false;      // integration points, thinned where there are many
  bool show_forces = true;       // arrow of the tool's force
  bool show_contact = false;     // arrows of the forces at the skin's vertices
  bool show_fixed = true;        // hint of the imposed region on the skin
  bool ghost = false;            // the skin is translucent, what is inside is seen through it
  std::vector<Ball> balls = {};  // inside
  Section section = {};
  int picked_point = -1;  // integration point whose support is shown; -1: none

  int pulled_vertex = -1;           // skin vertex that a spring pulls; -1: none
  Vec3 pull_target = Vec3::Zero();  // m

  bool show_room = true;                         // backdrop and ground; else the body on white paper
  std::optional<double> light_azimuth_deg = {};  // of the key light; else beside the scene's first camera

  /// Whether it tells what lies below the skin, and shutInside: nothing does any more.
  bool showsInside() const {
    return ghost || section.on || show_nodes || show_points || picked_point >= 0 || colour_map == ColourMap::VonMises ||
           colour_map == ColourMap::J;
  }
  void shutInside() {
    ghost = section.on = show_nodes = show_points = false;
    picked_point = -1;
    if (colour_map == ColourMap::VonMises || colour_map == ColourMap::J) colour_map = ColourMap::Tissue;
  }

  float pixel_ratio = 1;  // framebuffer pixels per screen unit: sizes of points and lines
};

}  // namespace palpate::app

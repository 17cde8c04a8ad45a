#pragma once

#include <optional>
#include <string>

#include "app/render/view.h"

namespace palpate::app {

/// What the command line says about an off-screen picture: --no-panels, --close, --camera, --view, --field, --range,
/// --show,
/// --hide, --timing.
struct PictureChoice {
  bool panels = true;
  bool cut = false, ghost = false;  // open through the probe; seen through
  bool close = false;               // looks at the probe's tip
  bool timing = false;              // what the clock says of this machine: never the same twice
  std::optional<double> azimuth_deg, elevation_deg, distance_m;
  ColourMap field = ColourMap::Tissue;
  std::optional<double> low, high;  // m, Pa or 1: the colours' range
  std::string show, hide;           // overlays, e.g. "nodes,contact"

  /// Whether it tells what lies below the skin.
  bool showsInside() const;
};

/// The texts of the options, each empty where it was not given. Returns what is wrong; empty: nothing.
///   --camera AZIMUTH,ELEVATION[,DISTANCE] in degrees and m; --view front, back, left, right, top or bottom;
///   --field tissue, displacement, von_mises, J or pressure (peak, in a task); --range LOW:HIGH in m, Pa or 1;
///   --show and --hide of nodes, points, force, contact, fixed, tool
std::string readPictureChoice(const std::string& camera, const std::string& view, const std::string& field,
                              const std::string& range, PictureChoice& choice);

/// Does to the view what was chosen.
void applyChoice(const PictureChoice& choice, View& view);

}  // namespace palpate::app

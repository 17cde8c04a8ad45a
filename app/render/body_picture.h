#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/render/colour_map.h"
#include "base/types.h"

namespace palpate::app {

/// A value at each node to colour a body by, e.g. the distance to a reference.
struct NodeField {
  std::vector<float> values;  // (node_count) in the unit that the label names; NaN counts for nothing
  std::string label;          // "Distance to the reference, mm"
  bool diverging = false;     // colours that part at the middle of the range
};

/// A picture of a deformed body for a printed page.
struct BodyPicture {
  std::string title;                           // may be empty
  ColourMap colour = ColourMap::Displacement;  // Tissue: no colour bar
  std::optional<NodeField> field;              // shown in place of `colour`
  std::optional<double> low, high;             // of the colours: the field's unit, or m, Pa or 1; else from the values
  double azimuth_deg = -60;                    // of the eye around +z, from +x
  double elevation_deg = 18;                   // of the eye above the horizon
  bool rest_outline = true;                    // thin lines where the body's outline was at rest
  std::optional<Pose> tool;                    // else none is drawn
};

}  // namespace palpate::app

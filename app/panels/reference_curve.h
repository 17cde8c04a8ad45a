#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/panels/plot.h"
#include "model/body.h"

namespace palpate::app {

/// A force over depth that presses are held against: force (N) over depth (mm), in the order of its file.
struct ReferenceCurve {
  std::string label;
  std::vector<PlotPoint> curve;
};

/// Reads a CSV file (readForceRows). Throws InputError with file, line and what is wrong.
ReferenceCurve readReferenceCurve(const std::string& file);

/// F = 4/3 E / (1 - nu^2) sqrt(R) d^(3/2): a rigid sphere on an elastic half-space (Hertz 1882), for small depths.
/// Nothing where the scene's tool is no sphere, or its tissue not of one material.
/// @param material  at present
/// @param depth_mm  how far it goes
std::optional<ReferenceCurve> hertzCurve(const Body& model, const Material& material, double depth_mm);

}  // namespace palpate::app

#pragma once

#include <string>
#include <vector>

#include "discretization/surface/surface_geometry.h"
#include "mtled/scan/case_regions.h"

namespace palpate::tools {

/// What the scene of a case says that its surface does not.
struct CaseScene {
  std::string name;
  double spacing = 0;               // m
  bool has_fluid = false;           // csf.nii.gz is there
  std::string known;                // the mask of the voxels whose tissue is known, in the case's folder
  std::string electrodes;           // file in the case's folder; "" for none
  std::string electrode_keys;       // lines with unit and frame
  bool in_skull = false;            // slides in a rigid shell around the brain as it lies
  Box3 opened;                      // m, of the skull: the ball around it; empty: none
  std::vector<NamedBall> openings;  // of the skull, too
  std::vector<NamedBall> fixed;     // where it is held; empty: the lowest twentieth
};

/// Share of the organ's height that is held where nothing is said.
inline constexpr double lowest_held = 0.05;

/// m between nodes, so that a volume (m^3) has about so many.
double spacingFor(double volume, int nodes);

/// The text of scene.toml: surface.obj, brain and fluid as the paper has them (E 3000 and 100 Pa, Poisson's ratio
/// 0.49), held where it is said or at the lowest twentieth, in a skull where there is one, moved by the electrodes, a
/// ball above it.
std::string sceneText(const CaseScene& scene, const TriangleSurface& surface);

}  // namespace palpate::tools

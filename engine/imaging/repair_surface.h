#pragma once

#include <functional>
#include <string>

#include "discretization/surface/surface_check.h"
#include "imaging/repair_report.h"

namespace palpate {

struct RepairOptions {
  int body_nodes = 5000;  // of the body that the surface is for: what the grid's cell follows
  int max_faces = 0;      // a surface with more is made anew with fewer; 0: no limit
  double thinnest = 0;    // m; above 0 the surface is made anew, without spikes and walls thinner than this
  /// Gets what is being done and the share behind, 0..1; may throw to end it. Long stages also look at SetupWatch.
  std::function<void(const std::string& what, double share)> progress = {};
};

struct RepairedSurface {
  TriangleSurface surface;  // passes checkSurface
  RepairReport report;
};

/// A surface that bounds a solid, from one that was meant to. A surface that passes checkSurface is returned as it is,
/// without parts too small to matter. Otherwise faces are mended one by one (mend_surface.h), which leaves all other
/// faces exactly as they were. Where that is not enough (parts that overlap, walls that cross), the surface is made
/// anew: distance on a grid, its sign by winding numbers (signed_field.h), isosurface, even triangles (remesh.h). The
/// grid's cell is about a quarter of the spacing with which the body would have `body_nodes` nodes, and finer where
/// the body is thin. Where even triangles would make walls meet, spikes and walls thinner than two cells go.
/// Deterministic. Throws InputError at the file for an open sheet, which bounds no solid, saying what an organ needs.
RepairedSurface repairSurface(TriangleSurface surface, SurfaceSource source, const RepairOptions& options = {});

}  // namespace palpate

#pragma once

#include <string>

#include "discretization/surface/surface_geometry.h"

namespace palpate::organs {

/// What one wants to know of a surface before calling it an organ.
struct SurfaceReport {
  int vertices = 0, triangles = 0;
  std::string problem;  // checkSurface's; empty: closed, all faces outward, none through another
  int components = 0;   // of triangles joined by edges
  int genus = 0;        // by Euler's formula; of one component 0: no vertex is pinched
  double volume = 0;    // m^3, positive if the normals point outward
  double area = 0;      // m^2
  Box3 box;             // m
  double shortest_edge = 0, mean_edge = 0, longest_edge = 0;  // m
  double smallest_angle_deg = 0;

  bool isClosedSphere() const { return problem.empty() && components == 1 && genus == 0; }
  std::string text() const;
};

/// @param surface  with at most two faces at each edge
SurfaceReport reportOn(const TriangleSurface& surface);

}  // namespace palpate::organs

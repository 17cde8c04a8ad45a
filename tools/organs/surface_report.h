#pragma once

#include <string>

#include "discretization/surface/triangle_surface.h"

namespace palpate::organs {

/// What one wants to know of a surface before calling it an organ.
struct SurfaceReport {
  int vertices = 0, triangles = 0;
  bool closed = false;                          // each edge is shared by two triangles that agree on its direction
  bool manifold = false;                        // closed, and the triangles around each vertex form one fan
  int components = 0;                           // of triangles joined by vertices
  int genus = 0;                                // from Euler's formula; meaningful if manifold and in one piece
  double volume = 0;                            // m^3, positive if the normals point outward
  double area = 0;                              // m^2
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  // m
  double shortest_edge = 0, mean_edge = 0, longest_edge = 0;  // m
  double smallest_angle_deg = 0;

  bool isClosedSphere() const { return manifold && components == 1 && genus == 0 && volume > 0; }
  std::string text() const;
};

SurfaceReport reportOn(const TriangleSurface& surface);

}  // namespace palpate::organs

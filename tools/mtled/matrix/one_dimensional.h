#pragma once

#include <vector>

#include "mechanics/materials/material.h"

namespace palpate::tools {

/// Equilibria that depend on one coordinate s alone, in which tissue goes from s to r(s): found by minimising the
/// energy of 240 straight pieces, each with its strain in the middle (they meet the closed forms to 3e-4).
///
///   Cylinder  s = R:  r(R), theta = Theta + turn Z, z = stretch Z     turn in rad/m
///   Sphere    s = R:  r(R), the angles stay
///   Beam      s = X:  r(X), theta = Y / a, z = Z, a = 1 / turn        Rivlin's flexure, in plane strain
///
/// Of a cylinder the material's directions are those along R, Theta, Z; of a beam X, Y, Z.
/// Test: tools/matrix_test.cpp, Rivlin's closed forms (1949) for incompressible neo-Hookean tissue.
struct OneDimensional {
  enum class Kind { Cylinder, Sphere, Beam };
  struct Zone {
    double end = 0;  // m, of s
    Material material;
  };

  Kind kind = Kind::Cylinder;
  double begin = 0;         // m, of s; 0 but for a beam
  std::vector<Zone> zones;  // by s
  double turn = 0, stretch = 1;
  bool end_held = false;  // r(end) is `held`; else the last face is free
  double held = 0;        // m

  struct Answer {
    std::vector<double> s, r;  // m
    double force = 0;          // N: Cylinder: along z. Sphere: of the surface outward, all around
    double moment = 0;         // N m, Cylinder: about z. Beam: about the ring's middle, N of its width
    /// r at s, m.
    double at(double s) const;
  };

  /// Throws std::runtime_error where no equilibrium is found.
  Answer solve() const;
};

}  // namespace palpate::tools

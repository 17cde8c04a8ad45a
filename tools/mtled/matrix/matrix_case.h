#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "mtled/matrix/lot.h"
#include "scene/scene.h"
#include "step/trust.h"

namespace palpate::tools {

/// Nodes of the organ's surface that each go to a place of their own.
struct PlacedSurface {
  std::function<bool(const Vec3& X)> on;   // which of the surface's nodes
  std::function<Vec3(const Vec3& X)> to;   // where they go at the end, m
  bool component[3] = {true, true, true};  // which of x, y, z are imposed
  Vec3 axis_point = Vec3::Zero();          // they go along turns about this axis by `angle`, rad, and straight ways
  double angle = 0;                        // about z
};

/// A small scene drawn by lot, with one force that it is asked for.
struct MatrixCase {
  unsigned seed = 0;
  std::string kind;   // how it is loaded: "press", "twisted", ...
  std::string about;  // what of: "cylinder with a core, ogden, nu 0.43, 1 : 12"
  Scene scene;
  std::vector<PlacedSurface> placed;

  // What it is asked for: of a press the force on the tool; else f . lever, summed over the forces f of imposed nodes
  // on the tissue: with a unit vector a force, N, with an arm a moment, N m.
  bool pressed = false;
  double depth = 0;     // m, of the tool past its first touch of the undeformed body
  bool looped = false;  // by the real-time step, in float; else in equilibrium, in double
  /// @param node  where it is at rest  @param X, x  where its force acts, at rest and now; all in m
  std::function<Vec3(const Vec3& node, const Vec3& X, const Vec3& x)> lever;

  /// What it should be, where that is known in closed form; else NaN: what finer clouds converge to.
  double known = std::numeric_limits<double>::quiet_NaN();
  bool hasClosedForm() const { return known == known; }
};

/// Bodies, all laws, Poisson's ratios from 0 to 0.499, layers and lumps to 1 : 100, flat and curved borders, all tools,
/// ways of loading and spacings, from the seed: nobody tuned to them. The same on every machine.
MatrixCase drawCase(unsigned seed);

/// What a cloud answers.
struct MatrixAnswer {
  double value = 0;  // N, or N m
  RunTrust trust;    // of the whole way
  int nodes = 0;
  bool sound = false;  // else there is no answer: it diverged, or said so
  Doubt at_end = Doubt::None;
  double expected_at_end = 0;  // its expected error
};

/// @param fineness  of the spacing, as a share of the scene's
/// @param looped    see MatrixCase
/// Throws InputError where the scene can't be had at that spacing.
MatrixAnswer answerOf(const MatrixCase& one, double fineness, bool looped, int threads);

/// What it should be.
struct MatrixReference {
  double value = 0;
  double uncertainty = 0;  // of a closed form 0; else what Richardson's extrapolation of second order adds
  int nodes = 0;           // of the finest cloud; of a closed form 0
  bool known = false;
};
/// The closed form, or two finer clouds in double, extrapolated.
MatrixReference referenceOf(const MatrixCase& one, int threads);

}  // namespace palpate::tools

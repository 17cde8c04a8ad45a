#pragma once

#include <string>

#include "simulation/scene.h"
#include "simulation/trust.h"

namespace palpate::tools {

/// A small scene drawn by lot, with one force that it is asked for: on a tool that is pressed in and held, or of a face
/// that is moved (of one that is twisted its moment).
struct MatrixCase {
  unsigned seed = 0;
  std::string kind;  // "press sphere", "shear", ...
  Scene scene;
  bool pressed = false;  // by a tool; else moved
  double depth = 0;      // m, of the tool past its first touch of the undeformed body
};

/// Bodies, laws, Poisson's ratios from 0 to 0.499, layers and lumps to 1 : 100, tools, ways of moving and spacings, all
/// from the seed: nobody tuned to them. The same on every machine.
MatrixCase drawCase(unsigned seed);

/// What a cloud answers.
struct MatrixAnswer {
  double value = 0;  // N, or N m
  RunTrust trust;    // of the whole way
  int nodes = 0;
  bool sound = false;  // else there is no answer: it diverged, or said so
  Doubt at_end = Doubt::None;
};

/// By the real-time step where a tool presses, in equilibrium where a face is moved.
/// @param fineness  of the spacing, as a share of the scene's: where the tool presses, or everywhere
/// Throws InputError where the scene can't be had at that spacing.
MatrixAnswer answerOf(const MatrixCase& one, double fineness, int threads);

/// What finer clouds converge to, and how much of it is not known: Richardson's extrapolation of second order.
struct MatrixReference {
  double value = 0, uncertainty = 0;
  int nodes = 0;  // of the finest
  bool known = false;
};
MatrixReference referenceOf(const MatrixCase& one, int threads);

}  // namespace palpate::tools

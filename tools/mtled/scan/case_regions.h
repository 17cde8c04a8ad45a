#pragma once

#include <string>
#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate::tools {

/// A ball that was named on the command line: `--fix 2,-30,-71,12`.
struct NamedBall {
  Vec3 centre;        // m, RAS
  double radius = 0;  // m
  std::string text;   // option and value, for messages
};

/// Reads balls "X,Y,Z,R" in mm.
/// @param lps  x to the patient's left, y to the back; else right and front
/// Throws InputError saying what to write.
std::vector<NamedBall> ballsOf(const std::string& option, const std::vector<std::string>& values, bool lps);

/// Throws InputError where one of the balls holds no vertex of the surface, saying how far off it is, or where the
/// balls hold all of them.
void checkBalls(const std::vector<NamedBall>& balls, const TriangleSurface& surface);

}  // namespace palpate::tools

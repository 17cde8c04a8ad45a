#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/render/skin_surface.h"
#include "model/model.h"

namespace palpate::app {

/// A stiff ball in softer tissue, and where on the skin it is felt.
struct Lump {
  Vec3 centre = Vec3::Zero();  // m, at rest
  double radius = 0;           // m
  double stiffness = 1;        // shear modulus over that of the tissue
  SkinSurface::Place foot;     // the skin nearest to it
  double top = 0;              // m, its top below the skin; negative: it reaches out

  bool isInside() const { return top > -radius; }  // its centre is
};

/// The spheres of the scene's later materials that are stiffer than the first.
std::vector<Lump> lumpsOf(const Body& model);

/// How a lump is felt: the slope of force over depth above it and beside it, at the working depth, held there.
struct LumpFeel {
  double above_N_per_m = 0, beside_N_per_m = 0;
  double error = 0;  // expected of the ratio from how fine the nodes are, as a share of it

  double ratio() const { return beside_N_per_m > 0 ? above_N_per_m / beside_N_per_m : 0; }
  /// Whether the ratio is on this side of least_feel on any nodes.
  bool isSure() const;
};

/// Ratio from which a lump is taken for felt. Told apart are stiffnesses that differ by 15 % (fingers on rubber:
/// Bergmann Tiest and Kappers, IEEE Trans. Haptics 2, 2009) to 23 % (arms: Jones and Hunter, Exp. Brain Res. 79, 1990).
inline constexpr double least_feel = 1.25;

/// "reaches 2.0 mm out of the skin", "is 14.0 mm outside of the organ"; else "".
std::string misplaced(const Lump& lump);

/// A task's model, and, where its cloud follows the tool, the one for a tool near a point of the skin.
struct TaskBody {
  std::shared_ptr<const Model> model;
  std::function<std::shared_ptr<const Model>(const Vec3& point)> near{};  // empty: the cloud stays
};

/// Presses the scene's tool in above each lump and beside it, on states of its own; half a second or so each.
/// Beside means the same skin 2.5 to 4 lump radii away, as far from all lumps as can be.
/// @param depth  m, the working depth
/// @param progress  called before each press with the share that is done; may throw to end it
std::vector<LumpFeel> feelLumps(const TaskBody& body, double depth, const std::function<void(double)>& progress = {});

}  // namespace palpate::app

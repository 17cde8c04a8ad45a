#pragma once

#include <algorithm>
#include <cstdint>

#include "base/types.h"
#include "contact/rigid_bodies.h"
#include "contact/skin_contact.h"
#include "contact/tool_set.h"

namespace palpate {

/// Reasons to distrust a step; the loop decides what to do about them.
enum StepFlag : std::uint32_t {
  kNotFinite = 1u << 0,        // NaN or infinity in the displacement
  kBlowUp = 1u << 1,           // a node moved further in one step than physics allows
  kInvertedPoints = 1u << 2,   // integration points with J <= 0
  kContactOverflow = 1u << 3,  // more skin touches than memory was taken for
  kDeepContact = 1u << 4,      // penetration beyond a fifth of the tool's radius; skin at a tool in a rigid body
  kLetsGo = 1u << 5,           // a tool touches nothing, wherever it is (Command::lets_go)
};

/// Why the numbers of a step should not be believed, the gravest that applies (step/trust.h).
enum class Doubt : std::uint8_t {
  None,
  Resolution,  // the nodes are too far apart for how the tissue deforms, or mass_scaling slows it (expected_error.h)
  Volume,      // nearly incompressible tissue has crumpled, or is under a pressure at which it may
  Contact,   // the tool or other bodies are deep in the skin, it has let go, or there is no memory for all that touches
  Squeezed,  // a point is near collapse
  Step,      // the mass that keeps squeezed tissue stable with this time step slows it
  Energy,    // the steps make energy
  Inverted,  // a point is inside out
  Lost,      // not finite, or blown up
};

/// A force on each of the scene's organs (Scene::organs), N.
using OrganForces = std::array<Vec3, max_organs>;

/// What presses, by one number: the tools, then the rigid bodies.
inline constexpr int max_pressers = max_tools + max_rigid_bodies;

/// One step's (or, accumulated, one tick's) outcome.
struct StepReport {
  std::uint32_t flags = 0;
  int worst_point = -1;  // integration point with min J
  int worst_node = -1;   // node that moved furthest in one step, or is not finite
  float min_J = 1;
  int inverted_points = 0;
  float max_increment = 0;             // m, largest |du| of a node in one step
  Vec3 tool_force = Vec3::Zero();      // N, on the first tool
  Vec3 base_reaction = Vec3::Zero();   // N, of the held (imposed and not moving) nodes on the tissue
  Vec3 tool_torque = Vec3::Zero();     // N m, on the tool about its tip; of a whole tick only (tool_contact.h)
  Vec3 contact_normal = Vec3::Zero();  // unit, from the tissue towards the tool; 0: no contact; likewise
  int contact_count = 0;               // skin vertices that carry force
  double max_penetration = 0;          // m; of several tools the deepest for its radius, times the first one's radius
  ToolLoads loads;                     // on each tool
  OrganForces organ_force{};           // N, of the other organs on each; of a whole tick only
  double skin_penetration = 0;         // m, of bodies into one another
  int skin_contact_count = 0;          // skin vertices at which bodies touch
  RigidLoads rigid;                    // of the rigid bodies on the tissue
  // For step/trust.h.
  double strain_energy = 0;   // J
  double kinetic_energy = 0;  // J
  double energy_error = 0;    // of EnergyBalance
  double volume_change = 0;   // relative, of all integration points
  // Largest local pressures over shear moduli: where points hold the volume (without node patches: the body's mean),
  // and where cells do.
  double pressure_over_shear = 0, cell_pressure_over_shear = 0;
  bool nearly_incompressible = false;   // Poisson's ratio of all materials in force is at least 0.45
  double step_share = 0;                // dt over the stable step, as the tissue is now, with the mass that was added
  double added_mass = 0;                // by followStiffness, as a share of the body's own
  double added_inertia = 0;             // force that accelerates that mass, as a share of the recent forces
  Vec3 scaled_momentum = Vec3::Zero();  // kg m/s, of the mass that the scene's mass_scaling added
  // Of forces, as a share, because the cloud is no finer, and the force that it was found for, N: of a moment some
  // tenths of a second ago, of a whole tick only (step/resolution.h); and because that mass is accelerated. 1 and 0:
  // nothing is known yet. Of several tools, or round rigid bodies, that press, of what is worst off.
  double expected_error = 0, error_force = 0;
  int error_by = -1;  // whose, of max_pressers; -1: of what holds the body

  /// A tool touches the tissue.
  bool isTouched() const {
    if (contact_count > 0 || !tool_force.isZero(0)) return true;
    return std::any_of(loads.begin(), loads.end(), [](const ToolLoad& load) { return load.contact_count > 0; });
  }
};

}  // namespace palpate

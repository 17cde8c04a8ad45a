#pragma once

#include <span>

#include "contact/contact_state.h"
#include "contact/skin.h"
#include "contact/tool.h"

namespace palpate {

/// Pushes the predicted displacement out of the tool: finds forces f_v at the skin
/// vertices, compressive along the tool's normal and inside the friction cone, with
///   du_i += alpha / m_i sum_v N_i(X_v) f_v
/// so that u + du satisfies the contact law at the end of the step (implicit in the
/// contact, hence no limit on the step). The tool's force is exactly -sum_v f_v.
///
/// The law is that of a thin elastic layer on the tool. With penetration d at the end of the step,
/// layer stiffness K = k a_v (k = skin.bulk_stiffness, a_v the vertex's area) and s the tangential
/// slip of the skin over the tool's surface during the step:
///   f_n = K min(max(d, 0), 0.2 R)                           normal
///   f_t = f_t(last step) - K s,  |f_t| <= friction * f_n    tangential: stick, else slip (Coulomb)
/// Both are monotone and derive from stored energy or dissipation; they act along and across the normal of where the
/// point was at the step's start, as the tissue's forces are those of it, so contact never creates energy;
/// f_t is its own memory of the stick, so static friction does not creep.
///
/// Solved by Gauss-Seidel over the vertices, forwards and backwards by turns, in place on du,
/// starting from the last step's forces; at most kMaxSweeps sweeps.
///
/// Samples of stretched faces (contact.samples) take part like vertices; a force on one goes to its corners by their
/// shares. A point that is deep in the tool is pushed out by the side it came in by (tool_side.h).
/// A vertex whose position is not finite takes no part.
///
/// @param alpha         the step's mobility factor of paper eq. 12, s^2
/// @param inverse_mass  1/kg                                   (node_count)
/// @param u             displacement at the start, m           (node_count)
/// @param du            predicted increment, m; corrected      (node_count)
/// @param pose, previous_pose  tool at the step's end and start; at most ~1 mm or R/2 apart for no
///                      tunnelling, whichever is less
/// @return the force on the tool, N. It balances the step's start (the central difference's
///         acceleration is that at u), so its work is force . (mean of this and the last step's way).
/// Real-time: no allocation, no lock, no throw. With n support nodes per vertex: 2 n four-lane FMAs
/// per candidate, and per vertex in contact n (5 + 2 sweeps).
/// Test: contact/contact_solver_test.cpp.
Vec3 solveContact(const SkinModel& skin, const ToolShape& tool, const Pose& pose, const Pose& previous_pose,
                  double friction, double alpha, const float* inverse_mass, const Float4* u, Float4* du,
                  ContactState& contact);

/// How a hand holds a tool: as a motor that is as strong as this, and gives way to more within the step.
///   x_tool = wanted + way,   |F| <= max_force,   way = 0 or |F| = max_force
/// F is the force on the tool. Jaws open likewise to more than their max_pinch. Beyond `longest` it gives way no
/// further, and yet pushes no harder: the skin is deeper in it then.
struct ToolHold {
  double max_force = 0, max_pinch = 0;  // N; 0: it never gives way
  double longest = 0;                   // m
  // By how much it gives way (m): as a first guess, which the pose has in it already; receives the truth.
  Vec3 way = Vec3::Zero();
  double opening = 0;
};

/// One of several tools that touch the same skin.
struct TouchingTool {
  const ToolShape* shape = nullptr;
  Pose pose, previous_pose;
  double friction = 0;
  ContactState* contact = nullptr;
  ToolHold* hold = nullptr;   // null: nothing moves it from its pose. Bodies of one tool have the same, side by side
  Vec3 apart = Vec3::Zero();  // by which it moves per m of opening; 0: no finger of jaws
  Vec3 force = Vec3::Zero();  // receives what solveContact returns
};

/// The same for tools that touch at once: each sweep goes over the points of all of them, so their forces answer each
/// other within the step, and each gives way as its hold says. With one tool that does not it is solveContact, bit for
/// bit.
/// @param tools  at most max_tool_bodies
void solveContacts(const SkinModel& skin, std::span<TouchingTool> tools, double alpha, const float* inverse_mass,
                   const Float4* u, Float4* du);

}  // namespace palpate

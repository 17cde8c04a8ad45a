#pragma once

#include <span>

#include "contact/contact_row.h"
#include "contact/rigid_rows.h"
#include "contact/skin_contact.h"
#include "contact/tool_rows.h"

namespace palpate {

/// All that may touch the skin in a step.
struct Touching {
  std::span<TouchingTool> tools{};  // at most max_tool_bodies; each receives the force on it
  // What imposes displacements, once the last step's forces act: rows then see nodes as they will go; null: nothing.
  ContactGroup* held = nullptr;
  // Parts of the skin that touch each other; null: none do.
  SkinContactState* skins = nullptr;
  SkinContactScratch* pairs = nullptr;
  // Rigid bodies, which go from where they are at `begin` to where they are at `end` (s); null: none.
  const RigidBodies* rigid = nullptr;
  RigidState* rigid_state = nullptr;
  double begin = 0, end = 0;
};

/// What touched did in a step.
struct ContactForces {
  SkinContact skins;
  RigidLoads rigid;
  int sweeps = 0;
};

/// Keeps the predicted displacement out of all that it may touch: tools, other parts of the skin, rigid bodies. Each
/// point that touches is a row (ContactRow); forces f_r at places of the skin with shape functions N_r act as
///   du_i += alpha / m_i sum_r N_r(i) f_r
/// implicit in the contact, hence without a limit on the step. One Gauss-Seidel iteration over all rows, forwards and
/// backwards by turns, in place on du, from the last step's forces: what presses a flap and what it lies on answer each
/// other within the step. Groups of rows that have settled wait for the others, and are then looked at once more.
///
/// Serial, in a fixed order, so that it is the same for any number of threads.
/// Real-time: no allocation, no lock, no throw. With n support nodes per vertex: 2 n four-lane FMAs per candidate, and
/// per row n (5 + 2 sweeps).
/// Test: contact/contact_solver_test.cpp, simulation/skin_contact_test.cpp, simulation/rigid_bodies_test.cpp
ContactForces solveContacts(const ContactStep& step, const Touching& touching);

}  // namespace palpate

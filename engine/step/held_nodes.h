#pragma once

#include <span>
#include <utility>

#include "model/model.h"
#include "model/state.h"

namespace palpate {

/// Whether something touched the skin in the last step beside nodes that displacements are imposed on
/// (Model::beside_held). What the solver of contacts predicts of such nodes is not how they will go: in a thin layer on
/// a fixed base each step saw the skin come by 4 um, and friction, which is of ways, drove tissue on with that (a ball
/// held in 4 mm: force growing by a third in 7 s, energy doubled). There the displacements are imposed first, too.
/// Real-time: no allocation, no lock, no throw. Test: simulation/held_nodes_test.cpp
bool touchesBesideHeld(const Model& model, std::span<const ContactState> tools, const SkinContactState& skins,
                       const RigidState& rigid);

/// What imposes displacements, as a group of the contact solver that has no rows.
template <class Impose>
class HeldNodes final : public ContactGroup {
 public:
  explicit HeldNodes(Impose impose) : impose_(std::move(impose)) {}
  std::size_t makeRows() override { return impose_(), 0; }
  bool sweep(bool) override { return true; }

 private:
  Impose impose_;
};

}  // namespace palpate

#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/types.h"
#include "contact/contact_state.h"
#include "contact/rigid_bodies.h"
#include "contact/skin_contact.h"
#include "model/model.h"

namespace palpate {

/// The friction that holds nodes of the skin against what touches it, as far as it holds at all:
///   friction_j = sum_c N_j(X_c) mu_c |f_c| / sum_v N_j(X_v) a_v                  Pa
/// over the last step's forces f_c of tools, rigid bodies and other skin, of which a face's corners have a third each;
/// of the nodes of the cells' outer faces, others have none.
class HoldingFriction {
 public:
  explicit HoldingFriction(const Model& model);

  /// @param of_tools  Coulomb coefficients
  /// @param friction  receives it (CellVolumeScratchOf::friction; empty: nobody asks)
  /// Real-time: no allocation, no lock, no throw; an interpolation for each force.
  void find(const Model& model, std::span<const ContactState> tools, const std::array<double, max_tools>& of_tools,
            const SkinContactState& skins, const RigidState& rigid, AlignedVector<float>& friction);

 private:
  std::vector<float> inverse_area_;  // (node_count) 1/m^2; 0: in no outer face. Empty: without cells
  bool any_ = false;                 // friction was found last
};

}  // namespace palpate

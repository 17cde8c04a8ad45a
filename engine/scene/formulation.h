#pragma once

namespace palpate {

/// The floor under the energy: its barrier's strength, and the volume ratio below which it acts (Material). Paper eq.
/// 32 and its like let a point collapse at a pressure of K. Confined tissue of nu 0.49 is at J = 0.2 under 40 shear
/// moduli, the most that is promised; below, no state is one that a scene is made for.
inline constexpr double floor_strength = 1, floor_J0 = 0.2;

/// How forces follow from displacements, beyond the paper's equations. A scene has all of it, without keys, or with
/// `scheme = "paper"` nothing of it; tools take single steps away to show what each buys. What a scene does not need
/// costs it nothing: one material has no border, tissue far from incompressible no patches (needsPatches), and where
/// nothing is pressed no cell is looked at.
struct Formulation {
  bool consistent_gradients = true;  // gradients corrected to the divergence theorem (consistent_gradients.h)
  bool node_patches = true;          // volume averaged over node patches, against locking (node_patch.h)
  double own_bulk = 2.25;            // of a point's bulk modulus what patches leave to it, in shear moduli
  bool cell_volume = true;           // pressed tissue keeps the volume of its cells (cell_volume.h)
  bool sharp_interfaces = true;      // supports end at borders between materials (sharp_interfaces.h)
  bool floor = true;                 // points do not collapse (floor_J0)

  /// The paper's own.
  static constexpr Formulation paper() { return {false, false, 0, false, false, false}; }

  bool operator==(const Formulation&) const = default;
};

}  // namespace palpate

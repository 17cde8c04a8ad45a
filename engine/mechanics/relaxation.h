#pragma once

#include <vector>

#include "base/types.h"
#include "mechanics/materials/material.h"

namespace palpate {

/// Relaxation of the isochoric stress by Prony terms (Simo, Comput. Methods Appl. Mech. Eng. 60, 153 (1987); Holzapfel,
/// Nonlinear Solid Mechanics (2000), section 6.10). The law's moduli are those at once:
///
///   G(t) = G_0 (1 - sum_i g_i (1 - e^(-t / tau_i)))
///   P   = P_law - sum_i Dev(Q_i),    tau_i dQ_i/dt = g_i S - Q_i,    Q_i = 0 before all motion
///   S   = J^(2/3) F^-1 P_iso         isochoric 2nd Piola-Kirchhoff stress of the law, by its work on
///   C'  = J^(-2/3) F^T F             the isochoric strain
///   Dev(Q) = J^(-2/3) F Q - 1/3 (C' : Q) F^-T
///   P_iso  = P_law - 1/3 (P_law : F) F^-T
///
/// Whatever the pressure in P_law comes from (the point, node patches, cells, the barrier): it does not relax. At a
/// strain that is held each Q goes to g S, and P_iso to the share 1 - sum g of the law's.
///
/// Where S goes straight from one step to the next, Q is exact (second order else). With E = e^(-h / tau),
/// a = 1 - (1 - E) tau / h and b = (1 - E) tau / h - E:
///   Q_(n+1) = E Q_n + g (a S_(n+1) + b S_n)
/// Kept is Z_n = E Q_n + g b S_n, which knows S_n: 6 numbers a term, and stable for any h.
struct RelaxationStep {
  struct Term {
    double g, rate;            // 1/tau, 1/s
    double now, later, decay;  // Q = Z + now S;  Z += later S - decay Z
  };
  int term_count = 0;
  Term term[Material::max_relaxation_terms]{};
};

/// @param h               s; infinity: Q is g S, the equilibrium after a long time
/// @param max_term_count  terms beyond it are left out
RelaxationStep relaxationStep(const Material& material, double h, int max_term_count = Material::max_relaxation_terms);

/// What the points of a kernel layout remember. Part of a simulation's state.
template <class Real>
struct RelaxationHistoryOf {
  static constexpr std::size_t batch_numbers = 96;  // a term of a batch's 16 points

  int term_count = 0;     // largest of the materials
  AlignedVector<Real> Z;  // (batch_count)(term_count)(6)(16) Pa: 11, 22, 33, 23, 13, 12 of a batch's 16 points
};

using RelaxationHistory = RelaxationHistoryOf<float>;

/// At rest; empty where no material relaxes.
template <class Real>
RelaxationHistoryOf<Real> makeRelaxationHistory(std::size_t batch_count, const std::vector<Material>& materials);

/// A history by the model's points, in any order of theirs; empty: the equilibrium after a long time.
struct PointHistory {
  int term_count = 0;
  double h = 0;         // s, of the steps that it was kept in
  std::vector<Mat3> Z;  // (point_count)(term_count) Pa

  bool empty() const { return Z.empty(); }
};

/// Stress of a point that relaxes.
struct RelaxedStress {
  Mat3 P;
  double energy;  // J/m^3, sum Q : E with the isochoric strain E = (C' - I) / 2
  double power;   // W/m^3, sum dQ/dt : E
};

/// The formulas above plainly: what the kernel (relaxation_lanes.h) is held to.
/// @param P  the law's stress, Pa
/// @param Z  (term_count) the step is done in it; null: the equilibrium
/// Test: mechanics/relaxation_test.cpp
RelaxedStress relaxedStress(const RelaxationStep& step, const Mat3& F, const Mat3& P, Mat3* Z = nullptr);

}  // namespace palpate

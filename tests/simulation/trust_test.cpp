#include "step/trust.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "contact/tools/tool_list.h"
#include "mechanics/bounded_pressure.h"
#include "mechanics/internal_forces.h"
#include "step/follow_stiffness.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// What a run saw, tick by tick, with the tool pressed in and held.
struct Watched {
  double worst_energy_error = 0, worst_step_share = 0;
  int first_doubt = -1, lost = -1;  // ticks
  Doubt first = Doubt::None;
};

Watched press(const Model& model, double depth, double seconds) {
  Workspace workspace(model, 1);
  State state = initialState(model);
  Watched watched;
  const auto ticks = static_cast<int>(seconds * model.scene.dynamics.rate_hz);
  for (int k = 0; k < ticks; ++k) {
    const double s = std::min(1.0, 2.0 * k / ticks);
    Command command;
    command.tools[0].pose = toolAt(model, model.tools.first().first_contact_travel + depth * s * s * (3 - 2 * s));
    const StepReport report = tick(model, state, command, workspace);
    watched.worst_energy_error = std::max(watched.worst_energy_error, report.energy_error);
    watched.worst_step_share = std::max(watched.worst_step_share, report.step_share);
    const Doubt doubt = doubtOf(model, report);
    if (doubt == Doubt::Lost) {
      watched.lost = k;
      break;
    }
    if (doubt > Doubt::Resolution && watched.first_doubt < 0) {
      watched.first_doubt = k;
      watched.first = doubt;
    }
  }
  return watched;
}

}  // namespace

TEST_CASE("The error that mass added for longer steps makes in fast motion is expected", "[trust][whole]") {
  Scene own = blockScene(0.008);
  own.tools[0].max_speed = 0.5;
  Scene slowed = own;
  slowed.dynamics.time_step = 1 / own.dynamics.rate_hz;  // which the body's own mass is not stable with
  slowed.dynamics.mass_scaling = 10;
  const Model with = blockModel(slowed), without = blockModel(own);
  REQUIRE(without.substeps_per_tick > 1);
  REQUIRE(with.substeps_per_tick == 1);
  struct Pressed {
    double error, expected, expected_without;  // of the largest force: rms, and as RunTrust has it
  };
  // To a third of the radius and back.
  const auto pressed = [&](double seconds) {
    Workspace a(with, 1), b(without, 1);
    State state_a = initialState(with), state_b = initialState(without);
    double largest = 0, sum = 0;
    RunTrust trust, trust_without;
    const int ticks = static_cast<int>(seconds * own.dynamics.rate_hz);
    for (int k = 0; k <= ticks; ++k) {
      const double s = std::sin(M_PI * k / ticks);
      Command command;
      command.tools[0].pose =
          toolAt(with, with.tools.first().first_contact_travel + own.tools[0].shape.radius / 3 * s * s);
      const StepReport report = tick(with, state_a, command, a);
      const StepReport right = tick(without, state_b, command, b);
      sum += (report.tool_force - right.tool_force).squaredNorm();
      largest = std::max(largest, right.tool_force.norm());
      trust.add(doubtOf(with, report), report.expected_error, report.error_force, k / own.dynamics.rate_hz);
      trust_without.add(doubtOf(without, right), right.expected_error, right.error_force, k / own.dynamics.rate_hz);
    }
    return Pressed{std::sqrt(sum / ticks) / largest, trust.expectedError(), trust_without.expectedError()};
  };
  const Pressed slow = pressed(3), fast = pressed(0.1);
  CAPTURE(slow.error, slow.expected, slow.expected_without, fast.error, fast.expected, fast.expected_without);
  CHECK(slow.error < 0.01);
  CHECK(slow.expected == Approx(slow.expected_without).margin(0.01));
  CHECK(fast.error > 0.1);
  CHECK(fast.expected > fast.expected_without + fast.error);
}

TEST_CASE("A plain indentation is trusted from the first tick to the last", "[trust]") {
  const Model model = blockModel();
  const Watched watched = press(model, 0.004, 0.5);
  CHECK(watched.first_doubt == -1);
  CHECK(watched.worst_energy_error < 0.5 * TrustLimits::energy_error);
  CHECK(watched.worst_step_share < 1);
  CHECK(watched.worst_step_share >= model.dt / model.dt_critical);
}

TEST_CASE("A first touch is no energy of nothing, however fast", "[trust][whole]") {
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::FlatCylinder}) {
    Scene scene = blockScene();
    scene.tools[0].shape.kind = kind;
    scene.tools[0].max_speed = 2;
    const Model model = blockModel(scene);
    Workspace workspace(model, 1);
    for (const double speed : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0}) {
      State state = initialState(model);
      state.tool[0].pose = toolAt(model, model.tools.first().first_contact_travel - 1e-6);
      double worst = 0, force = 0;
      for (int k = 1; k <= 20; ++k) {
        Command command;
        command.tools[0].pose = toolAt(model, model.tools.first().first_contact_travel +
                                                  std::min(0.003, speed * k / model.scene.dynamics.rate_hz));
        const StepReport report = tick(model, state, command, workspace);
        worst = std::max(worst, report.energy_error);
        force = std::max(force, report.tool_force.norm());
      }
      CAPTURE(speed);
      CHECK(force > 0.01);  // it did touch
      CHECK(worst < 0.7 * TrustLimits::energy_error);
    }
  }
}

TEST_CASE("The strain energy is that of the double reference, and the work done on the tissue", "[trust][whole]") {
  for (const bool patches : {false, true}) {
    Scene scene = blockScene();
    scene.discretization.formulation.node_patches = patches;
    const Model model = blockModel(scene);
    Workspace workspace(model, 2);
    State state = initialState(model);
    StepReport report;
    for (int k = 1; k <= 200; ++k) {
      Command command;
      command.tools[0].pose = toolAt(model, model.tools.first().first_contact_travel + 0.004 * k / 200);
      // Of the state that the last step began with.
      std::vector<Vec3> u;
      for (const auto& a : state.u) u.push_back(toVec3(a));
      report = tick(model, state, command, workspace);
      if (k != 200 || model.substeps_per_tick != 1) continue;
      CHECK(report.strain_energy == Approx(strainEnergy(model.point_shape, model.point_volume, model.point_material,
                                                        model.materials, u, model.patches))
                                        .epsilon(1e-4));
    }
    CHECK(report.strain_energy > 1e-6);
    CHECK(state.energy.work == Approx(report.strain_energy).epsilon(0.02));
    CHECK(report.kinetic_energy > 0);
    CHECK(report.kinetic_energy < 0.1 * report.strain_energy);
  }
}

TEST_CASE("The pressure that is doubted is the one under the tool, of which the body's mean says nothing",
          "[trust][whole]") {
  for (const bool cells : {false, true}) {
    Scene scene = blockScene();
    scene.dynamics.rate_hz = 1000;  // one step a tick
    scene.discretization.formulation.cell_volume = cells;
    const Model model = blockModel(scene);
    Workspace workspace(model, 2);
    State state = initialState(model);
    StepReport report;
    std::vector<Vec3> u;  // that the last step began with
    for (int k = 1; k <= 300; ++k) {
      Command command;
      command.tools[0].pose = toolAt(model, model.tools.first().first_contact_travel + 0.012 * k / 300);
      u.clear();
      for (const auto& a : state.u) u.push_back(toVec3(a));
      report = tick(model, state, command, workspace);
    }
    REQUIRE(model.substeps_per_tick == 1);
    const Material& m = model.materials[0];
    std::vector<double> change;
    for (int q = 0; q < model.pointCount(); ++q)
      change.push_back(deformationGradient(model.point_shape, q, u).determinant() - 1);
    std::vector<double> pressure = patchPressure(model.patches, model.point_volume, change);
    addOwnPressure(model.patches, model.point_material, model.materials, change, pressure);
    const double largest = -*std::min_element(pressure.begin(), pressure.end()) / m.shear_modulus;
    // Of that what points keep for themselves, which the cells do not take over.
    const double own = -scene.discretization.formulation.own_bulk * *std::min_element(change.begin(), change.end());
    INFO("patches " << largest << ", reported " << report.pressure_over_shear << ", " << report.cell_pressure_over_shear
                    << ", body's mean " << -report.volume_change * m.bulk_modulus / m.shear_modulus);
    CHECK(largest > 1);
    CHECK(largest > 5 * -report.volume_change * m.bulk_modulus / m.shear_modulus);
    if (cells) {
      CHECK(report.pressure_over_shear < 1.01 * pressure_limit + own);  // what is beyond is the cells'
      CHECK(report.cell_pressure_over_shear > 1);
      CHECK(doubtOf(model, report) <= Doubt::Resolution);
    } else {
      CHECK(report.pressure_over_shear == Approx(largest).epsilon(1e-3));
      CHECK(report.cell_pressure_over_shear == 0);
      CHECK((doubtOf(model, report) == Doubt::Volume) == (largest > TrustLimits::pressure));
    }
  }
}

TEST_CASE("A step too long for the tissue at rest gives it the mass that it needs", "[trust][whole]") {
  Model model = blockModel();
  for (const double share : {1.03, 1.3}) {
    // No scene may ask for this: the set-up refuses it.
    model.dt = share * model.dt_critical;
    const Watched watched = press(model, 0.003, 3);
    CAPTURE(share);
    CHECK(watched.lost == -1);
    CHECK(watched.worst_step_share <= followed_step_share * (1 + 1e-6));
    CHECK(watched.worst_energy_error < TrustLimits::energy_error);
  }
}

TEST_CASE("Energy that comes from nowhere is seen without knowing the stable step", "[trust]") {
  Model model = blockModel();
  model.dt = 1.2 * model.dt_critical;
  model.dt_critical *= 10;  // as if it were
  Workspace workspace(model, 1);
  State state = initialState(model);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  state.du[static_cast<std::size_t>(model.nodeCount() / 2)].z = 1e-6F;  // a nudge
  int doubted = -1, lost = -1;
  for (int k = 0; k < 4000 && lost < 0; ++k) {
    const StepReport report = tick(model, state, command, workspace);
    if (report.energy_error > TrustLimits::energy_error && doubted < 0) doubted = k;
    if (report.flags & (kBlowUp | kNotFinite)) lost = k;
  }
  REQUIRE(lost > 0);
  REQUIRE(doubted >= 0);
  CHECK(doubted < lost);
}

TEST_CASE("The share of the stable step follows the squeeze of the volume", "[trust]") {
  Model model;
  model.dt = 0.5;
  model.dt_critical = 1;
  ForceReport forces;
  forces.max_modulus = forces.max_squeeze = 1;  // K s^2 alone
  CHECK(stepShare(model, {}, forces) == Approx(0.5));
  // Squeezed to 1 / s^2 in one direction at constant volume, F = diag(s, s, 1 / s^2): singular values of cof F 1 /
  // s, 1 / s, s^2.
  for (const double s : {1.1, 1.5, 2.0}) {
    const double largest = s * s, cof2 = largest * largest + 2 / (s * s);
    forces.max_cof2 = cof2;
    CHECK(stepShare(model, {}, forces) == Approx(0.5 * largest).epsilon(1e-3));
  }
  forces.max_cof2 = 3;
  forces.max_modulus = 4;  // fibres, stretched and nowhere squeezed
  CHECK(stepShare(model, {}, forces) == Approx(1.0));
}

TEST_CASE("Each doubt has its words, and the gravest is told", "[trust]") {
  Model model;
  model.scene.tools[0].shape.radius = 0.01;
  StepReport report;
  report.nearly_incompressible = true;
  report.min_J = 0.4F;
  CHECK(doubtOf(model, report) == Doubt::Volume);
  report.nearly_incompressible = false;
  CHECK(doubtOf(model, report) == Doubt::None);
  report.nearly_incompressible = true;
  report.min_J = 1;
  CHECK(doubtOf(model, report) == Doubt::None);
  for (const double share : {0.95, 1.05}) {
    const Doubt expected = share < 1 ? Doubt::None : Doubt::Volume;
    model.scene.discretization.quadrature.cells_per_point = 1;
    report.cell_pressure_over_shear = 0;
    report.pressure_over_shear = share * TrustLimits::pressure;
    CHECK(doubtOf(model, report) == expected);
    model.scene.discretization.quadrature.cells_per_point = 2;
    CHECK(doubtOf(model, report) == Doubt::Volume);
    report.pressure_over_shear = share * TrustLimits::pressure_of_pairs;
    CHECK(doubtOf(model, report) == expected);
    report.pressure_over_shear = 0;
    report.cell_pressure_over_shear = share * TrustLimits::pressure_with_cells;
    CHECK(doubtOf(model, report) == expected);
  }
  report.max_penetration = 0.002;
  CHECK(doubtOf(model, report) == Doubt::Contact);
  report.min_J = 0.2F;
  CHECK(doubtOf(model, report) == Doubt::Squeezed);
  report.step_share = 1.1;
  CHECK(doubtOf(model, report) == Doubt::Step);
  report.step_share = followed_step_share;
  CHECK(doubtOf(model, report) == Doubt::Squeezed);
  report.added_inertia = 0.03;
  CHECK(doubtOf(model, report) == Doubt::Step);
  report.energy_error = 0.2;
  CHECK(doubtOf(model, report) == Doubt::Energy);
  report.inverted_points = 1;
  CHECK(doubtOf(model, report) == Doubt::Inverted);
  report.flags = kBlowUp;
  CHECK(doubtOf(model, report) == Doubt::Lost);
  for (const Doubt doubt :
       {Doubt::Volume, Doubt::Contact, Doubt::Squeezed, Doubt::Step, Doubt::Energy, Doubt::Inverted, Doubt::Lost})
    CHECK(std::string(doubtText(doubt)).size() > 10);
}

#include "simulation/contact_patch.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "contact/tools/tool_list.h"
#include "simulation/step.h"
#include "simulation/trust.h"
#include "simulation/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

TEST_CASE("A ball's contact has Hertz's radius, and no tool's is wider than the tool", "[contact_patch]") {
  constexpr double R = 0.01, plane = 4000;
  const ToolProfile ball = toolProfile(ToolShape::of(ToolKind::Sphere, R));
  for (const double depth : {1e-4, 5e-4, 1e-3}) {
    const double force = 4.0 / 3 * plane * std::sqrt(R) * std::pow(depth, 1.5);
    // The ball is a little steeper than the parabola that stands for it.
    CHECK(contactRadius(ball, force, plane, 0) == Approx(std::sqrt(R * depth)).epsilon(0.02));
    // What the nodes' distance adds to the force is none of the contact's.
    const double a = contactRadius(ball, force, plane, 0.005);
    CHECK(a < 0.97 * std::sqrt(R * depth));
    CHECK(contactRadius(ball, force / (1 + expectedForceError({a, 0.005, force})), plane, 0) ==
          Approx(a).epsilon(1e-3));
  }
  CHECK(contactRadius(ball, 1e6, plane, 0.005) == Approx(R));
  CHECK(contactRadius(toolProfile(ToolShape::of(ToolKind::FlatCylinder, R)), 0.01, plane, 0.005) > 0.6 * R);
}

TEST_CASE("The expected error falls with the square of the spacing, and says which spacing is fine enough",
          "[contact_patch]") {
  CHECK(expectedForceError({}) == 0);
  const double coarse = expectedForceError({0.01, 0.008, 1});
  CHECK(coarse > 0.005);
  CHECK(expectedForceError({0.01, 0.004, 1}) == Approx(coarse / 4));
  CHECK(expectedForceError({0.01, spacingFor(0.01, 0.05), 1}) == Approx(0.05));
  CHECK(expectedForceError({1e-6, 0.008, 1}) < 10);  // never anything that can't be printed
}

TEST_CASE("A coarse block's force is doubted for its resolution, a fine one's is not, and the warning names a spacing",
          "[contact_patch]") {
  for (const double spacing : {0.012, 0.004}) {
    const Model model = test::blockModel(test::blockScene(spacing));
    State state = initialState(model);
    Workspace workspace(model, 1);
    Command command;
    StepReport report;
    constexpr int ticks = 100;
    RunTrust trust;
    for (int k = 1; k <= ticks; ++k) {
      command.tool_target = test::toolAt(model, model.first_contact_travel + 0.007 * std::min(1.0, 1.5 * k / ticks));
      report = tick(model, state, command, workspace);
      trust.add(doubtOf(model, report), report.expected_error, report.tool_force.norm(), k * 0.002);
    }
    CAPTURE(spacing, report.expected_error, trust.expectedError());
    const bool coarse = spacing > 0.01;
    CHECK((report.expected_error > TrustLimits::expected_error) == coarse);
    CHECK(trust.doubt() == (coarse ? Doubt::Resolution : Doubt::None));
    CHECK((trust.firstTime() >= 0) == coarse);
    CHECK(resolutionWarning(model).empty() != coarse);
    if (coarse) CHECK(resolutionWarning(model).find("mtled fit") != std::string::npos);
    command.tool_target = model.tool_start;
    for (int k = 0; k < 20; ++k) report = tick(model, state, command, workspace);
    CHECK(report.expected_error == 0);  // in the air
  }
}

TEST_CASE("A run's trust is that of its gravest row, and of its resolution at the largest force", "[contact_patch]") {
  RunTrust trust;
  trust.add(Doubt::Resolution, 0.8, 0.01, 0.1);  // first touch: never resolved
  trust.add(Doubt::None, 0.03, 1, 0.2);
  CHECK(trust.doubt() == Doubt::None);
  CHECK(trust.firstTime() < 0);
  CHECK(trust.expectedError() == Approx(0.03));
  trust.add(Doubt::Resolution, 0.08, 1, 0.3);
  CHECK(trust.doubt() == Doubt::Resolution);
  CHECK(trust.firstTime() == 0.1);
  trust.add(Doubt::Volume, 0.01, 1, 0.4);
  trust.add(Doubt::Contact, 0.01, 1, 0.5);
  CHECK(trust.doubt() == Doubt::Contact);
  CHECK(trust.firstTime() == 0.4);
}

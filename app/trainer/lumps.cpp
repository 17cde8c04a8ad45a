#include "app/trainer/lumps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/number_text.h"
#include "base/turn.h"
#include "setup/build_model.h"
#include "step/resolution.h"
#include "step/step.h"
#include "step/workspace.h"

namespace palpate::app {

namespace {

constexpr double press_speed = 0.03;  // m/s
constexpr double start_gap = 0.002;   // m
constexpr double slope_begin = 0.6;   // of the working depth: from here on the slope is taken
constexpr double hold_seconds = 0.3;  // s, at each of the two depths; with 20 1/s a twentieth of the swinging is left,
constexpr double mean_seconds = 0.1;  // s, and of that the mean is taken

/// A tool that is pressed in along the skin's normal.
class Press {
 public:
  Press(const Model& model, const SkinSurface::Place& place)
      : model_(model),
        place_(place),
        workspace_(model, std::max(1, model.scene.dynamics.threads)),
        state_(initialState(model)) {
    command_.tools[0].pose.orientation = uprightOn(place.normal);
    state_.tool[0].pose = command_.tools[0].pose;
    state_.tool[0].pose.position = place.point + start_gap * place.normal;
  }

  /// N, as the tissue bears it in rest: neither its mass nor what a scene adds for longer steps has a share in it.
  double holdAt(double depth) {
    const double from = depth_;
    const int way = ticksOf((depth - from) / press_speed), ticks = way + ticksOf(hold_seconds),
              last = ticksOf(mean_seconds);
    double sum = 0;
    for (int k = 1; k <= ticks; ++k) {
      depth_ = from + (depth - from) * std::min(1.0, static_cast<double>(k) / way);
      command_.tools[0].pose.position = place_.point - depth_ * place_.normal;
      report_ = tick(model_, state_, command_, workspace_);
      if (k > ticks - last) sum += report_.tool_force.norm();
    }
    return sum / last;
  }

  /// Expected of the force now, as a share.
  double expectedError() const {
    RunTrust trust;
    addLast(model_, state_, report_, 0, trust);
    return trust.expectedError();
  }

 private:
  int ticksOf(double seconds) const {
    return std::max(1, static_cast<int>(std::lround(seconds * model_.scene.dynamics.rate_hz)));
  }

  const Model& model_;
  const SkinSurface::Place& place_;
  Workspace workspace_;
  State state_;
  Command command_;
  StepReport report_;
  double depth_ = -start_gap;  // m
};

/// Slope of force over depth of a press along the skin's normal.
struct Slope {
  double N_per_m = 0, error = 0;  // a share: nodes that are too stiff are so at both depths
};

Slope pressSlope(const Model& model, const SkinSurface::Place& place, double depth) {
  Press press(model, place);
  const double first = press.holdAt(slope_begin * depth), last = press.holdAt(depth);
  return {(last - first) / ((1 - slope_begin) * depth), press.expectedError()};
}

/// Of the places around a lump's foot, the one farthest from all lumps that faces much the same way.
SkinSurface::Place besideOf(const Lump& lump, const std::vector<Lump>& all, const SkinSurface& skin) {
  const Vec3 n = lump.foot.normal;
  const Vec3 side = n.unitOrthogonal();
  SkinSurface::Place best = lump.foot;
  double farthest = -1;
  for (const double radii : {2.5, 3.0, 4.0})
    for (int k = 0; k < 12; ++k) {
      const double angle = 2 * std::numbers::pi * k / 12;
      const Vec3 away = std::cos(angle) * side + std::sin(angle) * n.cross(side);
      const SkinSurface::Place place = skin.nearest(lump.foot.point + radii * lump.radius * away);
      double distance = std::numeric_limits<double>::infinity();
      for (const Lump& other : all) distance = std::min(distance, (other.centre - place.point).norm() - other.radius);
      const double merit = std::min(distance, 0.03) * std::max(0.0, place.normal.dot(n));
      if (merit > farthest) {
        farthest = merit;
        best = place;
      }
    }
  return best;
}

}  // namespace

std::vector<Lump> lumpsOf(const Body& model) {
  const SkinSurface skin(model.skin.surface);
  std::vector<Lump> lumps;
  const auto& materials = model.scene.materials;
  for (std::size_t m = 1; m < materials.size(); ++m) {
    const MaterialSpec& spec = materials[m];
    const double stiffness = spec.material.shear_modulus / materials.front().material.shear_modulus;
    if (spec.everywhere || spec.region.kind != Region::Kind::Sphere || stiffness <= 1) continue;
    Lump lump{spec.region.point, spec.region.radius, stiffness, skin.nearest(spec.region.point), 0};
    const Vec3 out = lump.foot.point - lump.centre;
    lump.top = std::copysign(out.norm(), out.dot(lump.foot.normal)) - lump.radius;
    lumps.push_back(lump);
  }
  return lumps;
}

std::string misplaced(const Lump& lump) {
  if (!lump.isInside()) return format("is %.1f mm outside of the organ", -1e3 * (lump.top + lump.radius));
  return lump.top < 0 ? format("reaches %.1f mm out of the skin", -1e3 * lump.top) : "";
}

bool LumpFeel::isSure() const { return std::abs(ratio() - least_feel) >= error * ratio(); }

std::vector<LumpFeel> feelLumps(const TaskBody& body, double depth, const std::function<void(double)>& progress) {
  const std::vector<Lump> lumps = lumpsOf(*body.model);
  const SkinSurface skin(body.model->skin.surface);
  std::vector<LumpFeel> feels;
  feels.reserve(lumps.size());
  const auto slopeAt = [&](const SkinSurface::Place& place, double presses) {
    if (progress) progress(presses / static_cast<double>(2 * lumps.size()));
    return pressSlope(body.near ? *body.near(place.point) : *body.model, place, depth);
  };
  for (const Lump& lump : lumps) {
    const auto done = static_cast<double>(2 * feels.size());
    const Slope above = slopeAt(lump.foot, done), beside = slopeAt(besideOf(lump, lumps, skin), done + 1);
    feels.push_back({above.N_per_m, beside.N_per_m, std::hypot(above.error, beside.error)});
  }
  return feels;
}

}  // namespace palpate::app

#include "simulation/yielding_contacts.h"

#include <algorithm>
#include <cmath>

#include "contact/skin_forces.h"
#include "simulation/tool_bodies.h"
#include "simulation/tool_contact.h"

namespace palpate {
namespace {

constexpr int max_tries = 8;        // contacts solved in one step,
constexpr int max_lost_tries = 14;  // and where a tool looks for another way
constexpr double low_enough = 1.0;  // of the limit
constexpr double high_enough = 0.85;
constexpr double aim = 0.93;

/// What gives way: a tool as a whole, or the opening of jaws.
struct Yielding {
  bool active = false;
  Vec3 out = Vec3::Zero();      // unit; as a whole: the way that it goes
  double t = 0;                 // m, how far
  double stands = 0;            // m, where it stays as it was
  double most = 0;              // m
  double below = 0, above = 0;  // m, its force is known to be above the limit up to here, within it from here on
  double f_below = 0;           // of the limit, there
  double f_above = 0;
  bool bracketed = false;

  /// The force at t is `f` of the limit. @return whether that will do
  bool learn(double f) {
    if (f > low_enough) {
      below = t;
      if (bracketed && f_below > 0) f_above = aim - 0.5 * (aim - f_above);  // Illinois: the old end counts half
      f_below = f;
      return t >= most;
    }
    above = t;
    f_above = f;
    bracketed = true;
    return f >= high_enough || t <= 0;
  }

  /// Where to look next. The last look is for where it is within the limit.
  void next(bool last) {
    if (!bracketed) {
      t = t < stands ? stands : most;
      return;
    }
    const double share = (f_below - aim) / std::max(f_below - f_above, 1e-9);
    t = last ? above : below + std::clamp(share, 0.1, 0.9) * (above - below);
  }
};

/// Where a tool as a whole goes that is beyond its limit all along the way out, between walls: by the force that it
/// feels there, over the stiffness that the last two places show, to the place with the least force.
struct Walk {
  bool on = false;
  Vec3 at = Vec3::Zero(), before = Vec3::Zero();  // m, from where the tool should be
  Vec3 force = Vec3::Zero(), force_before = Vec3::Zero();
  Vec3 best = Vec3::Zero();
  double least = 0;  // N

  /// @return whether that will do
  bool learn(const Vec3& felt, double limit) {
    force_before = force;
    force = felt;
    if (const double size = felt.norm(); size < least || least == 0) {
      least = size;
      best = at;
    }
    return felt.norm() <= low_enough * limit;
  }

  /// @param from  m, where the tool comes from, likewise
  void next(bool last, double limit, const Vec3& from, double longest) {
    const Vec3 way = at - before, change = force - force_before;
    const double shown = -way.dot(change) / std::max(way.squaredNorm(), 1e-18), size = force.norm();
    const double stiffness = shown > 0 ? shown : size / longest;
    before = at;
    const Vec3 there = at + (1 - aim * limit / size) / stiffness * force - from;
    at = there.norm() > longest ? Vec3(from + longest / there.norm() * there) : Vec3(from + there);
    if (last || !at.allFinite()) at = best;
  }
};

/// Contact's memory of the step before, kept where only the search for candidates at a tick's begin has its scratch.
void keep(ContactState& c) {
  std::copy_n(c.force.begin(), c.count, c.old_force.begin());
  std::copy_n(c.normal.begin(), c.count, c.old_normal.begin());
  std::copy_n(c.side.begin(), c.count, c.old_side.begin());
  FaceSamples& s = c.samples;
  std::copy_n(s.force.begin(), s.count, s.old_force.begin());
  std::copy_n(s.normal.begin(), s.count, s.old_normal.begin());
  std::copy_n(s.side.begin(), s.count, s.old_side.begin());
}

/// Takes back what contact has done to the increments and to itself.
void undo(const Model& model, double alpha, const float* inverse_mass, State& state, ContactState& c) {
  forEachContactForce(c, [&](int vertex, const Float4& f) {
    applyForce(model.skin, vertex, Eigen::Vector4f(-f.x, -f.y, -f.z, 0), static_cast<float>(alpha), inverse_mass,
               state.du.data());
  });
  std::copy_n(c.old_force.begin(), c.count, c.force.begin());
  std::copy_n(c.old_normal.begin(), c.count, c.normal.begin());
  std::copy_n(c.old_side.begin(), c.count, c.side.begin());
  FaceSamples& s = c.samples;
  std::copy_n(s.old_force.begin(), s.count, s.force.begin());
  std::copy_n(s.old_normal.begin(), s.count, s.normal.begin());
  std::copy_n(s.old_side.begin(), s.count, s.side.begin());
}

struct Limit {
  double force, grip, speed;  // N, N of the pinch, m/s; a force of 0: none
};

Limit limitOf(const Model& model, int tool) {
  if (model.tools.empty()) return {model.max_tool_force, 0, model.scene.tool_max_speed};
  const ToolSetUp& set_up = model.tools.tool[static_cast<std::size_t>(tool)];
  return {set_up.max_force, set_up.grip_force, set_up.max_speed};
}

/// How far a tool goes back in a step at most: faster than it may follow a hand, for a cell that was crushed thrusts.
double longestWay(const Model& model, const Limit& limit) { return 4 * limit.speed * model.dt; }

/// The search for one step: each tool as a whole, then each opening.
struct Search {
  const Model& model;
  const State& state;
  const ToolPostures wanted;
  std::array<Yielding, 2 * max_tools> yielding;
  std::array<Walk, max_tools> walks;

  static Vec3 forceOn(const Model& model, int tool, const Vec3& first, const ToolLoads& loads) {
    return model.tools.empty() ? first : loads[static_cast<std::size_t>(tool)].force;
  }

  /// Looks at what the tools bear now. @return whether that will do
  bool look(const Vec3& first, const ToolLoads& loads) {
    bool good = true;
    for (int k = 0; k < model.tools.toolCount(); ++k) {
      const Limit limit = limitOf(model, k);
      const Vec3 force = forceOn(model, k, first, loads);
      const double most_way = longestWay(model, limit);
      const auto tool = static_cast<std::size_t>(k);
      const ToolPosture from = postureOf(state, k);
      Yielding& whole = yielding[tool];
      if (!whole.active && limit.force > 0 && force.norm() > limit.force) {
        whole.active = true;
        whole.out = force.normalized();
        whole.stands = std::max(0.0, -(wanted[tool].pose.position - from.pose.position).dot(whole.out));
        whole.most = whole.stands + most_way;
      }
      Yielding& jaws = yielding[max_tools + tool];
      const double pinch = loads[tool].pinch;
      if (!jaws.active && limit.grip > 0 && pinch > limit.grip) {
        jaws.active = true;
        jaws.stands = std::max(0.0, from.opening - wanted[tool].opening);
        jaws.most = jaws.stands + most_way;
      }
      if (whole.active) good = learn(tool, force, limit.force) && good;
      if (jaws.active) good = jaws.learn(pinch / limit.grip) && good;
    }
    return good;
  }

  bool learn(std::size_t tool, const Vec3& force, double limit) {
    Yielding& whole = yielding[tool];
    Walk& walk = walks[tool];
    if (walk.on) return walk.learn(force, limit);
    walk.before = walk.at;
    walk.at = whole.t * whole.out;
    const bool enough = walk.learn(force, limit);
    if (!whole.learn(force.norm() / limit)) return false;
    walk.on = !enough;
    return enough;
  }

  bool isLost() const {
    return std::any_of(walks.begin(), walks.end(), [](const Walk& walk) { return walk.on; });
  }

  ToolPostures next(bool last) {
    ToolPostures tools = wanted;
    for (std::size_t k = 0; k < max_tools; ++k) {
      if (Walk& walk = walks[k]; walk.on) {
        const Limit limit = limitOf(model, static_cast<int>(k));
        const Vec3 from = postureOf(state, static_cast<int>(k)).pose.position - wanted[k].pose.position;
        walk.next(last, limit.force, from, longestWay(model, limit));
        tools[k].pose.position += walk.at;
      } else if (Yielding& whole = yielding[k]; whole.active) {
        whole.next(last);
        tools[k].pose.position += whole.t * whole.out;
      }
      if (Yielding& jaws = yielding[max_tools + k]; jaws.active) {
        jaws.next(last);
        tools[k].opening += jaws.t;
      }
    }
    return tools;
  }
};

}  // namespace

Vec3 solveYieldingContacts(const Model& model, double alpha, const float* inverse_mass, ToolPostures& tools,
                           State& state, ToolLoads& loads) {
  const int bodies = model.tools.bodyCount();
  for (int b = 0; b < bodies; ++b) keep(contactOf(state, b));
  Vec3 force = solveToolContacts(model, tools, alpha, inverse_mass, state, loads);
  Search search{model, state, tools, {}, {}};
  for (int tries = 1; !search.look(force, loads); ++tries) {
    const int most = search.isLost() ? max_lost_tries : max_tries;
    if (tries >= most) break;
    for (int b = 0; b < bodies; ++b) undo(model, alpha, inverse_mass, state, contactOf(state, b));
    loads = {};
    tools = search.next(tries + 1 == most);
    force = solveToolContacts(model, tools, alpha, inverse_mass, state, loads);
  }
  return force;
}

void StayedBehind::shift(ToolPostures& tools) const {
  if (!any_) return;
  for (std::size_t k = 0; k < max_tools; ++k) {
    tools[k].pose.position += way_[k];
    tools[k].opening += opening_[k];
  }
}

void StayedBehind::add(const Model& model, const ToolPostures& wanted, const State& state) {
  for (int k = 0; k < model.tools.toolCount(); ++k) {
    const auto tool = static_cast<std::size_t>(k);
    const ToolPosture is = postureOf(state, k);
    way_[tool] += is.pose.position - wanted[tool].pose.position;
    if (!model.tools.empty()) opening_[tool] += is.opening - wanted[tool].opening;
    any_ = any_ || !way_[tool].isZero(0) || opening_[tool] != 0;
  }
}

}  // namespace palpate

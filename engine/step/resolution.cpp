#include "step/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/scene_messages.h"
#include "step/rim_force.h"
#include "step/tool_bodies.h"
#include "step/tool_contact.h"

namespace palpate {
namespace {

// Of a tick: at the liver's 20,124 points a hundredth of its time.
constexpr std::size_t points_a_tick = 64, most_ticks = 400;
// So many times faster until there is an estimate, and while the energy is another than a sweep's by a fifth.
constexpr std::size_t faster = 5;
constexpr double changed = 0.2;
constexpr double settling_seconds = 0.1;  // after a change of place: a late one over a seam was taken for a jerk
constexpr double touched_energy = 1e-2;   // of Model::rest_energy, from which on a touch is looked at

/// The largest force that a tool has on it, N.
double toolForce(const StepReport& report) {
  double largest = report.tool_force.norm();
  for (const ToolLoad& load : report.loads) largest = std::max({largest, load.force.norm(), load.pinch});
  return largest;
}

/// The largest force that something has on it, N.
double largestForce(const StepReport& report) {
  double largest = std::max(toolForce(report), report.base_reaction.norm());
  for (const RigidLoad& load : report.rigid) largest = std::max(largest, load.force.norm());
  return largest;
}

/// The node that moves the skin most where a tool presses it hardest; -1: it touches nothing.
int touchedNode(const Model& model, const State& state, int tool) {
  int vertex = -1;
  double most = 0;
  for (std::size_t b = 0; b < model.tools.body.size(); ++b)
    if (model.tools.body[b].tool == tool)
      forEachContactForce(state.contact[b], [&](int v, const Float4& force) {
        if (const double size = toVec3(force).norm(); size > most) most = size, vertex = v;
      });
  return vertex < 0 ? -1 : heaviestNode(model, vertex);
}

/// Where a rigid body presses the skin hardest.
void findTouch(const Model& model, const RigidState& state, Press& press) {
  const RigidBody& body = model.rigid.body[press.rigid()];
  int hardest = -1;
  float most = 0;
  const auto look = [&](int p) {
    if (p < body.begin || p >= body.end) return;
    const Float4& f = state.force[p];
    if (const float size = f.x * f.x + f.y * f.y + f.z * f.z; size > most) most = size, hardest = p;
  };
  const bool listed = state.near_count >= 0;
  for (int k = 0; k < (listed ? state.near_count : model.rigid.pointCount()); ++k) look(listed ? state.near[k] : k);
  if (hardest >= 0) PressList::touch(model, model.rigid.vertex[hardest], state.normal[hardest].cast<double>(), press);
}

/// What presses in a tick, with the nodes that it touches.
PressList pressesOf(const Model& model, const State& state, const StepReport& report) {
  PressList presses(model, report.loads, report.rigid);
  for (std::size_t k = 0; k < presses.count; ++k) {
    Press& press = presses.press[k];
    if (press.isTool())
      press.node = touchedNode(model, state, press.by);
    else
      findTouch(model, state.rigid, press);
  }
  return presses;
}

/// Where a report keeps what is known of a press.
std::pair<double*, double*> errorOf(StepReport& report, const Press& press) {
  if (press.isTool()) {
    ToolLoad& load = report.loads[press.tool()];
    return {&load.expected_error, &load.error_force};
  }
  RigidLoad& load = report.rigid[press.rigid()];
  return {&load.expected_error, &load.error_force};
}

/// Adds a force that is wrong, as a share of what is felt now and in N, to an error, a share of a force that may be
/// another moment's: in N both count as they are. @param error, error_force  0: not known
void addForce(double share, double newtons, double& error, double& error_force) {
  if (!(share > 0) || !(error_force > 0)) return;
  const double sum = std::hypot(error * error_force, newtons);
  error = std::hypot(error, share);
  error_force = sum / error;
}

}  // namespace

ResolutionWatch::ResolutionWatch(const Model& model)
    : u_(model.X.size()),
      at_(model.point_X.size()),
      fit_(static_cast<std::size_t>(model.point_groups.count)),
      material_(nodeMaterials(model)) {}

void ResolutionWatch::restart() {
  forget();
  before_ = -1;
}

void ResolutionWatch::forget() {
  next_ = 0;
  is_new_ = true;
  inertia_ = 0;
  known_.fill({});
  jerks_.fill({});
}

void ResolutionWatch::goOnFrom(const ResolutionWatch& before) {
  forget();
  before_ = before.before_;
  known_ = before.known_;
  jerks_ = before.jerks_;
  settling_ = settling_seconds;
  tool_at_ = before.tool_at_;
  quickest_ = before.quickest_;
}

void ResolutionWatch::advance(const Model& model, const State& state, StepReport& report) {
  watchTools(model, state);
  const PressList presses = pressesOf(model, state, report);
  if (presses.count == 0) before_ = report.strain_energy;
  // What presses of late, or harder or less than when it was looked at.
  bool is_new = false, other = presses.count == 0 && !(known_[max_pressers].force > 0);
  for (std::size_t k = 0; k < presses.count; ++k) {
    const Press& press = presses.press[k];
    const double known = known_[static_cast<std::size_t>(press.by)].force;
    other = other || std::abs(press.force - known) > changed * known;
    is_new = is_new || (!(known > 0) && std::none_of(moment_.presses().begin(), moment_.presses().end(),
                                                     [&](const Press& seen) { return seen.by == press.by; }));
  }
  if (is_new) next_ = 0;
  if (next_ == 0) {
    const double least = (presses.count > 0 ? touched_energy : 1) * model.rest_energy;
    if (!(report.strain_energy > least)) {  // nothing to look at
      forget();
      report.expected_error = presses.count > 0 ? 1 : 0;
      return;
    }
    begin(model, state, report, presses);
  }
  const bool old = other || std::abs(report.strain_energy - energy_) > changed * energy_;
  const std::size_t count = at_.size(), part = std::max(points_a_tick, count / most_ticks + 1) * (old ? faster : 1);
  if (next_ < count) {
    const std::size_t end = std::min(next_ + part, count);
    gather(model, next_, end);
    next_ = end;
  } else {
    const std::size_t begin = next_ - count, end = std::min(begin + 4 * part, count);  // each a quarter of the work
    compare(model, state.live.kernel.materials, begin, end);
    next_ = count + end;
  }
  if (next_ == 2 * count) {
    next_ = 0;
    known_.fill({});
    for (std::size_t k = 0; k < moment_.presses().size(); ++k) {
      const Press& press = moment_.presses()[k];
      known_[press.by < 0 ? max_pressers : static_cast<std::size_t>(press.by)] = {moment_.error(k, energy_, before_),
                                                                                  press.force};
    }
  }
  tell(model, state, presses, report);
  addScaledInertia(model, report);
  addJerks(model, state, presses, report);
}

/// A moment to look at.
void ResolutionWatch::begin(const Model& model, const State& state, const StepReport& report, PressList presses) {
  std::copy(state.u.begin(), state.u.end(), u_.begin());
  std::fill(fit_.begin(), fit_.end(), Rows{});
  energy_ = report.strain_energy;
  if (presses.count == 0) presses.press[presses.count++] = {-1, largestForce(report), -1};
  moment_ =
      PressErrors(model, presses, state.live.kernel.materials, material_, strainedBeside(model, state.live.loads));
}

/// Of a press, when it was last looked at.
double ResolutionWatch::localShare(int by) const {
  const auto presses = moment_.presses();
  for (std::size_t k = 0; k < presses.size(); ++k)
    if (presses[k].by == by) return moment_.localShare(k, energy_, before_);
  return 1;
}

/// What is known of all that presses now, and of the worst of it; where nothing does, of what did last.
void ResolutionWatch::tell(const Model& model, const State& state, const PressList& presses, StepReport& report) const {
  const double of_layers = layerError(model, state.live.kernel.materials);
  Known worst;
  for (std::size_t k = 0; k < presses.count; ++k) {
    const Press& press = presses.press[k];
    Known known = known_[static_cast<std::size_t>(press.by)];
    if (!(known.force > 0)) {
      known = {1, 0};
    } else if (press.node >= 0) {
      const auto at = static_cast<std::size_t>(press.node), m = static_cast<std::size_t>(material_[at]);
      const double narrow = localShare(press.by) * narrowError(model, state.live.kernel.materials[m], press);
      if (narrow > known.error) known = {narrow, press.force};
    }
    known.error = std::max(known.error, of_layers);
    if (press.isTool()) {
      const double rim = rimForce(model, state, static_cast<int>(press.tool()));
      addForce(rim / std::max(press.force, known.force), rim, known.error, known.force);
    }
    const auto [error, force] = errorOf(report, press);
    *error = known.error;
    *force = known.force;
    if (k == 0 || known.error > worst.error) worst = known, report.error_by = press.by;
  }
  if (presses.count == 0) {
    report.error_by = -1;
    worst = known_[max_pressers];
    for (std::size_t p = 0; p < max_pressers; ++p)
      if (known_[p].error > worst.error) worst = known_[p], report.error_by = static_cast<int>(p);
    worst.error = worst.force > 0 ? std::max(worst.error, of_layers) : 1;
  }
  report.expected_error = worst.error;
  report.error_force = worst.force;
}

/// Of the tool's force, or of all where none touches.
void ResolutionWatch::addScaledInertia(const Model& model, StepReport& report) {
  if (model.own_share.empty()) return;
  constexpr double smoothing = 0.01, kept = 0.1;  // s, since vibrations take turns
  const double tick = 1 / model.scene.dynamics.rate_hz;
  if (is_new_) momentum_ = report.scaled_momentum;
  is_new_ = false;
  const Vec3 change = report.scaled_momentum - momentum_;
  momentum_ += tick / (smoothing + tick) * change;
  inertia_ = std::max(change.norm() / smoothing, inertia_ * (1 - tick / kept));
  const double force = std::max(largestForce(report), report.error_force);
  if (!(force > 0)) return;
  const double share = std::min(1.0, inertia_ / force);
  const auto add = [&](double& of, double& of_force) {
    const double most = std::max(1.0, of);
    addForce(share, share * force, of, of_force);
    of = std::min(most, of);
  };
  add(report.expected_error, report.error_force);
  for (ToolLoad& load : report.loads) add(load.expected_error, load.error_force);
  for (RigidLoad& load : report.rigid) add(load.expected_error, load.error_force);
}

void ResolutionWatch::watchTools(const Model& model, const State& state) {
  constexpr double kept = 0.1;  // s
  const double tick = 1 / model.scene.dynamics.rate_hz;
  quickest_ *= 1 - tick / kept;
  for (std::size_t t = 0; t < state.tool.size(); ++t) {
    quickest_ = std::max(quickest_, largestWay(model, static_cast<int>(t), tool_at_[t], state.tool[t]) / tick);
    tool_at_[t] = state.tool[t];
  }
}

/// Skin that slips off a tool is many times as fast as any tool; where other things move it, nothing is told from that.
void ResolutionWatch::addJerks(const Model& model, const State& state, const PressList& presses, StepReport& report) {
  constexpr double times_as_fast = 3, of_sound = 0.02;   // of the speed of shear waves
  constexpr double smoothing = 0.02, longest_off = 0.1;  // s
  const double tick = 1 / model.scene.dynamics.rate_hz;
  for (std::size_t t = 0; t < jerks_.size(); ++t) {
    Jerks& now = jerks_[t];
    const bool presses_now = report.loads[t].force.squaredNorm() > 0 || report.loads[t].pinch > 0;
    now.off = presses_now ? 0 : now.off + tick;
    if (now.off > longest_off) now = {};
    now.force += tick / (smoothing + tick) * (report.loads[t].force - now.force);
  }
  settling_ -= tick;
  const auto moves = [](const auto& motion) { return motion.moves(); };
  const auto& motions = model.essential.motions;
  if (model.rigid.moves() || state.live.loads.any() || std::any_of(motions.begin(), motions.end(), moves)) return;
  for (std::size_t k = 0; k < presses.count; ++k) {
    const Press& press = presses.press[k];
    if (press.node < 0 || !press.isTool()) continue;
    const std::size_t tool = press.tool();
    const auto at = static_cast<std::size_t>(press.node);
    const Material& material = state.live.kernel.materials[static_cast<std::size_t>(material_[at])];
    const double speed = toVec3(state.du[at]).norm() / model.dt,
                 sound = std::sqrt(material.shear_modulus / material.density);
    Jerks& now = jerks_[tool];
    if (speed > times_as_fast * quickest_ + of_sound * sound && settling_ <= 0)
      now.jump = std::max(now.jump, (report.loads[tool].force - now.force).norm());
    const double error = std::min(now.jump / press.force, 2.0);
    ToolLoad& load = report.loads[tool];
    if (error > load.expected_error) load.expected_error = error, load.error_force = press.force;
    if (error > report.expected_error)
      report.expected_error = error, report.error_force = press.force, report.error_by = press.by;
  }
}

void ResolutionWatch::gather(const Model& model, std::size_t begin, std::size_t end) {
  const ShapeTable& shape = model.point_shape;
  const PointGroups& groups = model.point_groups;
  const auto& weight = moment_.weights(groups);
  for (std::size_t q = begin; q < end; ++q) {
    Rows s{};
    for (auto e = static_cast<std::size_t>(shape.begin[q]); e < static_cast<std::size_t>(shape.begin[q + 1]); ++e) {
      const Float4& a = u_[static_cast<std::size_t>(shape.node[e])];
      const float gx = static_cast<float>(shape.gradN[e].x()), gy = static_cast<float>(shape.gradN[e].y()),
                  gz = static_cast<float>(shape.gradN[e].z());
      s[0] += a.x * gx, s[1] += a.x * gy, s[2] += a.x * gz;
      s[3] += a.y * gx, s[4] += a.y * gy, s[5] += a.y * gz;
      s[6] += a.z * gx, s[7] += a.z * gy, s[8] += a.z * gz;
    }
    // The invariants of F - 1 instead of a determinant near 1, of which float would leave little.
    const float yz = s[4] * s[8] - s[5] * s[7];
    s[9] = s[0] + s[4] + s[8] + s[0] * s[4] - s[1] * s[3] + s[0] * s[8] - s[2] * s[6] + yz + s[0] * yz -
           s[1] * (s[3] * s[8] - s[5] * s[6]) + s[2] * (s[3] * s[7] - s[4] * s[6]);
    at_[q] = s;
    for (std::size_t n = 0; n < 4; ++n) {
      Rows& fit = fit_[static_cast<std::size_t>(groups.of_point[q][n])];
      for (std::size_t k = 0; k < s.size(); ++k) fit[k] += weight[q][n] * s[k];
    }
  }
}

void ResolutionWatch::compare(const Model& model, std::span<const Material> materials, std::size_t begin,
                              std::size_t end) {
  const auto strainOf = [](const Rows& rows) {
    using Map = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>;
    return Strain{Map(rows.data()).cast<double>(), static_cast<double>(rows[9])};
  };
  for (std::size_t q = begin; q < end; ++q) {
    std::array<Strain, 4> at_nodes;
    for (std::size_t k = 0; k < 4; ++k)
      at_nodes[k] = strainOf(fit_[static_cast<std::size_t>(model.point_groups.of_point[q][k])]);
    moment_.add(model, q, materials[static_cast<std::size_t>(model.point_material[q])], strainOf(at_[q]), at_nodes);
  }
}

void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust) {
  const PressList presses = pressesOf(model, state, report);
  // What each of several has of the strain, or a tool beside something else, the watch knows better.
  if (report.error_force > 0 && (presses.count > 1 || (presses.count > 0 && strainedBeside(model, state.live.loads)))) {
    trust.add(doubtOfError(report.expected_error), report, time);
    return;
  }
  const bool at_rest = !(report.strain_energy > model.rest_energy);
  double error = at_rest ? 0
                         : expectedError(model, state.live.kernel.materials, inDouble(state.u), report.strain_energy,
                                         presses, {state.tool.begin(), state.tool.end()});
  if (!std::isfinite(error)) return;
  const bool touches = presses.count > 0;
  error = std::hypot(error, rimShare<float>(model, state.contact, {state.tool.begin(), state.tool.end()},
                                            state.u.data(), report.loads));
  double force = touches ? 0 : largestForce(report);
  for (std::size_t k = 0; k < presses.count; ++k) force = std::max(force, presses.press[k].force);
  trust.add(doubtOfError(error), error, force, time, touches ? presses.press[0].by : -1);
}

namespace {

/// m, between the nodes about that nearest to a place.
double spacingNear(const Body& body, const Vec3& place) {
  double least = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < body.X.size(); ++i)
    if (const double d = (body.X[i] - place).squaredNorm(); d < least) {
      least = d;
      nearest = i;
    }
  return body.support_radius[nearest] / body.scene.discretization.support_factor;
}

}  // namespace

double spacingAtTool(const Body& body, std::size_t tool) {
  const ToolSetUp& set_up = body.tools.tool[tool];
  return spacingNear(
      body, set_up.start.pose.position - set_up.first_contact_travel * (set_up.start.pose.orientation * Vec3::UnitZ()));
}

std::string layerWarning(const Body& body) {
  if (body.thin_layer < 0) return {};
  const auto number = static_cast<std::size_t>(body.thin_layer);
  const MaterialSpec& layer = body.scene.materials[number];
  if (layer.membership)
    return layer.place.text() +
           format(
               ": borders of the membership's image run through cells, which have the mean of both tissues there: too "
               "stiff where one lies upon the other; forces may be off by %.0f %%. Finer nodes (refine, or spacing), "
               "or a region for what is layered, would do",
               100 * body.layer_error);
  return placeOf(body.scene, "discretization").text() +
         format(
             ": material %zu%s is a layer thinner than the nodes are apart, and the cells see little of it: forces "
             "may be off by %.2g %%. Nodes no further apart than it is thick (refine, or spacing) would do; leave "
             "it out where it does not matter",
             number + 1, layer.name.empty() ? "" : (" (\"" + layer.name + "\")").c_str(), 100 * body.layer_error);
}

std::string resolutionWarning(const Model& body) {
  double worst = coarsest_nodes, spacing = 0, radius = 0;
  const auto meets = [&](double h, double r) {
    if (h > worst * r) worst = h / r, spacing = h, radius = r;
  };
  for (std::size_t t = 0; t < body.tools.tool.size(); ++t)
    if (body.tools.tool[t].first_contact_travel > 0)
      meets(spacingAtTool(body, t), touchRadius(body.scene.tools[t].shape));
  for (const RigidBody& rigid : body.rigid.body)
    if (rigid.shape.radius > 0 && !rigid.encloses) meets(spacingNear(body, rigid.shape.middle()), rigid.shape.radius);
  if (radius == 0) return {};
  return placeOf(body.scene, "discretization.spacing").text() +
         format(
             ": where a tool or a rigid body meets the organ the nodes are %.3g mm apart, which is coarse for what "
             "touches as "
             "a ball of %.3g mm radius does: it will feel the tissue too stiff, by more the lighter it touches. A "
             "spacing of %.2g mm there (spacing, with follow = true near the tool alone, or refine) would do; `mtled "
             "fit` finds the best cloud for a rate, "
             "`mtled certify` says how exact this one is",
             1e3 * spacing, 1e3 * radius, 1e3 * coarsest_nodes * radius);
}

}  // namespace palpate

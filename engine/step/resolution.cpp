#include "step/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mechanics/materials/fibre_energy.h"
#include "scene/scene_messages.h"
#include "step/tool_contact.h"

namespace palpate {
namespace {

constexpr double c_uneven = 0.86, c_held = 0.24, c_missed = 0.72, c_both = 3;  // c_0 .. c_3 of moved faces
// What turns fibres strains them by its square: what they store, c_4, grows faster than the whole.
constexpr double c_missed_fibres = 1.8;
constexpr double c_pressed = 0.12, c_pressed_held = 0.08, c_pressed_missed = 0.2;  // of what is pressed
constexpr double c_flat = 2.2;                                                     // by a flat end
// Of Model::rest_energy, which is far above float's noise: in double strains of 3e-6 are none, either.
constexpr double least_energy = 1e-6;
// Of a tick: at the liver's 20,124 points a hundredth of its time.
constexpr std::size_t points_a_tick = 64, most_ticks = 400;
// So many times faster until there is an estimate, and while the energy is another than a sweep's by a fifth.
constexpr std::size_t faster = 5;
constexpr double changed = 0.2;
constexpr double touched_energy = 1e-2;  // of Model::rest_energy, from which on a touch is looked at

constexpr double narrowest = 0.64, most_narrow = 2;  // touches, of the nodes' distance; the error that is said of them

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

/// What a ball's force stores in a half-space, J: 2/5 F d, F = 16/3 mu sqrt(R) d^(3/2) (Hertz); no more than there is.
double touchEnergy(const Model& model, double force, double strain_energy) {
  const double stiffness = 16.0 / 3 * model.materials[0].shear_modulus * std::sqrt(smallestToolRadius(model.scene));
  return std::min(strain_energy, 0.4 * force * std::pow(force / stiffness, 2.0 / 3));
}

/// What is not seen of a touch at a node, of this material, that is narrower than the nodes are apart.
double narrowError(const Model& model, const Material& m, std::size_t node, const ToolShape& tool, double force) {
  const double h = model.support_radius[node] / model.scene.discretization.support_factor, K = m.bulk_modulus,
               G = m.shear_modulus, nu = (3 * K - 2 * G) / (6 * K + 2 * G), E = 2 * G / (1 - nu);
  const ToolProfile profile = toolProfile(tool);
  const double sine = profile.corner_count > 1 ? std::clamp(-profile.side_normal[0].z, 0.0, 0.999) : 0.0,
               slope = sine / std::sqrt(1 - sine * sine);
  const double square =
                   std::max(1.25 * force * profile.rounding / (E * h * h * h), 2 * force * slope / (M_PI * E * h * h)),
               touched = std::min(std::sqrt(square), tool.radius / h);
  return std::clamp(narrowest / touched - 1, 0.0, most_narrow);
}

/// Of a point of a cell that each node has (node_count).
std::vector<int> nodeMaterials(const Model& model) {
  std::vector<int> material(model.X.size(), 0);
  for (std::size_t q = 0; q < model.point_material.size(); ++q)
    for (const int i : model.cells[static_cast<std::size_t>(model.point_cell[q])])
      material[static_cast<std::size_t>(i)] = model.point_material[q];
  return material;
}

/// The node that moves the skin most where a tool presses it hardest; -1: it touches nothing.
int touchedNode(const Model& model, const State& state, std::size_t tool) {
  int vertex = -1;
  double most = 0;
  for (std::size_t b = 0; b < model.tools.body.size(); ++b)
    if (model.tools.body[b].tool == static_cast<int>(tool))
      forEachContactForce(state.contact[b], [&](int v, const Float4& force) {
        if (const double size = toVec3(force).norm(); size > most) most = size, vertex = v;
      });
  if (vertex < 0) return -1;
  const auto first = model.skin.N.begin() + model.skin.begin[vertex],
             last = model.skin.N.begin() + model.skin.begin[vertex + 1];
  return model.skin.node[static_cast<std::size_t>(std::max_element(first, last) - model.skin.N.begin())];
}

/// The node next to a tool's tip, of a solution that is over.
std::size_t nodeAt(const Model& model, const AlignedVector<Double4>& u, const Vec3& tip) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < model.X.size(); ++i)
    if (const double d = (model.X[i] + toVec3(u[i]) - tip).squaredNorm(); d < least) least = d, nearest = i;
  return nearest;
}

/// The tool that presses hardest.
std::size_t hardest(const StepReport& report) {
  std::size_t most = 0;
  for (std::size_t t = 1; t < report.loads.size(); ++t)
    if (report.loads[t].force.norm() > report.loads[most].force.norm()) most = t;
  return most;
}

/// Forces are a tool's, or from loads, not from faces that are moved.
ErrorSums sumsOf(const Model& model, double tool_force) {
  if (!(tool_force > 0)) return {model.surface_loads.empty() ? 0.0 : 1.0};
  const ToolShape& tool = model.scene.tools[0].shape;
  const bool flat = tipProfile(tool, tool.radius / 2) < 1e-3 * tool.radius;
  return {flat ? c_flat : 1.0};
}

/// mu |D|^2 of a deviation D from F, and half of what fibres along n, which are under tension where |F n| > 1, add to
/// the modulus there times (n . D n)^2; Pa.
double pressedEnergy(const Material& m, const Mat3& F, const Mat3& D) {
  const double shear = m.shear_modulus * D.squaredNorm();
  if (m.fibre_modulus == 0) return shear;
  const Vec3 n(m.fibre[0], m.fibre[1], m.fibre[2]), stretched = F * n;
  if (stretched.squaredNorm() <= 1) return shear;
  const double along = stretched.dot(D * n);
  return shear + m.fibre_modulus / 2 * along * along;
}

/// What a deviation D from the deformation F of a point stores at its volume: (W(F + D) + W(F - D)) / 2 - W(F), to
/// second order of W = mu/2 J^(-2/3) |F|^2, whatever the law, and all of what its fibres store.
class DeviationEnergy {
 public:
  DeviationEnergy(const Material& m, const Mat3& F, double J) : material_(m), F_(F), square_(F.squaredNorm()) {
    constexpr double least_J = 0.1;
    J = std::max(J, least_J);
    inverse_ << F.row(1).cross(F.row(2)).transpose(), F.row(2).cross(F.row(0)).transpose(),
        F.row(0).cross(F.row(1)).transpose();
    inverse_ /= J;
    stiffness_ = m.shear_modulus / std::cbrt(J * J);
    fibre_ = fibreEnergy(m, (F_ * fibre()).squaredNorm());
  }

  struct Parts {
    double shape, fibres;
  };

  /// Pa
  Parts of(const Mat3& D) const {
    const Mat3 d = D * inverse_;
    const double trace = d.trace();
    const double shape = stiffness_ * (D.squaredNorm() / 2 - 2.0 / 3 * trace * F_.cwiseProduct(D).sum() +
                                       square_ * (trace * trace / 9 + d.cwiseProduct(d.transpose()).sum() / 6));
    if (material_.fibre_modulus == 0) return {std::max(0.0, shape), 0};
    const Vec3 Fn = F_ * fibre(), Dn = D * fibre();
    const double there =
        fibreEnergy(material_, (Fn + Dn).squaredNorm()) + fibreEnergy(material_, (Fn - Dn).squaredNorm());
    return {std::max(0.0, shape), std::max(0.0, there / 2 - fibre_)};
  }

 private:
  Vec3 fibre() const { return {material_.fibre[0], material_.fibre[1], material_.fibre[2]}; }

  const Material& material_;
  Mat3 F_, inverse_;
  double square_, stiffness_, fibre_;
};

}  // namespace

void ErrorSums::add(const Model& model, std::size_t q, const Material& material, const Strain& strain,
                    const std::array<Strain, 4>& at_nodes) {
  const Mat3 F = Mat3::Identity() + strain.H;
  const double V = model.point_volume[q], unseen = static_cast<double>(model.point_groups.unseen[q]);
  Strain mean;
  for (const Strain& s : at_nodes) mean.add(0.25, s);
  if (pressed > 0) {
    uneven += V * pressedEnergy(material, F, strain.H - mean.H);
    held += V * material.bulk_modulus * std::pow(strain.dilatation - mean.dilatation, 2);
    for (const Strain& s : at_nodes) missed += V * PointGroups::of_cell * pressedEnergy(material, F, s.H - mean.H);
    return;
  }
  const DeviationEnergy energy(material, F, 1 + strain.dilatation);
  const std::array<float, 4>& position = model.point_groups.position[q];
  Strain here;
  for (std::size_t k = 0; k < 4; ++k) here.add(static_cast<double>(position[k]), at_nodes[k]);
  const DeviationEnergy::Parts off = energy.of(strain.H - here.H);
  uneven += V * (off.shape + off.fibres);
  for (const Strain& s : at_nodes) {
    held += V * std::max(unseen, PointGroups::of_cell) * material.bulk_modulus *
            std::pow(s.dilatation - mean.dilatation, 2);
    const DeviationEnergy::Parts part = energy.of(s.H - mean.H);
    missed += V * unseen * part.shape;
    missed_fibres += V * unseen * part.fibres;
  }
}

double ErrorSums::off(double energy) const {
  if (pressed > 0) return pressed * (c_pressed * uneven + c_pressed_held * held + c_pressed_missed * missed);
  const double stiff = c_uneven * uneven + c_held * held, soft = c_missed * missed + c_missed_fibres * missed_fibres,
               sum = stiff + soft;
  return std::hypot(stiff - soft, c_both * sum * sum / energy);
}

double expectedError(const Model& model, std::span<const Material> materials, const AlignedVector<Double4>& u,
                     double strain_energy, double tool_force, const Pose* tool) {
  if (!(strain_energy > least_energy * model.rest_energy)) return 0;
  const ShapeTable& shape = model.point_shape;
  const PointGroups& groups = model.point_groups;
  ErrorSums sums = sumsOf(model, tool_force);
  const auto& weight = sums.pressed > 0 ? groups.share : groups.weight;
  std::vector<Strain> at(model.point_X.size()), fit(static_cast<std::size_t>(groups.count));
  for (std::size_t q = 0; q < at.size(); ++q) {
    for (auto e = static_cast<std::size_t>(shape.begin[q]); e < static_cast<std::size_t>(shape.begin[q + 1]); ++e)
      at[q].H += toVec3(u[static_cast<std::size_t>(shape.node[e])]) * shape.gradN[e].transpose();
    at[q].dilatation = (Mat3::Identity() + at[q].H).determinant() - 1;
    for (std::size_t k = 0; k < 4; ++k)
      fit[static_cast<std::size_t>(groups.of_point[q][k])].add(static_cast<double>(weight[q][k]), at[q]);
  }
  for (std::size_t q = 0; q < at.size(); ++q) {
    std::array<Strain, 4> at_nodes;
    for (std::size_t k = 0; k < 4; ++k) at_nodes[k] = fit[static_cast<std::size_t>(groups.of_point[q][k])];
    sums.add(model, q, materials[static_cast<std::size_t>(model.point_material[q])], at[q], at_nodes);
  }
  const double energy =
      model.surface_loads.empty() || !(tool_force > 0) ? strain_energy : touchEnergy(model, tool_force, strain_energy);
  const double error = sums.off(strain_energy) / energy;
  double narrow = 0;
  if (tool != nullptr && tool_force > 0) {
    const std::size_t node = nodeAt(model, u, tool->position);
    const Material& material = materials[static_cast<std::size_t>(nodeMaterials(model)[node])];
    narrow = narrowError(model, material, node, model.scene.tools[0].shape, tool_force);
  }
  return std::max({model.layer_error, narrow, energy < strain_energy ? std::min(1.0, error) : error});
}

ResolutionWatch::ResolutionWatch(const Model& model)
    : u_(model.X.size()),
      at_(model.point_X.size()),
      fit_(static_cast<std::size_t>(model.point_groups.count)),
      material_(nodeMaterials(model)) {}

void ResolutionWatch::restart() {
  next_ = 0;
  is_new_ = true;
  error_ = error_force_ = inertia_share_ = 0;
}

void ResolutionWatch::goOnFrom(const ResolutionWatch& before) {
  restart();
  load_error_ = before.load_error_;
  error_ = before.error_;
  error_force_ = before.error_force_;
}

void ResolutionWatch::advance(const Model& model, const State& state, StepReport& report) {
  const std::span<const Material> materials = state.live.kernel.materials;
  const AlignedVector<Float4>& u = state.u;
  const bool old = !(error_force_ > 0) || std::abs(report.strain_energy - energy_) > changed * energy_;
  const std::size_t count = at_.size(), part = std::max(points_a_tick, count / most_ticks + 1) * (old ? faster : 1);
  if (next_ == 0) {
    const double least = (toolForce(report) > 0 ? touched_energy : 1) * model.rest_energy;
    if (!(report.strain_energy > least)) {  // nothing to look at
      restart();
      report.expected_error = toolForce(report) > 0 ? 1 : 0;
      return;
    }
    std::copy(u.begin(), u.end(), u_.begin());
    std::fill(fit_.begin(), fit_.end(), Rows{});
    sums_ = sumsOf(model, toolForce(report));
    energy_ = report.strain_energy;
    touch_ = model.surface_loads.empty() ? 0 : toolForce(report);
    const std::size_t tool = hardest(report);
    const double force = report.loads[tool].force.norm();
    narrow_ = 0;
    if (const int node = touchedNode(model, state, tool); node >= 0 && force > 0)
      narrow_ = narrowError(model, materials[static_cast<std::size_t>(material_[static_cast<std::size_t>(node)])],
                            static_cast<std::size_t>(node), model.scene.tools[tool].shape, force);
    force_ = touch_ > 0 ? touch_ : narrow_ > 0 ? force : largestForce(report);
  }
  if (next_ < count) {
    const std::size_t end = std::min(next_ + part, count);
    gather(model, next_, end);
    next_ = end;
  } else {
    const std::size_t begin = next_ - count, end = std::min(begin + 4 * part, count);  // each a quarter of the work
    compare(model, materials, begin, end);
    next_ = count + end;
  }
  if (next_ == 2 * count) {
    next_ = 0;
    const double sum = sums_.off(energy_);
    error_ = sum / energy_;
    if (touch_ > 0) {
      const double touch = touchEnergy(model, touch_, energy_);
      error_ = std::clamp((sum - load_error_ * (energy_ - touch)) / touch, 0.0, 1.0);
    } else if (!(toolForce(report) > 0)) {  // nor was it a moment off a tool that hits
      load_error_ = error_;
    }
    error_ = std::max(error_, narrow_);
    error_force_ = force_;
  }
  report.expected_error = error_force_ > 0 ? std::max(error_, model.layer_error) : 1;
  report.error_force = error_force_;
  addScaledInertia(model, report);
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
  const double force = std::max(largestForce(report), report.error_force);
  if (!(force > 0)) return;
  inertia_share_ = std::max(change.norm() / smoothing / force, inertia_share_ * (1 - tick / kept));
  if (!(report.error_force > 0)) return;
  // The error was found for another moment's force than what accelerates now: in N both count as they are.
  const double error = std::hypot(report.expected_error, inertia_share_),
               newtons = std::hypot(report.expected_error * report.error_force, inertia_share_ * force);
  if (error > 0) report.error_force = newtons / error;
  report.expected_error = std::min(std::max(1.0, report.expected_error), error);
}

void ResolutionWatch::gather(const Model& model, std::size_t begin, std::size_t end) {
  const ShapeTable& shape = model.point_shape;
  const PointGroups& groups = model.point_groups;
  const auto& weight = sums_.pressed > 0 ? groups.share : groups.weight;
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
    sums_.add(model, q, materials[static_cast<std::size_t>(model.point_material[q])], strainOf(at_[q]), at_nodes);
  }
}

void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust) {
  AlignedVector<Double4> u;
  for (const Float4& a : state.u) u.push_back({a.x, a.y, a.z, 0});
  const bool at_rest = !(report.strain_energy > model.rest_energy);
  // A tool's share beside surface loads' only the watch knows.
  const double tool = toolForce(report), touch = model.surface_loads.empty() ? 0 : tool;
  const bool watched = touch > 0 && report.expected_error > 0;
  const double error =
      at_rest   ? 0
      : watched ? report.expected_error
                : expectedError(model, state.live.kernel.materials, u, report.strain_energy, tool, &state.tool[0].pose);
  if (!std::isfinite(error)) return;
  trust.add(error > TrustLimits::expected_error ? Doubt::Resolution : Doubt::None, error,
            touch > 0 ? touch : largestForce(report), time);
}

double spacingAtTool(const Body& body) {
  const Vec3 touched =
      body.tools.first().start.pose.position -
      body.tools.first().first_contact_travel * (body.tools.first().start.pose.orientation * Vec3::UnitZ());
  double least = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < body.X.size(); ++i)
    if (const double d = (body.X[i] - touched).squaredNorm(); d < least) {
      least = d;
      nearest = i;
    }
  return body.support_radius[nearest] / body.scene.discretization.support_factor;
}

std::string layerWarning(const Body& body) {
  if (body.thin_layer < 0) return {};
  const auto number = static_cast<std::size_t>(body.thin_layer);
  const MaterialSpec& layer = body.scene.materials[number];
  return placeOf(body.scene, "discretization").text() +
         format(
             ": material %zu%s is a layer thinner than the nodes are apart, and the cells see little of it: forces "
             "may be off by %.2g %%. Nodes no further apart than it is thick (refine, or spacing) would do; leave "
             "it out where it does not matter",
             number + 1, layer.name.empty() ? "" : (" (\"" + layer.name + "\")").c_str(), 100 * body.layer_error);
}

std::string resolutionWarning(const Body& body) {
  const double spacing = spacingAtTool(body), radius = touchRadius(body.scene.tools[0].shape);
  if (body.tools.first().first_contact_travel <= 0 || spacing <= coarsest_nodes * radius) return {};
  return placeOf(body.scene, "discretization.spacing").text() +
         format(
             ": where the tool meets the organ the nodes are %.3g mm apart, which is coarse for a tip that touches as "
             "a ball of %.3g mm radius does: it will feel the tissue too stiff, by more the lighter it touches. A "
             "spacing of %.2g mm there (spacing, or refine) would do; `mtled fit` finds the best cloud for a rate, "
             "`mtled certify` says how exact this one is",
             1e3 * spacing, 1e3 * radius, 1e3 * coarsest_nodes * radius);
}

}  // namespace palpate

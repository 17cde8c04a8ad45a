#include "batch/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/float4.h"
#include "base/nearest_word.h"
#include "base/number_text.h"
#include "discretization/surface/surface_tree.h"
#include "mechanics/critical_time_step.h"
#include "mechanics/materials/material_law.h"
#include "scene/scene_messages.h"
#include "setup/mixtures.h"
#include "step/resolution.h"
#include "step/rim_force.h"

namespace palpate {
namespace {

using NodeField = AlignedVector<Double4>;

/// Of the body's size, of differences of forces: rounding 2e-10, curvature 1e-11. A tenfold reach passes kinks of the
/// pressure's bounds, which took 0.5 % from a derivative by Poisson's ratio.
constexpr double difference_reach = 1e-7;
/// Of the tool's radius: vertices that are no nearer take no part in a solution.
constexpr double contact_reach = 0.5;

double dotOf(const NodeField& a, const NodeField& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].x * b[i].x + a[i].y * b[i].y + a[i].z * b[i].z;
  return sum;
}

void addTo(NodeField& a, double share, const NodeField& b) {
  for (std::size_t i = 0; i < a.size(); ++i) store(a[i], load(a[i]) + share * load(b[i]));
}

double largestOf(const NodeField& a) {
  double largest = 0;
  for (const Double4& v : a) largest = std::max(largest, toVec3(v).squaredNorm());
  return std::sqrt(largest);
}

void checkScene(const Model& model) {
  const Scene& scene = model.scene;
  const char* const problem =
      model.tools.several() ? "equilibria with sensitivities are those of one tool without jaws, and the scene has more"
      : scene.tools[0].friction != 0
          ? "equilibria with sensitivities are those of a tool without friction: with it, forces depend on the way"
      : model.bodies.several()
          ? "equilibria with sensitivities are those of one body, and the scene has several, which touch"
      : !model.rigid.empty()
          ? "equilibria with sensitivities are those of a body without rigid ones, whose contact comes and goes"
      : !scene.loads.empty() ? "equilibria with sensitivities are those of a body without loads on its skin"
      : scene.discretization.boundary_method == DiscretizationSpec::BoundaryMethod::Ebciem
          ? "equilibria with sensitivities are those of the symmetric boundary method"
          : nullptr;
  if (problem == nullptr) return;
  throw InputError(scene.place, problem,
                   model.tools.several()          ? "leave the others, or the jaws, out"
                   : scene.tools[0].friction != 0 ? "set tool.friction to 0"
                   : scene.discretization.boundary_method == DiscretizationSpec::BoundaryMethod::Ebciem
                       ? "set discretization.boundary_method to \"sebciem\""
                       : "leave them out");
}

/// Throws InputError where a scene has no such number.
const Parameter& parameterOf(const Scene& scene, const std::vector<Material>& materials, const MaterialNumber& number) {
  if (number.material < 0 || number.material >= static_cast<int>(materials.size()))
    throw InputError(scene.place, "there is no material " + std::to_string(number.material),
                     "the first has the number 0");
  const Material& material = materials[static_cast<std::size_t>(number.material)];
  std::vector<std::string> names;
  for (const Parameter& parameter : material.lawDescription().parameters) {
    names.emplace_back(parameter.name);
    if (number.name != parameter.name) continue;
    const auto count = static_cast<int>(material.get(number.name).size());
    if (number.entry >= 0 && number.entry < count) return parameter;
    throw InputError(scene.place, inQuotes(number.name) + " has no entry " + std::to_string(number.entry),
                     "the first has the number 0");
  }
  throw InputError(scene.place,
                   std::string(material.lawDescription().title) + " has no parameter " + inQuotes(number.name),
                   "there is " + listed(names, "and"));
}

}  // namespace

EquilibriumSensitivity::EquilibriumSensitivity(const Model& model, int threads, Watch watch, double accuracy)
    : model_((checkScene(model), model)),
      watch_(std::move(watch)),
      accuracy_(accuracy),
      scene_(model.scene),
      threads_(threads),
      mass_(
          gershgorinRows(model.point_shape, model.point_volume, model.point_material, model.materials, model.X.size())),
      body_(model, mass_, threads),
      profile_(toolProfile(model.scene.tools[0].shape)),
      size_(boxOf(model.X).diagonal().norm()),
      u_(model.X.size()),
      probe_(model.X.size()),
      f_plus_(model.X.size()),
      f_minus_(model.X.size()) {
  for (const MaterialSpec& material : scene_.materials) of_scene_.push_back(material.material);
}

std::vector<Material> EquilibriumSensitivity::modelMaterials() {
  for (std::size_t m = 0; m < of_scene_.size(); ++m) scene_.materials[m].material = of_scene_[m];
  return materialsOf(scene_);
}

void EquilibriumSensitivity::setMaterials(const std::vector<Material>& of_scene) {
  of_scene_ = of_scene;
  body_.setMaterials(modelMaterials());
}

Vec3 EquilibriumSensitivity::placeOf(const ContactPoint& point, const Field& u) const {
  const SkinModel& skin = model_.skin;
  Vec3 x = skin.surface.vertices[static_cast<std::size_t>(point.vertex)];
  for (int e = skin.begin[point.vertex]; e < skin.begin[point.vertex + 1]; ++e)
    x += static_cast<double>(skin.N[e]) * toVec3(u[skin.node[e]]);
  return x;
}

/// On the tissue, N, where the point is active.
Vec3 EquilibriumSensitivity::contactForce(const ContactPoint& point, const Vec3& x) const {
  const ToolDistance d = toolDistance(profile_, tool_->toLocal(x));
  const double depth = std::min(-d.distance, most_depths * model_.skin.layer_depth);
  return point.stiffness * depth * (tool_->orientation * d.normal);
}

/// The vertices near the tool, and which of them it touches.
void EquilibriumSensitivity::findContact() {
  contact_.clear();
  if (!tool_) return;
  for (int v = 0; v < model_.skin.vertexCount(); ++v) {
    ContactPoint point{v,
                       body_.layerShare(v) * static_cast<double>(model_.skin.layer[static_cast<std::size_t>(v)]) *
                           model_.skin.area[static_cast<std::size_t>(v)],
                       true};
    const double distance = toolDistance(profile_, tool_->toLocal(placeOf(point, u_))).distance;
    point.active = distance < 0;
    if (distance < contact_reach * model_.scene.tools[0].shape.radius) contact_.push_back(point);
  }
}

/// f = -F + f_c + w, N, with the points that are active.
void EquilibriumSensitivity::unbalanced(const Field& u, Field& f) {
  body_.forces(u, f);
  for (std::size_t i = 0; i < model_.weight.size(); ++i) store(f[i], load(f[i]) + load(model_.weight[i]));
  const SkinModel& skin = model_.skin;
  for (const ContactPoint& point : contact_) {
    if (!point.active) continue;
    const auto force = load(toReal4<double>(contactForce(point, placeOf(point, u))));
    for (int e = skin.begin[point.vertex]; e < skin.begin[point.vertex + 1]; ++e)
      store(f[skin.node[e]], load(f[skin.node[e]]) + static_cast<double>(skin.N[e]) * force);
  }
}

void EquilibriumSensitivity::multiply(const Field& v, Field& Kv, Difference difference) {
  if (watch_ && !watch_()) throw std::runtime_error("interrupted");
  const double scale = difference_reach * size_ / largestOf(v);
  const auto forcesAt = [&](double share, Field& f) {
    for (std::size_t i = 0; i < v.size(); ++i) store(probe_[i], load(u_[i]) + share * load(v[i]));
    unbalanced(probe_, f);
  };
  const bool central = difference == Difference::Central;
  forcesAt(scale, f_plus_);
  if (central) forcesAt(-scale, f_minus_);
  for (std::size_t i = 0; i < v.size(); ++i)
    store(Kv[i], ((central ? 0.5 : 1.0) / scale) * (load(f_minus_[i]) - load(f_plus_[i])));
}

/// g = P M^-1 r, which moves no imposed node, and r = M g, without what these nodes bear. In place of r, which holds it
/// only to the rounding of what they bear, the products r . g are those of the rest.
/// @return r . g
double EquilibriumSensitivity::precondition(Field& r, Field& g) {
  for (std::size_t i = 0; i < r.size(); ++i) store(g[i], body_.inverseMass()[i] * load(r[i]));
  body_.project(g);
  for (std::size_t i = 0; i < r.size(); ++i) store(r[i], mass_[i] * load(g[i]));
  return dotOf(r, g);
}

/// x += K^-1 r on what is not imposed, until the residual is a share of r. K may be somewhat unsymmetric: directions
/// are those of flexible conjugate gradients (Notay, SIAM J. Sci. Comput. 22, 1444 (2000)), each conjugate to the last
/// one only; with a symmetric K they are the usual ones.
/// @param difference  Forward: for a step of Newton's, which is tried. Central: throws std::runtime_error where K is
///                    not positive or the tolerance is not met
void EquilibriumSensitivity::solve(Field r, Field& x, double tolerance, Difference difference) {
  constexpr int max_iterations = 20000;
  ++solution_count_;
  const bool careful = difference == Difference::Central;
  if (!careful) unbalanced(u_, f_minus_);
  Field g(r.size()), p, Kp(r.size()), before(r.size());
  precondition(r, g);
  double rg = precondition(r, g);  // of what the first one's rounding left
  const double begin = rg;
  double least = rg;
  int since_least = 0;
  p = g;
  for (int k = 0; k < max_iterations && rg > tolerance * tolerance * begin; ++k) {
    multiply(p, Kp, difference);
    const double curvature = dotOf(p, Kp);
    if (!(curvature > 0)) {
      if (careful || !std::isfinite(curvature))
        throw std::runtime_error("the equilibrium is not stable: the body would leave it");
      if (k == 0) addTo(x, 1, p);
      break;
    }
    const double step = rg / curvature;
    before = r;
    addTo(x, step, p);
    addTo(r, -step, Kp);
    const double next = precondition(r, g), turn = std::max(0.0, (next - dotOf(g, before)) / rg);
    for (std::size_t i = 0; i < p.size(); ++i) store(p[i], load(g[i]) + turn * load(p[i]));
    rg = next;
    constexpr int patience = 500;  // iterations that bring nothing: rounding
    if (rg < 0.5 * least)
      least = rg, since_least = 0;
    else if (++since_least > patience)
      break;
  }
  const double share = begin > 0 ? std::sqrt(std::max(0.0, rg) / begin) : 0;
  constexpr double good_enough = 1e-6;
  if (careful && share > std::max(tolerance, good_enough))
    throw std::runtime_error("the linear system of a sensitivity was not solved: its residual stays at " +
                             shortest(share));
}

/// Newton's method from u_, whose imposed nodes are where they should be.
void EquilibriumSensitivity::polish() {
  constexpr int max_steps = 30;
  Field f(u_.size()), g(u_.size()), step(u_.size()), tried_f(u_.size());
  const auto residualOf = [&](Field& force) {
    precondition(force, g);
    return precondition(force, g);
  };
  findContact();
  unbalanced(u_, f);
  double now = residualOf(f), tolerance = 1e-3;  // of the next step
  for (int k = 0; k < max_steps; ++k) {
    std::fill(step.begin(), step.end(), Double4{});
    solve(f, step, tolerance, Difference::Forward);
    const double size = largestOf(step), scale = std::max(largestOf(u_), 1e-3 * size_);
    if (!std::isfinite(size)) break;
    if (size <= accuracy_ * scale) return;
    const Field before = u_;
    double share = std::min(1.0, 0.1 * size_ / size), next = 0;
    constexpr double least_share = 1e-3;
    for (; share > least_share; share *= 0.5) {
      u_ = before;
      addTo(u_, share, step);
      findContact();
      unbalanced(u_, tried_f);
      next = residualOf(tried_f);
      if (next < now) break;
      if (size <= 1e-8 * scale) return;  // rounding: no step is better
    }
    if (!(next < now)) break;
    // What is left, as the residual tells; ten times for what the residual does not.
    const double left = 10 * size * std::sqrt(next / now);
    if (left <= accuracy_ * scale) return;
    tolerance = std::clamp(accuracy_ * scale / left, 1e-4, 1e-2);  // forward differences bring no more
    std::swap(f, tried_f);
    now = next;
  }
  throw std::runtime_error("no equilibrium was found: the body does not come to rest there");
}

void EquilibriumSensitivity::settle(const std::optional<Pose>& tool, double time) {
  tool_ = tool;
  StaticSolver solver(model_, threads_, 1e-4);
  solver.setMaterials(modelMaterials());
  const Field rest(u_.size());
  const StaticSolver::Watch watch = [this](int) { return !watch_ || watch_(); };
  Vec3 force = Vec3::Zero();
  const auto follow = [&](double at, const ToolsAt& tools) {
    const Equilibrium equilibrium = solver.advanceTo(at, tools, watch);
    force = equilibrium.tool_force;
    if (equilibrium.interrupted) throw std::runtime_error("interrupted");
    if (equilibrium.diverged)  // where it merely goes on trembling, polish() finds it, or says that there is none
      throw std::runtime_error("no equilibrium was found: the body does not come to rest there");
  };
  if (!tool) {
    solver.resume(0, rest, {});
    follow(time, {});
  } else {
    // From where it does not touch, in steps of a quarter of its radius.
    const double radius = model_.scene.tools[0].shape.radius;
    const Vec3 axis = tool->orientation * Vec3::UnitZ();
    const auto away = [&](int steps) {
      Pose pose = *tool;
      pose.position += 0.25 * radius * steps * axis;
      return pose;
    };
    const SurfaceTree surface(model_.skin.surface);
    const auto touches = [&](const Pose& pose) {
      const auto& vertices = model_.skin.surface.vertices;
      return surface.inside(pose.position) || std::any_of(vertices.begin(), vertices.end(), [&](const Vec3& x) {
               return toolDistance(profile_, pose.toLocal(x)).distance <= 0;
             });
    };
    if (!touches(*tool) && surface.firstHit(tool->position, axis))
      throw std::runtime_error(
          "the tool touches nothing there, and the organ is in its way from outside, along its axis");
    int steps = 0;
    while (touches(away(steps)) && 0.25 * radius * steps < 2 * size_) ++steps;
    solver.resume(0, rest, away(steps));
    if (time > 0) follow(time, away(steps));
    for (; steps > 0; --steps) follow(time, away(steps - 1));
    if (solver.body().tools().posture[0].pose.position != tool->position)
      throw std::runtime_error("the tool can't come there: what holds the organ is rigid, and in its way");
  }
  u_ = solver.body().u;
  polish();
  lacking_ = force.isZero(0) ? 0 : (force - toolForce()).norm() / force.norm();
}

void EquilibriumSensitivity::settleFrom(const AlignedVector<Double4>& u, const std::optional<Pose>& tool,
                                        double lacking) {
  takeFrom(u, tool, lacking);
  polish();
}

void EquilibriumSensitivity::takeFrom(const AlignedVector<Double4>& u, const std::optional<Pose>& tool,
                                      double lacking) {
  lacking_ = lacking;
  tool_ = tool;
  u_ = u;
  findContact();
}

Vec3 EquilibriumSensitivity::toolForce() const {
  Vec3 force = Vec3::Zero();
  for (const ContactPoint& point : contact_)
    if (point.active) force -= contactForce(point, placeOf(point, u_));
  return force;
}

double EquilibriumSensitivity::expectedError() {
  ToolLoads loads;
  loads[0].force = toolForce();
  ToolPosture tip;
  if (tool_) tip.pose = *tool_;
  const double of_cloud = palpate::expectedError(model_, modelMaterials(), u_, body_.forces(u_, f_plus_).strain_energy,
                                                 PressList(loads), {&tip, tool_ ? 1U : 0U});
  const double force = loads[0].force.norm();
  if (!(force > 0)) return lacking_ + of_cloud;
  const Vec3 aside = asideOfRims(profile_, *tool_, [this](auto call) {
    for (const ContactPoint& point : contact_) {
      if (!point.active) continue;
      const Vec3 x = placeOf(point, u_), normal = toolDistance(profile_, tool_->toLocal(x)).normal;
      const double area = model_.skin.area[static_cast<std::size_t>(point.vertex)];
      call(normal, contactForce(point, x).norm(), [&] { return std::pair(x, area); });
    }
  });
  return lacking_ + std::hypot(of_cloud, aside.norm() / force);
}

void EquilibriumSensitivity::check(const MaterialNumber& number) const { parameterOf(scene_, of_scene_, number); }

double EquilibriumSensitivity::valueOf(const EquilibriumQuantity& q) {
  Vec3 value = Vec3::Zero();
  switch (q.kind) {
    case EquilibriumQuantity::Kind::ToolForce:
      value = toolForce();
      break;
    case EquilibriumQuantity::Kind::RegionForce: {
      Field f(u_.size()), g(u_.size());
      unbalanced(u_, f);
      precondition(f, g);  // what is held balances it
      value = body_.reactions()[static_cast<std::size_t>(q.region)].force;
      break;
    }
    case EquilibriumQuantity::Kind::Displacement:
      for (const auto& [node, N] : q.row) value += N * toVec3(u_[static_cast<std::size_t>(node)]);
  }
  return q.direction.dot(value);
}

/// Whether K is: it is not where the patches' share in the cells' pressure changes with the volume of a point, of which
/// forces leave something out (cell_volume.h).
bool EquilibriumSensitivity::isSymmetric() {
  constexpr double rounding = 1e-9;  // on scenes where K is symmetric 1e-12 to 1e-11, else 1e-4 and more
  Field v[2], Kv[2];
  for (const int k : {0, 1}) {
    Field noise(u_.size());
    for (std::size_t i = 0; i < noise.size(); ++i) {
      const auto phase = static_cast<double>(i + 1) * (1 + k);
      noise[i] = {std::sin(phase * phase), std::sin(2 * phase * phase), std::sin(3 * phase * phase), 0};
    }
    v[k].resize(u_.size());
    Kv[k].resize(u_.size());
    precondition(noise, v[k]);
    multiply(v[k], Kv[k], Difference::Central);
  }
  return std::abs(dotOf(v[0], Kv[1]) - dotOf(v[1], Kv[0])) <=
         rounding * std::sqrt(std::abs(dotOf(v[0], Kv[0]) * dotOf(v[1], Kv[1])));
}

/// df/dp, N over the number's unit, where nothing moves.
/// @return the same of the force on the tool
Vec3 EquilibriumSensitivity::differentiateForce(const MaterialNumber& number, Field& slope) {
  const std::vector<Material> before = of_scene_;
  const Parameter& parameter = parameterOf(scene_, before, number);
  Material& material = of_scene_[static_cast<std::size_t>(number.material)];
  const auto present = material.get(number.name);
  std::vector<double> values(present.begin(), present.end());
  double& value = values[static_cast<std::size_t>(number.entry)];
  const double middle = value;
  // Five points, so that even Poisson's ratio near 1/2 has no curvature over them. A hundred times as far they pass
  // kinks, too: 0.7 % of a derivative by Poisson's ratio 0.49 of layer_sphere at 3 mm.
  constexpr double share = 1e-6, share_of_way = 0.05;
  const double way = std::min(middle - parameter.range.low, parameter.range.high - middle);
  const double h = std::min(share * std::abs(middle), share_of_way * way);
  if (!(h > 0))
    throw InputError(scene_.place, inQuotes(number.name) + " is at an end of its range, where it has no derivative",
                     "give it another value, or leave it out");
  std::fill(slope.begin(), slope.end(), Double4{});
  Vec3 on_tool = Vec3::Zero();
  for (const auto& [steps, weight] : {std::pair{-2, 1.0}, {-1, -8.0}, {1, 8.0}, {2, -1.0}}) {
    value = middle + steps * h;
    material.set(number.name, values);
    body_.setMaterials(modelMaterials());
    findContact();
    unbalanced(u_, f_plus_);
    addTo(slope, weight / (12 * h), f_plus_);
    on_tool += weight / (12 * h) * toolForce();
  }
  of_scene_ = before;
  body_.setMaterials(modelMaterials());
  findContact();
  return on_tool;
}

std::vector<double> EquilibriumSensitivity::derivatives(const EquilibriumQuantity& q,
                                                        const std::vector<MaterialNumber>& numbers) {
  using Kind = EquilibriumQuantity::Kind;
  for (const MaterialNumber& number : numbers) check(number);
  if (q.kind == Kind::RegionForce && q.region >= BoundaryShifts::max_count)
    throw InputError(scene_.place, "equilibria with sensitivities are those of the first sixteen regions",
                     "put others before");
  Field lift(u_.size()), r(u_.size()), product(u_.size());  // Phi lift = -dq/dt; r = dq/du
  if (q.kind == Kind::RegionForce) body_.moveRegion(q.region, -q.direction, lift);
  for (const auto& [node, N] : q.row)
    if (q.kind == Kind::Displacement)
      store(r[static_cast<std::size_t>(node)],
            load(r[static_cast<std::size_t>(node)]) + load(toReal4<double>(Vec3(N * q.direction))));
  for (const ContactPoint& point : contact_) {
    if (q.kind != Kind::ToolForce || !point.active) continue;
    const double reach = difference_reach * size_;
    const Vec3 x = placeOf(point, u_);
    // As the layer's tangent is symmetric, d(direction . f)/dx is its product with the direction.
    const Vec3 slope =
        (contactForce(point, x - reach * q.direction) - contactForce(point, x + reach * q.direction)) / (2 * reach);
    for (int e = model_.skin.begin[point.vertex]; e < model_.skin.begin[point.vertex + 1]; ++e) {
      Double4& at = r[static_cast<std::size_t>(model_.skin.node[e])];
      store(at, load(at) + static_cast<double>(model_.skin.N[e]) * load(toReal4<double>(slope)));
    }
  }
  const bool of_region = largestOf(lift) > 0;
  if (!of_region && !(largestOf(r) > 0)) return std::vector<double>(numbers.size());
  const double tolerance = std::max(1e-10, accuracy_);
  const auto explicitSlope = [&](const Vec3& of_tool) {
    return q.kind == Kind::ToolForce ? q.direction.dot(of_tool) : 0;
  };
  std::vector<double> slopes;
  Field df(u_.size());
  if (isSymmetric()) {
    Field l = lift;
    if (of_region) {
      multiply(l, product, Difference::Central);
      addTo(r, -1, product);
    }
    solve(r, l, tolerance, Difference::Central);
    for (const MaterialNumber& number : numbers) {
      const double at_once = explicitSlope(differentiateForce(number, df));
      slopes.push_back(at_once + dotOf(l, df));
    }
    return slopes;
  }
  for (const MaterialNumber& number : numbers) {
    const double at_once = explicitSlope(differentiateForce(number, df));
    Field du(u_.size());
    solve(df, du, tolerance, Difference::Central);
    double slope = at_once + dotOf(r, du);
    if (of_region) {
      multiply(du, product, Difference::Central);
      addTo(df, -1, product);
      slope += dotOf(lift, df);
    }
    slopes.push_back(slope);
  }
  return slopes;
}

}  // namespace palpate

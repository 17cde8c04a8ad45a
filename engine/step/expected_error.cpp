#include "step/expected_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mechanics/materials/fibre_energy.h"

namespace palpate {
namespace {

constexpr double c_uneven = 0.86, c_held = 0.24, c_missed = 0.72, c_both = 3;  // c_0 .. c_3 of moved faces
// What turns fibres strains them by its square: what they store, c_4, grows faster than the whole.
constexpr double c_missed_fibres = 1.8;
constexpr double c_edge = 2.4;  // beside where what is held ends amid skin, or is thin
constexpr double c_pressed = 0.12, c_pressed_held = 0.08, c_pressed_missed = 0.2;  // of what is pressed
constexpr double c_flat = 2.2;                                                     // by a flat end
// Of Model::rest_energy, which is far above float's noise: in double strains of 3e-6 are none, either.
constexpr double least_energy = 1e-6;
constexpr double narrowest = 0.64, most_narrow = 2;  // touches, of the nodes' distance; the error that is said of them
constexpr double near_touch = 3, most_of_touch = 4;  // reach of what counts beside other strains; times Hertz

/// The node next to a tool's tip, of a solution that is over.
std::size_t nodeAt(const Model& model, const AlignedVector<Double4>& u, const Vec3& tip) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < model.X.size(); ++i)
    if (const double d = (model.X[i] + toVec3(u[i]) - tip).squaredNorm(); d < least) least = d, nearest = i;
  return nearest;
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

/// What a press by a tool stores in a half-space, J: 2/5 F d, F = 16/3 mu sqrt(R) d^(3/2) (Hertz).
double storedByHertz(double force, double shear_modulus, double radius) {
  return 0.4 * force * std::pow(force / (16.0 / 3 * shear_modulus * std::sqrt(radius)), 2.0 / 3);
}

constexpr double widest_press = 4;  // nodes' distances: what is rounder than that of a rigid body holds the tissue

double spacingAt(const Model& model, int node) {
  return model.support_radius[static_cast<std::size_t>(node)] / model.scene.discretization.support_factor;
}

/// What a touch goes by.
struct TouchShape {
  double radius = 0, ball = 0;  // m, of the whole, and of the ball that it touches as
  bool flat = false;
};

TouchShape touchShapeOf(const Model& model, const Press& press) {
  if (!press.isTool()) {
    const double radius = model.rigid.body[press.rigid()].shape.radius;
    return {radius, radius, press.flat};
  }
  const ToolShape& tool = model.scene.tools[press.tool()].shape;
  return {tool.radius, touchRadius(tool), tipProfile(tool, tool.radius / 2) < 1e-3 * tool.radius};
}

/// By how much a point of mixed tissue may be too stiff: by the mean of the compliances, a share of its modulus.
double mixedExcess(const Model& model, std::size_t q) {
  const std::vector<MaterialSpec>& specs = model.scene.materials;
  const int step = model.point_material[q] - static_cast<int>(specs.size()) + 1;
  if (step <= 0) return 0;
  const auto other = std::find_if(specs.begin(), specs.end(), [](const MaterialSpec& m) { return m.membership; });
  const double share = static_cast<double>(step) / mixture_steps;
  const double softness = (1 - share) / specs[0].material.shear_modulus + share / other->material.shear_modulus;
  return 1 - 1 / (softness * model.materials[static_cast<std::size_t>(model.point_material[q])].shear_modulus);
}

}  // namespace

void ErrorSums::add(const Model& model, std::size_t q, const Material& material, const Strain& strain,
                    const std::array<Strain, 4>& at_nodes) {
  const Mat3 F = Mat3::Identity() + strain.H;
  double V = model.point_volume[q];
  const double unseen = static_cast<double>(model.point_groups.unseen[q]);
  Strain mean;
  for (const Strain& s : at_nodes) mean.add(0.25, s);
  if (const double excess = mixedExcess(model, q); excess > 0)
    mixed += V * excess * material.shear_modulus * (0.5 * (F.transpose() * F - Mat3::Identity())).squaredNorm();
  if (pressed > 0) {
    uneven += V * pressedEnergy(material, F, strain.H - mean.H);
    held += V * material.bulk_modulus * std::pow(strain.dilatation - mean.dilatation, 2);
    for (const Strain& s : at_nodes) missed += V * PointGroups::of_cell * pressedEnergy(material, F, s.H - mean.H);
    return;
  }
  if (model.point_groups.at_edge[q] != 0) V *= c_edge;
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
  if (pressed > 0)
    return std::hypot(pressed * (c_pressed * uneven + c_pressed_held * held + c_pressed_missed * missed), mixed);
  const double stiff = c_uneven * uneven + c_held * held, soft = c_missed * missed + c_missed_fibres * missed_fibres,
               sum = stiff + soft;
  return std::hypot(stiff - soft, c_both * sum * sum / energy, mixed);
}

PressList::PressList(const ToolLoads& loads) {
  for (std::size_t t = 0; t < loads.size(); ++t)
    if (const double force = std::max(loads[t].force.norm(), loads[t].pinch); force > 0)
      press[count++] = {static_cast<int>(t), force, -1};
}

PressList::PressList(const Model& model, const ToolLoads& loads, const RigidLoads& rigid) : PressList(loads) {
  for (std::size_t b = 0; b < model.rigid.body.size(); ++b) {
    const RigidBody& body = model.rigid.body[b];
    const bool is_round = body.shape.radius > 0 && !body.encloses &&
                          body.shape.radius < widest_press * model.scene.discretization.spacing;
    if (const double force = rigid[b].force.norm(); is_round && force > 0)
      press[count++] = {max_tools + static_cast<int>(b), force, -1};
  }
}

void PressList::touch(const Model& model, int vertex, const Vec3& normal, Press& by) {
  constexpr double along_axis = 0.7;  // cosine
  const RigidShape& shape = model.rigid.body[by.rigid()].shape;
  by.flat = shape.kind == RigidShape::Kind::Cylinder && std::abs(normal.dot(shape.normal)) > along_axis * normal.norm();
  by.node = heaviestNode(model, vertex);
}

void PressList::findTouches(const Model& model, double time, const AlignedVector<Double4>& u) {
  for (std::size_t k = 0; k < count; ++k) {
    if (press[k].isTool()) continue;
    const RigidBody& body = model.rigid.body[press[k].rigid()];
    const Pose pose = body.at(time);
    double least = RigidShape::away;
    for (int p = body.begin; p < body.end; ++p) {
      const auto v = static_cast<std::size_t>(model.rigid.vertex[static_cast<std::size_t>(p)]);
      Vec3 x = model.skin.surface.vertices[v], normal;
      for (auto e = static_cast<std::size_t>(model.skin.begin[v]);
           e < static_cast<std::size_t>(model.skin.begin[v + 1]); ++e)
        x += static_cast<double>(model.skin.N[e]) * toVec3(u[static_cast<std::size_t>(model.skin.node[e])]);
      const double gap = body.shape.gapAt(pose.toLocal(x), normal);
      if (gap >= least) continue;
      least = gap;
      touch(model, static_cast<int>(v), normal, press[k]);
    }
  }
}

int heaviestNode(const Model& model, int vertex) {
  const auto first = model.skin.N.begin() + model.skin.begin[vertex],
             last = model.skin.N.begin() + model.skin.begin[vertex + 1];
  return model.skin.node[static_cast<std::size_t>(std::max_element(first, last) - model.skin.N.begin())];
}

PressErrors::PressErrors(const Model& model, std::span<const Press> presses, std::span<const Material> materials,
                         const std::vector<int>& material, bool strained)
    : count_(std::max<std::size_t>(presses.size(), 1)) {
  std::copy(presses.begin(), presses.end(), press_.begin());
  if (press_[0].by < 0) {
    share_[0].sums.pressed = model.surface_loads.empty() ? 0 : 1;
    return;
  }
  strained_ = strained;
  for (std::size_t k = 0; k < count_; ++k) {
    const Press& press = press_[k];
    Share& share = share_[k];
    const TouchShape touch = touchShapeOf(model, press);
    share.sums.pressed = touch.flat ? c_flat : 1;
    share.reach2 = std::numeric_limits<double>::infinity();
    int m = 0;
    if (press.node >= 0) {
      share.at = model.X[static_cast<std::size_t>(press.node)];
      m = material[static_cast<std::size_t>(press.node)];
      const double reach = near_touch * (touch.radius + spacingAt(model, press.node));
      if (strained_) share.reach2 = reach * reach;
    }
    share.stored = storedByHertz(press.force, materials[static_cast<std::size_t>(m)].shear_modulus, touch.ball);
  }
}

void PressErrors::add(const Model& model, std::size_t point, const Material& material, const Strain& strain,
                      const std::array<Strain, 4>& at_nodes) {
  std::size_t nearest = 0;
  if (count_ > 1 || strained_) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count_; ++k)
      if (const double d = (model.point_X[point] - share_[k].at).squaredNorm(); d < least) least = d, nearest = k;
    if (least > share_[nearest].reach2) return;
  }
  share_[nearest].sums.add(model, point, material, strain, at_nodes);
}

double PressErrors::storedBy(std::size_t k, double strain_energy, double before) const {
  double all = 0;
  for (std::size_t p = 0; p < count_; ++p) all += share_[p].stored;
  const double stored =
      strained_
          ? std::min(strain_energy, std::clamp(before < 0 ? all : strain_energy - before, all, most_of_touch * all))
          : strain_energy;
  return count_ > 1 ? stored * share_[k].stored / all : stored;
}

double PressErrors::error(std::size_t k, double strain_energy, double before) const {
  const double stored = storedBy(k, strain_energy, before), error = share_[k].sums.off(stored) / stored;
  return strained_ ? std::min(1.0, error) : error;
}

double PressErrors::localShare(std::size_t k, double strain_energy, double before) const {
  return std::min(1.0, share_[k].stored / storedBy(k, strain_energy, before));
}

std::vector<int> nodeMaterials(const Model& model) {
  std::vector<int> material(model.X.size(), 0);
  for (std::size_t q = 0; q < model.point_material.size(); ++q)
    for (const int i : model.cells[static_cast<std::size_t>(model.point_cell[q])])
      material[static_cast<std::size_t>(i)] = model.point_material[q];
  return material;
}

bool strainedBeside(const Model& model, const LiveLoads& live) {
  const auto moves = [](const auto& motion) { return motion.moves(); };
  return !model.surface_loads.empty() || !model.scene.dynamics.gravity.isZero(0) || live.any() || model.rigid.moves() ||
         std::any_of(model.essential.motions.begin(), model.essential.motions.end(), moves);
}

double narrowError(const Model& model, const Material& m, const Press& press) {
  const double h = spacingAt(model, press.node), K = m.bulk_modulus, G = m.shear_modulus,
               nu = (3 * K - 2 * G) / (6 * K + 2 * G), E = 2 * G / (1 - nu);
  double radius = 0, rounding = 0, slope = 0;
  if (press.isTool()) {
    const ToolShape& tool = model.scene.tools[press.tool()].shape;
    const ToolProfile profile = toolProfile(tool);
    const double sine = profile.corner_count > 1 ? std::clamp(-profile.side_normal[0].z, 0.0, 0.999) : 0.0;
    radius = tool.radius, rounding = profile.rounding, slope = sine / std::sqrt(1 - sine * sine);
  } else {
    radius = model.rigid.body[press.rigid()].shape.radius;
    rounding = press.flat ? std::numeric_limits<double>::infinity() : radius;
  }
  const double square = std::max(1.25 * press.force * rounding / (E * h * h * h),
                                 2 * press.force * slope / (M_PI * E * h * h)),
               touched = std::min(std::sqrt(square), radius / h);
  return std::clamp(narrowest / touched - 1, 0.0, most_narrow);
}

double expectedError(const Model& model, std::span<const Material> materials, const AlignedVector<Double4>& u,
                     double strain_energy, std::span<const Press> presses, std::span<const ToolPosture> tips,
                     double before) {
  if (!(strain_energy > least_energy * model.rest_energy)) return 0;
  const std::vector<int> material = nodeMaterials(model);
  std::vector<Press> found(presses.begin(), presses.end());
  for (Press& press : found) {
    if (press.node < 0 && press.isTool() && press.tool() < tips.size())
      press.node = static_cast<int>(nodeAt(model, u, tips[press.tool()].pose.position));
  }
  const ShapeTable& shape = model.point_shape;
  const PointGroups& groups = model.point_groups;
  PressErrors errors(model, found, materials, material, strainedBeside(model));
  const auto& weight = errors.weights(groups);
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
    errors.add(model, q, materials[static_cast<std::size_t>(model.point_material[q])], at[q], at_nodes);
  }
  double largest = layerError(model, materials);
  for (std::size_t k = 0; k < std::max<std::size_t>(found.size(), 1); ++k)
    largest = std::max(largest, errors.error(k, strain_energy, before));
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k].node < 0) continue;
    const auto node = static_cast<std::size_t>(found[k].node);
    largest = std::max(largest, errors.localShare(k, strain_energy, before) *
                                    narrowError(model, materials[static_cast<std::size_t>(material[node])], found[k]));
  }
  return largest;
}

}  // namespace palpate

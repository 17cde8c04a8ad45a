#include "simulation/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "simulation/scene_messages.h"

namespace palpate {
namespace {

constexpr double error_constant = 0.28;  // c
// Of Model::rest_energy, which is far above float's noise: in double strains of 3e-6 are none, either.
constexpr double least_energy = 1e-6;
// Of a tick: at the liver's 20,124 points a hundredth of its time.
constexpr std::size_t points_a_tick = 64, most_ticks = 400;
// Nodes' distance over a tool's radius: the liver's 0.77 is 1.5 % off at its press, a kidney of 1.4 was by 10 %.
constexpr double coarsest = 0.8;

/// The largest force that something has on it, N.
double largestForce(const StepReport& report) {
  double largest = std::max(report.tool_force.norm(), report.base_reaction.norm());
  for (const ToolLoad& load : report.loads) largest = std::max({largest, load.force.norm(), load.pinch});
  return largest;
}

/// mu |D|^2 of a deviation D = F - F*, and half of what fibres along n, which are under tension where |F n| > 1, add to
/// the modulus there times (n . D n)^2; Pa.
double deviationEnergy(const Material& m, const Mat3& F, const Mat3& D) {
  const double shear = m.shear_modulus * D.squaredNorm();
  if (m.fibre_modulus == 0) return shear;
  const Vec3 n(m.fibre[0], m.fibre[1], m.fibre[2]), stretched = F * n;
  if (stretched.squaredNorm() <= 1) return shear;
  const double along = stretched.dot(D * n);
  return shear + m.fibre_modulus / 2 * along * along;
}

}  // namespace

PointGroups makePointGroups(const Preparation& p) {
  PointGroups groups;
  std::map<std::pair<int, int>, int> number;  // of node and material
  std::vector<double> volume;
  groups.of_point.resize(p.point_X.size());
  for (std::size_t q = 0; q < p.point_X.size(); ++q)
    for (std::size_t k = 0; k < 4; ++k) {
      const int node = p.cells[static_cast<std::size_t>(p.point_cell[q])][k];
      const int g = number.try_emplace({node, p.point_material[q]}, static_cast<int>(number.size())).first->second;
      groups.of_point[q][k] = g;
      volume.resize(number.size(), 0);
      volume[static_cast<std::size_t>(g)] += p.point_volume[q];
    }
  for (const double v : volume) groups.inverse_volume.push_back(static_cast<float>(1 / v));
  return groups;
}

double expectedError(const Model& model, std::span<const Material> materials, const AlignedVector<Double4>& u,
                     double strain_energy) {
  if (!(strain_energy > least_energy * model.rest_energy)) return 0;
  const ShapeTable& shape = model.point_shape;
  const PointGroups& groups = model.point_groups;
  std::vector<Mat3> F(model.point_X.size(), Mat3::Zero()), mean(groups.inverse_volume.size(), Mat3::Zero());
  for (std::size_t q = 0; q < F.size(); ++q) {
    for (auto e = static_cast<std::size_t>(shape.begin[q]); e < static_cast<std::size_t>(shape.begin[q + 1]); ++e)
      F[q] += toVec3(u[static_cast<std::size_t>(shape.node[e])]) * shape.gradN[e].transpose();
    for (const int g : groups.of_point[q])
      mean[static_cast<std::size_t>(g)] +=
          model.point_volume[q] * groups.inverse_volume[static_cast<std::size_t>(g)] * F[q];
  }
  double sum = 0;
  for (std::size_t q = 0; q < F.size(); ++q) {
    Mat3 around = Mat3::Zero();
    for (const int g : groups.of_point[q]) around += 0.25 * mean[static_cast<std::size_t>(g)];
    sum += model.point_volume[q] * deviationEnergy(materials[static_cast<std::size_t>(model.point_material[q])],
                                                   F[q] + Mat3::Identity(), F[q] - around);
  }
  return error_constant * sum / strain_energy;
}

ResolutionWatch::ResolutionWatch(const Model& model)
    : u_(model.X.size()), F_(model.point_X.size()), mean_(model.point_groups.inverse_volume.size()) {}

void ResolutionWatch::restart() {
  next_ = 0;
  error_ = error_force_ = 0;
}

void ResolutionWatch::goOnFrom(const ResolutionWatch& before) {
  next_ = 0;
  error_ = before.error_;
  error_force_ = before.error_force_;
}

void ResolutionWatch::advance(const Model& model, std::span<const Material> materials, const AlignedVector<Float4>& u,
                              StepReport& report) {
  const std::size_t count = F_.size(), part = std::max(points_a_tick, count / most_ticks + 1);
  if (next_ == 0) {
    if (!(report.strain_energy > model.rest_energy)) {  // nothing to look at
      error_ = error_force_ = 0;
      return;
    }
    std::copy(u.begin(), u.end(), u_.begin());
    std::fill(mean_.begin(), mean_.end(), Gradient{});
    sum_ = 0;
    energy_ = report.strain_energy;
    force_ = largestForce(report);
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
    error_ = error_constant * sum_ / energy_;
    error_force_ = force_;
  }
  report.expected_error = error_;
  report.error_force = error_force_;
}

void ResolutionWatch::gather(const Model& model, std::size_t begin, std::size_t end) {
  const ShapeTable& shape = model.point_shape;
  for (std::size_t q = begin; q < end; ++q) {
    Gradient F{};
    for (auto e = static_cast<std::size_t>(shape.begin[q]); e < static_cast<std::size_t>(shape.begin[q + 1]); ++e) {
      const Float4& a = u_[static_cast<std::size_t>(shape.node[e])];
      const float gx = static_cast<float>(shape.gradN[e].x()), gy = static_cast<float>(shape.gradN[e].y()),
                  gz = static_cast<float>(shape.gradN[e].z());
      F[0] += a.x * gx, F[1] += a.x * gy, F[2] += a.x * gz;
      F[3] += a.y * gx, F[4] += a.y * gy, F[5] += a.y * gz;
      F[6] += a.z * gx, F[7] += a.z * gy, F[8] += a.z * gz;
    }
    F_[q] = F;
    for (const int g : model.point_groups.of_point[q]) {
      const auto group = static_cast<std::size_t>(g);
      const float share = static_cast<float>(model.point_volume[q]) * model.point_groups.inverse_volume[group];
      for (std::size_t k = 0; k < 9; ++k) mean_[group][k] += share * F[k];
    }
  }
}

void ResolutionWatch::compare(const Model& model, std::span<const Material> materials, std::size_t begin,
                              std::size_t end) {
  for (std::size_t q = begin; q < end; ++q) {
    Gradient off = F_[q];
    for (const int g : model.point_groups.of_point[q])
      for (std::size_t k = 0; k < 9; ++k) off[k] -= 0.25F * mean_[static_cast<std::size_t>(g)][k];
    const Material& material = materials[static_cast<std::size_t>(model.point_material[q])];
    if (material.fibre_modulus == 0) {
      double square = 0;
      for (const float a : off) square += static_cast<double>(a) * a;
      sum_ += model.point_volume[q] * material.shear_modulus * square;
      continue;
    }
    using Rows = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
    const Mat3 F = Eigen::Map<const Rows>(F_[q].data()).cast<double>() + Mat3::Identity();
    sum_ += model.point_volume[q] * deviationEnergy(material, F, Eigen::Map<const Rows>(off.data()).cast<double>());
  }
}

void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust) {
  AlignedVector<Double4> u;
  for (const Float4& a : state.u) u.push_back({a.x, a.y, a.z, 0});
  const bool at_rest = !(report.strain_energy > model.rest_energy);
  const double error = at_rest ? 0 : expectedError(model, state.live.kernel.materials, u, report.strain_energy);
  if (!std::isfinite(error)) return;
  trust.add(error > TrustLimits::expected_error ? Doubt::Resolution : Doubt::None, error, largestForce(report), time);
}

double spacingAtTool(const Body& body) {
  const Vec3 touched =
      body.tool_start.position - body.first_contact_travel * (body.tool_start.orientation * Vec3::UnitZ());
  double least = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < body.X.size(); ++i)
    if (const double d = (body.X[i] - touched).squaredNorm(); d < least) {
      least = d;
      nearest = i;
    }
  return body.support_radius[nearest] / body.scene.support_factor;
}

std::string resolutionWarning(const Body& body) {
  const double spacing = spacingAtTool(body), radius = body.scene.tool.radius;
  if (body.first_contact_travel <= 0 || spacing <= coarsest * radius) return {};
  return placeOf(body.scene, "discretization.spacing").text() +
         format(
             ": where the tool meets the organ the nodes are %.3g mm apart, which is coarse for a tool of %.3g mm "
             "radius: it will feel the tissue too stiff, by more the lighter it touches. A spacing of %.2g mm there "
             "(spacing, or refine) would do; `mtled fit` finds the best cloud for a rate, `mtled certify` says how "
             "exact this one is",
             1e3 * spacing, 1e3 * radius, 1e3 * coarsest * radius);
}

}  // namespace palpate

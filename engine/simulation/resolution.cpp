#include "simulation/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "simulation/scene_messages.h"

namespace palpate {
namespace {

constexpr double c_shape = 0.16, c_slope = 0.3, c_bulk = 0.12;  // c_0, c_1, c_2
// Of Model::rest_energy, which is far above float's noise: in double strains of 3e-6 are none, either.
constexpr double least_energy = 1e-6;
// Of a tick: at the liver's 20,124 points a hundredth of its time.
constexpr std::size_t points_a_tick = 64, most_ticks = 400;
// Nodes' distance over a tool's radius: the liver's 0.77 is 1.5 % off at its press, a kidney of 1.4 was by 10 %.
constexpr double coarsest = 0.8;

/// The largest force that a tool has on it, N.
double toolForce(const StepReport& report) {
  double largest = report.tool_force.norm();
  for (const ToolLoad& load : report.loads) largest = std::max({largest, load.force.norm(), load.pinch});
  return largest;
}

/// The largest force that something has on it, N.
double largestForce(const StepReport& report) { return std::max(toolForce(report), report.base_reaction.norm()); }

/// What a ball's force stores in a half-space, J: 2/5 F d, F = 16/3 mu sqrt(R) d^(3/2) (Hertz); no more than there is.
double touchEnergy(const Model& model, double force, double strain_energy) {
  const double stiffness = 16.0 / 3 * model.materials[0].shear_modulus * std::sqrt(smallestToolRadius(model.scene));
  return std::min(strain_energy, 0.4 * force * std::pow(force / stiffness, 2.0 / 3));
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

/// What a point adds to e W, over its volume, Pa. @param K  Pa
double weighed(double shape, double slope, double K, double dJ) {
  return c_shape * shape + c_slope * slope + c_bulk * K * dJ * dJ;
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
                     double strain_energy, double tool_force) {
  if (!(strain_energy > least_energy * model.rest_energy)) return 0;
  const ShapeTable& shape = model.point_shape;
  const PointGroups& groups = model.point_groups;
  std::vector<Mat3> F(model.point_X.size(), Mat3::Identity()), mean(groups.inverse_volume.size(), Mat3::Zero());
  std::vector<double> J(F.size()), mean_J(mean.size(), 0);
  for (std::size_t q = 0; q < F.size(); ++q) {
    for (auto e = static_cast<std::size_t>(shape.begin[q]); e < static_cast<std::size_t>(shape.begin[q + 1]); ++e)
      F[q] += toVec3(u[static_cast<std::size_t>(shape.node[e])]) * shape.gradN[e].transpose();
    J[q] = F[q].determinant();
    for (const int g : groups.of_point[q]) {
      const auto k = static_cast<std::size_t>(g);
      const double share = model.point_volume[q] * groups.inverse_volume[k];
      mean[k] += share * F[q];
      mean_J[k] += share * J[q];
    }
  }
  double sum = 0;
  for (std::size_t q = 0; q < F.size(); ++q) {
    const Material& material = materials[static_cast<std::size_t>(model.point_material[q])];
    Mat3 around = Mat3::Zero();
    double J_around = 0;
    for (const int g : groups.of_point[q]) {
      around += 0.25 * mean[static_cast<std::size_t>(g)];
      J_around += 0.25 * mean_J[static_cast<std::size_t>(g)];
    }
    double slope = 0;
    for (const int g : groups.of_point[q])
      slope += 0.05 * deviationEnergy(material, F[q], mean[static_cast<std::size_t>(g)] - around);
    sum += model.point_volume[q] *
           weighed(deviationEnergy(material, F[q], F[q] - around), slope, material.bulk_modulus, J[q] - J_around);
  }
  if (model.surface_loads.empty() || !(tool_force > 0)) return sum / strain_energy;
  return std::min(1.0, sum / touchEnergy(model, tool_force, strain_energy));
}

ResolutionWatch::ResolutionWatch(const Model& model)
    : u_(model.X.size()), at_(model.point_X.size()), mean_(model.point_groups.inverse_volume.size()) {}

void ResolutionWatch::restart() {
  next_ = 0;
  error_ = error_force_ = 0;
}

void ResolutionWatch::goOnFrom(const ResolutionWatch& before) {
  next_ = 0;
  load_error_ = before.load_error_;
  error_ = before.error_;
  error_force_ = before.error_force_;
}

void ResolutionWatch::advance(const Model& model, std::span<const Material> materials, const AlignedVector<Float4>& u,
                              StepReport& report) {
  const std::size_t count = at_.size(), part = std::max(points_a_tick, count / most_ticks + 1);
  if (next_ == 0) {
    if (!(report.strain_energy > model.rest_energy)) {  // nothing to look at
      error_ = error_force_ = 0;
      return;
    }
    std::copy(u.begin(), u.end(), u_.begin());
    std::fill(mean_.begin(), mean_.end(), Strain{});
    sum_ = 0;
    energy_ = report.strain_energy;
    touch_ = model.surface_loads.empty() ? 0 : toolForce(report);
    force_ = touch_ > 0 ? touch_ : largestForce(report);
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
    error_ = sum_ / energy_;
    if (touch_ > 0) {
      const double touch = touchEnergy(model, touch_, energy_);
      error_ = std::clamp((sum_ - load_error_ * (energy_ - touch)) / touch, 0.0, 1.0);
    } else if (!(toolForce(report) > 0)) {  // nor was it a moment off a tool that hits
      load_error_ = error_;
    }
    error_force_ = force_;
  }
  report.expected_error = error_;
  report.error_force = error_force_;
}

void ResolutionWatch::gather(const Model& model, std::size_t begin, std::size_t end) {
  const ShapeTable& shape = model.point_shape;
  for (std::size_t q = begin; q < end; ++q) {
    Strain s{};
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
    for (const int g : model.point_groups.of_point[q]) {
      const auto group = static_cast<std::size_t>(g);
      const float share = static_cast<float>(model.point_volume[q]) * model.point_groups.inverse_volume[group];
      for (std::size_t k = 0; k < s.size(); ++k) mean_[group][k] += share * s[k];
    }
  }
}

void ResolutionWatch::compare(const Model& model, std::span<const Material> materials, std::size_t begin,
                              std::size_t end) {
  using Rows = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>;
  for (std::size_t q = begin; q < end; ++q) {
    const Material& material = materials[static_cast<std::size_t>(model.point_material[q])];
    const Mat3 F = Mat3::Identity() + Rows(at_[q].data()).cast<double>();
    const auto energyOf = [&](const Strain& off) {
      if (material.fibre_modulus != 0) return deviationEnergy(material, F, Rows(off.data()).cast<double>());
      float square = 0;
      for (std::size_t k = 0; k < 9; ++k) square += off[k] * off[k];
      return material.shear_modulus * static_cast<double>(square);
    };
    Strain around{};
    for (const int g : model.point_groups.of_point[q])
      for (std::size_t k = 0; k < around.size(); ++k) around[k] += 0.25F * mean_[static_cast<std::size_t>(g)][k];
    const auto from_around = [&](Strain s) {
      for (std::size_t k = 0; k < s.size(); ++k) s[k] -= around[k];
      return s;
    };
    double slope = 0;
    for (const int g : model.point_groups.of_point[q])
      slope += 0.05 * energyOf(from_around(mean_[static_cast<std::size_t>(g)]));
    const Strain off = from_around(at_[q]);
    sum_ += model.point_volume[q] * weighed(energyOf(off), slope, material.bulk_modulus, static_cast<double>(off[9]));
  }
}

void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust) {
  AlignedVector<Double4> u;
  for (const Float4& a : state.u) u.push_back({a.x, a.y, a.z, 0});
  const bool at_rest = !(report.strain_energy > model.rest_energy);
  // A tool's share beside surface loads' only the watch knows.
  const double touch = model.surface_loads.empty() ? 0 : toolForce(report);
  const bool watched = touch > 0 && report.expected_error > 0;
  const double error = at_rest   ? 0
                       : watched ? report.expected_error
                                 : expectedError(model, state.live.kernel.materials, u, report.strain_energy, touch);
  if (!std::isfinite(error)) return;
  trust.add(error > TrustLimits::expected_error ? Doubt::Resolution : Doubt::None, error,
            touch > 0 ? touch : largestForce(report), time);
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

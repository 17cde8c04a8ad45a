#include <algorithm>
#include <cmath>

#include "approximation/shape_functions.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/solids.h"
#include "mtled/verify/cases/cases.h"
#include "mtled/verify/clouds.h"

namespace palpate::tools {
namespace {

template <int Dim>
void addClouds(ResultTable& table, CaseResult& result) {
  constexpr double mu = 0.1;
  const AdmissibilityLimits limits;
  for (const auto& cloud : singularClouds<Dim>()) {
    double worst_rcond = 0, unity_mls = 0, unity = 0, linear = 0;
    int stands = 0;
    Mmls<Dim> mmls({2, mu});
    for (const auto& x : cloud.at) {
      const PlainMls classical = plainMls<Dim>(x, cloud.X, cloud.radius, 0),
                     modified = plainMls<Dim>(x, cloud.X, cloud.radius, mu);
      worst_rcond = std::max(worst_rcond, classical.reciprocal_condition);
      unity_mls = std::max(unity_mls, classical.unity_error);
      unity = std::max(unity, modified.unity_error);
      linear = std::max(linear, modified.linear_error);
      stands += mmls.evaluate(x, cloud.X.data(), cloud.radius.data(), static_cast<int>(cloud.X.size())) &&
                        limits.admit(mmls.quality())
                    ? 1
                    : 0;
    }
    const bool all = stands == static_cast<int>(cloud.at.size());
    table.rows.push_back({std::to_string(Dim) + "D, " + cloud.name, std::to_string(cloud.X.size()),
                          formatted(worst_rcond), formatted(unity_mls), formatted(unity), formatted(linear),
                          all ? "admitted" : "refused", cloud.reason});
    const std::string which = std::to_string(Dim) + "D, " + cloud.name;
    if (cloud.mmls_admissible) {
      result.bounds.push_back({"Linear reproduction by MMLS, " + which, all ? std::max(unity, linear) : NAN, 1e-11,
                               true, "", "MMLS stands"});
      result.bounds.push_back(
          {"rcond of classical MLS, " + which, worst_rcond, 1e-15, true, "", "the cloud is singular"});
    } else {
      result.bounds.push_back({"Points admitted, " + which, static_cast<double>(stands), 0, true, "",
                               "the linear part is lost: to be refused"});
    }
  }
}

struct InterpolationError {
  double spacing, values, gradients;  // m; relative to the field's and its gradient's size
};

/// Errors of interpolating sin products on an irregular cloud in a unit box.
InterpolationError interpolate(double spacing, const MmlsOptions& options) {
  SpacingField field;
  field.spacing = spacing;
  const SurfaceTree box(boxSurface(Vec3(1, 1, 1), 0.5));
  const NodeCloud cloud = makeNodeCloud(box, field, 1);
  const auto f = [](const Vec3& x) {
    return std::sin(3 * x.x() + 1) * std::cos(2 * x.y()) * std::sin(2 * x.z() + 0.5);
  };
  const auto gradient = [](const Vec3& x) {
    return Vec3(3 * std::cos(3 * x.x() + 1) * std::cos(2 * x.y()) * std::sin(2 * x.z() + 0.5),
                -2 * std::sin(3 * x.x() + 1) * std::sin(2 * x.y()) * std::sin(2 * x.z() + 0.5),
                2 * std::sin(3 * x.x() + 1) * std::cos(2 * x.y()) * std::cos(2 * x.z() + 0.5));
  };
  const std::vector<double> radius(cloud.X.size(), 2.2 * spacing);
  const Neighbours neighbours(cloud.X, radius);
  std::vector<Vec3> at;  // inside, where supports are whole
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j)
      for (int k = 0; k < 9; ++k) at.emplace_back(-0.3 + 0.07 * i, -0.3 + 0.072 * j, 0.2 + 0.071 * k);
  std::vector<InadmissibleSupport> failed;
  const ShapeTable table = shapeFunctions(at, cloud.X, radius, neighbours, options, failed);
  double value_error = 0, value_size = 0, gradient_error = 0, gradient_size = 0;
  for (int p = 0; p < table.rowCount(); ++p) {
    double value = 0;
    Vec3 slope = Vec3::Zero();
    for (int e = table.begin[p]; e < table.begin[p + 1]; ++e) {
      value += table.N[e] * f(cloud.X[table.node[e]]);
      slope += table.gradN[e] * f(cloud.X[table.node[e]]);
    }
    value_error += std::pow(value - f(at[p]), 2);
    value_size += std::pow(f(at[p]), 2);
    gradient_error += (slope - gradient(at[p])).squaredNorm();
    gradient_size += gradient(at[p]).squaredNorm();
  }
  return {spacing, std::sqrt(value_error / value_size),
          failed.empty() ? std::sqrt(gradient_error / gradient_size) : NAN};
}

}  // namespace

CaseResult approximationCase(const CaseContext& context) {
  CaseResult result;
  result.name = "approximation";
  result.title = "Modified moving least squares (paper 2.1)";
  result.reference =
      "Identities (unity, linear reproduction) and a known field; the classical moment matrix evaluated as it stands.";
  result.text =
      "Clouds on which the classical quadratic moment matrix is singular, mu 0.1; then the error of interpolating a "
      "smooth field on "
      "irregular clouds, and its rate.";
  ResultTable clouds{
      "Singular clouds",
      {"cloud", "nodes", "MLS: rcond", "MLS: unity error", "MMLS: unity error", "MMLS: linear error", "MMLS", "why"},
      {},
      ""};
  addClouds<2>(clouds, result);
  addClouds<3>(clouds, result);
  result.tables.push_back(clouds);

  struct Basis {
    const char* label;
    MmlsOptions options;
    double value_rate, gradient_rate;  // at least
  };
  const Basis bases[] = {{"linear", {1, 0.1}, 1.7, 0.9},
                         {"quadratic, mu 0.1", {2, 0.1}, 1.7, 0.9},
                         {"quadratic, mu 1e-7", {2, 1e-7}, 2.6, 1.6}};
  ResultTable rates{
      "Interpolation in a unit box, R = 2.2 h",
      {"basis", "values, h 0.2", "values, h 0.08", "rate", "gradients, h 0.2", "gradients, h 0.08", "rate"},
      {},
      ""};
  Figure figure;
  figure.title = "Error of interpolated values and gradients";
  figure.x_label = "Node spacing, share of the box";
  figure.y_label = "Relative error";
  figure.log_x = figure.log_y = true;
  int done = 0;
  for (const Basis& basis : bases) {
    std::vector<InterpolationError> errors;
    for (const double h : {0.2, 0.13, 0.08}) {
      context.progress(done++ / 9.0, basis.label);
      errors.push_back(interpolate(h, basis.options));
    }
    const double ratio = std::log(errors.front().spacing / errors.back().spacing);
    const double values = std::log(errors.front().values / errors.back().values) / ratio;
    const double gradients = std::log(errors.front().gradients / errors.back().gradients) / ratio;
    rates.rows.push_back({basis.label, formatted(errors.front().values), formatted(errors.back().values),
                          formatted(values), formatted(errors.front().gradients), formatted(errors.back().gradients),
                          formatted(gradients)});
    result.bounds.push_back({std::string("Rate of values, ") + basis.label, values, basis.value_rate, false, "",
                             "what the basis reproduces"});
    result.bounds.push_back({std::string("Rate of gradients, ") + basis.label, gradients, basis.gradient_rate, false,
                             "", "what the basis reproduces"});
    Series v{std::string("values, ") + basis.label, {}, {}, SeriesStyle::LineAndPoints},
        g{std::string("gradients, ") + basis.label, {}, {}, SeriesStyle::Dashed};
    for (const auto& e : errors) {
      v.x.push_back(e.spacing);
      g.x.push_back(e.spacing);
      v.y.push_back(e.values);
      g.y.push_back(e.gradients);
    }
    figure.series.push_back(v);
    figure.series.push_back(g);
  }
  result.tables.push_back(rates);
  if (context.pictures) {
    addFigure(context, "approximation_rates.png", "Convergence of the interpolation", figure, result);
  }
  return result;
}

}  // namespace palpate::tools

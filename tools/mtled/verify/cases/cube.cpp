#include "mtled/verify/cases/cases.h"

#include <algorithm>
#include <cmath>

namespace palpate::tools {
namespace {

constexpr double edge = 0.1, top_motion = -0.02;

/// Section 3.1: the top is pressed down by 20 %, the sides are free; u_z = -0.2 z everywhere.
Scene cubeScene(double spacing, int points_per_cell, double accuracy) {
  Scene scene = caseScene(3000, 0.49);
  scene.name = "cube";
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(edge, edge, edge);
  scene.discretization.spacing = spacing;
  scene.tools[0].shape.radius = 0.05;
  scene.discretization.support_factor = 1.8;
  scene.discretization.mmls_weight = 0.1;
  scene.discretization.quadrature.points_per_cell = points_per_cell;
  scene.discretization.quadrature.accuracy = accuracy;
  scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ(), {false, false, true}),
                      planeBoundary("x side", Vec3(-edge / 2, 0, 0), Vec3::UnitX(), {true, false, false}),
                      planeBoundary("y side", Vec3(0, -edge / 2, 0), Vec3::UnitY(), {false, true, false}),
                      planeBoundary("top", Vec3(0, 0, edge), Vec3::UnitZ(), {false, false, true})};
  scene.boundaries.back().translation = Vec3(0, 0, top_motion);
  scene.boundaries.back().duration = 1;
  return scene;
}

struct Outcome {
  double nrmse = NAN, boundary_error = NAN, force = NAN;
  int nodes = 0, points = 0;
  std::vector<double> relative_errors;  // of u_z at the nodes, as in the paper's Fig. 2
};

Outcome compress(const Scene& scene, const CaseContext& context) {
  // The estimated error is far below the discretization's 1e-4, and below the 1e-6 that a consistent one must reach.
  const StaticSolution s = solveCase(scene, {1.0}, context, 1e-7);
  Outcome out;
  out.nodes = s.model->nodeCount();
  out.points = s.model->pointCount();
  if (s.steps.empty() || !s.steps.back().converged) return out;
  const auto u = fieldAt(s.model->node_shape, s.u());
  double sum = 0;
  out.boundary_error = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double error = std::abs(u[i].z() - top_motion * s.model->X[i].z() / edge);
    sum += error * error;
    out.relative_errors.push_back(error / std::abs(top_motion));
    if (s.model->imposed[i] & 4) out.boundary_error = std::max(out.boundary_error, error);
  }
  out.nrmse = std::sqrt(sum / static_cast<double>(u.size())) / std::abs(top_motion);
  out.force = s.reactions.back().back().force.z();
  return out;
}

/// One row of the table.
struct Row {
  const char* label;
  double paper;
  double spacing;
  int points_per_cell;
  double accuracy;
  bool only_full;
  double cells_per_point = 1;
};
constexpr double coarse = 0.0209, fine = 0.0079;  // about 260 and 3,364 nodes
constexpr Row rows[] = {{"1 point", 3.08e-3, coarse, 1, 0, false},      {"4 points", 6.92e-4, coarse, 4, 0, false},
                        {"4 points", 2.94e-4, fine, 4, 0, true},        {"tau 0.1", 6.30e-4, coarse, 4, 0.1, false},
                        {"tau 0.05", 3.45e-4, coarse, 4, 0.05, true},   {"tau 0.01", 1.04e-4, coarse, 4, 0.01, true},
                        {"2 cells a point", NAN, coarse, 1, 0, true, 2}};

void addErrorHistogram(const CaseContext& context, const std::vector<double>& relative_errors, CaseResult& result) {
  std::vector<double> percent;
  percent.reserve(relative_errors.size());
  for (const double e : relative_errors) percent.push_back(e * 100);
  Histogram h = histogramOf(percent, 30);
  h.title = "Error of u_z node by node (the paper's Fig. 2a)";
  h.x_label = "Relative error, %";
  h.y_label = "Nodes";
  addFigure(context, "cube_errors.png", "Relative errors of the nodes, 4 points a cell, as the paper", h, result);
}

void addErrorFigure(const CaseContext& context, const std::vector<double>& points, const std::vector<double>& errors,
                    CaseResult& result) {
  Figure figure;
  figure.title = "Cube, about 260 nodes: error against the number of integration points";
  figure.x_label = "Integration points";
  figure.y_label = "NRMSE of u_z";
  figure.log_x = figure.log_y = true;
  Series ours{"as the paper", points, errors, SeriesStyle::Points};
  figure.series.push_back(ours);
  figure.series.push_back({"paper's Table 1 (its own points)",
                           {1014, 4056, 4992, 16284, 71352},
                           {3.08e-3, 6.92e-4, 6.30e-4, 3.45e-4, 1.04e-4},
                           SeriesStyle::LineAndPoints,
                           ink_colour});
  addFigure(context, "cube_points.png", "Adaptive quadrature: points against error", figure, result);
}

}  // namespace

CaseResult cubeCase(const CaseContext& context) {
  CaseResult result;
  result.name = "cube";
  result.title = "Unconstrained compression of a cube (paper 3.1, Table 1, Fig. 2)";
  result.reference =
      "Closed form: u_z = -0.2 z; total force -7.6327 N (tests/reference/uniaxial_neo_hookean_E3000_nu0.49.csv).";
  result.text =
      "Edge 100 mm, neo-Hookean, E 3000 Pa, nu 0.49, 20 % compression. It is a patch test: what is left is the error "
      "of the "
      "quadrature, which consistent gradients remove. EBCIEM, R/h 1.8, mu 0.1. NRMSE of u_z at the nodes.";
  constexpr double exact_force = -7.6327;

  ResultTable table{"NRMSE of u_z",
                    {"row", "nodes", "points", "paper", "as the paper", "node patches", "consistent gradients", "both",
                     "force, as the paper"},
                    {},
                    ""};
  std::vector<double> points, errors;
  double boundary_error = 0;
  int done = 0;
  for (const Row& row : rows) {
    if (row.only_full && context.quick) continue;
    std::vector<std::string> cells;
    Outcome first;
    for (const Variant& variant : variants) {
      if (row.spacing == fine && (variant.consistent_gradients != variant.node_patch_volume)) {
        cells.emplace_back("–");  // the coarse rows show each alone
        continue;
      }
      const int all = context.quick ? 12 : 26;
      const CaseContext within = partOf(context, done++, all);
      Scene scene = cubeScene(row.spacing, row.points_per_cell, row.accuracy);
      scene.discretization.quadrature.cells_per_point = row.cells_per_point;
      apply(variant, scene);
      const Outcome out = compress(scene, within);
      boundary_error = std::max(boundary_error, std::isnan(out.boundary_error) ? 1 : out.boundary_error);
      cells.push_back(formatted(out.nrmse));
      const std::string what = std::string(row.label) + ", " + std::to_string(out.nodes) + " nodes";
      if (&variant == &variants[0]) {
        first = out;
        if (!std::isnan(row.paper))
          result.bounds.push_back(
              {"NRMSE, " + what + ", as the paper", out.nrmse, row.paper, true, "", "the paper's Table 1"});
      }
      if (variant.consistent_gradients)
        result.bounds.push_back(
            {"NRMSE, " + what + ", " + variant.name, out.nrmse, 1e-7, true, "", "a linear field is exact"});
    }
    table.rows.push_back({row.label, std::to_string(first.nodes), std::to_string(first.points),
                          std::isnan(row.paper) ? "–" : formatted(row.paper)});
    table.rows.back().insert(table.rows.back().end(), cells.begin(), cells.end());
    table.rows.back().push_back(formattedPercent(first.force / exact_force - 1));
    if (row.spacing == coarse && !std::isnan(row.paper)) {
      points.push_back(first.points);
      errors.push_back(first.nrmse);
    }
    if (context.pictures && &row == &rows[1]) {
      addErrorHistogram(context, first.relative_errors, result);
    }
  }
  result.tables.push_back(table);
  result.bounds.push_back(
      {"Largest error at imposed nodes, over the edge", boundary_error / edge, 1e-12, true, "", "exact in double"});
  if (context.pictures) {
    addErrorFigure(context, points, errors, result);
  }
  return result;
}

}  // namespace palpate::tools

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "model/solution_fields.h"
#include "mtled/verify/cases/cases.h"

namespace palpate::tools {
namespace {

/// How unlike the pressures of cells are that share a face.
struct PressureSmoothness {
  double opposite_signs = 0;  // share of the neighbours
  double rms_jump = 0;        // over the mean |p|
};

PressureSmoothness smoothness(const Model& model, const std::vector<double>& pressure) {
  std::map<std::array<int, 3>, int> first;
  double jumps = 0, mean = 0;
  int pairs = 0, opposite = 0;
  for (int c = 0; c < static_cast<int>(model.cells.size()); ++c) {
    mean += std::abs(pressure[c]) / static_cast<double>(model.cells.size());
    for (int k = 0; k < 4; ++k) {
      std::array<int, 3> face{};
      for (int v = 0, n = 0; v < 4; ++v)
        if (v != k) face[n++] = model.cells[c][v];
      std::sort(face.begin(), face.end());
      const auto [other, is_new] = first.emplace(face, c);
      if (is_new) continue;
      const double jump = pressure[c] - pressure[other->second];
      jumps += jump * jump;
      opposite += pressure[c] * pressure[other->second] < 0 ? 1 : 0;
      ++pairs;
    }
  }
  return {static_cast<double>(opposite) / pairs, std::sqrt(jumps / pairs) / mean};
}

}  // namespace

CaseResult lockingCase(const CaseContext& context) {
  CaseResult result;
  result.name = "locking";
  result.title = "Volumetric locking: pressure under 20 % compression (paper Fig. 7)";
  result.reference =
      "tests/reference/locking_linear_tets.txt: linear tetrahedra (CalculiX C3D4), force +43 % with 12.7k nodes and "
      "+112 % with 1.9k "
      "against 0.597 N; a third of neighbouring elements have pressures of opposite sign, rms jump 1.85 x the mean.";
  result.text =
      "The sheep-brain sample with mu 1003.3 Pa, nu 0.495, as in the paper's Fig. 7. Pressure is the cells' mean; "
      "neighbours share a face.";
  constexpr double height = 5.25e-3, mu = 1003.3, nu = 0.495, converged_force = 0.597;
  ResultTable table{
      "Force and pressure",
      {"nodes", "variant", "force", "error", "neighbours of opposite sign", "rms jump / mean", "min J", "time"},
      {},
      ""};
  table.rows.push_back({"1,900", "linear tetrahedra", "", "+112 %", "", "", "", ""});
  table.rows.push_back({"12,700", "linear tetrahedra", "", "+43 %", "33 %", "1.85", "", ""});
  std::vector<double> spacings{1.44e-3};
  if (!context.quick) spacings.push_back(1.16e-3);
  int done = 0;
  for (const double spacing : spacings)
    for (const Variant& variant : variantsFor(context, spacing != spacings.front())) {
      const int all = context.quick ? 1 : 6;
      const CaseContext within = partOf(context, done++, all);
      Scene scene = caseScene(2 * mu * (1 + nu), nu);
      scene.name = "locking";
      scene.organs[0].solid = OrganSpec::Solid::Box;
      scene.organs[0].size = Vec3(0.020, 0.015, height);
      scene.discretization.spacing = spacing;
      scene.discretization.support_factor = 2.0;
      scene.discretization.mmls_weight = 0.2;
      scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
      scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ()),
                          planeBoundary("top", Vec3(0, 0, height), Vec3::UnitZ())};
      scene.boundaries.back().translation = Vec3(0, 0, -0.2 * height);
      beEven(scene.boundaries.back());
      apply(variant, scene);
      const StaticSolution s = solveCase(scene, evenTimes(4), within);
      const bool solved = !s.steps.empty() && s.steps.back().converged;
      const double force = solved ? -s.reactions.back()[1].force.z() : NAN;
      const SolutionFields fields = solutionFields(*s.model, s.uAsVectors());
      const PressureSmoothness p = smoothness(*s.model, fields.pressure);
      const std::string nodes = std::to_string(s.model->nodeCount());
      table.rows.push_back({nodes, variant.name, formatted(force, "N"),
                            formattedSigned((force / converged_force - 1) * 100, "%"),
                            formattedPercent(p.opposite_signs), formatted(p.rms_jump),
                            formatted(s.steps.empty() ? NAN : s.steps.back().min_J), formatted(s.seconds, "s")});
      if (!(variant.consistent_gradients && variant.node_patch_volume)) continue;
      result.bounds.push_back({"Force, relative error, " + nodes + " nodes", std::abs(force / converged_force - 1),
                               0.03, true, "", "linear tetrahedra: 0.43 with 12.7k nodes"});
      result.bounds.push_back({"Neighbours with pressures of opposite sign, " + nodes + " nodes", p.opposite_signs, 0.1,
                               true, "", "linear tetrahedra: a third"});
      result.bounds.push_back(
          {"rms jump of pressure / mean, " + nodes + " nodes", p.rms_jump, 0.5, true, "", "linear tetrahedra: 1.85"});
      if (!context.pictures || spacing != spacings.back()) continue;
      // Means of the cells around each node, for the picture.
      NodeField field{std::vector<float>(s.model->X.size(), 0.0F), "Pressure, kPa"};
      std::vector<float> count(s.model->X.size(), 0.0F);
      for (std::size_t c = 0; c < s.model->cells.size(); ++c)
        for (const int node : s.model->cells[c]) {
          field.values[node] += static_cast<float>(fields.pressure[c] / 1000);
          count[node] += 1;
        }
      for (std::size_t i = 0; i < count.size(); ++i) field.values[i] /= std::max(count[i], 1.0F);
      BodyPicture picture;
      picture.title = "Pressure under 20 % compression";
      picture.field = field;
      addBodyPicture(context, "locking_pressure.png", "Pressure: smooth where linear tetrahedra show a checkerboard",
                     picture, s, result);
    }
  result.tables.push_back(table);
  return result;
}

}  // namespace palpate::tools

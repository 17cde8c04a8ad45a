#include "app/panels/reference_curve.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "base/input_error.h"
#include "base/number_text.h"
#include "contact/tools/tool_list.h"
#include "io/text_file.h"

namespace palpate::app {

namespace {

constexpr std::size_t most_bytes = 64 << 20;
constexpr std::size_t most_points = 4000;  // more would not be seen
constexpr const char* advice = "give columns such as \"depth_mm,force_N\", or two columns without a header, mm and N";

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream parts(line);
  for (std::string cell; std::getline(parts, cell, ',');) {
    const auto begin = cell.find_first_not_of(" \t\r\""), end = cell.find_last_not_of(" \t\r\"");
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

std::optional<double> numberIn(const std::string& cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) return {};
  return value;
}

/// Which columns hold depth and force.
struct Columns {
  std::size_t depth = 0;
  double mm = 1;                         // per unit of the depth
  std::vector<std::size_t> force = {1};  // one, or three components
};

Columns columnsOf(const std::vector<std::string>& header, const std::string& file) {
  const auto find = [&](std::string_view name) -> std::optional<std::size_t> {
    const auto at = std::find(header.begin(), header.end(), name);
    if (at == header.end()) return {};
    return static_cast<std::size_t>(at - header.begin());
  };
  Columns columns;
  if (const auto depth = find("depth_mm")) {
    columns.depth = *depth;
  } else if (const auto metres = find("depth_m")) {
    columns.depth = *metres;
    columns.mm = 1e3;
  } else {
    throw InputError({file, 1}, "no column of the depth", advice);
  }
  if (const auto force = find("force_N")) {
    columns.force = {*force};
    return columns;
  }
  columns.force.clear();
  for (const char* name : {"force_raw_N_x", "force_raw_N_y", "force_raw_N_z"})
    if (const auto component = find(name)) columns.force.push_back(*component);
  if (columns.force.size() != 3) throw InputError({file, 1}, "no column of the force", advice);
  return columns;
}

}  // namespace

ReferenceCurve readReferenceCurve(const std::string& file) {
  std::istringstream lines(readWholeFile(file, {}, most_bytes));
  ReferenceCurve reference;
  reference.label = std::filesystem::path(file).filename().string();
  std::optional<Columns> columns;
  int row = 0;
  for (std::string line; std::getline(lines, line);) {
    ++row;
    const std::vector<std::string> cells = cellsOf(line);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty())) continue;
    if (!columns) {
      columns = numberIn(cells[0]) ? Columns{} : columnsOf(cells, file);
      if (!numberIn(cells[0])) continue;
    }
    const auto value = [&](std::size_t column) {
      const std::optional<double> number = column < cells.size() ? numberIn(cells[column]) : std::nullopt;
      if (!number) throw InputError({file, row}, "no number in column " + std::to_string(column + 1), advice);
      return *number;
    };
    double square = 0;
    for (const std::size_t column : columns->force) square += value(column) * value(column);
    const double force = columns->force.size() == 1 ? value(columns->force[0]) : std::sqrt(square);
    reference.curve.push_back({static_cast<float>(columns->mm * value(columns->depth)), static_cast<float>(force)});
  }
  if (reference.curve.size() < 2) throw InputError({file}, "fewer than two points", advice);
  if (reference.curve.size() > most_points) {
    const std::size_t every = reference.curve.size() / most_points + 1;
    std::vector<PlotPoint> thinned;
    for (std::size_t k = 0; k < reference.curve.size(); k += every) thinned.push_back(reference.curve[k]);
    reference.curve = std::move(thinned);
  }
  return reference;
}

std::optional<ReferenceCurve> hertzCurve(const Body& model, const Material& material, double depth_mm) {
  if (model.scene.materials.size() != 1 || material.fibre_modulus > 0 ||
      std::string_view(toolType(model.scene.tools[0].shape.kind).name) != "sphere")
    return {};
  constexpr int points = 60;
  const double K = material.bulk_modulus, mu = material.shear_modulus, R = model.scene.tools[0].shape.radius;
  const double young = 9 * K * mu / (3 * K + mu), poisson = (3 * K - 2 * mu) / (2 * (3 * K + mu));
  ReferenceCurve hertz;
  hertz.label = "Hertz";
  for (int k = 0; k <= points; ++k) {
    const double d = 1e-3 * depth_mm * k / points;
    const double F = 4.0 / 3 * young / (1 - poisson * poisson) * std::sqrt(R * d) * d;
    hertz.curve.push_back({static_cast<float>(1e3 * d), static_cast<float>(F)});
  }
  return hertz;
}

}  // namespace palpate::app

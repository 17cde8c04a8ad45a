#include "io/force_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/printable_text.h"
#include "base/types.h"
#include "io/csv_table.h"

namespace palpate {
namespace {

/// A column under one of its names, with what makes SI units of it.
struct Column {
  std::string name;
  double scale = 1;
};

/// The first of the columns that a table has; none: null. Throws InputError where it has one in two units.
const Column* columnOf(const CsvTable& table, const std::vector<Column>& columns) {
  const auto found =
      std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return table.find(c.name) >= 0; });
  if (found == columns.end()) return nullptr;
  const auto other = std::find_if(found + 1, columns.end(),
                                  [&](const Column& c) { return c.scale != found->scale && table.find(c.name) >= 0; });
  if (other != columns.end())
    throw InputError(table.header, "columns " + found->name + " and " + other->name + " for the same",
                     "leave one of them out");
  return &*found;
}

}  // namespace

std::vector<ForceRow> readForceRows(const std::string& path, bool advance) {
  std::vector<Column> depths{{"depth_m"}, {"depth_mm", 1e-3}};
  if (advance) depths.insert(depths.begin(), {"advance_m"});
  const std::vector<Column> forces{{"force_N"}, {"force_mN", 1e-3}, {"force_raw_N_x"}};
  const std::vector<std::string> others{"force_raw_N_y", "force_raw_N_z", "time_s"};
  const auto needed = [&](const std::string& name) {
    const auto is = [&](const Column& c) { return lowerCase(c.name) == lowerCase(name); };
    return std::any_of(depths.begin(), depths.end(), is) || std::any_of(forces.begin(), forces.end(), is) ||
           std::any_of(others.begin(), others.end(), [&](const std::string& w) { return is({w}); });
  };
  const CsvTable table = readCsvTable(path, {}, needed, {"depth_mm", "force_N"});
  const Column* const depth = columnOf(table, depths);
  const Column* const force = columnOf(table, forces);
  if (depth == nullptr || force == nullptr)
    throw InputError(table.header, std::string("there is no column ") + (depth == nullptr ? "depth_m" : "force_N"),
                     "a force curve has the columns depth_m (or depth_mm) and force_N (or force_mN), or two columns "
                     "without names, mm and N, or is a run's force.csv");
  const bool is_vector = force->name == "force_raw_N_x";
  std::vector<ForceRow> rows;
  double pushed = 0;  // N m: which sign a push has in this file
  for (std::size_t r = 0; r < table.rowCount(); ++r) {
    const double first = table[force->name][r];
    const double size = is_vector ? Vec3(first, table["force_raw_N_y"][r], table["force_raw_N_z"][r]).norm() : first;
    const ForceRow read{depth->scale * table[depth->name][r], force->scale * size,
                        table.find("time_s") < 0 ? 0 : table["time_s"][r]};
    for (const auto& [what, value] :
         {std::pair{"depth", read.depth}, std::pair{"force", read.force}, std::pair{"time", read.time}})
      if (!std::isfinite(value))
        throw InputError({table.file, table.line[r], 0}, std::string("the ") + what + " is no number",
                         "give it, or leave the row out");
    rows.push_back(read);
    pushed += std::max(0.0, read.depth) * read.force;
  }
  if (pushed < 0)
    for (ForceRow& row : rows) row.force = -row.force;
  return rows;
}

}  // namespace palpate

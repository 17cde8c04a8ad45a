#include "io/probes_file.h"

#include <cmath>

namespace palpate {

Probes readProbes(const std::string& path, const SourceLocation& asked_from) {
  Probes probes;
  probes.table = readCsvTable(path, asked_from);
  const CsvTable& table = probes.table;
  const auto &x = table["X"], &y = table["Y"], &z = table["Z"];
  for (std::size_t i = 0; i < table.rowCount(); ++i) {
    probes.X.emplace_back(x[i], y[i], z[i]);
    if (!probes.X.back().allFinite()) {
      throw InputError({path, table.line[i], 0}, "a coordinate is missing", "give X, Y and Z in m on each line");
    }
  }
  if (probes.X.empty())
    throw InputError(table.header, "no points below the header", "give X,Y,Z in m, one point a line");
  return probes;
}

}  // namespace palpate

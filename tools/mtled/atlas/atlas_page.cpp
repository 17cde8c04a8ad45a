#include "mtled/atlas/atlas_page.h"

#include <algorithm>

#include "io/output_file.h"
#include "mtled/report/case_result.h"
#include "mtled/report/pictures.h"
#include "mtled/report/report_page.h"

namespace palpate::tools {

void writeAtlasPage(const std::string& folder, const std::string& command, const Atlas& atlas,
                    const std::vector<AtlasAxis>& axes) {
  makeFolder(folder);
  Report report;
  report.title = "Where Palpate's numbers are true";
  report.intro =
      "Small bodies driven in real time (float32, one thread) to the ends of what a scene and a hand can ask for. "
      "**Stable**: right within the "
      "stated bound, and nothing was doubted. **Degraded**: the screen says so in amber (the doubt and its first time "
      "stand in the table), before "
      "a loss where there is one. **Refused**: the set-up says why. **SILENT**: wrong beyond the bound, lost, or with "
      "energy of nothing, without a "
      "doubt; the run then fails.\n\n";
  const std::string picture = writePicture(folder + "/atlas.png", atlas, axes);
  report.intro += withoutPictures().empty() ? "![Map of the cells](atlas.png)" : "Map of the cells: " + picture + ".";
  report.command = command;
  report.build = atlas.build;
  for (const auto& axis : axes) {
    CaseResult one;
    one.name = axis.key;
    one.title = axis.title;
    one.text = axis.about;
    ResultTable table{"", {"cell", "outcome", "how much", "nodes", "steps", "min J", "energy error"}, {}, ""};
    int silent = 0;
    for (const auto& r : atlas.rows) {
      if (r.axis != axis.key) continue;
      const AtlasOutcome outcome = outcomeOf(r.measure);
      const bool ran = r.measure.steps > 0;
      silent += outcome == AtlasOutcome::Silent;
      one.seconds += r.seconds;
      table.rows.push_back({r.value, outcomeName(outcome), howMuch(r.measure),
                            r.measure.nodes > 0 ? std::to_string(r.measure.nodes) : "",
                            ran ? formatted(r.measure.steps) : "", ran ? formatted(r.measure.min_J) : "",
                            ran ? formatted(r.measure.energy_error) : ""});
    }
    if (table.rows.empty()) continue;
    one.tables.push_back(table);
    one.bounds.push_back({"Cells silently wrong", static_cast<double>(silent), 0, true, "", ""});
    report.cases.push_back(std::move(one));
  }
  writeReport(folder, report);
}

}  // namespace palpate::tools

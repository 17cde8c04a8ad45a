#include "mtled/matrix/matrix_command.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <iostream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "io/csv_table.h"
#include "io/output_file.h"
#include "mtled/matrix/matrix_rows.h"
#include "mtled/report/pictures.h"
#include "mtled/report/report_page.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

using KeptReferences = std::map<unsigned, MatrixReference>;

std::string referenceFile() { return sourceFolder() + "/tests/reference/matrix.csv"; }

KeptReferences keptReferences() {
  KeptReferences kept;
  if (!std::filesystem::exists(referenceFile())) return kept;
  const CsvTable table = readCsvTable(referenceFile());
  for (std::size_t r = 0; r < table.rowCount(); ++r)
    kept[static_cast<unsigned>(table.column[0][r])] = {table.column[1][r], table.column[2][r],
                                                       static_cast<int>(table.column[3][r]), table.column[4][r] != 0};
  return kept;
}

void keep(const KeptReferences& references) {
  std::string text = "seed,value,uncertainty,nodes,known\n";
  for (const auto& [seed, r] : references)
    text += format("%u,%.6g,%.3g,%d,%d\n", seed, r.value, r.uncertainty, r.nodes, r.known ? 1 : 0);
  writeWholeFile(referenceFile(), text);
}

/// Draws and answers seeds, one after the other on each thread.
class MatrixRun {
 public:
  explicit MatrixRun(const MatrixOptions& options)
      : options_(options), kept_(keptReferences()), made_(kept_), rows_(static_cast<std::size_t>(options.count)) {}

  /// All rows, by seed.
  std::vector<MatrixRow> rows() {
    const int count = threadsOr(options_.threads);
    std::vector<std::thread> team;
    for (int k = 1; k < count; ++k) team.emplace_back([this] { work(); });
    work();
    for (std::thread& member : team) member.join();
    if (interrupted()) throw std::runtime_error("interrupted; references that were made are kept");
    if (options_.quick) std::erase_if(rows_, [](const MatrixRow& row) { return !row.one.hasClosedForm(); });
    return std::move(rows_);
  }

 private:
  void work() {
    for (int k = next_++; k < options_.count && !interrupted(); k = next_++) {
      MatrixRow row = rowOf(static_cast<unsigned>(options_.first + k));
      const std::lock_guard lock(one_);
      progress_.show(static_cast<double>(++done_) / options_.count, row.one.kind);
      if (options_.make && !row.one.hasClosedForm() && row.refused.empty()) {
        made_[row.one.seed] = row.reference;
        keep(made_);
      }
      rows_[static_cast<std::size_t>(k)] = std::move(row);
    }
  }

  MatrixRow rowOf(unsigned seed) const {
    MatrixRow row;
    row.one = drawCase(seed);
    if (row.one.hasClosedForm() ? options_.make : options_.quick) return row;
    try {
      const auto found = kept_.find(seed);
      const bool is_kept = found != kept_.end() && !row.one.hasClosedForm();
      row.reference = is_kept ? found->second : referenceOf(row.one, 1);
      if (!options_.make) row.answer = answerOf(row.one, 1, row.one.looped, 1);
    } catch (const InputError& error) {
      row.refused = error.what();
    }
    return row;
  }

  const MatrixOptions& options_;
  const KeptReferences kept_;
  KeptReferences made_;  // and those
  std::vector<MatrixRow> rows_;
  ProgressLine progress_{"matrix"};
  std::atomic<int> next_{0};
  std::mutex one_;
  int done_ = 0;
};

/// Every row, for programs.
ResultTable rowsTable(const std::vector<MatrixRow>& rows) {
  ResultTable table{"Rows",
                    {"seed", "loaded", "what", "nodes", "value", "reference", "not known", "error", "expected error",
                     "trust", "at the end", "remark"},
                    {},
                    ""};
  for (const MatrixRow& r : rows)
    table.rows.push_back({std::to_string(r.one.seed), r.one.kind, r.one.about, std::to_string(r.answer.nodes),
                          format("%.6g", r.answer.value), format("%.6g", r.reference.value),
                          format("%.3g", r.reference.uncertainty), r.comparable() ? format("%.6g", r.error()) : "",
                          format("%.6g", r.answer.trust.expectedError()), doubtName(r.answer.trust.doubt()),
                          doubtName(r.answer.at_end),
                          !r.refused.empty() ? r.refused
                          : r.answer.sound   ? ""
                                             : "unsound"});
  return table;
}

}  // namespace

int matrixCommand(const MatrixOptions& options) {
  constexpr int doubted_code = 3;
  std::unique_ptr<Pictures> pictures;
  if (!options.report.empty()) {
    std::filesystem::create_directories(options.report);
    pictures = openPictures();
  }
  const std::vector<MatrixRow> rows = MatrixRun(options).rows();
  if (options.make) return 0;
  Report report;
  report.title = "Scenes drawn by lot";
  report.command =
      format("build/release/tools/mtled verify matrix --first %d --count %d", options.first, options.count);
  if (options.quick) report.command += " --quick";
  if (!options.report.empty()) report.command += " --report " + options.report;
  report.build = buildInfo();
  report.cases.push_back(matrixResult(rows, pictures.get(), options.report));
  printCase(std::cout, report.cases[0]);
  if (!options.report.empty()) writeReport(options.report, report);
  if (!options.json.empty()) {
    report.cases[0].tables.push_back(rowsTable(rows));
    writeWholeFile(options.json, jsonOf(report));
  }
  return std::any_of(rows.begin(), rows.end(), [](const MatrixRow& row) { return row.isLie(); }) ? doubted_code : 0;
}

}  // namespace palpate::tools

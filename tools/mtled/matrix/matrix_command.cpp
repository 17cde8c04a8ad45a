#include "mtled/matrix/matrix_command.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/csv_table.h"
#include "io/output_file.h"
#include "mtled/matrix/matrix_case.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

constexpr double wrong = 0.1;           // beyond which a trusted number is a lie
constexpr double well_known = 0.02;     // of a reference, for its error to be compared with the expected one
constexpr double worth_a_look = 0.005;  // smaller errors are not compared with what was expected

struct Row {
  MatrixCase one;
  MatrixAnswer answer;
  MatrixReference reference;
  std::string refused;  // why the scene can't be had

  double error() const { return answer.value / reference.value - 1; }
  double unknown() const { return reference.uncertainty / std::abs(reference.value); }
  bool answered() const { return refused.empty() && answer.sound; }
  bool comparable() const { return answered() && reference.known && reference.value != 0; }
  bool trusted() const { return answered() && answer.trust.doubt() == Doubt::None; }
};

std::string referenceFile() { return sourceFolder() + "/tests/reference/matrix.csv"; }

std::map<unsigned, MatrixReference> keptReferences() {
  std::map<unsigned, MatrixReference> kept;
  if (!std::filesystem::exists(referenceFile())) return kept;
  const CsvTable table = readCsvTable(referenceFile());
  for (std::size_t r = 0; r < table.rowCount(); ++r)
    kept[static_cast<unsigned>(table.column[0][r])] = {table.column[1][r], table.column[2][r],
                                                       static_cast<int>(table.column[3][r]), table.column[4][r] != 0};
  return kept;
}

void keep(const std::vector<Row>& rows) {
  std::string text = "seed,value,uncertainty,nodes,known\n";
  for (const Row& r : rows)
    text += format("%u,%.6g,%.3g,%d,%d\n", r.one.seed, r.reference.value, r.reference.uncertainty, r.reference.nodes,
                   r.reference.known ? 1 : 0);
  writeWholeFile(referenceFile(), text);
}

Row rowOf(unsigned seed, const std::map<unsigned, MatrixReference>& kept) {
  Row row;
  row.one = drawCase(seed);
  try {
    row.answer = answerOf(row.one, 1, 1);
    const auto found = kept.find(seed);
    row.reference = found != kept.end() ? found->second : referenceOf(row.one, 1);
  } catch (const InputError& error) {
    row.refused = error.what();
  }
  return row;
}

/// All rows, by seed.
std::vector<Row> rowsOf(const MatrixOptions& options) {
  const std::map<unsigned, MatrixReference> kept =
      options.make ? std::map<unsigned, MatrixReference>() : keptReferences();
  std::vector<Row> rows(static_cast<std::size_t>(options.count));
  ProgressLine progress("matrix");
  std::atomic<int> next{0};
  std::mutex one;
  int done = 0;
  const auto work = [&] {
    for (int k = next++; k < options.count && !interrupted(); k = next++) {
      Row row = rowOf(static_cast<unsigned>(options.first + k), kept);
      const std::lock_guard lock(one);
      progress.show(static_cast<double>(++done) / options.count, row.one.kind);
      rows[static_cast<std::size_t>(k)] = std::move(row);
    }
  };
  const int count = options.threads > 0 ? options.threads : std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::thread> team;
  for (int k = 1; k < count; ++k) team.emplace_back(work);
  work();
  for (std::thread& member : team) member.join();
  if (interrupted()) throw std::runtime_error("interrupted; nothing is kept");
  return rows;
}

nlohmann::ordered_json jsonOf(const std::vector<Row>& rows) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Row& r : rows)
    all.push_back({{"seed", r.one.seed},
                   {"kind", r.one.kind},
                   {"nodes", r.answer.nodes},
                   {"value", r.answer.value},
                   {"reference", r.reference.value},
                   {"uncertainty", r.reference.uncertainty},
                   {"error", r.comparable() ? nlohmann::ordered_json(r.error()) : nlohmann::ordered_json()},
                   {"expected_error", r.answer.trust.expectedError()},
                   {"trust", r.refused.empty() ? doubtName(r.answer.trust.doubt()) : "refused"}});
  return {{"program", buildInfo()}, {"rows", all}};
}

void print(const Row& r) {
  std::printf("%6u  %-28s %6d nodes  %+7.2f %% (+-%.2f)  expected %5.1f %%  %s\n", r.one.seed, r.one.kind.c_str(),
              r.answer.nodes, 100 * r.error(), 100 * r.unknown(), 100 * r.answer.trust.expectedError(),
              doubtName(r.answer.trust.doubt()));
}

}  // namespace

int matrixCommand(const MatrixOptions& options) {
  const std::vector<Row> rows = rowsOf(options);
  if (options.make) keep(rows);
  if (!options.json.empty()) writeWholeFile(options.json, jsonOf(rows).dump(2) + "\n");

  std::vector<const Row*> trusted;
  int refused = 0, lost = 0, doubted = 0, not_known = 0, compared = 0, honest = 0;
  for (const Row& r : rows) {
    refused += !r.refused.empty();
    lost += r.refused.empty() && !r.answer.sound;
    doubted += r.answered() && !r.trusted();
    not_known += r.answered() && !r.comparable();
    if (!r.comparable()) continue;
    if (r.trusted()) trusted.push_back(&r);
    if (r.unknown() > well_known || r.answer.trust.doubt() > Doubt::Resolution) continue;
    const double ratio = r.answer.trust.expectedError() / std::max(std::abs(r.error()), worth_a_look);
    ++compared;
    honest += ratio > 0.5 && ratio < 2;
  }
  std::sort(trusted.begin(), trusted.end(),
            [](const Row* a, const Row* b) { return std::abs(a->error()) > std::abs(b->error()); });
  const auto within = [&](double most) {
    return 100.0 *
           static_cast<double>(
               std::count_if(trusted.begin(), trusted.end(),
                             [=](const Row* r) { return std::abs(r->error()) <= most + r->unknown(); })) /
           static_cast<double>(std::max<std::size_t>(1, trusted.size()));
  };
  std::printf("the trusted ones that are off most:\n");
  for (std::size_t k = 0; k < std::min<std::size_t>(10, trusted.size()); ++k) print(*trusted[k]);
  std::printf(
      "%d scenes: %zu trusted, %d doubted, %d without an equilibrium and said so, %d refused, %d whose reference is "
      "not "
      "known\nof the trusted, within 2, 5 and 10 %% (and what is not known): %.0f, %.0f and %.0f %%\nthe expected "
      "error "
      "is within a factor of two of the true one in %d of %d\n",
      options.count, trusted.size(), doubted, lost, refused, not_known, within(0.02), within(0.05), within(wrong),
      honest, compared);
  return within(wrong) < 100 ? 1 : 0;
}

}  // namespace palpate::tools

#include "mtled/bench/bench_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <utility>

#include "mtled/report/report_page.h"

namespace palpate::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string cell(double value) { return std::isfinite(value) && value > 0 ? formatted(value) : "\u2013"; }
std::string times(double value) { return std::isfinite(value) ? formatted(value) + " x" : "\u2013"; }
std::string percent(double share) { return std::isfinite(share) ? formattedPercent(share) : "\u2013"; }

double timeOf(const BenchRow* row) { return row ? row->best_ns : nan; }

ResultTable ceilingTable(const BenchReport& report) {
  ResultTable table;
  table.title = "Ceilings of this machine, measured";
  table.columns = {"Threads"};
  if (report.ceilings.empty()) return table;
  for (std::size_t k = 0; k < report.ceilings[0].fma_gflops.size(); ++k)
    if (report.ceilings[0].fma_gflops[k] > 0)
      table.columns.push_back(std::string("FMA ") + nameOf(static_cast<InstructionSet>(k)) + ", GFLOP/s");
  for (const auto& level : report.ceilings[0].levels) table.columns.push_back(level.name + ", GB/s");
  for (const Ceilings& c : report.ceilings) {
    std::vector<std::string> row = {std::to_string(c.threads)};
    for (const double g : c.fma_gflops)
      if (g > 0) row.push_back(formatted(g));
    for (const auto& level : c.levels) row.push_back(formatted(level.gb_per_s));
    table.rows.push_back(row);
  }
  return table;
}

std::string headOf(const BenchBodyResult& body) {
  return body.name + ": " + std::to_string(body.nodes) + " nodes, " + std::to_string(body.points) +
         " points, mean support " + formatted(body.mean_support) + ", set up in " + formatted(body.setup_seconds, "s");
}

std::vector<std::string> namesOf(const BenchRow& row) {
  return {row.kernel, row.precision, row.instruction_set, std::to_string(row.threads)};
}

ResultTable timeTable(const BenchBodyResult& body) {
  ResultTable table;
  table.title = headOf(body) + "\n  Time per point and step";
  table.columns = {"Kernel",       "Precision",       "Set",         "Threads", "Best, ns", "Median, ns",
                   "Plain / this", "1 thread / this", "Force error", "Allowed"};
  for (const BenchRow& row : body.rows) {
    const double plain = timeOf(body.plain(1));
    const double alone = timeOf(body.find(row.kernel, row.precision, row.instruction_set, 1));
    auto cells = namesOf(row);
    for (const std::string& text : {cell(row.best_ns), cell(row.median_ns), times(plain / row.best_ns),
                                    times(alone / row.best_ns), cell(row.force_error), cell(row.error_limit)})
      cells.push_back(text);
    if (row.wrong()) cells.push_back("WRONG");
    table.rows.push_back(cells);
  }
  if (std::any_of(body.rows.begin(), body.rows.end(), [](const BenchRow& r) { return r.wrong(); }))
    table.columns.emplace_back("");
  return table;
}

ResultTable costTable(const BenchBodyResult& body) {
  ResultTable table;
  table.title = "Cost per point, counted, and the ceiling that binds";
  table.columns = {"Kernel",       "Precision", "Set",     "Threads", "Bytes",      "Flops",
                   "with padding", "GB/s",      "GFLOP/s", "Ceiling", "allows, ns", "Reached"};
  for (const BenchRow& row : body.rows) {
    if (!std::isfinite(row.bytes)) continue;
    auto cells = namesOf(row);
    for (const std::string& text :
         {cell(row.bytes), cell(row.useful_flops), cell(row.executed_flops), cell(row.gb_per_s), cell(row.gflop_per_s),
          row.ceiling, cell(row.ceiling_ns), percent(row.share)})
      cells.push_back(text);
    table.rows.push_back(cells);
  }
  return table;
}

/// Of a report with a body of about 5,000 nodes, the rows that promises speak of.
struct Judge {
  const BenchBodyResult* body = nullptr;
  std::string set;
  std::vector<Verdict> verdicts{};

  const BenchRow* row(const std::string& kernel, const std::string& precision, int threads) const {
    return body ? body->find(kernel, precision, set, threads) : nullptr;
  }
  void add(const std::string& quantity, double value, double limit, bool at_most, const std::string& of_unit,
           const std::string& note, const std::string& unasked = "") {
    Verdict v{{quantity, value, limit, at_most, of_unit, note}, unasked};
    if (v.missing.empty() && !body) v.missing = "no body of about 5,000 nodes";
    if (v.missing.empty() && std::isnan(value)) v.missing = "no such row";
    verdicts.push_back(v);
  }
};

}  // namespace

const BenchRow* BenchBodyResult::find(const std::string& kernel, const std::string& precision,
                                      const std::string& instruction_set, int threads) const {
  const auto it = std::find_if(rows.begin(), rows.end(), [&](const BenchRow& r) {
    return r.kernel == kernel && r.precision == precision && r.instruction_set == instruction_set &&
           r.threads == threads;
  });
  return it == rows.end() ? nullptr : &*it;
}

const BenchRow* BenchBodyResult::plain(int threads) const {
  const auto it = std::find_if(rows.begin(), rows.end(),
                               [&](const BenchRow& r) { return r.kernel == "plain Eigen" && r.threads == threads; });
  return it == rows.end() ? nullptr : &*it;
}

bool BenchReport::right() const {
  return std::all_of(bodies.begin(), bodies.end(), [](const BenchBodyResult& b) {
    return std::none_of(b.rows.begin(), b.rows.end(), [](const BenchRow& r) { return r.wrong(); });
  });
}

std::string Verdict::text() const { return !missing.empty() ? "not measured" : bound.held() ? "held" : "missed"; }

std::vector<Verdict> verdictsOf(const BenchReport& report) {
  Judge judge;
  for (const auto& body : report.bodies)
    if (body.nodes > 4000 && body.nodes < 6000) judge.body = &body;
  for (const auto set : {InstructionSet::Plain, InstructionSet::Avx2, InstructionSet::Avx512})
    if (judge.body && judge.body->find("blocks", "float32", nameOf(set), 1)) judge.set = nameOf(set);
  const std::string narrow = judge.set == nameOf(InstructionSet::Avx512) ? "" : "no AVX-512 in use";
  const BenchRow* fast = judge.row("blocks", "float32", 1);
  const BenchRow* patched = judge.row("blocks, node patches", "float32", 1);
  const BenchRow* packed = judge.row("blocks", "int16", 1);

  judge.add("float32, one core", timeOf(fast), 60, true, "ns", "per point and step", narrow);
  judge.add("int16, one core", timeOf(packed), 45, true, "ns", "per point and step", narrow);
  judge.add("node patches, float32, one core", 100 * (timeOf(patched) / timeOf(fast) - 1), 40, true, "%",
            "on top of the same without");
  std::string gain = "one thread's time / two threads'";
  const auto pair =
      std::find_if(report.ceilings.begin(), report.ceilings.end(), [](const Ceilings& c) { return c.threads == 2; });
  if (pair != report.ceilings.end())
    gain += "; multiply-adds alone gain " + formatted(pair->mostGflops() / report.ceilings.front().mostGflops()) + " x";

  judge.add("two threads, float32", timeOf(fast) / timeOf(judge.row("blocks", "float32", 2)), 1.7, false, "x", gain);
  judge.add("two threads, float32, node patches",
            timeOf(patched) / timeOf(judge.row("blocks, node patches", "float32", 2)), 1.7, false, "x", gain);
  judge.add("float32 beside the plain double kernel",
            timeOf(judge.body ? judge.body->plain(1) : nullptr) / timeOf(fast), 5, false, "x", "one core each");
  for (const auto& [name, row] : {std::pair("float32", fast), std::pair("int16", packed)})
    judge.add(std::string(name) + ", time over what the ceiling allows", row ? 1 / row->share : nan, 2, true, "x",
              row ? "one core; " + row->ceiling + " binds" : "one core");
  return judge.verdicts;
}

void printMachine(std::ostream& out, const BenchReport& report) {
  const Machine& m = report.machine;
  out << report.build << '\n' << m.processor << ", " << m.cores << (m.cores == 1 ? " core" : " cores");
  if (m.l2_bytes > 0) out << ", L2 " << formatted(static_cast<double>(m.l2_bytes) / (1 << 20)) << " MiB each";
  if (m.l3_bytes > 0) out << ", L3 " << formatted(static_cast<double>(m.l3_bytes) / (1 << 20)) << " MiB";
  out << "\n\n";
  printTable(out, ceilingTable(report));
}

void printBody(std::ostream& out, const BenchBodyResult& body) {
  out << '\n';
  printTable(out, timeTable(body));
  out << '\n';
  printTable(out, costTable(body));
}

void printVerdicts(std::ostream& out, const BenchReport& report) {
  ResultTable table;
  table.title = "Promises, at about 5,000 nodes";
  table.columns = {"Quantity", "Value", "Limit", "Verdict", "Of what"};
  for (const Verdict& v : verdictsOf(report))
    table.rows.push_back({v.bound.quantity, v.missing.empty() ? formatted(v.bound.value, v.bound.unit) : "\u2013",
                          (v.bound.at_most ? "\u2264 " : "\u2265 ") + formatted(v.bound.limit, v.bound.unit), v.text(),
                          v.bound.note + (v.missing.empty() ? "" : " (" + v.missing + ")")});
  out << '\n';
  printTable(out, table);
}

}  // namespace palpate::tools

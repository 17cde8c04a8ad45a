// The JSON of bench_report.h.
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mtled/bench/bench_report.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
double toDouble(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json toJson(const Machine& m) {
  return {{"processor", m.processor}, {"cores", m.cores}, {"l2_bytes", m.l2_bytes}, {"l3_bytes", m.l3_bytes}};
}

Machine toMachine(const Json& j) { return {j.at("processor"), j.at("cores"), j.at("l2_bytes"), j.at("l3_bytes")}; }

Json toJson(const Ceilings& c) {
  Json fma = Json::object(), levels = Json::array();
  for (std::size_t k = 0; k < c.fma_gflops.size(); ++k)
    if (c.fma_gflops[k] > 0) fma[nameOf(static_cast<InstructionSet>(k))] = c.fma_gflops[k];
  for (const MemoryLevel& level : c.levels)
    levels.push_back(
        {{"name", level.name}, {"capacity_bytes", level.capacity}, {"read_gb_per_s", toJson(level.gb_per_s)}});
  return {{"threads", c.threads}, {"fma_float32_gflop_per_s", fma}, {"memory", levels}};
}

Ceilings toCeilings(const Json& j) {
  Ceilings c;
  c.threads = j.at("threads");
  for (const auto set : {InstructionSet::Plain, InstructionSet::Avx2, InstructionSet::Avx512})
    c.fma_gflops.push_back(j.at("fma_float32_gflop_per_s").value(nameOf(set), 0.0));
  for (const Json& level : j.at("memory"))
    c.levels.push_back({level.at("name"), level.at("capacity_bytes"), toDouble(level.at("read_gb_per_s"))});
  return c;
}

/// Every number of a row with its name in the file.
template <class Row, class Each>
void eachNumber(Row& row, Each each) {
  each("best_ns", row.best_ns);
  each("median_ns", row.median_ns);
  each("force_error", row.force_error);
  each("error_limit", row.error_limit);
  each("bytes_per_point", row.bytes);
  each("useful_flops_per_point", row.useful_flops);
  each("executed_flops_per_point", row.executed_flops);
  each("gb_per_s", row.gb_per_s);
  each("gflop_per_s", row.gflop_per_s);
  each("ceiling_ns", row.ceiling_ns);
  each("share_of_ceiling", row.share);
}

Json toJson(const BenchRow& row) {
  Json j = {{"kernel", row.kernel},
            {"precision", row.precision},
            {"instruction_set", row.instruction_set},
            {"threads", row.threads},
            {"ceiling", row.ceiling}};
  eachNumber(row, [&](const char* name, double value) { j[name] = toJson(value); });
  return j;
}

BenchRow toRow(const Json& j) {
  BenchRow row;
  row.kernel = j.at("kernel");
  row.precision = j.at("precision");
  row.instruction_set = j.at("instruction_set");
  row.threads = j.at("threads");
  row.ceiling = j.at("ceiling");
  eachNumber(row, [&](const char* name, double& value) { value = toDouble(j.at(name)); });
  return row;
}

Json toJson(const BenchBodyResult& body) {
  Json rows = Json::array();
  for (const BenchRow& row : body.rows) rows.push_back(toJson(row));
  return {{"name", body.name},
          {"nodes", body.nodes},
          {"points", body.points},
          {"mean_support", toJson(body.mean_support)},
          {"setup_seconds", toJson(body.setup_seconds)},
          {"rows", rows}};
}

BenchBodyResult toBody(const Json& j) {
  BenchBodyResult body{
      j.at("name"), j.at("nodes"), j.at("points"), toDouble(j.at("mean_support")), toDouble(j.at("setup_seconds")), {}};
  for (const Json& row : j.at("rows")) body.rows.push_back(toRow(row));
  return body;
}

Json toJson(const Verdict& v) {
  return {{"quantity", v.bound.quantity}, {"value", toJson(v.bound.value)},
          {"limit", v.bound.limit},       {"at_most", v.bound.at_most},
          {"unit", v.bound.unit},         {"note", v.bound.note},
          {"verdict", v.text()},          {"missing", v.missing}};
}

}  // namespace

std::string jsonOf(const BenchReport& report) {
  Json ceilings = Json::array(), bodies = Json::array(), verdicts = Json::array();
  for (const Ceilings& c : report.ceilings) ceilings.push_back(toJson(c));
  for (const BenchBodyResult& body : report.bodies) bodies.push_back(toJson(body));
  for (const Verdict& v : verdictsOf(report)) verdicts.push_back(toJson(v));
  const Json json = {{"command", report.command}, {"build", report.build}, {"machine", toJson(report.machine)},
                     {"ceilings", ceilings},      {"bodies", bodies},      {"verdicts", verdicts}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

BenchReport benchReportFromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    BenchReport report;
    report.command = json.at("command");
    report.build = json.at("build");
    report.machine = toMachine(json.at("machine"));
    for (const Json& c : json.at("ceilings")) report.ceilings.push_back(toCeilings(c));
    for (const Json& body : json.at("bodies")) report.bodies.push_back(toBody(body));
    return report;
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(std::string("benchmark in JSON: ") + error.what());
  }
}

}  // namespace palpate::tools

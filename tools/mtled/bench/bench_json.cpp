// The JSON of bench_report.h.
#include <nlohmann/json.hpp>

#include "mtled/bench/bench_report.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const Machine& m) {
  return {{"processor", m.processor}, {"cores", m.cores}, {"l2_bytes", m.l2_bytes}, {"l3_bytes", m.l3_bytes}};
}

Json toJson(const Ceilings& c) {
  Json fma = Json::object(), levels = Json::array();
  for (std::size_t k = 0; k < c.fma_gflops.size(); ++k)
    if (c.fma_gflops[k] > 0) fma[nameOf(static_cast<InstructionSet>(k))] = c.fma_gflops[k];
  for (const MemoryLevel& level : c.levels)
    levels.push_back({{"name", level.name}, {"capacity_bytes", level.capacity}, {"read_gb_per_s", level.gb_per_s}});
  return {{"threads", c.threads}, {"fma_float32_gflop_per_s", fma}, {"memory", levels}};
}

Json toJson(const BenchRow& row) {
  return {{"kernel", row.kernel},
          {"precision", row.precision},
          {"instruction_set", row.instruction_set},
          {"threads", row.threads},
          {"ceiling", row.ceiling},
          {"best_ns", row.best_ns},
          {"median_ns", row.median_ns},
          {"force_error", row.force_error},
          {"error_limit", row.error_limit},
          {"bytes_per_point", row.bytes},
          {"useful_flops_per_point", row.useful_flops},
          {"executed_flops_per_point", row.executed_flops},
          {"gb_per_s", row.gb_per_s},
          {"gflop_per_s", row.gflop_per_s},
          {"ceiling_ns", row.ceiling_ns},
          {"share_of_ceiling", row.share}};
}

Json toJson(const BenchBodyResult& body) {
  Json rows = Json::array();
  for (const BenchRow& row : body.rows) rows.push_back(toJson(row));
  return {{"name", body.name},
          {"nodes", body.nodes},
          {"points", body.points},
          {"mean_support", body.mean_support},
          {"setup_seconds", body.setup_seconds},
          {"rows", rows}};
}

Json toJson(const Verdict& v) {
  return {{"quantity", v.bound.quantity}, {"value", v.bound.value}, {"limit", v.bound.limit},
          {"at_most", v.bound.at_most},   {"unit", v.bound.unit},   {"note", v.bound.note},
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

}  // namespace palpate::tools

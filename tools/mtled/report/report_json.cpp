// The JSON of tools/mtled/report/report_page.h.
#include <cmath>
#include <nlohmann/json.hpp>

#include "mtled/report/report_page.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no word for these, and null would not tell them apart.
Json toJson(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

Json toJson(const Bound& b) {
  return {{"quantity", b.quantity}, {"value", toJson(b.value)}, {"limit", toJson(b.limit)}, {"at_most", b.at_most},
          {"unit", b.unit},         {"note", b.note},           {"held", b.held()}};
}

Json toJson(const CaseResult& one) {
  Json bounds = Json::array(), tables = Json::array(), figures = Json::array();
  for (const Bound& b : one.bounds) bounds.push_back(toJson(b));
  for (const ResultTable& t : one.tables)
    tables.push_back({{"title", t.title}, {"columns", t.columns}, {"rows", t.rows}, {"note", t.note}});
  for (const CaseFigure& f : one.figures) figures.push_back({{"file", f.file}, {"caption", f.caption}});
  return {{"name", one.name},           {"title", one.title}, {"held", one.held()},
          {"reference", one.reference}, {"text", one.text},   {"seconds", toJson(one.seconds)},
          {"bounds", bounds},           {"tables", tables},   {"figures", figures}};
}

}  // namespace

std::string jsonOf(const Report& report) {
  Json cases = Json::array();
  for (const CaseResult& one : report.cases) cases.push_back(toJson(one));
  const Json json = {
      {"title", report.title},     {"intro", report.intro}, {"held", report.held()}, {"missing", report.missing},
      {"command", report.command}, {"build", report.build}, {"cases", cases}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpate::tools

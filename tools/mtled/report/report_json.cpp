// The JSON of tools/mtled/report/report_page.h.
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

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

double toDouble(const Json& json) {
  if (!json.is_string()) return json.get<double>();
  const std::string text = json.get<std::string>();
  if (text == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (text == "inf") return std::numeric_limits<double>::infinity();
  if (text == "-inf") return -std::numeric_limits<double>::infinity();
  throw std::runtime_error("'" + text + "' is no number");
}

Json toJson(const Bound& b) {
  return {{"quantity", b.quantity}, {"value", toJson(b.value)}, {"limit", toJson(b.limit)}, {"at_most", b.at_most},
          {"unit", b.unit},         {"note", b.note},           {"held", b.held()}};
}

Bound toBound(const Json& j) {
  return {j.at("quantity"), toDouble(j.at("value")), toDouble(j.at("limit")), j.at("at_most"), j.at("unit"),
          j.at("note")};
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

CaseResult toCase(const Json& j) {
  CaseResult one;
  one.name = j.at("name");
  one.title = j.at("title");
  one.reference = j.at("reference");
  one.text = j.at("text");
  one.seconds = toDouble(j.at("seconds"));
  for (const Json& b : j.at("bounds")) one.bounds.push_back(toBound(b));
  for (const Json& t : j.at("tables"))
    one.tables.push_back({t.at("title"), t.at("columns").get<std::vector<std::string>>(),
                          t.at("rows").get<std::vector<std::vector<std::string>>>(), t.at("note")});
  for (const Json& f : j.at("figures")) one.figures.push_back({f.at("file"), f.at("caption")});
  return one;
}

}  // namespace

std::string jsonOf(const Report& report) {
  Json cases = Json::array();
  for (const CaseResult& one : report.cases) cases.push_back(toJson(one));
  const Json json = {{"title", report.title},     {"intro", report.intro}, {"held", report.held()},
                     {"command", report.command}, {"build", report.build}, {"cases", cases}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Report reportFromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    Report report{json.at("title"), json.at("intro"), json.at("command"), json.at("build"), {}};
    for (const Json& one : json.at("cases")) report.cases.push_back(toCase(one));
    return report;
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(std::string("report in JSON: ") + error.what());
  }
}

}  // namespace palpate::tools

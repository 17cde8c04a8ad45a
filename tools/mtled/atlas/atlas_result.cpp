#include "mtled/atlas/atlas_result.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "io/result_csv.h"
#include "mtled/report/case_result.h"
#include "mtled/report/report_page.h"
#include "mtled/report/vector_json.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

bool doubtedBefore(const AtlasMeasure& m, double time) { return m.doubt_at < time; }

bool isWrong(const AtlasMeasure& m) { return !m.compared.empty() && !(std::abs(m.deviation) <= m.bound); }

/// Every field of what was measured, but why it was refused, with its name in the file.
template <class Measure, class Each>
void eachField(Measure& m, Each each) {
  each("nodes", m.nodes);
  each("points", m.points);
  each("steps", m.steps);
  each("doubt", m.doubt);
  each("doubt_at_s", m.doubt_at);
  each("doubted_for_s", m.doubted_for);
  each("loss", m.loss);
  each("lost_at_s", m.lost_at);
  each("restored", m.restored);
  each("energy_error", m.energy_error);
  each("step_share", m.step_share);
  each("min_J", m.min_J);
  each("energy_growth", m.growth);
  each("compared", m.compared);
  each("deviation", m.deviation);
  each("bound", m.bound);
  each("doubted_then", m.doubted_then);
}

}  // namespace

const char* outcomeName(AtlasOutcome outcome) {
  switch (outcome) {
    case AtlasOutcome::Stable:
      return "stable";
    case AtlasOutcome::Degraded:
      return "degraded";
    case AtlasOutcome::Refused:
      return "refused";
    case AtlasOutcome::Silent:
      return "SILENT";
  }
  return "";
}

AtlasOutcome outcomeOf(const AtlasMeasure& m) {
  if (!m.refused.empty()) return AtlasOutcome::Refused;
  // What was lost is compared with nothing: the doubt has to come first.
  if (!std::isnan(m.lost_at)) return doubtedBefore(m, m.lost_at) ? AtlasOutcome::Degraded : AtlasOutcome::Silent;
  if (isWrong(m)) return m.doubted_then ? AtlasOutcome::Degraded : AtlasOutcome::Silent;
  if (!std::isnan(m.doubt_at)) return AtlasOutcome::Degraded;
  return m.growth <= atlas_growth_bound ? AtlasOutcome::Stable : AtlasOutcome::Silent;
}

std::string howMuch(const AtlasMeasure& m) {
  if (!m.refused.empty()) return m.refused;
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (!std::isnan(m.doubt_at))
    add("amber '" + m.doubt + "' from " + formatted(m.doubt_at, "s") +
        (m.doubted_then || !std::isnan(m.lost_at) ? "" : ", for " + formatted(m.doubted_for, "s")));
  if (!std::isnan(m.lost_at)) {
    add("lost at " + formatted(m.lost_at, "s") + " (" + m.loss + ")");
    return text;
  }
  if (!m.compared.empty()) {
    add(m.compared + " " + formattedSigned(100 * m.deviation, "%"));
    if (isWrong(m)) text += " (bound " + formattedPercent(m.bound) + (m.doubted_then ? ")" : ", not doubted then)");
  }
  if (m.restored > 0) add("put back " + std::to_string(m.restored) + (m.restored == 1 ? " time" : " times"));
  if (!(m.growth <= atlas_growth_bound)) add("energy grew by " + formattedPercent(m.growth));
  return text;
}

int Atlas::count(AtlasOutcome outcome) const {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [&](const AtlasRow& r) { return outcomeOf(r.measure) == outcome; }));
}

void printAtlas(std::ostream& out, const Atlas& atlas) {
  ResultTable table{
      "", {"cell", "nodes", "points", "steps", "outcome", "min J", "energy error", "time", "how much"}, {}, ""};
  for (const auto& r : atlas.rows) {
    const AtlasMeasure& m = r.measure;
    const bool ran = m.refused.empty() && m.steps > 0;
    table.rows.push_back({r.name, m.nodes > 0 ? std::to_string(m.nodes) : "",
                          m.points > 0 ? std::to_string(m.points) : "", ran ? formatted(m.steps) : "",
                          outcomeName(outcomeOf(m)), ran ? formatted(m.min_J) : "",
                          ran ? formatted(m.energy_error) : "", formatted(r.seconds, "s"), howMuch(m)});
  }
  printTable(out, table);
  out << "\n  " << atlas.rows.size() << " cells: " << atlas.count(AtlasOutcome::Stable) << " stable, "
      << atlas.count(AtlasOutcome::Degraded) << " degraded, " << atlas.count(AtlasOutcome::Refused) << " refused, "
      << atlas.count(AtlasOutcome::Silent) << " silently wrong\n";
}

std::string csvOf(const Atlas& atlas) {
  std::ostringstream out;
  out.precision(9);
  out << "axis,cell,value,outcome,";
  AtlasMeasure none;
  eachField(none, [&](const char* name, const auto&) { out << name << ','; });
  out << "wall_s,how_much\n";
  for (const auto& r : atlas.rows) {
    out << csvQuoted(r.axis) << ',' << csvQuoted(r.name) << ',' << csvQuoted(r.value) << ','
        << outcomeName(outcomeOf(r.measure)) << ',';
    eachField(r.measure, [&](const char*, const auto& value) { putCsv(out, value) << ','; });
    out << r.seconds << ',' << csvQuoted(howMuch(r.measure)) << '\n';
  }
  return out.str();
}

std::string jsonOf(const Atlas& atlas) {
  Json rows = Json::array();
  for (const auto& r : atlas.rows) {
    Json j = {{"axis", r.axis}, {"cell", r.name}, {"value", r.value}, {"outcome", outcomeName(outcomeOf(r.measure))}};
    j["refused"] = r.measure.refused;
    eachField(r.measure, [&](const char* name, const auto& value) { j[name] = value; });
    j["wall_s"] = r.seconds;
    j["how_much"] = howMuch(r.measure);
    rows.push_back(std::move(j));
  }
  const Json json = {{"build", atlas.build}, {"identity", atlas.identity}, {"rows", rows}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Atlas atlasFromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    Atlas atlas{json.at("build"), json.at("identity"), {}};
    for (const Json& j : json.at("rows")) {
      AtlasRow r{j.at("axis"), j.at("cell"), j.at("value"), {}, 0};
      readJson(j.at("wall_s"), r.seconds);
      r.measure.refused = j.at("refused");
      eachField(r.measure, [&](const char* name, auto& value) { readJson(j.at(name), value); });
      atlas.rows.push_back(std::move(r));
    }
    return atlas;
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(std::string("atlas in JSON: ") + error.what());
  }
}

}  // namespace palpate::tools

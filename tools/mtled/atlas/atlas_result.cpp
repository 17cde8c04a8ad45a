#include "mtled/atlas/atlas_result.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "io/result_csv.h"
#include "mtled/report/case_result.h"
#include "mtled/report/report_page.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
double toDouble(const Json& json) { return json.is_null() ? NAN : json.get<double>(); }

bool doubtedBefore(const AtlasMeasure& m, double time) { return m.doubt_at < time; }

bool isWrong(const AtlasMeasure& m) { return !m.compared.empty() && !(std::abs(m.deviation) <= m.bound); }

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
  out << "axis,cell,value,outcome,nodes,points,steps,doubt,doubt_at_s,doubted_for_s,loss,lost_at_s,restored,energy_"
         "error,step_"
         "share,min_J,energy_growth,compared,"
         "deviation,bound,doubted_then,wall_s,how_much\n";
  for (const auto& r : atlas.rows) {
    const AtlasMeasure& m = r.measure;
    out << csvQuoted(r.axis) << ',' << csvQuoted(r.name) << ',' << csvQuoted(r.value) << ','
        << outcomeName(outcomeOf(m)) << ',' << m.nodes << ',' << m.points << ',' << m.steps << ',' << m.doubt << ','
        << m.doubt_at << ',' << m.doubted_for << ',' << csvQuoted(m.loss) << ',' << m.lost_at << ',' << m.restored
        << ',' << m.energy_error << ',' << m.step_share << ',' << m.min_J << ',' << m.growth << ','
        << csvQuoted(m.compared) << ',' << m.deviation << ',' << m.bound << ',' << m.doubted_then << ',' << r.seconds
        << ',' << csvQuoted(howMuch(m)) << '\n';
  }
  return out.str();
}

std::string jsonOf(const Atlas& atlas) {
  Json rows = Json::array();
  for (const auto& r : atlas.rows) {
    const AtlasMeasure& m = r.measure;
    rows.push_back({{"axis", r.axis},
                    {"cell", r.name},
                    {"value", r.value},
                    {"outcome", outcomeName(outcomeOf(m))},
                    {"refused", m.refused},
                    {"nodes", m.nodes},
                    {"points", m.points},
                    {"steps", toJson(m.steps)},
                    {"doubt", m.doubt},
                    {"doubt_at_s", toJson(m.doubt_at)},
                    {"doubted_for_s", m.doubted_for},
                    {"loss", m.loss},
                    {"lost_at_s", toJson(m.lost_at)},
                    {"restored", m.restored},
                    {"energy_error", toJson(m.energy_error)},
                    {"step_share", toJson(m.step_share)},
                    {"min_J", toJson(m.min_J)},
                    {"energy_growth", toJson(m.growth)},
                    {"compared", m.compared},
                    {"deviation", toJson(m.deviation)},
                    {"bound", toJson(m.bound)},
                    {"doubted_then", m.doubted_then},
                    {"wall_s", toJson(r.seconds)},
                    {"how_much", howMuch(m)}});
  }
  const Json json = {{"build", atlas.build}, {"identity", atlas.identity}, {"rows", rows}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Atlas atlasFromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    Atlas atlas{json.at("build"), json.at("identity"), {}};
    for (const Json& j : json.at("rows")) {
      AtlasRow r;
      r.axis = j.at("axis");
      r.name = j.at("cell");
      r.value = j.at("value");
      r.seconds = toDouble(j.at("wall_s"));
      AtlasMeasure& m = r.measure;
      m.refused = j.at("refused");
      m.nodes = j.at("nodes");
      m.points = j.at("points");
      m.steps = toDouble(j.at("steps"));
      m.doubt = j.at("doubt");
      m.doubt_at = toDouble(j.at("doubt_at_s"));
      m.doubted_for = j.at("doubted_for_s");
      m.loss = j.at("loss");
      m.lost_at = toDouble(j.at("lost_at_s"));
      m.restored = j.at("restored");
      m.energy_error = toDouble(j.at("energy_error"));
      m.step_share = toDouble(j.at("step_share"));
      m.min_J = toDouble(j.at("min_J"));
      m.growth = toDouble(j.at("energy_growth"));
      m.compared = j.at("compared");
      m.deviation = toDouble(j.at("deviation"));
      m.bound = toDouble(j.at("bound"));
      m.doubted_then = j.at("doubted_then");
      atlas.rows.push_back(std::move(r));
    }
    return atlas;
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(std::string("atlas in JSON: ") + error.what());
  }
}

}  // namespace palpate::tools

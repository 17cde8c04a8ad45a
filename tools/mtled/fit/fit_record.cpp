#include "mtled/fit/fit_record.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/input_error.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "mtled/report/vector_json.h"

namespace palpate::tools {

namespace {

using Json = nlohmann::json;

/// Every field with its name in the file, but for the forces and displacements.
template <class Try, class Each>
void eachField(Try& t, Each each) {
  each("family", t.family);
  each("spacing_factor", t.spacing_factor);
  each("nodes", t.nodes);
  each("points", t.points);
  each("substeps", t.substeps);
  each("us_per_ms", t.cost.us_per_ms);
  each("tick_p50_us", t.cost.tick_p50);
  each("tick_p999_us", t.cost.tick_p999);
  each("flags", t.run.flags);
  each("min_J", t.run.min_J);
}

}  // namespace

void FitRecord::resume() {
  if (!std::filesystem::exists(file_))
    throw InputError({file_}, "there is nothing to resume", "start without --resume");
  std::vector<FitTry> tries;
  try {
    const Json json = Json::parse(readWholeFile(file_));
    if (json.at("identity") != identity_)
      throw InputError({file_}, "this is of another scene, way, rate, number of cores or program",
                       "start without --resume");
    for (const Json& j : json.at("tries")) {
      FitTry one;
      eachField(one, [&](const char* name, auto& value) { j.at(name).get_to(value); });
      one.run.force = vectorsFromJson(j.at("force_N"));
      one.run.probe_u = vectorsFromJson(j.at("probe_u_m"));
      tries.push_back(std::move(one));
    }
  } catch (const Json::exception&) {
    throw InputError({file_}, "this is no record of a fit, or a damaged one", "start without --resume");
  }
  tries_ = std::move(tries);
}

const FitTry* FitRecord::find(const std::string& family, double spacing_factor) const {
  const auto found = std::find_if(tries_.begin(), tries_.end(), [&](const FitTry& t) {
    return t.family == family && std::abs(t.spacing_factor - spacing_factor) <= 1e-9 * spacing_factor;
  });
  return found == tries_.end() ? nullptr : &*found;
}

void FitRecord::add(const FitTry& one) {
  tries_.push_back(one);
  Json tries = Json::array();
  for (const FitTry& t : tries_) {
    Json j = {{"force_N", vectorsToJson(t.run.force)}, {"probe_u_m", vectorsToJson(t.run.probe_u)}};
    eachField(t, [&](const char* name, const auto& value) { j[name] = value; });
    tries.push_back(std::move(j));
  }
  const Json json = {{"identity", identity_}, {"tries", tries}};
  writeWholeFile(file_, json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace palpate::tools

#include "mtled/fit/fit_record.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/input_error.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "mtled/report/vector_json.h"

namespace palpate::tools {

using Json = nlohmann::json;

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
      FitTry one{j.at("family"),
                 j.at("spacing_factor"),
                 j.at("nodes"),
                 j.at("points"),
                 j.at("substeps"),
                 {j.at("us_per_ms"), j.at("tick_p50_us"), j.at("tick_p999_us")},
                 {}};
      one.run.force = vectorsFromJson(j.at("force_N"));
      one.run.probe_u = vectorsFromJson(j.at("probe_u_m"));
      one.run.flags = j.at("flags");
      one.run.min_J = j.at("min_J");
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
  for (const FitTry& t : tries_)
    tries.push_back({{"family", t.family},
                     {"spacing_factor", t.spacing_factor},
                     {"nodes", t.nodes},
                     {"points", t.points},
                     {"substeps", t.substeps},
                     {"us_per_ms", t.cost.us_per_ms},
                     {"tick_p50_us", t.cost.tick_p50},
                     {"tick_p999_us", t.cost.tick_p999},
                     {"flags", t.run.flags},
                     {"min_J", t.run.min_J},
                     {"force_N", vectorsToJson(t.run.force)},
                     {"probe_u_m", vectorsToJson(t.run.probe_u)}});
  const Json json = {{"identity", identity_}, {"tries", tries}};
  writeWholeFile(file_, json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace palpate::tools

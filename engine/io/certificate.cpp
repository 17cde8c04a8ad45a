#include "io/certificate.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/number_text.h"
#include "io/output_file.h"

namespace palpate {

using Json = nlohmann::ordered_json;

const Certificate::Row* Certificate::at(double advance) const {
  const auto found = std::find_if(row.begin(), row.end(), [=](const Row& r) { return advance <= r.advance; });
  return found == row.end() ? nullptr : &*found;
}

bool hasOneWay(const Scene& scene) { return scene.tools.size() == 1 && !scene.tools[0].jaws(); }

std::string certificateFile(const std::string& scene_file) {
  return std::filesystem::path(scene_file).replace_extension(".certificate.json").string();
}

void writeCertificate(const std::string& file, const Certificate& c) {
  Json rows = Json::array();
  for (const Certificate::Row& r : c.row)
    rows.push_back(
        {{"advance_m", r.advance}, {"force_N", r.force}, {"force_error", r.error}, {"uncertainty", r.uncertainty}});
  const Json json = {{"model_hash", hex16(c.model_hash)},
                     {"script", c.script},
                     {"rows", rows},
                     {"displacement_error", c.displacement_error}};
  writeWholeFile(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<Certificate> readCertificate(const std::string& file, std::uint64_t model_hash) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  try {
    const Json json = Json::parse(in);
    if (json.at("model_hash") != hex16(model_hash)) return {};
    Certificate c;
    c.model_hash = model_hash;
    c.script = json.at("script");
    c.displacement_error = json.at("displacement_error");
    for (const Json& r : json.at("rows"))
      c.row.push_back({r.at("advance_m"), r.at("force_N"), r.at("force_error"), r.at("uncertainty")});
    return c;
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

std::string certifiedText(const Certificate& certificate, double advance) {
  const Certificate::Row* const row = certificate.at(advance);
  const double deepest = 1e3 * certificate.deepest();
  if (row == nullptr) return format("beyond the certified %.3g mm", deepest);
  return format("±%.2g %% (certified to %.3g mm)", 100 * (row->error + row->uncertainty), deepest);
}

}  // namespace palpate

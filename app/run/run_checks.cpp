#include "app/run/run_checks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/render/picture_difference.h"
#include "base/build_info.h"
#include "base/input_error.h"
#include "base/number_text.h"
#include "io/text_file.h"

namespace palpate::app {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_baseline_bytes = 1 << 20;  // of a baseline
constexpr double spots_per_tolerance = 0.004;  // share of strongly different pixels: 0.002 at the default tolerance

bool isClear(const Json& wanted) {
  if (wanted.is_string() || wanted.is_number_integer() || wanted.is_boolean()) return true;
  return wanted.is_object() && wanted.contains("value") && wanted["value"].is_number() &&
         (wanted.contains("abs") || wanted.contains("rel")) && wanted.value("abs", 0.0) >= 0 &&
         wanted.value("rel", 0.0) >= 0;
}

}  // namespace

Baseline::Baseline(const std::string& file) : file_(file), text_(readWholeFile(file, {}, most_baseline_bytes)) {
  const Json json = Json::parse(text_, nullptr, false);
  if (!json.is_object()) throw InputError({file}, "no JSON object", "give one whose keys are those of report.json");
  for (const auto& [key, wanted] : json.items()) {
    bool fine = false;
    try {
      fine = isClear(wanted);
    } catch (const Json::exception&) {  // a tolerance that is no number
    }
    if (!fine)
      throw InputError({file}, "\"" + key + "\" is neither a text nor a whole number nor a value with a tolerance",
                       R"(write e.g. "peak_force_N": {"value": 0.5, "rel": 0.01})");
  }
}

std::vector<std::string> Baseline::differences(const std::string& report_text) const {
  const Json report = Json::parse(report_text), baseline = Json::parse(text_);
  std::vector<std::string> lines;
  for (const auto& [key, wanted] : baseline.items()) {
    if (!report.contains(key)) {
      lines.push_back(file_ + ": the report has no \"" + key + "\"");
      continue;
    }
    const Json& got = report[key];
    if (!wanted.is_object()) {
      if (got != wanted) lines.push_back(key + " is " + got.dump() + ", not " + wanted.dump());
      continue;
    }
    const double value = wanted["value"].get<double>();
    const double allowed = std::max(wanted.value("abs", 0.0), wanted.value("rel", 0.0) * std::abs(value));
    const bool near = got.is_number() && std::abs(got.get<double>() - value) <= allowed;
    if (!near) lines.push_back(key + " is " + got.dump() + ", not " + shortest(value) + " +- " + shortest(allowed));
  }
  return lines;
}

std::string pictureDifference(const Picture& reference, const Picture& picture, double tolerance,
                              const std::string& image) {
  if (reference.width != picture.width || reference.height != picture.height)
    return format("the picture has %d x %d pixels, the reference %d x %d", picture.width, picture.height,
                  reference.width, reference.height);
  const PictureDifference found = difference(reference, picture);
  if (looksSame(found, tolerance, spots_per_tolerance * tolerance)) return {};
  if (!image.empty()) writePng(image, found.image);
  return format(
             "the picture differs from the reference: mean delta E %.3f (tolerance %.3g), %.3f %% of the pixels "
             "strongly",
             found.mean, tolerance, 100 * found.strong_share) +
         (image.empty() ? "" : "; where: " + image);
}

std::string toJson(const Manifest& m) {
  const Json json = {{"scene", m.scene_file}, {"scene_hash", m.scene_hash}, {"model_hash", m.model_hash},
                     {"build", buildInfo()},  {"opengl", m.opengl},         {"command", m.command},
                     {"width", m.width},      {"height", m.height},         {"picture_times_s", m.picture_times_s},
                     {"files", m.files}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpate::app

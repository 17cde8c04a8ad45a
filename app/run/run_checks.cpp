#include "app/run/run_checks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/render/picture_difference.h"
#include "base/build_info.h"
#include "base/input_error.h"
#include "base/nearest_word.h"
#include "base/number_text.h"
#include "io/json_text.h"
#include "io/text_file.h"

namespace palpate::app {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_baseline_bytes = 1 << 20;  // of a baseline
constexpr double spots_per_tolerance = 0.004;  // share of strongly different pixels: 0.002 at the default tolerance

bool isClear(const Json& wanted) {
  if (wanted.is_string() || wanted.is_number_integer() || wanted.is_boolean() || wanted.is_null()) return true;
  if (!wanted.is_object() || !wanted.contains("value") || !wanted["value"].is_number()) return false;
  const std::size_t limits = wanted.count("abs") + wanted.count("rel");
  return limits > 0 && wanted.size() == 1 + limits && wanted.value("abs", 0.0) >= 0 && wanted.value("rel", 0.0) >= 0;
}

/// Where a key stands first in the text.
SourceLocation placeOf(const std::string& file, const std::string& text, const std::string& key) {
  const std::size_t at = text.find(Json(key).dump());
  if (at == std::string::npos) return {file};  // written with escapes
  return {file, 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'))};
}

/// What a baseline may want of such a value; "": nothing.
std::string kindOf(const Json& value) {
  if (value.is_string()) return "a text";
  if (value.is_boolean()) return "true or false";
  return value.is_number() || value.is_null() ? "a number" : "";
}

/// Throws where the report won't have the key, or something else under it.
void checkKey(const SourceLocation& place, const std::string& key, const Json& wanted, const Json& report) {
  if (!report.contains(key)) {
    std::vector<std::string> known;
    for (const auto& [name, value] : report.items())
      if (!kindOf(value).empty()) known.push_back(name);
    const std::string nearest = nearestWord(key, known);
    throw InputError(place, "this run's report.json will have no " + inQuotes(key),
                     nearest.empty() ? "it has " + listed(known, "and") : "did you mean \"" + nearest + "\"?");
  }
  const std::string kind = kindOf(report[key]);
  if (kind.empty())
    throw InputError(place, inQuotes(key) + " is a list in report.json, which can't be compared", "leave it out");
  if (kind != (wanted.is_object() ? "a number" : kindOf(wanted)))
    throw InputError(place, inQuotes(key) + " is " + kind + " in report.json", "give one");
}

}  // namespace

Baseline::Baseline(const std::string& file, const std::string& blank_report)
    : file_(file), text_(readWholeFile(file, {}, most_baseline_bytes)) {
  const Json json = Json::parse(text_, nullptr, false), report = Json::parse(blank_report);
  if (!json.is_object() || json.empty())
    throw InputError({file}, json.is_object() ? "nothing to compare" : "no JSON object",
                     "give an object whose keys are those of report.json");
  if (const std::string key = doubledKey(text_); !key.empty())
    throw InputError(placeOf(file, text_, key), inQuotes(key) + " stands there twice", "leave one out");
  for (const auto& [key, wanted] : json.items()) {
    const SourceLocation place = placeOf(file, text_, key);
    bool fine = false;
    try {
      fine = isClear(wanted);
    } catch (const Json::exception&) {  // a tolerance that is no number
    }
    if (!fine)
      throw InputError(place,
                       "\"" + key + "\" is neither a text nor a whole number nor null nor a value with a tolerance",
                       R"(write e.g. "peak_force_N": {"value": 0.5, "rel": 0.01})");
    checkKey(place, key, wanted, report);
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
  const double most_strong = spots_per_tolerance * tolerance;
  if (looksSame(found, tolerance, most_strong)) return {};
  if (!image.empty()) writePng(image, found.image);
  const auto verdict = [](bool within) { return within ? "within" : "more than"; };
  return format(
             "the picture differs from the reference: mean delta E %.3f, %s the %.3g of --tolerance; %.3f %% of the "
             "pixels differ by a delta E of more than %g, %s the %.3g %% that go with it",
             found.mean, verdict(found.mean <= tolerance), tolerance, 100 * found.strong_share,
             PictureDifference::strong_delta_E, verdict(found.strong_share <= most_strong), 100 * most_strong) +
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

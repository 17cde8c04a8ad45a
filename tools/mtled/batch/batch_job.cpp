#include "mtled/batch/batch_job.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/nearest_word.h"
#include "io/json_text.h"
#include "io/text_file.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::json;

const std::vector<std::string> members{"id", "scene", "set", "tool", "seconds", "field", "picture"};
constexpr std::size_t max_id = 100;

/// A value as TOML writes it: for numbers, words and lists of them the same as JSON does.
std::string tomlValue(const Json& value, const SourceLocation& place, const std::string& key) {
  const bool plain = value.is_number() || value.is_boolean() || value.is_string() || value.is_array();
  if (!plain) throw InputError(place, "\"set\" gives " + inQuotes(key) + " no value", "write a number, text or list");
  return value.dump(-1, ' ', true);
}

void checkId(const std::string& id, const SourceLocation& place) {
  const auto allowed = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.';
  };
  if (id.empty() || id.size() > max_id || id.front() == '.' || !std::all_of(id.begin(), id.end(), allowed))
    throw InputError(place, inQuotes(id) + " can't be the name of a folder", "use letters, digits, -, _ and .");
  if (id == "results.jsonl" || id == "batch.json")
    throw InputError(place, inQuotes(id) + " is a file that the batch writes itself", "give the job another id");
}

/// A file beside the jobs' own, or what was said.
std::string besideJobs(const std::string& said, const std::string& jobs) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path beside = fs::path(jobs).parent_path() / said;
  return !said.empty() && fs::is_regular_file(beside, ignored) ? beside.string() : said;
}

BatchJob jobFrom(const Json& json, const SourceLocation& place) {
  if (!json.is_object()) throw InputError(place, "a job is no JSON object", "write {\"scene\": \"liver\"}");
  for (const auto& [key, value] : json.items())
    if (std::find(members.begin(), members.end(), key) == members.end())
      throw InputError(place, "a job has no " + inQuotes(key), "there are " + listed(members, "and"));
  const auto wrong = [&](const char* key, const char* what) {
    return InputError(place, std::string("\"") + key + "\" is no " + what, "");
  };
  const auto text = [&](const char* key, std::string& into) {
    if (!json.contains(key)) return;
    if (!json[key].is_string()) throw wrong(key, "text");
    into = json[key].get<std::string>();
  };
  BatchJob job;
  job.id = "job-" + std::to_string(place.line);
  text("id", job.id);
  text("scene", job.scene);
  text("tool", job.tool);
  job.scene = besideJobs(job.scene, place.file);
  job.tool = besideJobs(job.tool, place.file);
  checkId(job.id, place);
  if (job.scene.empty()) throw InputError(place, "a job without a scene", "add \"scene\": a file or a scene's name");
  if (json.contains("seconds")) {
    const Json& seconds = json["seconds"];
    if (!seconds.is_number() || !(seconds.get<double>() > 0 && seconds.get<double>() <= 1e5))
      throw wrong("seconds", "number above 0 and up to 1e5");
    job.seconds = seconds.get<double>();
  }
  if (json.contains("field")) {
    const Json& field = json["field"];
    if (!field.is_boolean() && field != "vtu" && field != "npz")
      throw InputError(place, "\"field\" is none of true, false, \"vtu\" and \"npz\"", "");
    job.field = field.is_string() ? field.get<std::string>() : field.get<bool>() ? "vtu" : "";
  }
  if (json.contains("picture")) {
    if (!json["picture"].is_boolean()) throw InputError(place, "\"picture\" is neither true nor false", "");
    job.picture = json["picture"].get<bool>();
  }
  if (json.contains("set")) {
    if (!json["set"].is_object()) throw wrong("set", "object of keys and values");
    for (const auto& [key, value] : json["set"].items()) job.changes.push_back({key, tomlValue(value, place, key)});
  }
  job.text = json.dump(-1, ' ', true);
  return job;
}

/// Each line of a file that is not blank, parsed. @param each  gets the JSON and its place
template <class Each>
void forEachLine(const std::string& path, Each each) {
  std::istringstream lines(readWholeFile(path));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const SourceLocation place{path, number, 0};
    const Json json = Json::parse(line, nullptr, false);
    if (json.is_discarded()) throw InputError(place, "this line is no JSON", "write one job in each line");
    if (const std::string key = doubledKey(line); !key.empty())
      throw InputError(place, inQuotes(key) + " stands there twice", "leave one out");
    each(json, place);
  }
}

}  // namespace

std::string BatchJob::modelKey() const {
  std::string key = scene;
  for (const SceneChange& change : changes) key += "\n" + change.key + " = " + change.value;
  return key;
}

std::vector<BatchJob> readBatchJobs(const std::string& path) {
  std::vector<BatchJob> jobs;
  std::set<std::string> ids;
  forEachLine(path, [&](const Json& json, const SourceLocation& place) {
    jobs.push_back(jobFrom(json, place));
    if (!ids.insert(jobs.back().id).second)
      throw InputError(place, "there is a job " + inQuotes(jobs.back().id) + " before", "give each an id of its own");
  });
  if (jobs.empty()) throw InputError({path}, "there is no job", "write one in each line: {\"scene\": \"liver\"}");
  return jobs;
}

std::string toLine(const BatchResult& r) {
  nlohmann::ordered_json json{{"id", r.id}, {"done", r.done}};
  if (!r.done) json["reason"] = r.reason;
  json["ticks"] = r.ticks;
  json["seconds"] = r.seconds;
  json["state_hash"] = r.state_hash;
  json["peak_force_N"] = r.peak_force;
  json["last_force_N"] = r.last_force;
  json["last_depth_m"] = r.last_depth;
  json["trust"] = r.doubt;
  json["expected_force_error"] = r.expected_error;
  json["job"] = r.job;
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

BatchResult resultFromLine(const std::string& line, const SourceLocation& place) try {
  const Json json = Json::parse(line);
  BatchResult r;
  r.id = json.at("id").get<std::string>();
  r.done = json.at("done").get<bool>();
  r.reason = json.value("reason", "");
  r.ticks = json.at("ticks").get<std::int64_t>();
  r.seconds = json.at("seconds").get<double>();
  r.state_hash = json.at("state_hash").get<std::string>();
  r.peak_force = json.at("peak_force_N").get<double>();
  r.last_force = json.at("last_force_N").get<double>();
  r.last_depth = json.at("last_depth_m").get<double>();
  r.doubt = json.at("trust").get<std::string>();
  r.expected_error = json.at("expected_force_error");
  r.job = json.at("job").get<std::string>();
  return r;
} catch (const Json::exception&) {
  throw InputError(place, "this is no result of a job", "run the batch anew");
}

}  // namespace palpate::tools

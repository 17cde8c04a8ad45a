#include "app/trainer/class_scores.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/trainer/task_score.h"
#include "base/input_error.h"
#include "base/number_text.h"
#include "io/output_file.h"
#include "io/result_csv.h"
#include "io/text_file.h"

namespace palpate::app {

namespace {

namespace fs = std::filesystem;
using Value = nlohmann::json;

constexpr std::size_t most_bytes = 64 << 20;

// Keys of the sheet, then of its conditions.
constexpr const char* sheet_columns[] = {
    "trainee",      "date",   "scene",          "scene_hash",          "level",         "seed",    "layout",
    "hits",         "misses", "false_alarms",   "hardness_right",      "mean_error_mm", "seconds", "mean_force_N",
    "peak_force_N", "trust",  "expected_error", "seconds_above_limit", "covered_share", "path_m",  "missed_too_light"};
constexpr const char* condition_columns[] = {"moved_by",      "probe",   "probe_of_scene", "friction", "rate_hz",
                                             "rate_of_scene", "changes", "undos",          "resets",   "answers_seen"};

/// A field of a table: a text stands in quotes, of a list its length, nothing for null. A text that a spreadsheet would
/// compute begins with an apostrophe there.
std::string field(const Value& object, const char* key) {
  const auto value = object.find(key);
  if (value == object.end() || value->is_null()) return "";
  if (value->is_array()) return std::to_string(value->size());
  if (!value->is_string()) return value->dump();
  const auto given = value->get<std::string>();
  return csvQuoted((given.find_first_of("=+-@\t\r") == 0 ? "'" : "") + given);
}

/// The sheet in a file; null where the file is something else. Throws std::exception where it can't be read.
Value sheetIn(const fs::path& file) {
  const std::string text = readWholeFile(file.string(), {}, most_bytes);
  const auto has = [&](const std::string& word) { return text.find("\"" + word + "\"") != std::string::npos; };
  const bool is_sheet = has(score_kind) || has("false_alarms");
  if (!is_sheet && !file.filename().string().starts_with("score")) return {};
  const Value json = Value::parse(text, nullptr, false);
  if (json.is_discarded()) throw std::runtime_error("it is damaged or cut short");
  if (!is_sheet) return {};
  for (const char* key : {"hits", "misses", "false_alarms", "conditions"})
    if (!json.is_object() || !json.contains(key) || json[key].is_null())
      throw std::runtime_error(inQuotes(key) + " is not in it");
  for (const char* key : {"hits", "misses", "false_alarms"})
    if (!json[key].is_number_integer()) throw std::runtime_error(inQuotes(key) + " is no whole number");
  if (!json["conditions"].is_object()) throw std::runtime_error("its conditions are none");
  return json;
}

}  // namespace

std::optional<std::string> traineeOf(const std::string& file) {
  try {
    const Value sheet = sheetIn(file);
    if (!sheet.is_null()) return sheet.value("trainee", "");
  } catch (const std::exception&) {  // not there, or damaged
  }
  return {};
}

ClassScores classScores(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw InputError({folder}, "no folder that could be read", "name one that score sheets lie below, e.g. out");
  std::vector<fs::path> files;
  const auto end = fs::recursive_directory_iterator();
  for (auto at = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error);
       !error && at != end; at.increment(error))
    if (at->path().extension() == ".json" && at->is_regular_file(error)) files.push_back(at->path());
  std::sort(files.begin(), files.end());

  ClassScores scores;
  scores.csv = "file";
  for (const char* column : sheet_columns) scores.csv += std::string(",") + column;
  for (const char* column : condition_columns) scores.csv += std::string(",") + column;
  scores.csv += "\n";
  for (const fs::path& file : files) {
    try {
      const Value sheet = sheetIn(file);
      if (sheet.is_null()) continue;
      const Value& conditions = sheet["conditions"];
      std::string row = field({{"file", file.lexically_relative(folder).string()}}, "file");
      for (const char* column : sheet_columns) row.append(",").append(field(sheet, column));
      for (const char* column : condition_columns) row.append(",").append(field(conditions, column));
      scores.csv += row + "\n";
      ++scores.sheets;
    } catch (const std::exception& problem) {
      scores.problems.push_back(file.string() + ": no score sheet can be read from it: " + problem.what());
    }
  }
  return scores;
}

int writeClassScores(const std::string& folder, const std::string& out) {
  const ClassScores scores = classScores(folder);
  for (const std::string& problem : scores.problems) std::cerr << "palpate: " << problem << '\n';
  const std::string file = (fs::path(out.empty() ? folder : out) / "scores.csv").string();
  if (scores.sheets == 0)
    throw InputError({folder}, "no score sheet lies below it",
                     "Submit writes score-1.json into out/<scene> of the folder that palpate was started in");
  std::error_code error;  // then the file can't be written
  fs::create_directories(fs::path(file).parent_path(), error);
  writeWholeFile(file, scores.csv, "choose another folder with --out");
  std::cout << format("scores       %s: %d sheet%s", file.c_str(), scores.sheets, scores.sheets == 1 ? "" : "s")
            << std::endl;
  return scores.problems.empty() ? 0 : 1;
}

}  // namespace palpate::app

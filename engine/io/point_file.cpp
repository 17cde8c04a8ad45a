#include "io/point_file.h"

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/csv_table.h"
#include "io/text_file.h"

namespace palpate {
namespace {

constexpr double slicer_unit = 1e-3;  // m
constexpr std::uintmax_t max_bytes = 16 << 20;

std::string nameOf(Frame frame) { return frame == Frame::Ras ? "ras" : "lps"; }

/// The frame that a Slicer file names. @param text  "RAS", "LPS", or the numbers that old files have for them
Frame frameOf(const std::string& text, const SourceLocation& place) {
  if (text == "RAS" || text == "0") return Frame::Ras;
  if (text == "LPS" || text == "1") return Frame::Lps;
  throw InputError(place, "the coordinate system " + inQuotes(text), "save the points in RAS or LPS");
}

Vec3 toOrgan(const Vec3& x, double unit, Frame frame) {
  return frame == Frame::Ras ? Vec3(unit * x) : Vec3(-unit * x.x(), -unit * x.y(), unit * x.z());
}

/// "# CoordinateSystem = LPS", "# columns = id,x,y,z,..." and a point a line.
PointLoad readFcsv(const std::string& path, const std::string& text, std::optional<Frame>& frame) {
  PointLoad load;
  std::istringstream in(text);
  int number = 0;
  std::size_t first = 1;  // field of x
  for (std::string line; std::getline(in, line);) {
    ++number;
    const SourceLocation place{path, number};
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.starts_with("#")) {
      const auto valueOf = [&](const std::string& key) -> std::optional<std::string> {
        const std::size_t at = line.find(key), equals = line.find('=');
        if (at == std::string::npos || equals == std::string::npos || at > equals) return {};
        const std::size_t begin = line.find_first_not_of(' ', equals + 1);
        return begin == std::string::npos ? "" : line.substr(begin, line.find_last_not_of(' ') - begin + 1);
      };
      if (const auto system = valueOf("CoordinateSystem")) frame = frameOf(*system, place);
      if (const auto columns = valueOf("columns")) first = columns->starts_with("id") ? 1 : 0;
      continue;
    }
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    std::vector<std::string> field;
    std::istringstream fields(line);
    for (std::string f; std::getline(fields, f, ',');) field.push_back(f);
    Vec3 x;
    for (std::size_t c = 0; c < 3; ++c) {
      char* end = nullptr;
      const char* begin = first + c < field.size() ? field[first + c].c_str() : "";
      x[static_cast<Eigen::Index>(c)] = std::strtod(begin, &end);
      if (end == begin || *end != '\0' || !std::isfinite(x[static_cast<Eigen::Index>(c)]))
        throw InputError(place, "a point without three coordinates", "save the points again");
    }
    load.after.push_back(x);
    load.line.push_back(number);
  }
  return load;
}

PointLoad readMarkups(const std::string& path, const std::string& text, std::optional<Frame>& frame) {
  PointLoad load;
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    for (const auto& markup : json.at("markups")) {
      frame = frameOf(markup.at("coordinateSystem").get<std::string>(), {path});
      if (markup.contains("coordinateUnits") && markup.at("coordinateUnits").is_string() &&
          markup.at("coordinateUnits") != "mm")
        throw InputError({path}, "the points are not in mm", "save them in mm");
      for (const auto& point : markup.at("controlPoints")) {
        const auto& x = point.at("position");
        load.after.emplace_back(x.at(0).get<double>(), x.at(1).get<double>(), x.at(2).get<double>());
      }
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError({path}, std::string("this is no markups file of 3D Slicer (") + error.what() + ")",
                     "save the points again");
  }
  return load;
}

PointLoad readCsv(const std::string& path, const SourceLocation& asked_from) {
  const CsvTable table = readCsvTable(path, asked_from);
  PointLoad load;
  load.line = table.line;
  const bool has_before = table.find("x0") >= 0;
  const auto points = [&](const char* x, const char* y, const char* z) {
    std::vector<Vec3> list;
    for (std::size_t r = 0; r < table.rowCount(); ++r) {
      list.emplace_back(table[x][r], table[y][r], table[z][r]);
      if (!list.back().allFinite())
        throw InputError({path, table.line[r]}, "a point without three coordinates", "fill the line, or remove it");
    }
    return list;
  };
  load.after = points("x", "y", "z");
  if (has_before) load.before = points("x0", "y0", "z0");
  return load;
}

}  // namespace

PointLoad readPoints(const std::string& path, std::optional<double> unit, std::optional<Frame> frame,
                     const SourceLocation& asked_from) {
  const bool fcsv = path.ends_with(".fcsv"), markups = path.ends_with(".json");
  PointLoad load;
  if (fcsv || markups) {
    std::optional<Frame> said;
    const std::string text = readWholeFile(path, asked_from, max_bytes);
    load = fcsv ? readFcsv(path, text, said) : readMarkups(path, text, said);
    if (said && frame && *said != *frame)
      throw InputError(asked_from, "the file says that its frame is " + inQuotes(nameOf(*said)), "leave \"frame\" out");
    if (said) frame = said;
    if (unit && *unit != slicer_unit) throw InputError(asked_from, "3D Slicer's files are in mm", "leave \"unit\" out");
    unit = slicer_unit;
  } else {
    load = readCsv(path, asked_from);
  }
  load.file = path;
  if (!frame)
    throw InputError(asked_from, "the frame of these points is not known",
                     "add frame = \"ras\" (+x to the patient's right, +y to the front) or \"lps\" (left, back)");
  if (!unit) throw InputError(asked_from, "the unit of these points is not known", "add unit = \"mm\"");
  if (load.after.empty()) throw InputError({path}, "there are no points", "is it the right file?");
  for (auto* list : {&load.before, &load.after})
    for (Vec3& x : *list) x = toOrgan(x, *unit, *frame);
  return load;
}

}  // namespace palpate

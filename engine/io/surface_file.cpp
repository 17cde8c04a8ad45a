#include "io/surface_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "base/number_text.h"
#include "base/printable_text.h"
#include "discretization/surface/weld_vertices.h"
#include "imaging/mend_surface.h"
#include "io/obj_parser.h"
#include "io/off_parser.h"
#include "io/output_file.h"
#include "io/ply_parser.h"
#include "io/stl_parser.h"
#include "io/text_file.h"
#include "io/vtk_surface_parser.h"

namespace palpate {

namespace {

// File indices are int, three to a face.
constexpr std::size_t max_faces = 20'000'000;

// Far beyond any organ, and so small that lengths, areas and volumes stay finite numbers.
constexpr double max_coordinate = 1e9;  // m

struct Format {
  const char* ending;
  SurfaceFile (*parse)(const std::string& bytes, const std::string& file, SurfaceReading reading);
};
constexpr Format formats[] = {
    {".obj", parseObj}, {".stl", parseStl}, {".ply", parsePly}, {".off", parseOff}, {".vtk", parseVtk}};

bool isNear(const Vec3& x) { return x.cwiseAbs().maxCoeff() <= max_coordinate; }

int unusedVertices(const TriangleSurface& surface) {
  std::vector<char> used(surface.vertices.size(), 0);
  for (const auto& t : surface.triangles)
    for (const int v : t)
      if (v >= 0 && static_cast<std::size_t>(v) < used.size()) used[static_cast<std::size_t>(v)] = 1;
  return static_cast<int>(std::count(used.begin(), used.end(), 0));
}

/// Leaves out the faces with vertices that are not there, not finite or out of this world.
void leaveOutUnreadable(SurfaceFile& file) {
  const auto& vertices = file.surface.vertices;
  const auto& triangles = file.surface.triangles;
  std::vector<char> good(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) good[v] = vertices[v].allFinite() && isNear(vertices[v]);
  file.unreadable_faces += keepFaces(file.surface, file.source, [&](int t) {
    const bool readable = std::all_of(triangles[t].begin(), triangles[t].end(), [&](int v) {
      return v >= 0 && static_cast<std::size_t>(v) < good.size() && good[static_cast<std::size_t>(v)];
    });
    if (!readable && file.unreadable.empty() && !file.source.triangle_line.empty())
      file.unreadable =
          SourceLocation{file.source.file, file.source.triangle_line[t]}.text() + ": a face without proper vertices";
    return readable;
  });
  dropUnusedVertices(file.surface, file.source);
}

/// Refuses the first vertex that is too far away, at its line.
void checkVertices(const SurfaceFile& file, const std::string& path) {
  for (std::size_t i = 0; i < file.surface.vertices.size(); ++i) {
    if (isNear(file.surface.vertices[i])) continue;
    const auto& line = file.source.vertex_line;
    int axis = 0;
    const Vec3& x = file.surface.vertices[i];
    for (int c = 0; c < 3; ++c)
      if (!(std::abs(x[c]) <= max_coordinate)) axis = c;
    throw InputError({path, i < line.size() ? line[i] : 0, 0},
                     "vertex " + std::to_string(i + 1) + " has " + std::string(1, "xyz"[axis]) + " = " +
                         format("%.3g", x[axis]) + " m, more than a billion metres away",
                     "check it, and the surface's unit or scale");
  }
}

/// Does what reads a file; its refusal names the place that asked for the file, too.
template <class Read>
auto askedFrom(const SourceLocation& place, Read read) {
  try {
    return read();
  } catch (const InputError& error) {
    if (place.file.empty()) throw;
    throw InputError({}, std::string(error.what()) + " (asked for at " + place.text() + ")", "");
  }
}

}  // namespace

std::string surfaceFormats() {
  std::string list;
  for (const Format& format : formats) list += (list.empty() ? "" : ", ") + std::string(format.ending);
  return list;
}

SurfaceFile readSurface(const std::string& path, double scale, const SourceLocation& asked_from,
                        SurfaceReading reading) {
  if (!(scale > 0) || !std::isfinite(scale)) {
    throw InputError(asked_from, "the surface's scale must be positive", "0.001 for a file in millimetres");
  }
  const std::string bytes = readWholeFile(path, asked_from);
  return askedFrom(asked_from, [&] { return surfaceFrom(bytes, path, scale, reading); });
}

SurfaceFile surfaceFrom(const std::string& bytes, const std::string& path, double scale, SurfaceReading reading) {
  const std::string ending = lowerCase(std::filesystem::path(path).extension().string());
  const auto parser =
      std::find_if(std::begin(formats), std::end(formats), [&](const Format& f) { return ending == f.ending; });
  if (parser == std::end(formats)) {
    throw InputError({path, 0, 0}, "\"" + ending + "\" is not a surface format that can be read",
                     "use one of " + surfaceFormats());
  }
  if (bytes.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw InputError({path, 0, 0}, "the file is empty", "export the organ as OBJ or STL");
  }
  SurfaceFile result = parser->parse(bytes, path, reading);
  if (result.surface.triangles.size() > max_faces) {
    throw InputError({path, 0, 0}, std::to_string(result.surface.triangles.size()) + " faces",
                     "simplify the surface: ten thousand faces show an organ well");
  }
  for (Vec3& x : result.surface.vertices) x *= scale;
  result.unused_vertices = unusedVertices(result.surface);
  if (reading == SurfaceReading::Tolerant) {
    leaveOutUnreadable(result);
    if (result.surface.triangles.empty()) {
      SurfaceFile again = parser->parse(bytes, path, SurfaceReading::Strict);  // says what is wrong first, and where
      for (Vec3& x : again.surface.vertices) x *= scale;
      checkVertices(again, path);
      throw InputError({path, 0, 0}, "no face of this file can be read", "export the surface again");
    }
  }
  checkVertices(result, path);
  weldVertices(result.surface, result.source);
  return result;
}

TriangleSurface readClosedSurface(const std::string& path, double scale, const SourceLocation& asked_from) {
  SurfaceFile file = readSurface(path, scale, asked_from);
  askedFrom(asked_from, [&] {
    try {
      checkSurface(file.surface, file.source);
    } catch (const InputError& error) {
      throw InputError({}, error.what(), "or let `mtled import " + path + "` repair it, or [organ] repair = true");
    }
  });
  return std::move(file.surface);
}

void writeObj(const TriangleSurface& surface, const std::string& path) {
  std::string text;
  for (const Vec3& x : surface.vertices) {
    text += "v " + shortest(x[0]) + ' ' + shortest(x[1]) + ' ' + shortest(x[2]) + '\n';
  }
  for (const auto& [a, b, c] : surface.triangles) {
    text += "f " + std::to_string(a + 1) + ' ' + std::to_string(b + 1) + ' ' + std::to_string(c + 1) + '\n';
  }
  writeWholeFile(path, text);
}

}  // namespace palpate

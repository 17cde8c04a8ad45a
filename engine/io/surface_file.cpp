#include "io/surface_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "base/number_text.h"
#include "discretization/surface/weld_vertices.h"
#include "io/obj_parser.h"
#include "io/stl_parser.h"
#include "io/text_file.h"

namespace palpate {

namespace {

// File indices are int, three to a face.
constexpr std::size_t max_faces = 20'000'000;

// Far beyond any organ, and so small that lengths, areas and volumes stay finite numbers.
constexpr double max_coordinate = 1e9;  // m

}  // namespace

SurfaceFile readSurface(const std::string& path, double scale, const SourceLocation& asked_from) {
  if (!(scale > 0) || !std::isfinite(scale)) {
    throw InputError(asked_from, "the surface's scale must be positive", "0.001 for a file in millimetres");
  }
  return surfaceFrom(readWholeFile(path, asked_from), path, scale);
}

SurfaceFile surfaceFrom(const std::string& bytes, const std::string& path, double scale) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (extension != ".obj" && extension != ".stl") {
    throw InputError({path, 0, 0}, "\"" + extension + "\" is not a surface format that can be read",
                     "use .obj or .stl");
  }
  if (bytes.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw InputError({path, 0, 0}, "the file is empty", "export the organ as OBJ or STL");
  }
  SurfaceFile result = extension == ".obj" ? parseObj(bytes, path) : parseStl(bytes, path);
  if (result.surface.triangles.size() > max_faces) {
    throw InputError({path, 0, 0}, std::to_string(result.surface.triangles.size()) + " faces",
                     "simplify the surface: ten thousand faces show an organ well");
  }
  for (std::size_t i = 0; i < result.surface.vertices.size(); ++i) {
    Vec3& x = result.surface.vertices[i];
    x *= scale;
    if (!(x.cwiseAbs().maxCoeff() <= max_coordinate)) {
      const auto& line = result.source.vertex_line;
      throw InputError({path, i < line.size() ? line[i] : 0, 0},
                       "vertex " + std::to_string(i + 1) + " is more than a billion metres away",
                       "check it, and the surface's unit or scale");
    }
  }
  weldVertices(result.surface, result.source);
  return result;
}

TriangleSurface readClosedSurface(const std::string& path, double scale, const SourceLocation& asked_from) {
  SurfaceFile file = readSurface(path, scale, asked_from);
  checkSurface(file.surface, file.source);
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
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error("can't write " + path);
}

}  // namespace palpate

#include <CLI/CLI.hpp>

#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "base/input_error.h"
#include "base/printable_text.h"
#include "imaging/remesh.h"
#include "io/output_file.h"
#include "organs/organ.h"
#include "organs/surface_report.h"

/// Makes the organs in assets/organs from formulas: implicit surface, marching
/// tetrahedra, isotropic remeshing, OBJ. The same bytes on every run.
namespace {

using namespace palpate;
using namespace palpate::organs;

constexpr double kSmallestAngleDeg = 20;  // below it a triangle is a sliver

TriangleSurface make(const Organ& organ) {
  // A grid a little finer than the triangles: they then only coarsen it.
  TriangleSurface surface = remesh(isosurface(organ, 0.8 * organ.edge_length), organ.field, organ.edge_length);
  const double lowest = boundingBox(surface).min().z();
  for (Vec3& x : surface.vertices) x.z() -= lowest;  // it lies on z = 0
  return surface;
}

/// OBJ text: positions in m with six significant digits, indices from 1.
std::string objText(const Organ& organ, const TriangleSurface& surface) {
  std::ostringstream s;
  s << "# " << organ.name << ", " << organ.description << "\n"
    << "# metres, z up; made by tools/make_organs (see assets/SOURCES.md), not by hand\n";
  s.precision(6);
  for (const Vec3& x : surface.vertices) s << "v " << x.x() << ' ' << x.y() << ' ' << x.z() << "\n";
  for (const auto& [a, b, c] : surface.triangles) s << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << "\n";
  return s.str();
}

void write(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw InputError({file.string()}, "can't be written", "choose another folder with --out");
}

bool sameAsFile(const std::filesystem::path& file, const std::string& text) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream found;
  found << in.rdbuf();
  return in && found.str() == text;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "Makes the organ surfaces (OBJ, metres, closed, outward normals) from formulas.\n"
      "Exit code: 0 done, 1 a surface is bad or --check found a difference, 2 bad arguments.");
  std::string out_folder;
  std::string check_folder;
  std::vector<std::string> wanted;
  std::vector<std::string> names;
  for (const Organ& organ : allOrgans()) names.push_back(organ.name);
  auto* out = app.add_option("--out", out_folder, "Write the organs to this folder (made if missing)");
  auto* check =
      app.add_option("--check", check_folder, "Compare with the files in this folder, byte for byte; write nothing");
  out->excludes(check);
  app.add_option("--organ", wanted, "Make only this one (may be repeated)")->check(CLI::IsMember(names));
  try {
    app.parse(argc, argv);
    if (out_folder.empty() && check_folder.empty()) throw CLI::RequiredError("--out or --check");
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    finishStandardOutput();
    return code == 0 ? 0 : 2;
  }

  bool good = true;
  for (const Organ& organ : allOrgans()) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), organ.name) == wanted.end()) continue;
    const TriangleSurface surface = make(organ);
    const SurfaceReport report = reportOn(surface);
    std::cout << organ.name << "\n" << report.text();
    if (!report.isClosedSphere() || report.smallest_angle_deg < kSmallestAngleDeg) {
      std::cout << "  BAD: must be one closed surface of genus 0 without angles below " << kSmallestAngleDeg
                << " degrees\n";
      good = false;
    }
    const std::string text = objText(organ, surface);
    const std::string file_name = organ.name + ".obj";
    if (check_folder.empty()) {
      const auto file = std::filesystem::path(out_folder) / file_name;
      write(file, text);
      std::cout << "  written to " << file.string() << "\n";
    } else {
      const auto file = std::filesystem::path(check_folder) / file_name;
      const bool same = sameAsFile(file, text);
      std::cout << "  " << file.string()
                << (same ? " is the same\n" : " DIFFERS: run make_organs --out on its folder\n");
      good = good && same;
    }
  }
  finishStandardOutput();
  return good ? 0 : 1;
} catch (const palpate::InputError& error) {
  std::cerr << palpate::printable(error.what(), palpate::LineEnds::Keep) << "\n";
  return 2;
} catch (const std::exception& error) {
  std::cerr << palpate::printable(error.what(), palpate::LineEnds::Keep) << "\n";
  return 1;
}

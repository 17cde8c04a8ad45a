#include "mtled/scan/case_scene.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "base/number_text.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate::tools {
namespace {

std::string vectorText(const Vec3& v) { return format("[%.5g, %.5g, %.5g]", v.x(), v.y(), v.z()); }

std::string quoted(const std::string& text) {
  std::string s = "\"";
  for (const char c : text) s += c == '"' || c == '\\' || static_cast<unsigned char>(c) < ' ' ? '_' : c;
  return s + "\"";
}

/// A region of a scene.
std::string ballText(const Vec3& centre, double radius) {
  return "shape = \"sphere\", centre = " + vectorText(centre) + ", radius = " + format("%.4g", radius);
}

std::string fixedText(const CaseScene& scene, const Box3& box) {
  std::ostringstream s;
  for (std::size_t n = 0; n < scene.fixed.size(); ++n)
    s << "[[fixed]]             # " << scene.fixed[n].text << "\nname = \"held_" << n + 1
      << "\"\nshape = \"sphere\"\ncentre = " << vectorText(scene.fixed[n].centre)
      << "\nradius = " << format("%.4g", scene.fixed[n].radius) << "\n\n";
  if (scene.fixed.empty())
    s << "[[fixed]]             # guessed: the lowest twentieth\nname = \"base\"\nshape = \"half-space\"\npoint = "
      << vectorText(Vec3(box.center().x(), box.center().y(), box.min().z() + lowest_held * box.sizes().z()))
      << "\nnormal = [0, 0, 1]\n\n";
  return s.str();
}

std::string skullText(const CaseScene& scene) {
  std::vector<std::string> open;
  if (!scene.opened.isEmpty())
    open.push_back(ballText(scene.opened.center(), 0.5 * scene.opened.diagonal().norm() + 2 * scene.spacing));
  for (const NamedBall& ball : scene.openings) open.push_back(ballText(ball.centre, ball.radius));
  std::string s = "[skull]               # the brain slides in it\nfrom = \"organ\"\nclearance = 0.0005\n";
  for (std::size_t n = 0; n < open.size(); ++n) s += (n == 0 ? "open = [{ " : ",\n        { ") + open[n] + " }";
  return s + (open.empty() ? "\n" : "]\n\n");
}

}  // namespace

double spacingFor(double volume, int nodes) {
  return std::cbrt(volume / (0.7 * nodes));  // what the cloud's density is, its surface included
}

std::string sceneText(const CaseScene& scene, const TriangleSurface& surface) {
  const Box3 box = boundingBox(surface);
  const double size = box.sizes().maxCoeff();
  const double radius = std::max(0.04 * size, 1e-3);
  std::ostringstream s;
  s << "# Written by mtled import. Coordinates are the scan's, in m: +x to the patient's right, +y to the front, +z "
       "up.\n"
    << "name = " << quoted(scene.name) << "\n\n"
    << "[organ]\nsurface = \"surface.obj\"\nunit = \"m\"\ncolour = [0.60, 0.36, 0.32]\n\n"
    << "[discretization]\nspacing = " << format("%.4g", scene.spacing) << "\n\n"
    << "[[material]]          # brain\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.49\ndensity = 1040\n\n";
  if (scene.has_fluid)
    s << "[[material]]          # as much fluid as the image says\nmodel = \"neo-hookean\"\nyoung = 100\npoisson = "
         "0.49\n"
      << "density = 1007\nmembership = \"csf.nii.gz\"\nmask = " << quoted(scene.known) << "\n\n";
  s << fixedText(scene, box);
  if (!scene.electrodes.empty())
    s << "[[prescribed]]        # where the electrodes are\nname = \"electrode\"\npoints = " << quoted(scene.electrodes)
      << "\n"
      << scene.electrode_keys << "duration = 1.0\n\n";
  if (scene.in_skull) s << skullText(scene);
  s << "[solve]\nload_steps = 5\ntolerance = 1e-3\nframes = 5\n\n"
    << "[tool]\nshape = \"sphere\"\nradius = " << format("%.4g", radius)
    << "\nposition = " << vectorText(Vec3(box.center().x(), box.center().y(), box.max().z() + 2 * radius))
    << "\ndirection = [0, 0, -1]\n\n"
    << "[camera]\ntarget = " << vectorText(box.center()) << "\ndistance = " << format("%.4g", 2.6 * size)
    << "\nazimuth = 60\nelevation = 20\n";
  return s.str();
}

}  // namespace palpate::tools

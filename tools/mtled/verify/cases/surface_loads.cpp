#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "mtled/verify/cases/cases.h"
#include "mtled/verify/thick_sphere.h"

namespace palpate::tools {
namespace {

/// A closed surface from quadrilaterals and triangles whose vertices are told apart by their places.
class SurfaceBuilder {
 public:
  int vertex(const Vec3& x) {
    const std::array<long, 3> key{std::lround(x.x() * 1e9), std::lround(x.y() * 1e9), std::lround(x.z() * 1e9)};
    const auto [entry, is_new] = number_.emplace(key, static_cast<int>(surface_.vertices.size()));
    if (is_new) surface_.vertices.push_back(x);
    return entry->second;
  }
  /// @param outward  on the side to which the face looks
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& outward) {
    const bool turned = (b - a).cross(c - a).dot(outward) < 0;
    surface_.triangles.push_back({vertex(a), vertex(turned ? c : b), vertex(turned ? b : c)});
  }
  void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& outward) {
    triangle(a, b, c, outward);
    triangle(a, c, d, outward);
  }
  TriangleSurface take() { return std::move(surface_); }

 private:
  std::map<std::array<long, 3>, int> number_;
  TriangleSurface surface_;
};

// The sphere: radii, m.
constexpr double a = 0.010, b = 0.020;

/// Its octant x, y, z >= 0, of edges of about `edge`, m.
TriangleSurface sphereOctant(double edge) {
  const int n = std::max(4, static_cast<int>(std::ceil(M_PI / 2 * b / edge)));
  const int layers = std::max(2, static_cast<int>(std::ceil((b - a) / edge)));
  const auto at = [&](int i, int j, double r) { return Vec3(r * Vec3(i, j, n - i - j).normalized()); };
  SurfaceBuilder builder;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j)
      for (const double r : {a, b}) {
        const Vec3 outward = (r == b ? 1 : -1) * at(i, j, 1);
        builder.triangle(at(i, j, r), at(i + 1, j, r), at(i, j + 1, r), outward);
        if (i + j < n - 1) builder.triangle(at(i + 1, j, r), at(i + 1, j + 1, r), at(i, j + 1, r), outward);
      }
  for (int k = 0; k < n; ++k)
    for (int l = 0; l < layers; ++l) {
      const double r = a + (b - a) * l / layers, s = a + (b - a) * (l + 1) / layers;
      const std::array<std::array<int, 4>, 3> edges{{{0, k, 0, k + 1}, {k, 0, k + 1, 0}, {k, n - k, k + 1, n - k - 1}}};
      for (int c = 0; c < 3; ++c) {
        const auto [i, j, p, q] = edges[static_cast<std::size_t>(c)];
        builder.quad(at(i, j, r), at(i, j, s), at(p, q, s), at(p, q, r), -Vec3::Unit(c));
      }
    }
  return builder.take();
}

Scene sphereScene(double spacing, double young, double poisson, double pressure) {
  Scene scene = caseScene(young, poisson);
  scene.name = "thick sphere";
  scene.discretization.spacing = spacing;
  scene.discretization.support_factor = 2.0;
  for (int c = 0; c < 3; ++c)
    scene.boundaries.push_back(
        planeBoundary(std::string("wall ") + "xyz" [c], Vec3::Zero(), Vec3::Unit(c), { c == 0, c == 1, c == 2 }));
  LoadSpec load;
  load.name = "gas";
  load.whole = false;
  load.region.kind = Region::Kind::Sphere;
  load.region.radius = a + 1e-6;
  load.pressure = pressure;
  beEven(load);
  scene.loads = {load};
  return scene;
}

/// The mean radius that the nodes at rest at `radius` go to, m.
double meanRadius(const StaticSolution& s, double radius) {
  double sum = 0;
  std::vector<Vec3> X;
  constexpr int n = 6;
  for (int i = 1; i < n; ++i)
    for (int j = 1; i + j < n; ++j) X.push_back(radius * Vec3(i, j, n - i - j).normalized());
  const std::vector<Vec3> u = s.at(X);
  for (std::size_t k = 0; k < X.size(); ++k) sum += (X[k] + u[k]).norm();
  return sum / static_cast<double>(X.size());
}

// Cook's panel: corners (0, 0), (48, 44), (48, 60), (0, 44) mm, and its thickness, m.
constexpr double panel_length = 0.048, panel_edge = 0.016, panel_rise = 0.044;

TriangleSurface cookSurface(double thickness, double edge) {
  const int n = std::max(4, static_cast<int>(std::ceil(panel_length / edge)));
  const int layers = std::max(1, static_cast<int>(std::ceil(thickness / edge)));
  const auto at = [&](int i, int j, double z) {
    const double x = static_cast<double>(i) / n, low = panel_rise * x, high = panel_rise + panel_edge * x;
    return Vec3(panel_length * x, low + (high - low) * j / n, z);
  };
  SurfaceBuilder builder;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (const double z : {0.0, thickness})
        builder.quad(at(i, j, z), at(i + 1, j, z), at(i + 1, j + 1, z), at(i, j + 1, z),
                     (z > 0 ? 1 : -1) * Vec3::UnitZ());
  for (int k = 0; k < n; ++k)
    for (int l = 0; l < layers; ++l) {
      const double z = thickness * l / layers, y = thickness * (l + 1) / layers;
      for (const int side : {0, n}) {
        builder.quad(at(side, k, z), at(side, k + 1, z), at(side, k + 1, y), at(side, k, y),
                     (side > 0 ? 1 : -1) * Vec3::UnitX());
        builder.quad(at(k, side, z), at(k + 1, side, z), at(k + 1, side, y), at(k, side, y),
                     (side > 0 ? 1 : -1) * Vec3::UnitY());
      }
    }
  return builder.take();
}

Scene cookScene(double spacing, double thickness, double young, double poisson, double traction) {
  Scene scene = caseScene(young, poisson);
  scene.name = "Cook's panel";
  scene.discretization.spacing = spacing;
  scene.discretization.support_factor = 2.0;
  scene.boundaries = {planeBoundary("left", Vec3::Zero(), Vec3::UnitX(), {true, true, false}),
                      planeBoundary("back", Vec3::Zero(), Vec3::UnitZ(), {false, false, true}),
                      planeBoundary("front", Vec3(0, 0, thickness), Vec3::UnitZ(), {false, false, true})};
  LoadSpec load;
  load.name = "shear";
  load.whole = false;
  load.region = planeBoundary("", Vec3(panel_length, 0, 0), Vec3::UnitX()).region;
  load.kind = LoadSpec::Kind::Traction;
  load.traction = Vec3(0, traction, 0);
  beEven(load);
  scene.loads = {load};
  return scene;
}

}  // namespace

CaseResult thickSphereCase(const CaseContext& context) {
  CaseResult result;
  result.name = "thick_sphere";
  result.title = "A thick sphere blown up from inside, its radius by a half (Green and Zerna)";
  result.reference =
      "The radial equation of the same law, integrated (tools/mtled/verify/thick_sphere.h); for nu to 1/2 it becomes "
      "p = mu/2 (4/l_b + 1/l_b^4 - 4/l_a - 1/l_a^4) of Green and Zerna (1954), l the hoop stretches.";
  result.text =
      "Radii 10 and 20 mm, mu 1000 Pa. One octant between walls of symmetry; gas presses on its inner face, along the "
      "normal and on the area that it comes to have.";
  ResultTable table{
      "Hoop stretch inside and outside",
      {"nu", "nodes", "p / mu", "inside", "closed form", "error", "outside", "closed form", "error", "time"},
      {},
      ""};
  constexpr double mu = 1000;
  int done = 0;
  for (const double nu : {0.3, 0.49})
    for (const double spacing : {2.5e-3, 1.8e-3}) {
      if (context.quick && spacing < 2e-3) continue;
      const double young = 2 * mu * (1 + nu);
      Scene scene = sphereScene(spacing, young, nu, 0);
      const ThickSphere exact(scene.materials[0].material, a, b, 1.5);
      scene.loads[0].pressure = exact.pressure();
      const TriangleSurface organ = sphereOctant(spacing / 4);
      const StaticSolution s =
          solveCase(scene, evenTimes(3), partOf(context, done++, context.quick ? 2 : 4), 1e-4, nullptr, &organ);
      const bool solved = !s.steps.empty() && s.steps.back().converged;
      const double inside = solved ? meanRadius(s, a) / a : NAN, outside = solved ? meanRadius(s, b) / b : NAN;
      const double error = (inside - 1) / 0.5 - 1, outer = (outside - 1) / (exact.outerStretch() - 1) - 1;
      const std::string nodes = std::to_string(s.model->nodeCount());
      table.rows.push_back({formatted(nu), nodes, formatted(exact.pressure() / mu), formatted(inside), "1.5",
                            formattedSigned(100 * error, "%"), formatted(outside), formatted(exact.outerStretch()),
                            formattedSigned(100 * outer, "%"), formatted(s.seconds, "s")});
      const std::string what = ", nu " + formatted(nu) + ", " + nodes + " nodes";
      const double limit = spacing < 2e-3 ? 0.03 : 0.05;
      result.bounds.push_back({"Widening inside, relative error" + what, std::abs(error), limit, true, "", ""});
      result.bounds.push_back({"Widening outside, relative error" + what, std::abs(outer), limit, true, "", ""});
      if (!context.pictures || nu < 0.4 || spacing > 2e-3) continue;
      BodyPicture picture;
      picture.title = "Blown up by a half";
      addBodyPicture(context, "thick_sphere_body.png", "The octant, blown up", picture, s, result);
    }
  result.tables.push_back(table);
  return result;
}

CaseResult cookCase(const CaseContext& context) {
  CaseResult result;
  result.name = "cook";
  result.title = "Cook's panel: shear on a tapered cantilever, nearly incompressible";
  result.reference =
      "Cook, J. Struct. Div. ASCE 100 (1974). In plane strain with G = 0.375, nu to 1/2 and a shear of 1 the middle of "
      "the right edge goes up by 16.43 (quadratic triangles, extrapolated; other elements 16.44), lengths as drawn.";
  result.text =
      "The panel of 48 x 44 to 16 mm, its left edge held, between smooth walls in z; nu 0.499. The load is so small "
      "that the solution is linear (a thousandth of the drawn one).";
  ResultTable table{
      "Way of the middle of the right edge, for the load drawn", {"nodes", "way", "error", "time"}, {}, ""};
  constexpr double reference = 16.43e-3, nu = 0.499, shear = 375, small = 1e-3;  // m; Pa: the drawn G times 1000
  int done = 0;
  for (const double spacing : {3e-3, 2e-3}) {
    if (context.quick && spacing < 2.5e-3) continue;
    const double thickness = 2 * spacing;
    // Drawn: a force of 1 on an edge of 16, thickness 1: a traction of 1/16, G in the same unit of stress.
    const Scene scene = cookScene(spacing, thickness, 2 * shear * (1 + nu), nu, small * 1000 / 16);
    const TriangleSurface organ = cookSurface(thickness, spacing / 2);
    const StaticSolution s =
        solveCase(scene, evenTimes(1), partOf(context, done++, context.quick ? 1 : 2), 1e-4, nullptr, &organ);
    const bool solved = !s.steps.empty() && s.steps.back().converged;
    const double way =
        solved ? s.at({Vec3(panel_length, panel_rise + panel_edge / 2, thickness / 2)})[0].y() / small : NAN;
    const std::string nodes = std::to_string(s.model->nodeCount());
    const double error = way / reference - 1;
    table.rows.push_back({nodes, formatted(way, "m"), formattedSigned(100 * error, "%"), formatted(s.seconds, "s")});
    result.bounds.push_back(
        {"Way of the edge, relative error, " + nodes + " nodes", std::abs(error), 0.01, true, "", ""});
  }
  result.tables.push_back(table);
  return result;
}

}  // namespace palpate::tools

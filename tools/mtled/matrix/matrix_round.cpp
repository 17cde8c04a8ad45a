#include <cmath>
#include <numbers>

#include "base/number_text.h"
#include "mtled/matrix/matrix_draws.h"
#include "mtled/matrix/one_dimensional.h"

// Cases whose equilibrium depends on one coordinate.

namespace palpate::tools {
namespace {

constexpr double on_face = 1e-9;  // m

/// A cylinder with a core or without.
struct Rod {
  double radius = 0, height = 0, core = 0;  // m
  DrawnTissue mantle, inside;
};

Rod drawRod(Lot& lot) {
  Rod rod;
  rod.radius = lot.between(0.01, 0.018);
  rod.height = lot.between(0.02, 0.036);
  rod.mantle = drawTissue(lot, lot.logBetween(300, 8000), drawPoisson(lot), Vec3::UnitZ());
  if (lot.chance(0.5)) return rod;
  rod.core = lot.between(0.4, 0.65) * rod.radius;
  rod.inside = drawTissue(lot, rod.mantle.shear * drawContrast(lot),
                          lot.chance(0.5) ? rod.mantle.poisson : drawPoisson(lot), Vec3::UnitZ());
  return rod;
}

std::string textOf(const Rod& rod) {
  if (rod.core == 0) return "cylinder, " + textOf(rod.mantle);
  return format("cylinder with a core 1 : %.3g, ", rod.inside.shear / rod.mantle.shear) + textOf(rod.mantle) +
         " around " + textOf(rod.inside);
}

Scene sceneOf(Lot& lot, const Rod& rod) {
  Scene s = drawScene(lot, rod.mantle);
  s.organs[0].solid = OrganSpec::Solid::Cylinder;
  s.organs[0].radius = rod.radius;
  s.organs[0].height = rod.height;
  s.discretization.spacing = rod.radius / lot.between(2.6, 4.2);
  s.tools[0].shape.radius = s.discretization.spacing;  // a finer polygon for the round
  if (rod.core == 0) return s;
  Region core;
  core.kind = Region::Kind::Cylinder;
  core.radius = rod.core;
  core.point = Vec3(0, 0, -rod.height);
  core.height = 3 * rod.height;
  addTissue(s, rod.inside, core);
  return s;
}

OneDimensional oneDimensional(const Rod& rod) {
  OneDimensional p;
  if (rod.core > 0) p.zones.push_back({rod.core, rod.inside.material});
  p.zones.push_back({rod.radius, rod.mantle.material});
  return p;
}

/// Of a place in the plane across z: as far from the axis as the answer says.
Vec3 radially(const OneDimensional::Answer& answer, const Vec3& X) {
  const double R = std::hypot(X.x(), X.y());
  if (R < on_face) return X;
  const double grown = answer.at(R) / R;
  return {grown * X.x(), grown * X.y(), X.z()};
}

}  // namespace

MatrixCase drawTwisted(Lot& lot) {
  MatrixCase one;
  const Rod rod = drawRod(lot);
  const double height = rod.height;
  const bool twisted = lot.chance(0.7);
  const double angle = twisted ? lot.between(0.2, 1) * height / rod.radius : 0;
  OneDimensional problem = oneDimensional(rod);
  problem.turn = angle / height;
  problem.stretch =
      !twisted || lot.chance(0.3) ? (lot.chance(0.5) ? lot.between(0.75, 0.95) : lot.between(1.05, 1.4)) : 1;
  const OneDimensional::Answer exact = problem.solve();
  one.known = twisted ? exact.moment : exact.force;
  one.kind = twisted ? "twisted" : problem.stretch < 1 ? "rod compressed" : "rod stretched";
  one.about = textOf(rod) + format(", by %.2g rad, to %.2g", angle, problem.stretch);
  one.scene = sceneOf(lot, rod);
  const double stretch = problem.stretch;
  one.placed.push_back(
      {[](const Vec3& X) { return X.z() < on_face; }, [exact](const Vec3& X) { return radially(exact, X); }});
  one.placed.push_back({[height](const Vec3& X) { return X.z() > height - on_face; },
                        [exact, stretch, angle](const Vec3& X) {
                          Vec3 x = radially(exact, X);
                          x.z() *= stretch;
                          return Vec3(Eigen::AngleAxisd(angle, Vec3::UnitZ()) * x);
                        }});
  one.placed[1].angle = angle;
  one.lever = [height, twisted](const Vec3& node, const Vec3&, const Vec3& x) {
    if (node.z() < height - on_face) return Vec3(Vec3::Zero());
    return twisted ? Vec3(Vec3::UnitZ().cross(x)) : Vec3(Vec3::UnitZ());
  };
  return one;
}

MatrixCase drawConfinedCore(Lot& lot) {
  MatrixCase one;
  Rod rod = drawRod(lot);
  if (rod.core == 0) {
    rod.core = 0.5 * rod.radius;
    rod.inside = drawTissue(lot, rod.mantle.shear * drawContrast(lot), drawPoisson(lot), Vec3::UnitZ());
  }
  OneDimensional problem = oneDimensional(rod);
  const double softest = std::min(rod.mantle.shear, rod.inside.shear),
               stiffest = std::max(rod.mantle.material.waveModulus(), rod.inside.material.waveModulus());
  problem.stretch = 1 - std::min(0.25, softest * lot.logBetween(0.3, 20) / stiffest);
  problem.end_held = true;
  problem.held = rod.radius;
  const OneDimensional::Answer exact = problem.solve();
  one.known = exact.force;
  one.kind = "confined core";
  one.about = textOf(rod) + format(", to %.3g", problem.stretch);
  Scene& s = one.scene = sceneOf(lot, rod);
  const double height = rod.height;
  s.boundaries = {planeBoundary("", Vec3::Zero(), Vec3::UnitZ(), {false, false, true}),
                  planeBoundary("", Vec3(0, 0, height), Vec3::UnitZ(), {false, false, true})};
  s.boundaries[1].translation = Vec3(0, 0, (problem.stretch - 1) * height);
  beEven(s.boundaries[1]);
  // All of the mantle, and the rims of both ends with it.
  PlacedSurface mantle{[radius = rod.radius, height](const Vec3& X) {
                         return (X.z() > on_face && X.z() < height - on_face) ||
                                std::hypot(X.x(), X.y()) > 0.97 * radius;
                       },
                       [](const Vec3& X) { return X; }};
  mantle.component[2] = false;
  one.placed.push_back(mantle);
  one.lever = [height](const Vec3& node, const Vec3&, const Vec3&) {
    return node.z() > height - on_face ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::Zero());
  };
  return one;
}

MatrixCase drawSphere(Lot& lot) {
  MatrixCase one;
  const double radius = lot.between(0.012, 0.02), lump = lot.between(0.4, 0.65) * radius;
  const DrawnTissue around = drawTissue(lot, lot.logBetween(300, 8000), drawPoisson(lot), Vec3::Zero()),
                    inside = drawTissue(lot, around.shear * drawContrast(lot),
                                        lot.chance(0.5) ? around.poisson : drawPoisson(lot), Vec3::Zero());
  OneDimensional problem;
  problem.kind = OneDimensional::Kind::Sphere;
  problem.zones = {{lump, inside.material}, {radius, around.material}};
  problem.end_held = true;
  const double change = std::min(0.12, around.shear * lot.logBetween(0.3, 20) / (3 * around.material.bulk_modulus));
  problem.held = radius * (1 + (lot.chance(0.3) ? change : -change));
  const OneDimensional::Answer exact = problem.solve();
  one.known = exact.force;
  one.kind = "sphere squeezed";
  one.about = format("lump 1 : %.3g, ", inside.shear / around.shear) + textOf(around) + " around " + textOf(inside) +
              format(", to %.4g", problem.held / radius);
  Scene& s = one.scene = drawScene(lot, around);
  s.organs[0].solid = OrganSpec::Solid::Ellipsoid;
  s.organs[0].semi_axes = Vec3::Constant(radius);
  s.discretization.spacing = radius / lot.between(3, 4.5);
  s.tools[0].shape.radius = s.discretization.spacing;
  Region region;
  region.kind = Region::Kind::Sphere;
  region.radius = lump;
  addTissue(s, inside, region);
  const double grown = problem.held / radius;
  one.placed.push_back({[](const Vec3&) { return true; }, [grown](const Vec3& X) { return Vec3(grown * X); }});
  one.lever = [radius](const Vec3&, const Vec3& X, const Vec3&) { return Vec3(X / radius); };
  return one;
}

MatrixCase drawBent(Lot& lot) {
  MatrixCase one;
  const double T = lot.between(0.008, 0.014), L = lot.between(1.6, 2.6) * T, W = lot.between(0.8, 1.2) * T;
  const Vec3 fibre = Vec3::Unit(lot.oneOf(3));
  const DrawnTissue tissue = drawTissue(lot, lot.logBetween(300, 8000), drawPoisson(lot), fibre);
  OneDimensional problem;
  problem.kind = OneDimensional::Kind::Beam;
  problem.begin = -T / 2;
  problem.zones = {{T / 2, tissue.material}};
  one.about = textOf(tissue);
  Scene& s = one.scene = drawScene(lot, tissue);
  if (lot.chance(0.5)) {
    const DrawnTissue other =
        drawTissue(lot, tissue.shear * drawContrast(lot), lot.chance(0.5) ? tissue.poisson : drawPoisson(lot), fibre);
    const double border = lot.between(-0.15, 0.15) * T;
    problem.zones.insert(problem.zones.begin(), {border, other.material});
    Region inner;
    inner.normal = Vec3::UnitX();
    inner.point = Vec3(border, 0, 0);
    addTissue(s, other, inner);
    one.about = format("two layers 1 : %.3g, ", other.shear / tissue.shear) + one.about + " outside " + textOf(other);
  }
  const double angle = lot.between(0.25, 0.6) * L / T, a = L / angle;
  problem.turn = 1 / a;
  const OneDimensional::Answer exact = problem.solve();
  one.known = exact.moment * W;
  one.kind = "bent";
  one.about += format(", by %.2g rad", angle);
  s.organs[0].solid = OrganSpec::Solid::Box;
  s.organs[0].size = Vec3(T, L, W);
  s.discretization.spacing = T / lot.between(3.5, 5.5);
  s.boundaries = {planeBoundary("", Vec3(0, -L / 2, 0), Vec3::UnitY(), {false, true, false}),
                  planeBoundary("", Vec3::Zero(), Vec3::UnitZ(), {false, false, true}),
                  planeBoundary("", Vec3(0, 0, W), Vec3::UnitZ(), {false, false, true})};
  const Vec3 middle(-a, -L / 2, 0);  // of the ring
  PlacedSurface end{[L](const Vec3& X) { return X.y() > L / 2 - on_face; },
                    [exact, middle, angle](const Vec3& X) {
                      const double r = exact.at(X.x());
                      return Vec3(middle + Vec3(r * std::cos(angle), r * std::sin(angle), X.z()));
                    }};
  end.axis_point = middle;
  end.angle = angle;
  end.component[2] = false;
  one.placed.push_back(end);
  one.lever = [L, middle](const Vec3& node, const Vec3&, const Vec3& x) {
    return node.y() > L / 2 - on_face ? Vec3(Vec3::UnitZ().cross(x - middle)) : Vec3(Vec3::Zero());
  };
  return one;
}

}  // namespace palpate::tools

#include <numbers>

#include "base/number_text.h"
#include "mtled/matrix/matrix_draws.h"
#include "mtled/matrix/uniform_parts.h"

// Cases of parts that are each strained evenly.

namespace palpate::tools {
namespace {

/// A box with one to four layers, the first material being that of the lowest.
struct Stack {
  std::vector<Layer> layers;
  std::vector<DrawnTissue> tissues;
  double softest = 0;  // Pa, shear modulus
};

Stack drawStack(Lot& lot, double height, const Vec3& fibre) {
  Stack stack;
  const int count = 1 + lot.oneOf(4);
  const double shear = lot.logBetween(300, 8000), poisson = drawPoisson(lot);
  double left = height;
  for (int k = 0; k < count; ++k) {
    const double mu = k == 0 ? shear : shear * drawContrast(lot),
                 high = k + 1 == count ? left : height / count * lot.between(0.8, 1.2);
    stack.tissues.push_back(drawTissue(lot, mu, lot.chance(0.5) ? poisson : drawPoisson(lot), fibre));
    stack.layers.push_back({high, stack.tissues.back().material});
    stack.softest = k == 0 ? mu : std::min(stack.softest, mu);
    left -= high;
  }
  return stack;
}

/// Puts the layers into the scene, from the top down, as each region is all that is below a plane.
void addLayers(const Stack& stack, Scene& scene) {
  double top = scene.organs[0].size.z();
  scene.materials[0].material = stack.tissues.back().material;
  for (std::size_t k = stack.layers.size() - 1; k > 0; --k) {
    top -= stack.layers[k].height;
    Region below;
    below.point = Vec3(0, 0, top);
    addTissue(scene, stack.tissues[k - 1], below);
  }
}

std::string textOf(const Stack& stack) {
  double low = stack.softest, high = low;
  for (const DrawnTissue& tissue : stack.tissues) high = std::max(high, tissue.shear);
  std::string text = textOf(stack.tissues[0]);
  if (stack.layers.size() > 1)
    text = std::to_string(stack.layers.size()) + " layers 1 : " + format("%.3g, ", high / low) + text + " below";
  return text;
}

/// How far a layer of that height gives way to a pressure, confined, at small strain.
double givesWay(const DrawnTissue& tissue, double height, double pressure) {
  return height * pressure / tissue.material.waveModulus();
}

Vec3 drawBox(Lot& lot) { return {lot.between(0.025, 0.05), lot.between(0.02, 0.04), lot.between(0.02, 0.04)}; }

}  // namespace

MatrixCase drawConfined(Lot& lot) {
  MatrixCase one;
  const Vec3 size = drawBox(lot);
  const Stack stack = drawStack(lot, size.z(), drawFibre(lot, false));
  Scene& s = one.scene = drawScene(lot, stack.tissues[0]);
  s.organs[0].solid = OrganSpec::Solid::Box;
  s.organs[0].size = size;
  s.discretization.spacing = size.z() / lot.between(3.5, 5.5);
  addLayers(stack, s);
  // Up to 40 shear moduli of the softest layer, where no layer gives way by more than a third of its height.
  const double pressure = stack.softest * lot.logBetween(0.1, 40);
  double down = 0, worst = 0;
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const double way = givesWay(stack.tissues[k], stack.layers[k].height, pressure);
    down += way;
    worst = std::max(worst, way / stack.layers[k].height);
  }
  down *= std::min(1.0, 0.33 / worst) * (lot.chance(0.15) ? -0.4 : 1);
  const Laminate exact(stack.layers, Vec3(0, 0, -down));
  one.known = size.x() * size.y() * exact.traction.z();
  one.kind = "confined";
  one.about = textOf(stack) + format(", pressure %.2g softest mu", -exact.traction.z() / stack.softest);
  const bool bonded = lot.chance(0.3);
  s.boundaries = {planeBoundary("", Vec3::Zero(), Vec3::UnitZ(), {bonded, bonded, true}),
                  planeBoundary("", Vec3(0, 0, size.z()), Vec3::UnitZ(), {bonded, bonded, true})};
  s.boundaries[1].translation = Vec3(0, 0, -down);
  beEven(s.boundaries[1]);
  for (const double side : {-0.5, 0.5}) {
    s.boundaries.push_back(planeBoundary("", Vec3(side * size.x(), 0, 0), Vec3::UnitX(), {true, false, false}));
    s.boundaries.push_back(planeBoundary("", Vec3(0, side * size.y(), 0), Vec3::UnitY(), {false, true, false}));
  }
  one.lever = [height = size.z()](const Vec3&, const Vec3& X, const Vec3&) {
    return Vec3(X.z() / height * Vec3::UnitZ());
  };
  return one;
}

MatrixCase drawSheared(Lot& lot) {
  MatrixCase one;
  const Vec3 size = drawBox(lot);
  const Stack stack = drawStack(lot, size.z(), drawFibre(lot, true));
  Scene& s = one.scene = drawScene(lot, stack.tissues[0]);
  s.organs[0].solid = OrganSpec::Solid::Box;
  s.organs[0].size = size;
  s.discretization.spacing = size.z() / lot.between(3.5, 5.5);
  addLayers(stack, s);
  const Vec3 motion = size.z() * Vec3(lot.between(0.05, 0.35), lot.between(-0.1, 0.1), 0);
  const Laminate exact(stack.layers, motion);
  const Vec3 along = motion.normalized();
  one.known = size.x() * size.y() * exact.traction.dot(along);
  one.kind = "sheared";
  one.about = textOf(stack) + format(", by %.2g", motion.norm() / size.z());
  const double top = size.z();
  s.boundaries = {planeBoundary("", Vec3::Zero(), Vec3::UnitZ()), planeBoundary("", Vec3(0, 0, top), Vec3::UnitZ())};
  s.boundaries[1].translation = motion;
  beEven(s.boundaries[1]);
  one.placed.push_back({[top](const Vec3& X) { return X.z() > 1e-9 && X.z() < top - 1e-9; },
                        [exact](const Vec3& X) { return exact.moved(X); }});
  one.lever = [top, along](const Vec3&, const Vec3& X, const Vec3&) { return Vec3(X.z() / top * along); };
  return one;
}

MatrixCase drawAffine(Lot& lot) {
  MatrixCase one;
  const DrawnTissue tissue = drawTissue(lot, lot.logBetween(300, 8000), drawPoisson(lot), drawFibre(lot, true));
  Scene& s = one.scene = drawScene(lot, tissue);
  Mat3 G;
  for (int k = 0; k < 9; ++k) G(k / 3, k % 3) = lot.between(-0.25, 0.25);
  // What changes the volume is as small as the tissue's compressibility.
  const double most = std::min(0.2, 20 * tissue.shear / tissue.material.bulk_modulus);
  Mat3 F = Mat3::Identity() + G;
  F *= std::cbrt((1 + lot.between(-most, most)) / F.determinant());
  const char* solid = "box";
  double volume = 0;
  if (lot.chance(0.5)) {
    s.organs[0].solid = OrganSpec::Solid::Box;
    s.organs[0].size = drawBox(lot);
    s.discretization.spacing = s.organs[0].size.z() / lot.between(4, 6);
    volume = s.organs[0].size.prod();
  } else {
    solid = "half-ellipsoid";
    s.organs[0].solid = OrganSpec::Solid::Ellipsoid;
    s.organs[0].upper_half = true;
    s.organs[0].semi_axes = Vec3(lot.between(0.02, 0.035), lot.between(0.02, 0.03), lot.between(0.015, 0.03));
    s.discretization.spacing = s.organs[0].semi_axes.z() / lot.between(3, 5);
    volume = 2.0 / 3 * std::numbers::pi * s.organs[0].semi_axes.prod();
  }
  G = F - Mat3::Identity();
  const Mat3 unit = G / G.norm() / std::cbrt(volume);
  one.known = volume * tissue.material.firstPiola(F).cwiseProduct(unit).sum();
  one.kind = "affine";
  one.about = std::string(solid) + ", " + textOf(tissue) + format(", by %.2g", G.norm());
  one.placed.push_back({[](const Vec3&) { return true; }, [F](const Vec3& X) { return Vec3(F * X); }});
  one.lever = [unit](const Vec3&, const Vec3& X, const Vec3&) { return Vec3(unit * X); };
  return one;
}

MatrixCase drawBetweenPlates(Lot& lot) {
  MatrixCase one;
  const Vec3 size = drawBox(lot), fibre = Vec3::Unit(lot.oneOf(3));
  const DrawnTissue tissue = drawTissue(lot, lot.logBetween(300, 8000), drawPoisson(lot), fibre);
  Scene& s = one.scene = drawScene(lot, tissue);
  s.organs[0].solid = OrganSpec::Solid::Box;
  s.organs[0].size = size;
  s.discretization.spacing = size.z() / lot.between(3.5, 5.5);
  // Two tissues side by side, with y held, each with its own width; or one.
  const bool two = lot.chance(0.5), held = two || lot.chance(0.4);
  // Two slabs that are pressed along their border bulge at a smaller strain than one, whose even strain is stable
  // beyond 0.7 (Biot 1963: it creases): seed 180 at 0.65 found no equilibrium on a finer cloud.
  const double stretch = lot.chance(0.5) ? lot.between(two ? 0.8 : 0.7, 0.95) : lot.between(1.05, 1.5);
  double force = size.x() * size.y() * stressBetweenPlates(tissue.material, stretch, held);
  one.about = textOf(tissue);
  if (two) {
    const DrawnTissue other =
        drawTissue(lot, tissue.shear * drawContrast(lot), lot.chance(0.5) ? tissue.poisson : drawPoisson(lot), fibre);
    const double share = lot.between(0.35, 0.65);
    Region left;
    left.normal = Vec3::UnitX();
    left.point = Vec3((share - 0.5) * size.x(), 0, 0);
    addTissue(s, other, left);
    force = (1 - share) * force + share * size.x() * size.y() * stressBetweenPlates(other.material, stretch, true);
    one.about =
        format("side by side 1 : %.3g, ", other.shear / tissue.shear) + textOf(tissue) + " and " + textOf(other);
  }
  one.known = force;
  one.kind = stretch < 1 ? "compressed between plates" : "stretched between plates";
  one.about += format(", to %.2g", stretch) + (held ? ", y held" : "");
  s.boundaries = {planeBoundary("", Vec3::Zero(), Vec3::UnitZ(), {false, false, true}),
                  planeBoundary("", Vec3(0, 0, size.z()), Vec3::UnitZ(), {false, false, true}),
                  planeBoundary("", Vec3(-size.x() / 2, 0, 0), Vec3::UnitX(), {true, false, false}),
                  planeBoundary("", Vec3(0, -size.y() / 2, 0), Vec3::UnitY(), {false, true, false})};
  if (held) s.boundaries.push_back(planeBoundary("", Vec3(0, size.y() / 2, 0), Vec3::UnitY(), {false, true, false}));
  s.boundaries[1].translation = Vec3(0, 0, (stretch - 1) * size.z());
  beEven(s.boundaries[1]);
  one.lever = [height = size.z()](const Vec3&, const Vec3& X, const Vec3&) {
    return Vec3(X.z() / height * Vec3::UnitZ());
  };
  return one;
}

}  // namespace palpate::tools

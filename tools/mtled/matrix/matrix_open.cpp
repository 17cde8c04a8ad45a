#include <algorithm>

#include "base/number_text.h"
#include "contact/tools/tool_list.h"
#include "mtled/matrix/matrix_draws.h"

// Cases whose answer finer clouds give. Bodies are small in spacings, so that clouds of half the spacing are, too.

namespace palpate::tools {
namespace {

constexpr double gap = 0.001;  // m, between tool and body at the start

/// A body that is bonded to the plane below it.
struct BondedBody {
  double height = 0, width = 0;  // m; width: the smallest
  std::string name;
};

BondedBody drawBody(Lot& lot, bool round, Scene& s) {
  BondedBody body;
  const int solid = lot.oneOf(round ? 3 : 2);
  if (solid == 0) {
    s.organs[0].solid = OrganSpec::Solid::Box;
    s.organs[0].size = Vec3(lot.between(0.026, 0.038), lot.between(0.026, 0.038), lot.between(0.014, 0.024));
    body = {s.organs[0].size.z(), std::min(s.organs[0].size.x(), s.organs[0].size.y()), "block"};
  } else if (solid == 1) {
    s.organs[0].solid = OrganSpec::Solid::Cylinder;
    s.organs[0].radius = lot.between(0.014, 0.02);
    s.organs[0].height = lot.between(0.014, 0.024);
    body = {s.organs[0].height, 2 * s.organs[0].radius, "cylinder"};
  } else {
    s.organs[0].solid = OrganSpec::Solid::Ellipsoid;
    s.organs[0].upper_half = true;
    s.organs[0].semi_axes = Vec3(lot.between(0.017, 0.024), lot.between(0.017, 0.024), lot.between(0.014, 0.022));
    body = {s.organs[0].semi_axes.z(), 2 * std::min(s.organs[0].semi_axes.x(), s.organs[0].semi_axes.y()),
            "half-ellipsoid"};
  }
  s.boundaries = {planeBoundary("", Vec3::Zero(), Vec3::UnitZ())};
  return body;
}

/// One tissue, two layers with a flat border, or a lump.
std::string addInside(Lot& lot, const DrawnTissue& tissue, const BondedBody& body, const Vec3& fibre, Scene& s) {
  const int borders = lot.oneOf(3);
  if (borders == 0) return body.name + ", " + textOf(tissue);
  const DrawnTissue other = drawTissue(lot, tissue.shear * drawContrast(lot),
                                       lot.chance(0.5) ? tissue.poisson : std::min(0.495, drawPoisson(lot)), fibre);
  Region region;
  region.kind = borders == 1 ? Region::Kind::HalfSpace : Region::Kind::Sphere;
  region.point = Vec3(0, 0, lot.between(0.4, 0.6) * body.height);
  region.radius = lot.between(0.22, 0.35) * body.height;
  addTissue(s, other, region);
  return body.name + (borders == 1 ? " over a layer" : " with a lump") +
         format(" 1 : %.3g, ", other.shear / tissue.shear) + textOf(tissue) + " and " + textOf(other);
}

}  // namespace

MatrixCase drawPress(Lot& lot) {
  MatrixCase one;
  const Vec3 fibre = drawFibre(lot, true);
  const DrawnTissue tissue = drawTissue(lot, lot.logBetween(300, 8000), std::min(0.495, drawPoisson(lot)), fibre);
  Scene& s = one.scene = drawScene(lot, tissue);
  const BondedBody body = drawBody(lot, true, s);
  const auto kinds = toolTypes();
  const int kind = lot.oneOf(static_cast<int>(kinds.size()));
  s.tools[0].shape = ToolShape::of(static_cast<ToolKind>(kind), lot.between(0.2, 0.42) * body.width);
  s.discretization.spacing =
      std::clamp(s.tools[0].shape.radius * lot.between(0.35, 0.9), body.height / 3.8, body.height / 2.3);
  s.tools[0].position =
      Vec3(lot.between(-0.1, 0.1) * body.width, lot.between(-0.1, 0.1) * body.width, body.height + gap);
  s.tools[0].friction = lot.chance(0.3) ? lot.between(0.1, 0.6) : 0;
  s.dynamics.damping = 60;
  one.pressed = true;
  one.looped = lot.chance(0.4);
  one.depth = std::min(lot.between(0.2, 0.8) * s.tools[0].shape.radius, lot.between(0.15, 0.3) * body.height);
  one.kind = std::string("press ") + kinds[static_cast<std::size_t>(kind)]->name;
  one.about = addInside(lot, tissue, body, fibre, s) + format(", spacing %.2g and depth %.2g radii",
                                                              s.discretization.spacing / s.tools[0].shape.radius,
                                                              one.depth / s.tools[0].shape.radius);
  return one;
}

MatrixCase drawBonded(Lot& lot) {
  MatrixCase one;
  const Vec3 fibre = drawFibre(lot, true);
  const DrawnTissue tissue = drawTissue(lot, lot.logBetween(300, 8000), std::min(0.495, drawPoisson(lot)), fibre);
  Scene& s = one.scene = drawScene(lot, tissue);
  const BondedBody body = drawBody(lot, false, s);
  const double height = body.height;
  s.discretization.spacing = height / lot.between(2.5, 3.8);
  BoundarySpec top = planeBoundary("", Vec3(0, 0, height), Vec3::UnitZ());
  beEven(top);
  Vec3 along = Vec3::UnitZ();
  bool moment = false;
  switch (lot.oneOf(5)) {
    case 0:
      one.kind = "bonded stretched";
      top.translation = lot.between(0.05, 0.35) * height * along;
      break;
    case 1:
      one.kind = "bonded compressed";
      top.translation = -lot.between(0.05, 0.2) * height * along;
      break;
    case 2:
      one.kind = "bonded sheared";
      along = Vec3::UnitX();
      top.translation = lot.between(0.1, 0.4) * height * along;
      break;
    case 3:
      one.kind = "bonded twisted";
      moment = true;
      top.angle = lot.between(0.2, 1);
      break;
    default:
      one.kind = "bonded tilted";
      moment = true;
      along = Vec3::UnitX();
      top.axis = along;
      top.axis_point = Vec3(0, 0, height);
      top.angle = lot.between(0.05, 0.25) * height / body.width;
  }
  s.boundaries.push_back(top);
  one.about = addInside(lot, tissue, body, fibre, s);
  const Vec3 arm_from(0, 0, height);
  one.lever = [=](const Vec3& node, const Vec3&, const Vec3& x) {
    if (node.z() < height - 1e-9) return Vec3(Vec3::Zero());
    return moment ? Vec3(along.cross(x - arm_from)) : along;
  };
  return one;
}

}  // namespace palpate::tools

#include "mtled/matrix/matrix_draws.h"

#include <array>
#include <stdexcept>
#include <string_view>

#include "base/number_text.h"
#include "mechanics/materials/material_law.h"

namespace palpate::tools {

double drawPoisson(Lot& lot) {
  const double group = lot.between(0, 1);
  return group < 0.35 ? lot.between(0, 0.45) : group < 0.8 ? lot.between(0.45, 0.49) : lot.between(0.49, 0.499);
}

DrawnTissue drawTissue(Lot& lot, double mu, double nu, const Vec3& fibre) {
  const double K = 2 * mu * (1 + nu) / (3 * (1 - 2 * nu)), young = 2 * mu * (1 + nu);
  const auto laws = materialLaws();
  std::string_view law = laws[static_cast<std::size_t>(lot.oneOf(static_cast<int>(laws.size())))].name;
  if (law == "fibre-reinforced" && fibre.isZero(0)) law = "neo-hookean";
  Material m = Material::of(law);
  if (law == "neo-hookean") {
    m.set("young", young).set("poisson", nu);
  } else if (law == "mooney-rivlin") {
    const double share = lot.between(0.3, 0.9);
    m.set("c10", share * mu / 2).set("c01", (1 - share) * mu / 2).set("D1", 2 / K);
  } else if (law == "ogden") {
    const bool two = lot.chance(0.5);
    const double first = two ? lot.between(0.3, 0.7) : 1;
    const std::array moduli{first * mu, (1 - first) * mu};
    const std::array powers{lot.chance(0.5) ? lot.between(-5, -1) : lot.between(1, 5), lot.between(1.5, 6)};
    const std::size_t count = two ? 2 : 1;
    m.set("mu", std::span(moduli.data(), count)).set("alpha", std::span(powers.data(), count)).set("D1", 2 / K);
  } else if (law == "fibre-reinforced") {
    m.set("young", young).set("poisson", nu);
    m.set("k1", mu * lot.logBetween(0.3, 6)).set("k2", lot.chance(0.5) ? 0 : lot.between(0.2, 3));
    const std::array along{fibre.x(), fibre.y(), fibre.z()};
    m.set("fibre", along);
  } else {
    throw std::logic_error("no parameters are drawn for the law " + std::string(law));
  }
  return {m, mu, nu};
}

Vec3 drawFibre(Lot& lot, bool oblique) {
  if (!oblique || lot.chance(0.4)) return Vec3::Unit(lot.oneOf(3));
  return Vec3(lot.between(-1, 1), lot.between(-1, 1), lot.between(0.1, 1)).normalized();
}

double drawContrast(Lot& lot) {
  const double contrast = lot.logBetween(1, 100);
  return lot.chance(0.5) ? contrast : 1 / contrast;
}

Scene drawScene(Lot& lot, const DrawnTissue& tissue) {
  Scene s;
  s.discretization.seed = 1 + static_cast<unsigned>(lot.oneOf(1000));
  s.materials.assign(1, MaterialSpec{});
  s.materials[0].material = tissue.material;
  if (lot.chance(0.3)) s.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  const int quadrature = lot.oneOf(6);
  if (quadrature == 0) s.discretization.quadrature.cells_per_point = lot.between(1, 2);
  if (quadrature == 1) s.discretization.quadrature.points_per_cell = 4;
  s.tools[0].position = Vec3(0, 0, 1);
  return s;
}

void addTissue(Scene& scene, const DrawnTissue& tissue, const Region& region) {
  MaterialSpec spec;
  spec.everywhere = false;
  spec.material = tissue.material;
  spec.region = region;
  scene.materials.push_back(spec);
}

std::string textOf(const DrawnTissue& tissue) {
  return std::string(tissue.material.lawDescription().name) + format(", nu %.3g", tissue.poisson);
}

}  // namespace palpate::tools

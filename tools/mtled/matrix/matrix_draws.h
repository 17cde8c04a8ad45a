#pragma once

#include "mtled/matrix/matrix_case.h"
#include "mtled/run/plane_boundary.h"

namespace palpate::tools {

// What the families of cases have in common, and the families (matrix_known.cpp, matrix_open.cpp).

/// Tissue as it was drawn.
struct DrawnTissue {
  Material material;
  double shear = 0, poisson = 0;
};

/// 0 .. 0.499, most of them nearly incompressible as soft tissue is.
double drawPoisson(Lot& lot);

/// Any registered law. @param fibre  along which fibres are, where it has some; zero: no law with fibres
DrawnTissue drawTissue(Lot& lot, double shear, double poisson, const Vec3& fibre);

/// A direction along an axis or, with `oblique`, any.
Vec3 drawFibre(Lot& lot, bool oblique);

/// Of a first material to another beside it: 1 : 1 to 1 : 100, to both sides.
double drawContrast(Lot& lot);

/// A scene of that tissue with quadrature, boundary method and cloud drawn, and its tool out of the way.
Scene drawScene(Lot& lot, const DrawnTissue& tissue);

/// Another tissue in a part of it.
void addTissue(Scene& scene, const DrawnTissue& tissue, const Region& region);

/// "ogden, nu 0.43"
std::string textOf(const DrawnTissue& tissue);

// Cases with a closed form.
MatrixCase drawConfined(Lot& lot);
MatrixCase drawSheared(Lot& lot);
MatrixCase drawAffine(Lot& lot);
MatrixCase drawBetweenPlates(Lot& lot);
MatrixCase drawTwisted(Lot& lot);
MatrixCase drawConfinedCore(Lot& lot);
MatrixCase drawSphere(Lot& lot);
MatrixCase drawBent(Lot& lot);

// Cases whose answer finer clouds give.
MatrixCase drawPress(Lot& lot);
MatrixCase drawBonded(Lot& lot);

}  // namespace palpate::tools

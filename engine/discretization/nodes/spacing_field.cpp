#include "discretization/nodes/spacing_field.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace palpate {
namespace {

std::string metres(double length) {
  std::ostringstream text;
  text << length << " m";
  return text.str();
}

bool positive(double length) { return std::isfinite(length) && length > 0; }

}  // namespace

double SpacingField::at(const Vec3& x) const {
  double h = spacing;
  for (const Refinement& r : refinements) {
    const double difference = spacing - r.spacing;
    if (difference == 0 || r.spacing >= h) continue;
    const double wanted = r.blend > 0 ? r.blend : 3 * difference;
    const double blend = std::max(wanted, difference / steepest_growth);
    const double beyond = std::max(0.0, (x - r.centre).norm() - r.radius);
    h = std::min(h, r.spacing + difference * std::min(1.0, beyond / blend));
  }
  return h;
}

double SpacingField::smallest() const {
  double h = spacing;
  for (const Refinement& r : refinements) h = std::min(h, r.spacing);
  return h;
}

void SpacingField::check() const {
  if (!positive(spacing)) {
    throw InputError(place, "the node spacing " + metres(spacing) + " is not a positive length",
                     "give the distance wanted between neighbouring nodes in metres");
  }
  for (const Refinement& r : refinements) {
    if (!positive(r.spacing) || r.spacing > spacing) {
      throw InputError(r.place, "the refined spacing " + metres(r.spacing) + " is not a finer one",
                       "give a positive length in metres, at most the global spacing " + metres(spacing));
    }
    if (!r.centre.allFinite() || !std::isfinite(r.radius) || r.radius < 0 || !std::isfinite(r.blend) || r.blend < 0) {
      throw InputError(r.place, "the refined sphere has a centre, radius or blend that is not usable",
                       "give finite numbers in metres, radius and blend not negative");
    }
  }
}

}  // namespace palpate

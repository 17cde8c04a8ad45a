#include "organs/organ.h"

#include "organs/implicit.h"

namespace palpate::organs {
namespace {

/// `p` turned about the vertical through `centre` so that direction (cosine, sine) becomes +x.
Vec3 turned(const Vec3& p, const Vec3& centre, double cosine, double sine) {
  const double norm = std::sqrt(cosine * cosine + sine * sine);
  const Vec3 d = p - centre;
  return centre + Vec3(cosine * d.x() + sine * d.y(), cosine * d.y() - sine * d.x(), d.z() * norm) / norm;
}

/// A liver lying on its visceral surface, seen from above as an atlas shows it from the
/// front: -x is the patient's right, +y the back and diaphragm, -y the inferior edge.
double liver(const Vec3& p) {
  // The diaphragmatic dome: a big right lobe, a flat left one that points up and away.
  const double right = ellipsoid(p, Vec3(-0.040, 0.004, 0.012), Vec3(0.066, 0.071, 0.078));
  const Vec3 left_centre(0.036, 0.018, 0.004);
  const double left = ellipsoid(turned(p, left_centre, 1.0, 0.16), left_centre, Vec3(0.078, 0.047, 0.047));
  double body = smoothUnion(right, left, 0.030);

  // The front slopes down to the inferior edge, which climbs from the right lobe's tip to the left.
  body = smoothIntersection(body, halfSpace(p, Vec3(0.0, -0.054, 0.010), Vec3(0.34, -1.0, 0.42)), 0.012);

  // The visceral surface: flat, hollowed in the middle, blunt where it meets the dome.
  const double hollow = 0.010 * bump(std::sqrt((p.x() + 0.010) * (p.x() + 0.010) + p.y() * p.y()) / 0.085);
  body = smoothIntersection(body, hollow - p.z(), 0.014);

  // The falciform notch in the inferior edge, and its shallow furrow over the dome.
  const double notch = ellipsoid(p, Vec3(0.030, -0.052, 0.0), Vec3(0.007, 0.024, 0.060));
  body = smoothDifference(body, notch, 0.012);

  const Vec3 q = p / 0.05;
  return body + 0.0012 * noise(q, 7);
}

/// A kidney lying on its flat side, hilum towards +y, upper pole at +x.
double kidney(const Vec3& p) {
  // A bent, flattened capsule whose upper pole is a little broader.
  const Vec3 bent(p.x(), p.y() - 5.0 * p.x() * p.x() + 0.006, p.z() * 1.22);
  const double along = std::clamp(bent.x(), -0.028, 0.028);
  const double radius = 0.0262 + 0.045 * along;
  double body = (bent - Vec3(along, 0, 0)).norm() - radius;
  body = smoothDifference(body, ellipsoid(p, Vec3(0, 0.041, 0), Vec3(0.016, 0.020, 0.011)), 0.008);
  return body + 0.0006 * noise(p / 0.03, 3);
}

}  // namespace

const std::vector<Organ>& allOrgans() {
  static const std::vector<Organ> organs = {
      {"liver", "human-liver-like: domed diaphragmatic side up, resting on its visceral side, -x the patient's right",
       Vec3(-0.16, -0.13, -0.04), Vec3(0.17, 0.13, 0.14), 0.0043, liver},
      {"kidney", "human-kidney-like: lying on its flat side, hilum towards +y", Vec3(-0.08, -0.06, -0.045),
       Vec3(0.08, 0.06, 0.045), 0.0023, kidney},
  };
  return organs;
}

}  // namespace palpate::organs

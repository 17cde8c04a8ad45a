#include "organs/organ.h"

#include "base/input_error.h"
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
  // The diaphragmatic dome: a big right lobe, a flat left one that points away and up.
  const double right = ellipsoid(p, Vec3(-0.047, 0.000, 0.006), Vec3(0.067, 0.085, 0.091));
  const double middle = ellipsoid(p, Vec3(0.002, 0.013, 0.000), Vec3(0.077, 0.067, 0.080));
  const Vec3 left_centre(0.044, 0.022, 0.000);
  const double left = ellipsoid(turned(p, left_centre, 1.0, 0.20), left_centre, Vec3(0.080, 0.053, 0.052));
  double body = smoothUnion(smoothUnion(right, middle, 0.022), left, 0.032);

  // The front slopes down to the inferior edge, which climbs from the right lobe's tip to the left.
  body = smoothIntersection(body, halfSpace(p, Vec3(0.0, -0.064, 0.006), Vec3(0.42, -1.0, 0.40)), 0.024);

  // The falciform ligament: a notch in the inferior edge and a faint furrow from there over the dome.
  const double notch = ellipsoid(p, Vec3(0.040, -0.072, 0.0), Vec3(0.013, 0.034, 0.080));
  body = smoothDifference(body, notch, 0.026);
  body += 0.0010 * bump((p.x() - 0.037 + 0.12 * (p.y() + 0.03)) / 0.022);

  // The visceral surface: hollowed where stomach and kidney lie, blunt where it meets the dome.
  const double hollow = 0.009 * bump(Vec3((p.x() - 0.005) / 0.115, (p.y() - 0.002) / 0.085, 0).norm());
  body = smoothIntersection(body, hollow - p.z(), 0.020);

  // The gallbladder's bed runs in from the inferior edge; the porta crosses behind it.
  const Vec3 bed_centre(-0.014, -0.040, 0.000);
  const double bed = ellipsoid(turned(p, bed_centre, 1.0, -0.25), bed_centre, Vec3(0.015, 0.038, 0.012));
  body = smoothDifference(body, bed, 0.014);
  const double porta = ellipsoid(p, Vec3(0.008, 0.016, 0.006), Vec3(0.036, 0.011, 0.011));
  body = smoothDifference(body, porta, 0.014);

  return body + 0.0010 * noise(p / 0.06, 7);
}

/// A kidney lying on its flat side, hilum towards +y, upper pole at +x.
double kidney(const Vec3& p) {
  // Two poles, the upper one broader, bent around the hilum.
  const Vec3 bent(p.x(), p.y() - 3.6 * p.x() * p.x(), p.z());
  const double upper = ellipsoid(bent, Vec3(0.023, 0, 0), Vec3(0.030, 0.0232, 0.0145));
  const double lower = ellipsoid(bent, Vec3(-0.023, 0, 0), Vec3(0.029, 0.0217, 0.0140));
  double body = smoothUnion(upper, lower, 0.026);
  body = smoothDifference(body, ellipsoid(p, Vec3(-0.001, 0.031, 0), Vec3(0.014, 0.016, 0.008)), 0.008);
  return body + 0.0005 * noise(p / 0.03, 3);
}

/// A brain resting on its base, front towards -y: two hemispheres with a gentle fissure
/// between them, a cerebellum behind and below, and shallow convolutions.
double brain(const Vec3& p) {
  const auto hemisphere = [](const Vec3& q) {
    const double cerebrum = ellipsoid(q, Vec3(0.025, 0.000, 0.050), Vec3(0.041, 0.080, 0.054));
    const double temporal = ellipsoid(q, Vec3(0.043, -0.014, 0.022), Vec3(0.021, 0.044, 0.022));
    return smoothUnion(cerebrum, temporal, 0.012);
  };
  const double both = smoothUnion(hemisphere(p), hemisphere(Vec3(-p.x(), p.y(), p.z())), 0.010);
  const double cerebrum = both + 0.006 * bump(p.x() / 0.010);  // the longitudinal fissure
  const double cerebellum = ellipsoid(p, Vec3(0, 0.046, 0.014), Vec3(0.046, 0.029, 0.021));

  // Sulci run where a smooth noise changes sign, gyri between them; a second noise bends
  // them so that they wander. The cerebellum has none that this mesh could carry.
  const Vec3 wander(noise(p / 0.050, 11), noise(p / 0.050, 12), noise(p / 0.050, 13));
  const double level = noise(p / 0.024 + 0.4 * wander, 9);
  const double convoluted = cerebrum + 0.0026 * bump(level / 0.32);

  const double body = smoothUnion(convoluted, cerebellum, 0.006);
  return smoothIntersection(body, 0.002 - p.z(), 0.016);
}

}  // namespace

const std::vector<Organ>& allOrgans() {
  static const std::vector<Organ> organs = {
      {"liver", "human-liver-like: domed diaphragmatic side up, resting on its visceral side, -x the patient's right",
       Vec3(-0.16, -0.13, -0.04), Vec3(0.17, 0.13, 0.14), 0.0043, liver},
      {"kidney", "human-kidney-like: lying on its flat side, hilum towards +y", Vec3(-0.08, -0.06, -0.045),
       Vec3(0.08, 0.06, 0.045), 0.0023, kidney},
      {"brain", "human-brain-like: resting on its base, front towards -y", Vec3(-0.10, -0.11, -0.02),
       Vec3(0.10, 0.11, 0.15), 0.0034, brain},
  };
  return organs;
}

TriangleSurface isosurface(const Organ& organ, double cell) {
  const SampledField sampled = sampleField(organ.field, organ.min, organ.max, cell);
  if (reachesBox(sampled))
    throw InputError({}, organ.name + " reaches its box", "enlarge min/max in tools/organs/organ.cpp");
  return palpate::isosurface(sampled);
}

}  // namespace palpate::organs

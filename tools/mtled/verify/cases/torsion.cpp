#include <algorithm>
#include <cmath>

#include "mtled/verify/cases/cases.h"

namespace palpate::tools {
namespace {

constexpr double mu = 1000, nu = 0.499;

double young() { return 2 * mu * (1 + nu); }

// Torsion: radius and length of the cylinder, m; twist, rad.
constexpr double R = 0.01, H = 0.02, angle = 2 * M_PI / 3;

Scene torsionScene(double spacing) {
  Scene scene = caseScene(young(), nu);
  scene.name = "torsion";
  scene.tools[0].shape.radius = spacing;  // a finer polygon for the round: the moment goes with R^4
  scene.organs[0].solid = OrganSpec::Solid::Cylinder;
  scene.organs[0].radius = R;
  scene.organs[0].height = H;
  scene.discretization.spacing = spacing;
  scene.discretization.support_factor = 2.0;
  scene.discretization.mmls_weight = 0.1;
  scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ()),
                      planeBoundary("top", Vec3(0, 0, H), Vec3::UnitZ())};
  scene.boundaries.back().angle = angle;
  beEven(scene.boundaries.back());
  return scene;
}

void addTorsionPictures(const CaseContext& context, const StaticSolution& s, CaseResult& result) {
  Figure figure;
  figure.title = "Torsion: moment and normal force";
  figure.x_label = "Twist, degrees";
  figure.y_label = "Moment / 10 mm, and normal force, N";
  Series exact_moment{"moment, closed form", {}, {}, SeriesStyle::Line, ink_colour},
      exact_normal{"normal force, closed form", {}, {}, SeriesStyle::Dashed, ink_colour};
  for (int k = 0; k <= 60; ++k) {
    const double a = angle * k / 60, p = a / H;
    exact_moment.x.push_back(a * 180 / M_PI);
    exact_moment.y.push_back(M_PI / 2 * mu * p * std::pow(R, 4) / R);
    exact_normal.x.push_back(a * 180 / M_PI);
    exact_normal.y.push_back(-M_PI / 4 * mu * p * p * std::pow(R, 4));
  }
  Series our_moment{"moment, mtled", {}, {}, SeriesStyle::Points},
      our_normal{"normal force, mtled", {}, {}, SeriesStyle::Points};
  for (std::size_t k = 0; k < s.reactions.size(); ++k) {
    our_moment.x.push_back(s.steps[k].time * angle * 180 / M_PI);
    our_normal.x.push_back(our_moment.x.back());
    our_moment.y.push_back(s.reactions[k][1].moment.z() / R);
    our_normal.y.push_back(s.reactions[k][1].force.z());
  }
  figure.series = {exact_moment, exact_normal, our_moment, our_normal};
  addFigure(context, "torsion_moment.png", "Moment (over the radius) and normal force against twist", figure, result);
  BodyPicture picture;
  picture.title = "Twisted by 120 degrees";
  addBodyPicture(context, "torsion_body.png", "The twisted cylinder", picture, s, result);
}

// Flexure: thickness, length and width of the block, m.
constexpr double T = 0.01, L = 0.03, W = 0.01;

/// Rivlin's ring, in which the block ends up.
struct Ring {
  double a = L / (M_PI / 2);
  // r_o^2 - r_i^2 = 2 a T and r_i r_o = a^2
  double ri2 = -a * T + std::sqrt(a * a * T * T + std::pow(a, 4)), ro2 = ri2 + 2 * a * T;
  double moment = -mu / 2 * (primitive(std::sqrt(ro2)) - primitive(std::sqrt(ri2))) * W;  // about z at its centre

 private:
  double primitive(double r) const {
    const double D = ri2 / (a * a) + a * a / ri2;
    return std::pow(r, 4) / (4 * a * a) + a * a * std::log(r) - D * r * r / 2;
  }
};

Scene flexureScene(double spacing, const Ring& ring) {
  Scene scene = caseScene(young(), nu);
  scene.name = "flexure";
  scene.organs[0].solid = OrganSpec::Solid::Box;  // x in +-T/2, y in +-L/2, z in 0..W
  scene.organs[0].size = Vec3(T, L, W);
  scene.discretization.spacing = spacing;
  scene.discretization.support_factor = 2.0;
  scene.discretization.mmls_weight = 0.1;
  scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  // Turned by 90 degrees about a point at x = c, all of the end comes to lie at x = c. It is first turned as a
  // stiff plate, about where the ring's centre will be; then only x is imposed, the component along
  // the plane's normal, and the end slides in its plane to where it likes.
  BoundarySpec end = planeBoundary("turned end", Vec3(0, L / 2, 0), Vec3::UnitY(), {true, true, false});
  const double c = -ring.a;
  end.axis_point = Vec3(c, -L / 2, 0);
  end.translation = Vec3(L, 0, 0);
  end.angle = M_PI / 2;
  beEven(end);
  scene.boundaries = {planeBoundary("symmetry", Vec3(0, -L / 2, 0), Vec3::UnitY(), {false, true, false}), end,
                      planeBoundary("front", Vec3::Zero(), Vec3::UnitZ(), {false, false, true}),
                      planeBoundary("back", Vec3(0, 0, W), Vec3::UnitZ(), {false, false, true})};
  return scene;
}

struct FlexureAnswer {
  double moment = NAN, rms = NAN;  // N m; of the displacements' error over T
};

/// The forces on the turned end are along x; their moment about the ring's centre is that of the section.
FlexureAnswer answerOf(const StaticSolution& s, const Ring& ring) {
  std::vector<Vec3> reaction(s.model->X.size(), Vec3::Zero());
  s.solver->body().addNodeReactions(reaction);
  const auto u = fieldAt(s.model->node_shape, s.u());
  FlexureAnswer answer;
  answer.moment = 0;
  double sum = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vec3& X = s.model->X[i];
    const double r = std::sqrt(2 * ring.a * X.x() + (ring.ri2 + ring.ro2) / 2), theta = (X.y() + L / 2) / ring.a;
    const Vec3 exact(-ring.a + r * std::cos(theta) - X.x(), r * std::sin(theta) - (X.y() + L / 2), 0);
    sum += (u[i] - exact).squaredNorm();
    if (std::abs(X.y() - L / 2) < 1e-9) answer.moment -= (X.y() + L / 2 + u[i].y()) * reaction[i].x();
  }
  answer.rms = std::sqrt(sum / static_cast<double>(u.size())) / T;
  return answer;
}

}  // namespace

CaseResult torsionCase(const CaseContext& context) {
  CaseResult result;
  result.name = "torsion";
  result.title = "Torsion of a cylinder by 120 degrees with its normal force (Rivlin)";
  result.reference =
      "Closed form for an incompressible neo-Hookean solid (Rivlin 1949): moment pi/2 mu psi R^4, normal force -pi/4 "
      "mu psi^2 R^4 "
      "with psi the twist per length; cross-sections turn as rigid discs.";
  result.text = "Radius 10 mm, length 20 mm, ends bonded at a fixed distance; mu 1000 Pa, nu 0.499. EBCIEM.";
  std::vector<double> spacings{2.2e-3};
  if (!context.quick) spacings.push_back(1.5e-3);

  ResultTable table{
      "At 120 degrees",
      {"nodes", "points", "variant", "moment", "error", "normal force", "error", "rms displacement error / R", "time"},
      {},
      ""};
  int done = 0;
  const int all = context.quick ? 1 : 6;
  for (const double spacing : spacings)
    for (const Variant& variant : variantsFor(context, spacing != spacings.front())) {
      const CaseContext within = partOf(context, done++, all);
      Scene scene = torsionScene(spacing);
      apply(variant, scene);
      const StaticSolution s = solveCase(scene, evenTimes(context.quick ? 3 : 6), within);
      const bool solved = !s.steps.empty() && s.steps.back().converged;
      const double psi = angle / H;
      const double moment = M_PI / 2 * mu * psi * std::pow(R, 4), normal = -M_PI / 4 * mu * psi * psi * std::pow(R, 4);
      const Reaction top = solved ? s.reactions.back()[1] : Reaction{Vec3::Constant(NAN), Vec3::Constant(NAN)};
      double sum = 0;
      const auto u = fieldAt(s.model->node_shape, s.u());
      for (std::size_t i = 0; i < u.size(); ++i) {
        const Vec3& X = s.model->X[i];
        const Vec3 exact = Eigen::AngleAxisd(psi * X.z(), Vec3::UnitZ()) * X - X;
        sum += (u[i] - exact).squaredNorm();
      }
      const double rms = solved ? std::sqrt(sum / static_cast<double>(u.size())) / R : NAN;
      table.rows.push_back({std::to_string(s.model->nodeCount()), std::to_string(s.model->pointCount()), variant.name,
                            formatted(top.moment.z(), "N m"), formattedSigned((top.moment.z() / moment - 1) * 100, "%"),
                            formatted(top.force.z(), "N"), formattedSigned((top.force.z() / normal - 1) * 100, "%"),
                            formatted(rms), formatted(s.seconds, "s")});
      if (!(variant.consistent_gradients && variant.node_patch_volume)) continue;
      const std::string which = ", " + std::to_string(s.model->nodeCount()) + " nodes, both";
      result.bounds.push_back({"Moment, relative error" + which, std::abs(top.moment.z() / moment - 1),
                               spacing > 2e-3 ? 0.03 : 0.02, true, "", "closed form"});
      result.bounds.push_back({"Normal force, relative error" + which, std::abs(top.force.z() / normal - 1), 0.05, true,
                               "", "closed form"});
      result.bounds.push_back({"Displacement error / R" + which, rms, 0.01, true, "", "closed form"});
      if (!context.pictures || spacing != spacings.back()) continue;
      addTorsionPictures(context, s, result);
    }
  result.tables.push_back(table);
  return result;
}

CaseResult flexureCase(const CaseContext& context) {
  CaseResult result;
  result.name = "flexure";
  result.title = "Bending of a block into a quarter of a ring (Rivlin)";
  result.reference =
      "Closed form for an incompressible neo-Hookean solid (Rivlin 1949): r^2 = 2 a X + b, theta = Y / a, plane "
      "strain, inner and "
      "outer faces free of stress: r_i r_o = a^2; moment from the circumferential stress.";
  result.text =
      "Block 10 x 30 x 10 mm; one end on a plane of symmetry, the other turned by 90 degrees and free to slide in its "
      "plane; mu 1000 Pa, "
      "nu 0.499. EBCIEM.";
  const Ring ring;
  const double moment = ring.moment;
  std::vector<double> spacings{1.9e-3};
  if (!context.quick) spacings.push_back(1.5e-3);
  ResultTable table{"At 90 degrees",
                    {"nodes", "points", "variant", "moment", "error", "rms displacement error / T", "min J", "time"},
                    {},
                    ""};
  int done = 0;
  const int all = context.quick ? 1 : 6;
  for (const double spacing : spacings)
    for (const Variant& variant : variantsFor(context, spacing != spacings.front())) {
      const CaseContext within = partOf(context, done++, all);
      Scene scene = flexureScene(spacing, ring);
      apply(variant, scene);
      const StaticSolution plate = solveCase(scene, evenTimes(2), within, 3e-2);
      scene.boundaries[1].component[1] = false;
      const StaticSolution s = solveCase(scene, {1.0}, within, 1e-4, &plate);
      const bool solved = !s.steps.empty() && s.steps.back().converged;
      const auto [turned, rms] = solved ? answerOf(s, ring) : FlexureAnswer{};
      table.rows.push_back({std::to_string(s.model->nodeCount()), std::to_string(s.model->pointCount()), variant.name,
                            formatted(turned, "N m"), formattedSigned((turned / moment - 1) * 100, "%"), formatted(rms),
                            formatted(s.steps.empty() ? NAN : s.steps.back().min_J), formatted(s.seconds, "s")});
      if (!(variant.consistent_gradients && variant.node_patch_volume)) continue;
      const std::string which = ", " + std::to_string(s.model->nodeCount()) + " nodes, both";
      result.bounds.push_back({"Moment, relative error" + which, std::abs(turned / moment - 1),
                               spacing > 1.6e-3 ? 0.05 : 0.03, true, "", "closed form"});
      result.bounds.push_back({"Displacement error / T" + which, rms, 0.02, true, "", "closed form"});
      if (!context.pictures || spacing != spacings.back()) continue;
      BodyPicture picture;
      picture.title = "Bent into a quarter of a ring";
      picture.azimuth_deg = -80;
      picture.elevation_deg = 60;
      addBodyPicture(context, "flexure_body.png", "The bent block", picture, s, result);
    }
  table.note = "Closed form: moment " + formatted(moment, "N m") + ".";
  result.tables.push_back(table);
  return result;
}

}  // namespace palpate::tools

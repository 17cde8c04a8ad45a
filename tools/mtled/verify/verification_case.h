#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "batch/static_solver.h"
#include "mtled/report/case_result.h"
#include "mtled/report/pictures.h"
#include "mtled/run/plane_boundary.h"

namespace palpate::tools {

/// What a verification case is given.
struct CaseContext {
  bool quick = false;  // the coarse rows only, for CI
  int threads = 1;
  std::string references;        // folder of the reference files, tests/reference
  std::string folder;            // where pictures go
  Pictures* pictures = nullptr;  // null: none are wanted, or none can be drawn
  std::function<void(double fraction, const std::string& what)> progress = [](double, const std::string&) {};
};

/// One of the program's verification cases.
struct VerificationCase {
  const char* name;   // as on the command line
  const char* about;  // one line
  CaseResult (*run)(const CaseContext&);
};

/// All of them, in the report's order.
const std::vector<VerificationCase>& verificationCases();

// What the cases share.

/// The two steps beyond the paper that every table shows on and off.
struct Variant {
  const char* name;
  bool consistent_gradients, node_patch_volume;
};
inline constexpr Variant variants[] = {{"as the paper", false, false},
                                       {"node patches", false, true},
                                       {"consistent gradients", true, false},
                                       {"both", true, true}};
void apply(const Variant& variant, Scene& scene);
/// All of them; for a case's fine rows the first and the last, for a quick run the last, which bounds are for.
std::vector<Variant> variantsFor(const CaseContext& context, bool fine = false);

/// The context of a part of a case's work, of `width` from `begin` in units of which the case has `all`.
CaseContext partOf(const CaseContext& context, double begin, double all, double width = 1);

/// A scene with one neo-Hookean material and the tool out of the way.
Scene caseScene(double young, double poisson);

/// A model and the equilibria it went through.
struct StaticSolution {
  std::unique_ptr<Model> model;
  std::unique_ptr<StaticSolver> solver;
  std::vector<Equilibrium> steps;                // the start at rest not included
  std::vector<std::vector<Reaction>> reactions;  // (step)(boundary)
  double seconds = 0;                            // without set-up

  const AlignedVector<Double4>& u() const { return solver->body().u; }
  AlignedVector<Float4> uForPictures() const;
  std::vector<Vec3> uAsVectors() const;
  /// The displacement field at points of the body at rest, m.
  std::vector<Vec3> at(const std::vector<Vec3>& X) const;
};

/// Follows a scene to each of `times` (s of its load curves). Stops early where no equilibrium is found:
/// steps.back().converged is then false.
/// @param start_from  a solution of the same nodes with other boundaries, to go on from; null: from rest
/// @param organ  the body's closed surface, m, where no file or solid of the scene is it; else null
StaticSolution solveCase(const Scene& scene, const std::vector<double>& times, const CaseContext& context,
                         double tolerance = 1e-4, const StaticSolution* start_from = nullptr,
                         const TriangleSurface* organ = nullptr);

/// Writes a plot, or the deformed body, as `file` into the context's folder and lists it in the result. Only with
/// context.pictures.
void addFigure(const CaseContext& context, const std::string& file, const std::string& caption, const Figure& figure,
               CaseResult& result);
void addFigure(const CaseContext& context, const std::string& file, const std::string& caption, const Histogram& figure,
               CaseResult& result);
void addBodyPicture(const CaseContext& context, const std::string& file, const std::string& caption,
                    const BodyPicture& picture, const StaticSolution& solution, CaseResult& result,
                    const CutPlane* cut = nullptr);

/// 1/n, 2/n, .., 1.
std::vector<double> evenTimes(int n);

/// The paper's normalised root mean square error, by component: rms difference over the reference's range.
Vec3 nrmse(const std::vector<Vec3>& computed, const std::vector<Vec3>& reference);

/// A reference's value at x, linear between its rows; NaN outside.
double interpolated(const std::vector<double>& at, const std::vector<double>& value, double x);

}  // namespace palpate::tools

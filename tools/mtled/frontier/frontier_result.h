#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "mtled/report/pictures.h"
#include "mtled/run/converged_run.h"

namespace palpate::tools {

/// One setting's place on the frontier.
struct FrontierRow {
  std::string group, name;
  int nodes = 0, points = 0, substeps = 0, threads = 1;
  double dt = 0;  // s
  double setup_seconds = 0;
  RunCost cost;
  double realtime_factor = 0;  // that it could reach: physics time over computing time
  RunError error;              // against the reference; NaN where the run is not sound
  double peak_force = 0;       // N
  double min_J = 1;
  std::string trouble;  // why its errors are not given; empty: none
};

struct Frontier {
  std::string scene, way, build;
  std::string identity;  // hash of scene and way, hexadecimal: what a resumed run must agree in
  double rate_hz = 0;
  ConvergedReference reference;
  std::vector<FrontierRow> rows;  // the first is the scene as it is
};

/// Indices of the rows than which none is both cheaper and of smaller force error.
std::vector<int> bestRows(const Frontier& frontier);

void printFrontier(std::ostream& out, const Frontier& frontier);
std::string csvOf(const Frontier& frontier);
std::string jsonOf(const Frontier& frontier);
/// Throws std::runtime_error where the text is no frontier.
Frontier frontierFromJson(const std::string& text);
/// Cost against force error, by group, with the Pareto front and the scene's present place.
Figure frontierFigure(const Frontier& frontier);

}  // namespace palpate::tools

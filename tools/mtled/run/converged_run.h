#pragma once

#include <functional>

#include "mtled/run/scene_spacing.h"
#include "mtled/run/scripted_run.h"

namespace palpate::tools {

/// What a converged run is.
struct ConvergedReference {
  int nodes = 0, points = 0;
  double peak_force = 0;        // N
  int coarser_nodes = 0;        // of the next coarser solution
  RunError convergence;         // its distance from the reference
  double layer_error = 0;       // Body::layer_error of the finest: it does not see all of a thin layer, either
  std::string layer_warning{};  // layerWarning of it; not kept in files
};

/// The fields that files keep of it, with their names there.
template <class Reference, class Each>
void eachReferenceField(Reference& r, Each each) {
  each("nodes", r.nodes);
  each("points", r.points);
  each("peak_force_N", r.peak_force);
  each("coarser_nodes", r.coarser_nodes);
  each("force_distance", r.convergence.force);
  each("displacement_distance", r.convergence.displacement);
}

/// A scene's way followed on finer clouds: what its errors are measured against.
struct ConvergedRun {
  ConvergedReference about;
  ScriptedRun run, coarser;  // the finest, and the one that shows how far it still is from the limit
};

/// How fine a converged run is.
struct Fineness {
  double outside = 0.75, inside = 0.4;  // times the scene's spacing, away from the tool's way and at it
  double coarser = 1.35;  // times these spacings, for the solution that shows how far the reference still is
};

/// The scene at that fineness, each cell with a point of its own, with a step of at most 0.4 of the critical one.
/// @param places  where the tools work
/// @param watch  told what is done (fraction of it, text)
/// Throws std::runtime_error where one of the runs is not sound, or its force trembles (trembleOf).
ConvergedRun convergedRun(const Model& present, const ToolTrajectory& way, const std::vector<Vec3>& probes,
                          const std::vector<ContactRegion>& places, const Fineness& fineness, int threads,
                          const std::function<void(double, const std::string&)>& watch);

/// Tells model, tool's way and program from others, and these numbers: what a resumed run must agree in. Hexadecimal.
std::string runIdentity(const Model& model, const ToolTrajectory& way, const std::vector<double>& numbers);

/// Keeps a converged run in a file. @param identity  of scene and way, checked by the reader
void writeConvergedRun(const std::string& file, const ConvergedRun& converged, const std::string& identity);
/// False where there is no such file of that identity, or it is damaged.
bool readConvergedRun(const std::string& file, const std::string& identity, ConvergedRun& converged);

/// Points of the surface at which displacements are compared: evenly chosen vertices of the skin.
std::vector<Vec3> surfaceProbes(const Model& model, int count);

}  // namespace palpate::tools

// Time of one force evaluation, per integration point and step, beside a plain kernel in the same run.

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "base/build_info.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "mechanics/internal_forces.h"
#include "simulation/step.h"
#include "simulation/workspace.h"

using namespace palpate;

namespace {

/// Best of several rounds, in ns per point: the machine's noise only ever adds.
template <class Body>
double nanosecondsPerPoint(int points, double seconds, Body&& body) {
  using Clock = std::chrono::steady_clock;
  double best = 1e300;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  do {
    const auto start = Clock::now();
    body();
    best = std::min(best, std::chrono::duration<double, std::nano>(Clock::now() - start).count() / points);
  } while (Clock::now() < end);
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Times the internal-force kernel on a scene's model: ns per integration point and step, and the share of a\n"
               "tick. The baseline is the plain fixed-size double kernel that the tests hold the fast one to.");
  std::string scene_path;
  double seconds = 1;
  app.add_option("scene", scene_path, "Scene file, e.g. assets/scenes/liver.toml")->required();
  app.add_option("--seconds", seconds, "Time spent on each figure");
  CLI11_PARSE(app, argc, argv);

  try {
    const Model model = loadModel(readScene(scene_path));
    const int points = model.pointCount();
    std::vector<Vec3> u(model.X.size()), f;
    AlignedVector<Float4> u4;
    for (std::size_t i = 0; i < u.size(); ++i) {
      u[i] = 0.05 * Vec3(model.X[i].y(), model.X[i].z(), model.X[i].x());
      u4.push_back(toFloat4(u[i]));
    }
    std::printf("%s\n%d nodes, %d points, mean support %.1f, %.0f B of gradients per point\n", buildInfo().c_str(),
                model.nodeCount(), points, model.point_shape.meanSupport(),
                static_cast<double>(model.kernel.gradN.size()) * 4 / points);
    const double plain = nanosecondsPerPoint(points, seconds, [&] {
      referenceInternalForces(model.point_shape, model.point_volume, model.point_material, model.materials, u, f);
    });
    std::printf("%-34s %8.1f ns per point   1.00 x\n", "plain double kernel, 1 thread", plain);
    for (const int threads : {1, 2}) {
      Workspace workspace(model, threads);
      workspace.team.wake();
      const double fast =
          nanosecondsPerPoint(points, seconds, [&] { internalForces(model.kernel, u4.data(), workspace.kernel, workspace.team); });
      State state = initialState(model);
      Command command;
      command.tool_target = model.tool_start;
      const double whole = nanosecondsPerPoint(points * model.substeps_per_tick, seconds,
                                               [&] { tick(model, state, command, workspace); });
      workspace.team.park();
      std::printf("quad kernel, float32, %d thread%s    %8.1f ns per point %6.2f x\n", threads, threads > 1 ? "s" : " ", fast, plain / fast);
      std::printf("  whole step %.1f ns per point; %d steps of %.3g ms take %.1f %% of a tick at %g Hz\n", whole,
                  model.substeps_per_tick, model.dt * 1e3,
                  whole * 1e-9 * points * model.substeps_per_tick * model.scene.rate_hz * 100, model.scene.rate_hz);
    }
  } catch (const InputError& e) {
    std::fprintf(stderr, "kernel_bench: %s\n", e.what());
    return 2;
  }
  return 0;
}

// The least that a program needs: loads a scene, presses the tool 2 mm into the tissue within a second, prints the
// force.
#include <exception>
#include <iostream>

#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "step/workspace.h"

int main(int argc, char** argv) try {
  using namespace palpate;
  const Model model = loadModel(readScene(findScene(argc > 1 ? argv[1] : "layer_sphere")));
  State state = initialState(model);
  Workspace workspace(model, 1);
  StepReport report;
  Command command;
  const Vec3 way = (model.tools.first().first_contact_travel + 0.002) *
                   (model.tools.first().start.pose.orientation * -Vec3::UnitZ());
  for (double t = 0; t < 1; t += 1 / model.scene.dynamics.rate_hz) {
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position += t * way;
    report = tick(model, state, command, workspace);
  }
  std::cout << "force on the tool: " << report.tool_force.transpose() << " N" << std::endl;
} catch (const std::exception& error) {
  std::cerr << "hello: " << error.what() << std::endl;
  return 2;
}

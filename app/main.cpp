// palpate SCENE: press a probe into soft tissue, in a window or off-screen.
#include <exception>
#include <iostream>

#include "app/panels/log.h"
#include "app/run/gl_window.h"
#include "app/run/offscreen_run.h"
#include "app/run/options.h"
#include "app/run/session.h"
#include "app/run/window.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/printable_text.h"
#include "io/output_file.h"

namespace {

constexpr int failed = 1, unusable_input = 2;

int run(const palpate::app::Options& options) {
  using namespace palpate;
  using namespace palpate::app;
  if (options.scene.ends_with(".png")) return comparePictures(options);
  const Scene scene = app::readScene(options);
  if (options.check_lumps) return checkLumps(options, scene);
  Log log;
  std::string failure;
  int code = 0;
  if (options.offscreen) {
    checkReferences(options);
    Session session(options, scene, log);
    code = runOffscreen(session);
    failure = session.failure();
    if (!failure.empty() && code != 0) {  // it has a code of its own
      std::cerr << "palpate: " << failure << std::endl;
      return code;
    }
  } else {
    requireDisplay();
    failure = runWindow(options, scene, log);
  }
  if (!failure.empty()) throw std::runtime_error(failure);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  const palpate::app::ParsedOptions parsed = palpate::app::parseOptions(argc, argv);
  palpate::catchInterrupts();
  try {
    int code = parsed.exit_code;
    if (parsed.options)
      code = run(*parsed.options);
    else
      (parsed.exit_code == 0 ? std::cout : std::cerr) << parsed.message << std::endl;
    palpate::finishStandardOutput();
    return code;
  } catch (const palpate::InputError& error) {
    std::cerr << "palpate: " << palpate::printable(error.what(), palpate::LineEnds::Keep) << std::endl;
    return unusable_input;
  } catch (const std::exception& error) {
    std::cerr << "palpate: " << palpate::printable(error.what(), palpate::LineEnds::Keep) << std::endl;
    return failed;
  }
}

// palpate SCENE: press a probe into soft tissue, in a window or off-screen.
#include <exception>
#include <iostream>

#include "app/panels/log.h"
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

void run(const palpate::app::Options& options) {
  using namespace palpate;
  using namespace palpate::app;
  const Scene scene = app::readScene(options);
  if (!options.offscreen) requireDisplay();
  Log log;
  Session session(options, scene, log);
  if (options.offscreen)
    runOffscreen(session);
  else
    runWindow(session);
  if (!session.failure().empty()) throw std::runtime_error(session.failure());
}

}  // namespace

int main(int argc, char** argv) {
  const palpate::app::ParsedOptions parsed = palpate::app::parseOptions(argc, argv);
  palpate::catchInterrupts();
  try {
    if (parsed.options)
      run(*parsed.options);
    else
      (parsed.exit_code == 0 ? std::cout : std::cerr) << parsed.message << std::endl;
    palpate::finishStandardOutput();
    return parsed.exit_code;
  } catch (const palpate::InputError& error) {
    std::cerr << "palpate: " << palpate::printable(error.what(), palpate::LineEnds::Keep) << std::endl;
    return unusable_input;
  } catch (const std::exception& error) {
    std::cerr << "palpate: " << palpate::printable(error.what(), palpate::LineEnds::Keep) << std::endl;
    return failed;
  }
}

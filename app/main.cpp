// palpate SCENE: press a probe into soft tissue, in a window or off-screen.
#include <exception>
#include <iostream>

#include "app/interrupt.h"
#include "app/log.h"
#include "app/offscreen_run.h"
#include "app/options.h"
#include "app/session.h"
#include "app/window.h"
#include "base/input_error.h"
#include "io/output_file.h"

namespace {

constexpr int failed = 1, unusable_input = 2;

void run(const palpate::Options& options) {
  using namespace palpate;
  const Scene scene = readScene(options);
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
  const palpate::ParsedOptions parsed = palpate::parseOptions(argc, argv);
  palpate::catchInterrupts();
  try {
    if (parsed.options)
      run(*parsed.options);
    else
      (parsed.exit_code == 0 ? std::cout : std::cerr) << parsed.message << std::endl;
    palpate::finishStandardOutput();
    return parsed.exit_code;
  } catch (const palpate::InputError& error) {
    std::cerr << "palpate: " << error.what() << std::endl;
    return unusable_input;
  } catch (const std::exception& error) {
    std::cerr << "palpate: " << error.what() << std::endl;
    return failed;
  }
}

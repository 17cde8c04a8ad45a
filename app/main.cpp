// palpate SCENE: press a probe into soft tissue, in a window or off-screen.
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "app/panels/log.h"
#include "app/run/gl_window.h"
#include "app/run/offscreen_run.h"
#include "app/run/options.h"
#include "app/run/session.h"
#include "app/run/window.h"
#include "app/trainer/class_scores.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "io/output_file.h"

namespace {

constexpr int failed = 1, unusable_input = 2, interrupted_run = 130;
constexpr auto told_every = std::chrono::seconds(10);

/// `palpate batch ...` is a command of mtled, which lies beside this program or, where it was built, in tools/.
/// Returns only where there is none.
int runBatch(char** argv) {
  std::error_code ignored;
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* place : {"mtled", "tools/mtled"}) execv((folder / place).c_str(), argv);
  std::cerr << "palpate: can't run " << (folder / "mtled").string() << " for \"batch\": " << std::strerror(errno)
            << "; build it: tools/build release mtled" << std::endl;
  return failed;
}

int run(const palpate::app::Options& options) {
  using namespace palpate;
  using namespace palpate::app;
  if (!options.scores.empty()) return writeClassScores(options.scores, options.out);
  if (options.scene.ends_with(".png")) return comparePictures(options);
  const Scene scene = app::readScene(options);
  if (options.check_lumps) return checkLumps(options, scene);
  Log log;
  std::string failure;
  int code = 0;
  if (options.offscreen) {
    checkReferences(options, scene);
    // Set-ups that take long say how far they are, now and then.
    auto told = std::chrono::steady_clock::now();
    Session session(options, scene, log, [&](const std::string& stage, double fraction) {
      const auto now = std::chrono::steady_clock::now();
      if (now - told < told_every) return;
      told = now;
      log.info("getting the tissue ready: " + stage + format(", %.0f %%", 100 * fraction));
    });
    code = runOffscreen(session);
    failure = session.failure();
    if (!failure.empty() && code != 0) {  // it has a code of its own
      std::cerr << "palpate: " << failure << std::endl;
      return code;
    }
  } else {
    requireDisplay();
    failure = runWindow(options, scene, log);
    if (interrupted()) code = interrupted_run;
  }
  if (!failure.empty()) throw std::runtime_error(failure);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "batch") == 0) return runBatch(argv);
  const palpate::app::ParsedOptions parsed = palpate::app::parseOptions(argc, argv);
  palpate::catchInterrupts();
  std::signal(SIGPIPE, SIG_IGN);  // who reads the log may go, and files are still written
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
    return palpate::interrupted() ? interrupted_run : failed;
  }
}

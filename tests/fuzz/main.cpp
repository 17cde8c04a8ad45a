#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>

#include "fuzz/mutator.h"
#include "fuzz/reader.h"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/common_interface_defs.h>
#endif

// Feeds the readers of input files with damaged inputs. Exit code: 0 where each was taken or refused as it must be;
// otherwise the input that was not, and how to have it again, stand on stderr.

namespace {

using namespace palpate::fuzz;

struct Options {
  std::string reader;  // "": all
  std::uint64_t seed = 1, first = 0, count = 20'000;
  double seconds = 0;  // > 0: as long, however many
  std::string input;   // a file to read instead
  std::string keep;    // a folder for the seeds
  bool list = false;
};

constexpr unsigned most_seconds_an_input = 60;

// What is being read, for the signal handler.
char again[200];
volatile std::size_t again_length = 0;

void describe(const Reader& reader, std::uint64_t seed, std::uint64_t number) {
  const int length =
      std::snprintf(again, sizeof again, "again with: --reader %s --seed %llu --first %llu --count 1\n", reader.name,
                    static_cast<unsigned long long>(seed), static_cast<unsigned long long>(number));
  again_length = static_cast<std::size_t>(length);
}

void tellWhichInput() {
  constexpr char text[] = "\nfuzz: the program ended while it read an input (or took a minute for it); ";
  if (::write(STDERR_FILENO, text, sizeof text - 1) < 0 || ::write(STDERR_FILENO, again, again_length) < 0) return;
}

extern "C" void onFatalSignal(int signal) {
  tellWhichInput();
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

void catchFatalSignals() {
  static char stack[1 << 16];  // of its own: the usual one may be what has run out
  stack_t alternative{};
  alternative.ss_sp = stack;
  alternative.ss_size = sizeof stack;
  ::sigaltstack(&alternative, nullptr);
  struct sigaction action {};
  action.sa_handler = onFatalSignal;
  action.sa_flags = SA_ONSTACK | static_cast<int>(SA_RESETHAND);
#ifdef __SANITIZE_ADDRESS__
  __sanitizer_set_death_callback(tellWhichInput);  // its own handlers say more of a crash
  ::sigaction(SIGALRM, &action, nullptr);
#else
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM}) ::sigaction(signal, &action, nullptr);
#endif
}

int readOne(const Options& options) {
  const Reader& reader = readerOf(options.reader);
  std::ifstream file(options.input, std::ios::binary);
  if (!file) throw std::invalid_argument("can't open " + options.input);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::cout << reader.name << (takes(reader, bytes) ? ": taken\n" : ": refused\n");
  return 0;
}

int readMany(const Reader& reader, const Options& options) {
  const Mutator mutator(options.seed, reader.seeds());
  const auto start = std::chrono::steady_clock::now();
  const auto goesOn = [&](std::uint64_t done) {
    if (options.seconds <= 0) return done < options.count;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < options.seconds;
  };
  std::uint64_t done = 0, taken = 0;
  for (; goesOn(done); ++done) {
    const std::uint64_t number = options.first + done;
    describe(reader, options.seed, number);
    ::alarm(most_seconds_an_input);
    const std::string bytes = mutator.input(number);
    try {
      const bool took = takes(reader, bytes);
      if (took) ++taken;
      if (!took && number < reader.seeds().size()) throw Fault("a sound input is refused");
    } catch (const std::exception& error) {
      std::cerr << "fuzz: " << reader.name << ", input " << number << ": " << error.what() << "; " << again;
      return 1;
    }
  }
  ::alarm(0);
  std::cout << reader.name << ": " << done << " inputs, " << taken << " taken, " << done - taken << " refused; seed "
            << options.seed << std::endl;
  // Where all or nothing passes, the damage tests nothing.
  const bool telling = done < 1000 || (taken * 200 > done && (done - taken) * 20 > done);
  if (!telling) std::cerr << "fuzz: " << reader.name << ": too few inputs were taken or refused\n";
  return telling ? 0 : 1;
}

int keepSeeds(const Reader& reader, const std::string& folder) {
  int k = 0;
  for (const std::string& seed : reader.seeds()) {
    std::ofstream out(folder + "/" + reader.name + "_" + std::to_string(k++), std::ios::binary);
    out << seed;
    if (!out.flush()) throw std::runtime_error("can't write to " + folder);
  }
  return 0;
}

int run(const Options& options) {
  if (!options.input.empty()) return readOne(options);
  int code = 0;
  for (const Reader& reader : readers()) {
    if (!options.reader.empty() && &reader != &readerOf(options.reader)) continue;
    if (options.list)
      std::cout << reader.name << '\n';
    else if (!options.keep.empty())
      code |= keepSeeds(reader, options.keep);
    else
      code |= readMany(reader, options);
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Feeds the readers of input files with damaged inputs, the same for the same seed.");
  app.add_option("--reader", options.reader, "One of --list; otherwise all");
  app.add_option("--seed", options.seed, "Of the damage")->capture_default_str();
  app.add_option("--first", options.first, "Number of the first input")->capture_default_str();
  app.add_option("--count", options.count, "How many inputs for each reader")->capture_default_str();
  app.add_option("--seconds", options.seconds, "How long for each reader, instead of --count");
  app.add_option("--input", options.input, "Read this file instead; needs --reader")->needs("--reader");
  app.add_option("--write-seeds", options.keep, "Write the undamaged inputs into this folder instead");
  app.add_flag("--list", options.list, "Print the readers' names instead");
  CLI11_PARSE(app, argc, argv);
  catchFatalSignals();
  try {
    return run(options);
  } catch (const std::exception& error) {
    std::cerr << "fuzz: " << error.what() << std::endl;
    return 1;
  }
}

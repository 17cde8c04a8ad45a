#include "mtled/atlas/atlas_command.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <mutex>
#include <thread>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "mtled/atlas/atlas_page.h"
#include "mtled/atlas/atlas_run.h"
#include "mtled/report/pictures.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

std::vector<AtlasCell> chosenCells(const AtlasOptions& options, const std::vector<AtlasAxis>& axes,
                                   const std::vector<AtlasCell>& all) {
  for (const auto& name : options.cells) {
    const bool known =
        std::any_of(all.begin(), all.end(), [&](const AtlasCell& c) { return c.name() == name || c.axis == name; });
    if (known) continue;
    std::string names;
    for (const auto& axis : axes) names += (names.empty() ? "" : ", ") + axis.key;
    for (const auto& c : all) names += ", " + c.name();
    throw InputError({}, "there is no cell " + inQuotes(name) + " in the atlas", "the axes and cells are " + names);
  }
  std::vector<AtlasCell> chosen;
  const auto asked = [&](const std::string& name) {
    return std::find(options.cells.begin(), options.cells.end(), name) != options.cells.end();
  };
  for (const auto& c : all) {
    const bool due =
        c.when == AtlasCell::When::Always || c.when == (options.quick ? AtlasCell::When::Quick : AtlasCell::When::Full);
    // A cell that is named is run; an axis that is named is run as far as it is due.
    if (asked(c.name()) || (due && (options.cells.empty() || asked(c.axis)))) chosen.push_back(c);
  }
  return chosen;
}

AtlasRow runCell(const AtlasCell& cell) {
  AtlasRow row;
  row.axis = cell.axis;
  row.name = cell.name();
  row.value = cell.value;
  const auto start = std::chrono::steady_clock::now();
  try {
    row.measure = cell.run();
  } catch (const InputError& error) {
    row.measure.refused = error.what();
  }
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return row;
}

/// Runs the cells that `before` lacks, one on each core. The last are begun first: among them are the longest, which
/// would else run alone in the end.
/// @param keep  gets after each cell all that are done, in their order; never called by two threads at once
/// @return whether it was interrupted
bool runCells(const std::vector<AtlasCell>& cells, const Atlas& before,
              const std::function<void(std::vector<AtlasRow>)>& keep) {
  ProgressLine progress("atlas");
  std::mutex mutex;  // of what follows
  std::map<std::size_t, AtlasRow> done;
  std::size_t left = cells.size();
  bool stopped = false;
  std::exception_ptr error;

  const auto work = [&] {
    std::unique_lock lock(mutex);
    while (left > 0 && !stopped) {
      const std::size_t k = --left;
      const AtlasCell& cell = cells[k];
      progress.show(static_cast<double>(done.size()) / static_cast<double>(cells.size()), cell.name());
      const auto earlier = std::find_if(before.rows.begin(), before.rows.end(),
                                        [&](const AtlasRow& r) { return r.name == cell.name(); });
      try {
        AtlasRow row;
        if (earlier != before.rows.end()) {
          row = *earlier;
        } else {
          lock.unlock();
          if (interrupted()) throw AtlasInterrupted();
          row = runCell(cell);
          lock.lock();
        }
        done[k] = std::move(row);
        std::vector<AtlasRow> rows;
        rows.reserve(done.size());
        for (const auto& [place, one] : done) rows.push_back(one);
        keep(std::move(rows));
      } catch (...) {
        if (!lock.owns_lock()) lock.lock();
        if (!stopped) error = std::current_exception();
        stopped = true;
      }
    }
  };
  std::vector<std::thread> others;
  const auto threads = std::min<std::size_t>(cells.size(), std::thread::hardware_concurrency());
  for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (auto& t : others) t.join();
  try {
    if (error) std::rethrow_exception(error);
  } catch (const AtlasInterrupted&) {
  }
  return stopped;
}

Atlas earlierAtlas(const std::string& file, const std::string& identity) {
  if (!std::filesystem::exists(file)) throw InputError({file}, "there is nothing to resume", "start without --resume");
  Atlas before;
  try {
    before = atlasFromJson(readWholeFile(file));
  } catch (const std::runtime_error&) {
    throw InputError({file}, "this is no atlas", "start without --resume");
  }
  if (before.identity != identity)
    throw InputError({file}, "this was made by another program", "start without --resume");
  return before;
}

std::string commandOf(const AtlasOptions& options) {
  std::string command = "build/release/tools/mtled atlas";
  for (const auto& name : options.cells) command += " " + name;
  if (options.quick) command += " --quick";
  return command + " --report " + options.report;
}

}  // namespace

int atlasCommand(const AtlasOptions& options) { return atlasCommand(options, atlasAxes(), atlasCells()); }

int atlasCommand(const AtlasOptions& options, const std::vector<AtlasAxis>& axes, const std::vector<AtlasCell>& all) {
  const auto cells = chosenCells(options, axes, all);
  Atlas atlas;
  atlas.build = buildInfo();
  atlas.identity = sourceIdentity() + ", " + atlas.build;
  Atlas before;
  if (options.resume) before = earlierAtlas(options.out + "/atlas.json", atlas.identity);
  makeFolder(options.out);
  const auto write = [&] {
    writeWholeFile(options.out + "/atlas.json", jsonOf(atlas));
    writeWholeFile(options.out + "/atlas.csv", csvOf(atlas));
    if (!options.json.empty()) writeWholeFile(options.json, jsonOf(atlas));
  };

  const bool stopped = runCells(cells, before, [&](std::vector<AtlasRow> rows) {
    atlas.rows = std::move(rows);
    write();
  });
  printAtlas(std::cout, atlas);
  std::cout << "\ntable        " << options.out << "/atlas.csv\nresults      " << options.out << "/atlas.json\n";
  if (!atlas.rows.empty()) {
    std::cout << "picture      " << writePicture(options.out + "/atlas.png", atlas, axes) << "\n";
    if (!options.report.empty()) writeAtlasPage(options.report, commandOf(options), atlas, axes);
  }
  std::cout.flush();
  if (stopped) std::cerr << "mtled: interrupted; --resume goes on with the next cell\n";
  return stopped || atlas.count(AtlasOutcome::Silent) > 0 ? 1 : 0;
}

}  // namespace palpate::tools

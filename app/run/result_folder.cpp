#include "app/run/result_folder.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "app/run/saved_files.h"
#include "io/output_file.h"

namespace palpate::app {

namespace {

const char* const elsewhere = "choose another place with --out";

/// Characters of the header that all runs have: without its line end, which comes when the run's tools are known.
const std::size_t common_columns = std::strlen(force_csv_header) - 1;

}  // namespace

ResultFolder::ResultFolder(const std::string& folder, bool with_forces)
    : folder_(folder), with_forces_(with_forces), pending_(with_forces ? forceFile() : "") {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error || !std::filesystem::is_directory(folder_, error))
    failWriting(folder_, error ? error.value() : ENOTDIR, elsewhere);
  if (!with_forces_) {
    checkWritable(reportFile(), elsewhere);
    return;
  }
  errno = 0;
  forces_.open(pending_.part(), std::ios::trunc);
  if (!forces_) failWriting(forceFile(), errno, elsewhere);
  forces_ << std::string_view(force_csv_header).substr(0, common_columns) << std::flush;
  checkForces();
}

void ResultFolder::begin(const ForceColumns& columns) {
  columns_ = columns;
  removeScore(fileNamed("score.json"));
  if (with_forces_) {
    errno = 0;
    forces_ << forceCsvHeader(columns).substr(common_columns) << std::flush;
    checkForces();
  }
  if (pending_.pending()) pending_.takePlace(elsewhere);
}

void ResultFolder::checkForces() {
  if (forces_) return;
  forces_lost_ = true;
  failWriting(forceFile(), errno, elsewhere);
}

void ResultFolder::addForce(const ForceSample& s, const ToolReadings& readings) {
  if (!with_forces_ || forces_lost_) return;
  errno = 0;
  forces_ << forceCsvRow(s, readings, columns_);
  checkForces();
}

void ResultFolder::finishForces() {
  if (!with_forces_ || forces_lost_) return;
  errno = 0;
  forces_.close();
  checkForces();
}

void ResultFolder::writeReport(const std::string& json) const { writeWholeFile(reportFile(), json + '\n', elsewhere); }

void ResultFolder::writePicture(const Picture& picture) const { writePng(pictureFile(), picture); }

void checkWritable(const std::string& file, const std::string& advice) {
  std::error_code ignored;
  const bool there = std::filesystem::exists(file, ignored);
  errno = 0;
  const std::ofstream probe(file, std::ios::app);
  if (!probe) failWriting(file, errno, advice);
  if (!there) std::filesystem::remove(file, ignored);
}

}  // namespace palpate::app

#include "app/run/result_folder.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "io/output_file.h"
#include "simulation/trust.h"

namespace palpate::app {

namespace {

const char* const elsewhere = "choose another place with --out";

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
  forces_ << "time_s,depth_m,advance_m,force_raw_N_x,force_raw_N_y,force_raw_N_z,"
             "force_filtered_N_x,force_filtered_N_y,force_filtered_N_z,trust\n"
          << std::flush;
  checkForces();
}

void ResultFolder::begin() {
  if (pending_.pending()) pending_.takePlace(elsewhere);
}

void ResultFolder::checkForces() {
  if (!forces_) failWriting(forceFile(), errno, elsewhere);
}

void ResultFolder::addForce(const ForceSample& s) {
  if (!with_forces_) return;
  // %.9g tells neighbouring floats apart; the clock's times have at most 1e-4 s of detail.
  char row[256];
  const int length =
      std::snprintf(row, sizeof row, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%s\n", s.time_s, s.depth_m,
                    s.advance_m, s.force_raw.x(), s.force_raw.y(), s.force_raw.z(), s.force_filtered.x(),
                    s.force_filtered.y(), s.force_filtered.z(), doubtName(s.doubt));
  errno = 0;
  forces_.write(row, length);
  checkForces();
}

void ResultFolder::finishForces() {
  if (!with_forces_) return;
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

#include "io/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <system_error>

namespace palpate {
namespace {

/// What a symbolic link leads to, so that the link stays; other paths as they are.
std::string linkedFile(std::string path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const std::filesystem::path target = std::filesystem::canonical(path, error);
  return error ? path : target.string();
}

/// A device or a folder: nothing can take its place, and it has nothing to lose.
bool isWrittenItself(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

bool isSameFile(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty() || isWrittenItself(a)) return false;
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  const auto whole = [&](const std::string& path) { return std::filesystem::weakly_canonical(path, error); };
  return whole(a) == whole(b);
}

void checkWritable(const std::string& path, const std::string& advice) {
  const PendingFile pending(path);
  errno = 0;
  if (!std::ofstream(pending.part(), std::ios::app)) failWriting(path, errno, advice);
}

void failWriting(const std::string& path, int error, const std::string& advice) {
  const bool full = error == ENOSPC || error == EDQUOT;
  throw std::runtime_error("can't write " + path + ": " +
                           (error != 0 ? std::generic_category().message(error) : "reason unknown") + "; " +
                           (full ? "free some space or " : "") + advice);
}

void makeFolder(const std::string& folder, const std::string& advice) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return;
  if (!advice.empty()) failWriting(folder, error.value(), advice);
  throw std::runtime_error(folder + ": " + error.message());
}

void finishStandardOutput() {
  errno = 0;
  const bool failed_earlier = std::ferror(stdout) != 0;
  if (std::fflush(stdout) == 0 && std::cout && !failed_earlier) return;  // std::cout goes through stdout
  if (errno == 0 && std::fputc('\n', stdout) != EOF)
    std::fflush(stdout);  // it failed earlier: what fails again says why
  failWriting("to standard output", errno, "send it elsewhere");
}

PendingFile::PendingFile(std::string path) : path_(linkedFile(std::move(path))) {
  if (isWrittenItself(path_)) suffix_ = "";
}

PendingFile::~PendingFile() {
  if (pending() && *suffix_ != '\0') ::unlink(part().c_str());
}

void PendingFile::takePlace(const std::string& advice) {
  if (*suffix_ != '\0' && std::rename(part().c_str(), path_.c_str()) != 0) failWriting(path_, errno, advice);
  path_.clear();
}

void writeWholeFile(const std::string& given_path, std::string_view bytes, const std::string& advice) {
  const std::string path = linkedFile(given_path);
  const bool direct = isWrittenItself(path);
  const std::string part = direct ? path : path + ".part";
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) failWriting(given_path, errno, advice);
  int error = 0;
  while (!bytes.empty() && error == 0) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (::close(file) != 0 && error == 0) error = errno;  // network file systems report of a full disk only here
  if (error == 0 && !direct && std::rename(part.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  if (!direct) ::unlink(part.c_str());
  failWriting(given_path, error, advice);
}

}  // namespace palpate

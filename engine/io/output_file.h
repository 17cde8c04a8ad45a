#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace palpate {

/// Writes a file whole or not at all: into FILE.part beside it, which then takes its place, so that who
/// reads it never sees a half. Throws std::runtime_error with the file and the system's reason (folder
/// missing or read-only, disk full) and `advice`; what stood there before is then untouched.
void writeWholeFile(const std::string& path, std::string_view bytes,
                    const std::string& advice = "choose another place");

/// Throws as writeWholeFile would, and leaves what stands there: before work that takes long.
void checkWritable(const std::string& path, const std::string& advice = "choose another place");

/// Whether both paths are one regular file, or would be; none is where one is empty.
bool isSameFile(const std::string& a, const std::string& b);

/// A file that grows beside the one that it replaces, as FILE.part, until what it is for has been accepted.
/// Given up before, it is removed, and what stood there stays. What is no regular file (a device, a folder) has
/// nothing to lose: it is written itself.
class PendingFile {
 public:
  explicit PendingFile(std::string path);
  ~PendingFile();
  PendingFile(PendingFile&& other) noexcept : path_(std::exchange(other.path_, {})), suffix_(other.suffix_) {}
  PendingFile& operator=(PendingFile&&) = delete;

  std::string part() const { return path_ + suffix_; }
  bool pending() const { return !path_.empty(); }

  /// Takes its place; whoever has the file open writes on. Throws std::runtime_error as failWriting does.
  void takePlace(const std::string& advice = "choose another place");

 private:
  std::string path_;              // empty: it stands in its place
  const char* suffix_ = ".part";  // empty where the path itself is written
};

/// Throws std::runtime_error "can't write FILE: reason; advice" for an errno (0: reason unknown).
[[noreturn]] void failWriting(const std::string& path, int error, const std::string& advice = "choose another place");

/// Makes a folder and those that it lies in, where they are missing. Throws std::runtime_error "FOLDER: reason", with
/// `advice` as failWriting does.
void makeFolder(const std::string& folder, const std::string& advice = "choose another place");

/// For the end of a program: throws as failWriting does where something that it printed has not arrived.
void finishStandardOutput();

}  // namespace palpate

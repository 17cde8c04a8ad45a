#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::tools {

/// A folder that gets its files all at once: they are written aside, in a folder within it, and take their places when
/// all of them are there, the scene last. So what opens is whole, and what is refused, interrupted or short of space
/// leaves the folder as it was.
class CaseFolder {
 public:
  /// Makes the folder, before anything that takes long. Throws std::runtime_error where it can't be written, InputError
  /// where one of `inputs` would be written over.
  /// @param names  of all files that may be written; the last is the scene
  CaseFolder(std::filesystem::path folder, std::vector<std::string> names, const std::vector<std::string>& inputs);
  /// Removes what did not take its place, and the folder where that was made.
  ~CaseFolder();
  CaseFolder(const CaseFolder&) = delete;
  CaseFolder& operator=(const CaseFolder&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  /// Where a file is written and, until takePlace(), read.
  std::string aside(const std::string& name) const { return (aside_ / name).string(); }
  /// Where it will be.
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// A message with the files' places in place of where they are aside.
  std::string inPlace(std::string message) const;

  void takePlace();

 private:
  std::filesystem::path folder_, aside_;
  std::filesystem::path made_;  // the highest folder that was not there before; empty: none
  std::vector<std::string> names_;
};

}  // namespace palpate::tools

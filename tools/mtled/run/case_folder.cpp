#include "mtled/run/case_folder.h"

#include <stdexcept>
#include <system_error>
#include <utility>

#include "base/input_error.h"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

/// The highest folder on the way to this one that is not there.
fs::path firstMissing(const fs::path& folder) {
  fs::path missing;
  std::error_code error;
  for (fs::path at = fs::absolute(folder, error).lexically_normal(); !at.empty() && !fs::exists(at, error);) {
    missing = at;
    const fs::path above = at.parent_path();
    if (above == at) break;
    at = above;
  }
  return missing;
}

}  // namespace

CaseFolder::CaseFolder(fs::path folder, std::vector<std::string> names, const std::vector<std::string>& inputs)
    : folder_(std::move(folder)), aside_(folder_ / "import.part"), names_(std::move(names)) {
  std::error_code error;
  for (const std::string& name : names_)
    for (const std::string& input : inputs)
      if (!input.empty() && fs::equivalent(folder_ / name, input, error))
        throw InputError({input}, "this file would be written over by the scene's own", "choose another --out");
  made_ = firstMissing(folder_);
  fs::remove_all(aside_, error);  // of an import that was killed
  fs::create_directories(aside_, error);
  if (!error) return;
  const std::string why = error.message();
  if (!made_.empty()) fs::remove_all(made_, error);
  throw std::runtime_error("can't write " + folder_.string() + ": " + why + "; choose another --out");
}

CaseFolder::~CaseFolder() {
  std::error_code ignored;
  fs::remove_all(aside_, ignored);
  if (made_.empty()) return;
  for (fs::path at = fs::absolute(folder_, ignored).lexically_normal(); fs::is_empty(at, ignored) && !ignored;
       at = at.parent_path()) {
    fs::remove(at, ignored);
    if (at == made_) break;
  }
}

std::string CaseFolder::inPlace(std::string message) const {
  const std::string from = aside_.string(), to = folder_.string();
  for (std::size_t at = 0; (at = message.find(from, at)) != std::string::npos; at += to.size())
    message.replace(at, from.size(), to);
  return message;
}

void CaseFolder::takePlace() {
  std::error_code error;
  fs::remove(folder_ / names_.back(), error);  // of an earlier import: it does not open with this one's files
  for (const std::string& name : names_) {
    if (!fs::exists(aside_ / name)) continue;
    fs::rename(aside_ / name, folder_ / name, error);
    if (error) throw std::runtime_error("can't write " + file(name) + ": " + error.message());
  }
  fs::remove_all(aside_, error);
  made_.clear();
}

}  // namespace palpate::tools

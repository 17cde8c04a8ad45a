#include "io/model_cache.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "base/build_info.h"
#include "base/number_text.h"
#include "io/preparation_file.h"

namespace palpate {
namespace fs = std::filesystem;
namespace {

constexpr char ending[] = ".model";
constexpr char unfinished[] = ".part";  // left only by a program that was killed while it wrote
constexpr auto unfinished_for = std::chrono::hours(1);

KeyHash identityOf(const std::string& key) { return hashOf(buildInfo() + '\n' + sourceIdentity() + '\n' + key); }

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

std::string ModelCache::userFolder() {
  if (const std::string own = environment("PALPATE_CACHE_DIR"); !own.empty()) return own;
  if (const std::string caches = environment("XDG_CACHE_HOME"); fs::path(caches).is_absolute())
    return caches + "/palpate";
  if (const std::string home = environment("HOME"); fs::path(home).is_absolute()) return home + "/.cache/palpate";
  return {};
}

std::string ModelCache::fileOf(const std::string& key) const {
  const KeyHash hash = identityOf(key);
  return (fs::path(folder_) / (hex16(hash[0]) + hex16(hash[1]) + ending)).string();
}

std::optional<Preparation> ModelCache::find(const std::string& key, std::size_t material_count,
                                            std::size_t boundary_count) const {
  if (folder_.empty()) return {};
  const std::string path = fileOf(key);
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return {};
  Preparation preparation;
  const bool good =
      readPreparation(file, identityOf(key), preparation) && isSound(preparation, material_count, boundary_count);
  ::close(file);
  if (!good) {
    if (tell_) tell_("the kept set-up " + path + " is damaged; making it again");
    return {};
  }
  std::error_code ignored;
  fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);  // used last
  return preparation;
}

void ModelCache::keep(const std::string& key, const Preparation& preparation) const {
  if (folder_.empty()) return;
  static std::atomic<int> count{0};
  const std::string path = fileOf(key),
                    part = path + "." + std::to_string(::getpid()) + "-" + std::to_string(count++) + unfinished;
  std::error_code ignored;
  fs::create_directories(folder_, ignored);  // where that fails, so does open
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  int error = file < 0 ? errno : writePreparation(file, identityOf(key), preparation);
  if (file >= 0 && ::close(file) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(part.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) {
    removeOldest(path);
    return;
  }
  if (file >= 0) ::unlink(part.c_str());
  if (tell_)
    tell_("the set-up is not kept for the next start: can't write " + path + ": " +
          std::generic_category().message(error));
}

void ModelCache::removeOldest(const std::string& newest) const {
  struct Kept {
    fs::file_time_type used;
    fs::path path;
    std::uintmax_t size;
  };
  std::vector<Kept> kept;
  std::uintmax_t total = 0;
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;  // another process cleans up, too
    const Kept file{it->last_write_time(gone), it->path(), it->file_size(gone)};
    if (gone) continue;
    if (file.path.extension() == unfinished && now - file.used > unfinished_for) fs::remove(file.path, gone);
    if (file.path.extension() != ending) continue;
    total += file.size;
    if (file.path != newest) kept.push_back(file);
  }
  std::sort(kept.begin(), kept.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  for (const Kept& file : kept) {
    if (total <= max_bytes_) return;
    std::error_code gone;
    fs::remove(file.path, gone);
    total -= file.size;
  }
}

}  // namespace palpate

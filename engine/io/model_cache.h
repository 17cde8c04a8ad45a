#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "model/preparation.h"

namespace palpate {

/// Keeps preparations between runs, one file each, named by a hash of preparationKey and of the program's own
/// sources and compiler: what another program made is not found.
///
/// A file has a header (magic, layout version, 128-bit key hash, every array's length, checksums) and the arrays'
/// bytes. Nothing of it is used before the header fits, the lengths add up to the file's and to each other, all
/// checksums hold, and every index and number is in its range. It is written under a name of its own and renamed, so
/// processes may share the folder. Beyond
/// `max_bytes` the files that were not used for longest are removed.
class ModelCache {
 public:
  static constexpr std::uintmax_t default_max_bytes = 2'000'000'000;

  /// @param folder  made when first needed; "": keeps nothing
  /// @param report    gets a line where a file is damaged or can't be written
  explicit ModelCache(std::string folder = {}, std::function<void(const std::string&)> report = {},
                      std::uintmax_t max_bytes = default_max_bytes)
      : folder_(std::move(folder)), tell_(std::move(report)), max_bytes_(max_bytes) {}

  /// $PALPATE_CACHE_DIR, or $XDG_CACHE_HOME/palpate, or ~/.cache/palpate; "" where none is set.
  static std::string userFolder();

  /// What was kept for this key, or nothing. A file that is there but can't be trusted is told of, also where its
  /// checksums hold and its contents do not (isSound).
  /// @param material_count, boundary_count  of the scene, which the preparation's indices count
  std::optional<Preparation> find(const std::string& key, std::size_t material_count, std::size_t boundary_count) const;

  /// Keeps it. Never throws: what can't be kept will be made again.
  void keep(const std::string& key, const Preparation& preparation) const;

  bool keeps() const { return !folder_.empty(); }

  /// The same, but nothing is reported: for other threads.
  ModelCache silent() const { return ModelCache(folder_, {}, max_bytes_); }

  /// The file for this key, whether it exists or not.
  std::string fileOf(const std::string& key) const;

 private:
  void removeOldest(const std::string& newest) const;

  std::string folder_;
  std::function<void(const std::string&)> tell_;
  std::uintmax_t max_bytes_;
};

}  // namespace palpate

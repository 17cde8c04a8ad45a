#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace palpate {

bool isGzip(std::string_view bytes);

/// Bytes as a gzip file: pieces of 1 MB compressed on all cores, one member each, which every reader of gzip takes for
/// one file (RFC 1952, 2.2). The same bytes on any number of cores.
std::string gzipped(std::string_view bytes);

/// The same of bytes that are made as they are needed.
/// @param fill  writes `count` bytes, from byte `begin` on, to `to`; begin is a multiple of a MB; on any thread
std::string gzipped(std::size_t size, const std::function<void(std::size_t begin, std::size_t count, char* to)>& fill);

/// Reads what stands in a gzip file or, where it is none, the bytes themselves, piece by piece.
class GzipReader {
 public:
  explicit GzipReader(std::string_view bytes);
  ~GzipReader();
  GzipReader(const GzipReader&) = delete;
  GzipReader& operator=(const GzipReader&) = delete;

  /// Reads up to `count` bytes; fewer at the end. Throws std::runtime_error saying what is wrong with the gzip data.
  std::size_t read(char* to, std::size_t count);

  /// How many bytes there can be at most: a gzip file of so many bytes expands to no more than 1032 times that.
  std::size_t maxSize() const;

 private:
  struct Inflate;
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::unique_ptr<Inflate> inflate_;  // null: not compressed
};

}  // namespace palpate

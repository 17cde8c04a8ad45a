#include "imaging/gzip.h"

#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <vector>

#include "base/parallel_for.h"

namespace palpate {
namespace {

constexpr int gzip_window = 15 + 16;          // zlib's largest window, with a gzip header
constexpr std::size_t piece_bytes = 1 << 20;  // smaller ones compress less, larger ones leave cores idle
constexpr std::size_t max_ratio = 1032;       // of deflate: a block of 258 equal bytes in two bits (zlib's manual)

/// Compresses one piece after the other.
class Deflate {
 public:
  Deflate() : compressor_(libdeflate_alloc_compressor(level)) {
    if (!compressor_) throw std::runtime_error("there is no memory to compress with");
    out_.resize(libdeflate_gzip_compress_bound(compressor_.get(), piece_bytes));
  }

  /// @param bytes  no more than a piece
  std::string operator()(std::string_view bytes) {
    const std::size_t size =
        libdeflate_gzip_compress(compressor_.get(), bytes.data(), bytes.size(), out_.data(), out_.size());
    if (size == 0) throw std::runtime_error("compression failed");
    return out_.substr(0, size);
  }

 private:
  // The quickest: higher ones take a quarter longer, and scans and fields hardly become smaller. zlib's quickest way
  // takes twice as long, and makes fields a third larger.
  static constexpr int level = 1;
  struct Free {
    void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  std::string out_;
};

}  // namespace

bool isGzip(std::string_view bytes) { return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b'; }

std::string gzipped(std::size_t size, const std::function<void(std::size_t begin, std::size_t count, char* to)>& fill) {
  const auto pieces = static_cast<int>(std::max<std::size_t>(1, (size + piece_bytes - 1) / piece_bytes));
  std::vector<std::string> piece(static_cast<std::size_t>(pieces));
  parallelFor(
      pieces,
      [&](int first, int last) {
        Deflate deflate;
        std::string bytes;
        for (auto p = static_cast<std::size_t>(first); p < static_cast<std::size_t>(last); ++p) {
          bytes.resize(std::min(piece_bytes, size - p * piece_bytes));
          fill(p * piece_bytes, bytes.size(), bytes.data());
          piece[p] = deflate(bytes);
        }
      },
      1);
  std::size_t total = 0;
  for (const std::string& p : piece) total += p.size();
  std::string all;
  all.reserve(total);
  for (std::string& p : piece) {
    all += p;
    p = std::string();
  }
  return all;
}

std::string gzipped(std::string_view bytes) {
  return gzipped(bytes.size(), [&](std::size_t begin, std::size_t count, char* to) {
    if (count != 0) std::memcpy(to, bytes.data() + begin, count);
  });
}

struct GzipReader::Inflate {
  z_stream stream{};
  bool ended = false;  // the last member is read
  Inflate() {
    if (inflateInit2(&stream, gzip_window) != Z_OK) throw std::runtime_error("there is no memory to expand with");
  }
  ~Inflate() { inflateEnd(&stream); }
};

GzipReader::GzipReader(std::string_view bytes) : bytes_(bytes) {
  if (isGzip(bytes)) inflate_ = std::make_unique<Inflate>();
}

GzipReader::~GzipReader() = default;

std::size_t GzipReader::maxSize() const {
  if (!inflate_) return bytes_.size();
  return bytes_.size() > std::numeric_limits<std::size_t>::max() / max_ratio ? std::numeric_limits<std::size_t>::max()
                                                                             : bytes_.size() * max_ratio;
}

std::size_t GzipReader::read(char* to, std::size_t count) {
  if (!inflate_) {
    count = std::min(count, bytes_.size() - at_);
    if (count != 0) std::memcpy(to, bytes_.data() + at_, count);
    at_ += count;
    return count;
  }
  constexpr std::size_t most = 1 << 30;  // zlib counts in 32 bits
  z_stream& stream = inflate_->stream;
  std::size_t done = 0;
  while (done < count && !inflate_->ended) {
    const std::size_t in = std::min(most, bytes_.size() - at_), out = std::min(most, count - done);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes_.data() + at_));
    stream.avail_in = static_cast<uInt>(in);
    stream.next_out = reinterpret_cast<Bytef*>(to + done);
    stream.avail_out = static_cast<uInt>(out);
    const int code = inflate(&stream, Z_NO_FLUSH);
    at_ += in - stream.avail_in;
    done += out - stream.avail_out;
    if (code == Z_STREAM_END) {
      // Another member may follow; what is no gzip after the end is left alone, as gzip does.
      inflate_->ended = !isGzip(bytes_.substr(at_));
      if (!inflate_->ended) inflateReset(&stream);
    } else if (code == Z_BUF_ERROR || (code == Z_OK && in == 0 && done < count)) {
      throw std::runtime_error("the gzip data is cut short");
    } else if (code != Z_OK) {
      throw std::runtime_error(std::string("the gzip data is damaged") +
                               (stream.msg ? std::string(" (") + stream.msg + ")" : std::string()));
    }
  }
  return done;
}

}  // namespace palpate

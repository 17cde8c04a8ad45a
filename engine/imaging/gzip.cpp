#include "imaging/gzip.h"

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
constexpr std::size_t piece_bytes = 4 << 20;  // smaller ones compress less, larger ones leave cores idle
constexpr std::size_t max_ratio = 1032;       // of deflate: a block of 258 equal bytes in two bits (zlib's manual)

std::string compressedPiece(std::string_view bytes) {
  z_stream stream{};
  // The fastest level: numbers of scans and fields compress little further, and take thrice as long.
  if (deflateInit2(&stream, 1, Z_DEFLATED, gzip_window, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("there is no memory to compress with");
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int code = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (code != Z_STREAM_END) throw std::runtime_error("compression failed");
  return out;
}

}  // namespace

bool isGzip(std::string_view bytes) { return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b'; }

std::string gzipped(std::string_view bytes) {
  const auto pieces = static_cast<int>(std::max<std::size_t>(1, (bytes.size() + piece_bytes - 1) / piece_bytes));
  std::vector<std::string> piece(static_cast<std::size_t>(pieces));
  parallelFor(
      pieces,
      [&](int first, int last) {
        for (int p = first; p < last; ++p)
          piece[static_cast<std::size_t>(p)] =
              compressedPiece(bytes.substr(static_cast<std::size_t>(p) * piece_bytes, piece_bytes));
      },
      1);
  std::string all;
  std::size_t size = 0;
  for (const std::string& p : piece) size += p.size();
  all.reserve(size);
  for (const std::string& p : piece) all += p;
  return all;
}

struct ByteReader::Inflate {
  z_stream stream{};
  bool ended = false;  // the last member is read
  Inflate() {
    if (inflateInit2(&stream, gzip_window) != Z_OK) throw std::runtime_error("there is no memory to expand with");
  }
  ~Inflate() { inflateEnd(&stream); }
};

ByteReader::ByteReader(std::string_view bytes) : bytes_(bytes) {
  if (isGzip(bytes)) inflate_ = std::make_unique<Inflate>();
}

ByteReader::~ByteReader() = default;

std::size_t ByteReader::maxSize() const {
  if (!inflate_) return bytes_.size();
  return bytes_.size() > std::numeric_limits<std::size_t>::max() / max_ratio ? std::numeric_limits<std::size_t>::max()
                                                                             : bytes_.size() * max_ratio;
}

std::size_t ByteReader::read(char* to, std::size_t count) {
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

#include "app/render/animation.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "io/output_file.h"

namespace palpate::app {

namespace {

using Colour = std::array<std::uint8_t, 3>;
using Bytes = std::vector<std::uint8_t>;

constexpr int palette_size = 255;  // the last index is what stays as it was
constexpr std::uint8_t unchanged = 255;
constexpr int same_colour = 3 * 7 * 7;        // squared distance that nobody sees from one picture to the next
constexpr std::size_t most_samples = 200000;  // of the pixels that the palette is made from

int squaredDistance(const Colour& a, const Colour& b) {
  int sum = 0;
  for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

Colour pixel(const Picture& picture, std::size_t k) {
  return {picture.rgb[3 * k], picture.rgb[3 * k + 1], picture.rgb[3 * k + 2]};
}

/// Colours that stand for those of the pictures: the widest box of colours is halved at its median, again and again.
std::vector<Colour> paletteOf(const std::vector<Picture>& pictures) {
  std::vector<Colour> samples;
  const std::size_t all = pictures.size() * pictures[0].rgb.size() / 3;
  const std::size_t every = all / most_samples + 1;
  for (std::size_t k = 0; k < all; k += every) {
    const std::size_t one = pictures[0].rgb.size() / 3;
    samples.push_back(pixel(pictures[k / one], k % one));
  }
  struct Range {
    std::size_t begin, end;
    int channel, width;
  };
  const auto rangeOf = [&](std::size_t begin, std::size_t end) {
    Range range{begin, end, 0, 0};
    for (int c = 0; c < 3; ++c) {
      std::uint8_t low = 255, high = 0;
      for (std::size_t k = begin; k < end; ++k) {
        low = std::min(low, samples[k][c]);
        high = std::max(high, samples[k][c]);
      }
      if (high - low > range.width) range = {begin, end, c, high - low};
    }
    return range;
  };
  std::vector<Range> ranges{rangeOf(0, samples.size())};
  while (static_cast<int>(ranges.size()) < palette_size) {
    const auto widest = std::max_element(ranges.begin(), ranges.end(),
                                         [](const Range& a, const Range& b) { return a.width < b.width; });
    if (widest->width == 0) break;
    const Range range = *widest;
    const std::size_t middle = (range.begin + range.end) / 2;
    const auto at = [&](std::size_t k) { return samples.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(at(range.begin), at(middle), at(range.end), [&](const Colour& a, const Colour& b) {
      return a[range.channel] != b[range.channel] ? a[range.channel] < b[range.channel] : a < b;
    });
    *widest = rangeOf(range.begin, middle);
    ranges.push_back(rangeOf(middle, range.end));
  }
  std::vector<Colour> palette;
  for (const Range& range : ranges) {
    std::array<std::size_t, 3> sum{};
    for (std::size_t k = range.begin; k < range.end; ++k)
      for (int c = 0; c < 3; ++c) sum[c] += samples[k][c];
    const std::size_t count = std::max<std::size_t>(1, range.end - range.begin);
    palette.push_back({static_cast<std::uint8_t>(sum[0] / count), static_cast<std::uint8_t>(sum[1] / count),
                       static_cast<std::uint8_t>(sum[2] / count)});
  }
  return palette;
}

/// The palette's nearest, looked up for five bits of each channel once.
class Nearest {
 public:
  explicit Nearest(const std::vector<Colour>& palette) : palette_(palette), index_(32 * 32 * 32, -1) {}

  std::uint8_t of(const Colour& colour) {
    int& index =
        index_[std::size_t{colour[0]} / 8 * 1024 + std::size_t{colour[1]} / 8 * 32 + std::size_t{colour[2]} / 8];
    if (index < 0) {
      int least = 1 << 30;
      for (std::size_t k = 0; k < palette_.size(); ++k) {
        const int distance = squaredDistance(palette_[k], colour);
        if (distance >= least) continue;
        least = distance;
        index = static_cast<int>(k);
      }
    }
    return static_cast<std::uint8_t>(index);
  }

 private:
  const std::vector<Colour>& palette_;
  std::vector<int> index_;
};

void put32(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}
void put16(Bytes& bytes, std::uint32_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

void putChunk(std::string& file, const char* name, const Bytes& data) {
  Bytes chunk;
  put32(chunk, static_cast<std::uint32_t>(data.size()));
  for (int k = 0; k < 4; ++k) chunk.push_back(static_cast<std::uint8_t>(name[k]));
  chunk.insert(chunk.end(), data.begin(), data.end());
  const auto sum = crc32(0, chunk.data() + 4, static_cast<uInt>(chunk.size() - 4));
  put32(chunk, static_cast<std::uint32_t>(sum));
  file.append(chunk.begin(), chunk.end());
}

/// A part of a picture, and what it shows, by the palette.
struct Part {
  int x = 0, y = 0, width = 0, height = 0;
  Bytes index;  // (height, width)
};

Bytes deflated(const Part& frame, const std::string& file) {
  Bytes rows;
  for (int y = 0; y < frame.height; ++y) {
    rows.push_back(0);  // no filter: indices have no neighbours in value
    const auto begin = frame.index.begin() + static_cast<std::ptrdiff_t>(y) * frame.width;
    rows.insert(rows.end(), begin, begin + frame.width);
  }
  uLongf size = compressBound(static_cast<uLong>(rows.size()));
  Bytes packed(size);
  if (compress2(packed.data(), &size, rows.data(), static_cast<uLong>(rows.size()), 9) != Z_OK)
    throw std::runtime_error(file + ": can't encode the animation");
  packed.resize(size);
  return packed;
}

/// What of a picture differs from what is shown, which it then is.
Part changesTo(const Picture& picture, const std::vector<Colour>& palette, Nearest& nearest, Bytes& shown) {
  const int width = picture.width, height = picture.height;
  Bytes next(shown.size(), unchanged);
  int left = width, right = 0, top = height, bottom = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      const Colour colour = pixel(picture, k);
      const bool first = shown[k] == unchanged;
      if (!first && squaredDistance(palette[shown[k]], colour) <= same_colour) continue;
      const std::uint8_t index = nearest.of(colour);
      if (index == shown[k]) continue;
      next[k] = shown[k] = index;
      left = std::min(left, x);
      right = std::max(right, x + 1);
      top = std::min(top, y);
      bottom = std::max(bottom, y + 1);
    }
  if (left >= right) left = top = 0, right = bottom = 1;  // nothing changed: a picture must have a pixel
  Part frame{left, top, right - left, bottom - top, {}};
  for (int y = top; y < bottom; ++y) {
    const auto begin = next.begin() + static_cast<std::ptrdiff_t>(y) * width;
    frame.index.insert(frame.index.end(), begin + left, begin + right);
  }
  return frame;
}

Bytes frameControl(std::uint32_t sequence, const Part& frame, double seconds, bool over) {
  Bytes bytes;
  put32(bytes, sequence);
  for (const int value : {frame.width, frame.height, frame.x, frame.y}) put32(bytes, static_cast<std::uint32_t>(value));
  put16(bytes, static_cast<std::uint32_t>(std::lround(100 * std::clamp(seconds, 0.01, 60.0))));
  put16(bytes, 100);
  bytes.push_back(0);             // left in place
  bytes.push_back(over ? 1 : 0);  // laid over what is there
  return bytes;
}

}  // namespace

void writeAnimation(const std::string& file, const std::vector<Picture>& pictures, double seconds,
                    double last_seconds) {
  if (pictures.empty()) throw std::invalid_argument("an animation of no pictures");
  const Picture& first = pictures[0];
  for (const Picture& picture : pictures)
    if (picture.width != first.width || picture.height != first.height)
      throw std::invalid_argument("the pictures of an animation differ in size");
  const std::vector<Colour> palette = paletteOf(pictures);
  Nearest nearest(palette);
  Bytes shown(first.rgb.size() / 3, unchanged);

  std::string out = "\x89PNG\r\n\x1a\n";
  Bytes header;
  put32(header, static_cast<std::uint32_t>(first.width));
  put32(header, static_cast<std::uint32_t>(first.height));
  header.insert(header.end(), {8, 3, 0, 0, 0});  // eight bits, palette
  putChunk(out, "IHDR", header);
  Bytes control;
  put32(control, static_cast<std::uint32_t>(pictures.size()));
  put32(control, 0);  // without end
  putChunk(out, "acTL", control);
  Bytes colours;
  for (int k = 0; k <= palette_size; ++k) {
    const Colour c = k < static_cast<int>(palette.size()) ? palette[static_cast<std::size_t>(k)] : Colour{};
    colours.insert(colours.end(), c.begin(), c.end());
  }
  putChunk(out, "PLTE", colours);
  Bytes alpha(palette_size, 255);
  alpha.push_back(0);
  putChunk(out, "tRNS", alpha);

  std::uint32_t sequence = 0;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const Part part = changesTo(pictures[k], palette, nearest, shown);
    const double stays = k + 1 == pictures.size() ? last_seconds : seconds;
    putChunk(out, "fcTL", frameControl(sequence++, part, stays, k > 0));
    Bytes data;
    if (k > 0) put32(data, sequence++);
    const Bytes packed = deflated(part, file);
    data.insert(data.end(), packed.begin(), packed.end());
    putChunk(out, k > 0 ? "fdAT" : "IDAT", data);
  }
  putChunk(out, "IEND", {});
  writeWholeFile(file, out);
}

}  // namespace palpate::app

#include "fuzz/mutator.h"

#include <algorithm>
#include <limits>
#include <set>
#include <string_view>

namespace palpate::fuzz {

namespace {

/// SplitMix64 (Steele, Lea and Flood 2014): the standard library's distributions differ from one to the next.
class Random {
 public:
  explicit Random(std::uint64_t state) : state_(state) {}
  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  /// 0 .. count - 1; 0 where count is 0.
  std::size_t below(std::size_t count) { return count == 0 ? 0 : static_cast<std::size_t>(bits() % count); }

 private:
  std::uint64_t state_;
};

constexpr std::size_t max_input = 1 << 20;

// Text that readers trip over.
constexpr const char* awkward_words[] = {"0",
                                         "-1",
                                         "-0.0",
                                         "1e308",
                                         "1.7e308",
                                         "-1.7e308",
                                         "5e-324",
                                         "1e-300",
                                         "1e999",
                                         "nan",
                                         "inf",
                                         "-inf",
                                         "+1",
                                         "0x7f",
                                         "1_000",
                                         "2147483647",
                                         "2147483648",
                                         "-2147483649",
                                         "4294967296",
                                         "9223372036854775807",
                                         "-9223372036854775808",
                                         "18446744073709551616",
                                         "1.5.2",
                                         "\"",
                                         "'",
                                         "\"\"\"",
                                         "'''",
                                         "\\",
                                         "\\u0000",
                                         "\n",
                                         "\r",
                                         "\r\n",
                                         "\t",
                                         "#",
                                         "=",
                                         ",",
                                         ".",
                                         "[",
                                         "]",
                                         "[[",
                                         "]]",
                                         "{",
                                         "}",
                                         "\xef\xbb\xbf",
                                         "\xff",
                                         "\xc2\x9b",
                                         "//",
                                         "/",
                                         " "};

// Words of binary files.
constexpr std::uint64_t awkward_numbers[] = {0,
                                             1,
                                             2,
                                             3,
                                             0x7f,
                                             0x80,
                                             0xff,
                                             0x7fff,
                                             0x8000,
                                             0xffff,
                                             0x7fffffff,
                                             0x80000000,
                                             0xffffffff,
                                             std::uint64_t{1} << 58,
                                             std::uint64_t{1} << 61,
                                             std::uint64_t{1} << 63,
                                             std::numeric_limits<std::uint64_t>::max(),
                                             0x7ff0000000000000,
                                             0x7ff8000000000000,
                                             0xffefffffffffffff};

bool isWordByte(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
         c == '+' || c == '.';
}

/// The word or single byte that stands at or behind a place: its begin and length.
std::pair<std::size_t, std::size_t> wordAt(const std::string& text, std::size_t at) {
  while (at > 0 && at < text.size() && isWordByte(text[at]) && isWordByte(text[at - 1])) --at;
  std::size_t end = at;
  while (end < text.size() && isWordByte(text[end])) ++end;
  return {at, std::max<std::size_t>(end - at, at < text.size() ? 1 : 0)};
}

struct Damage {
  std::string& text;
  Random& random;
  const std::vector<std::string>&seeds, &words;

  std::size_t place() { return random.below(text.size() + 1); }
  /// A part: mostly short, sometimes any length.
  std::pair<std::size_t, std::size_t> part() {
    const std::size_t at = place(), left = text.size() - at;
    return {at, random.below(std::min<std::size_t>(left, random.below(4) == 0 ? left : 16) + 1)};
  }

  void flipBit() {
    if (!text.empty()) text[random.below(text.size())] ^= static_cast<char>(1 << random.below(8));
  }
  void setByte() {
    if (!text.empty()) text[random.below(text.size())] = static_cast<char>(random.bits());
  }
  void insertBytes() {
    std::string bytes(1 + random.below(8), '\0');
    for (char& c : bytes) c = static_cast<char>(random.bits());
    text.insert(place(), bytes);
  }
  void eraseSome() {
    const auto [at, length] = part();
    text.erase(at, length);
  }
  void cut() { text.resize(place()); }
  void repeat() {
    const auto [at, length] = part();
    const std::size_t most = random.below(50) == 0 ? 60000 : 8;  // deep nesting; long lines
    const std::size_t times = std::min(1 + random.below(most), (max_input - text.size()) / (length + 1));
    const std::string one = text.substr(at, length);
    std::string all;
    for (std::size_t k = 0; k < times; ++k) all += one;
    text.insert(at, all);
  }
  void replaceWord() {
    const auto [at, length] = wordAt(text, place());
    text.replace(at, length, words[random.below(words.size())]);
  }
  void insertWord() { text.insert(place(), words[random.below(words.size())]); }
  void swapParts() {
    const auto [a, a_length] = part();
    const auto [b, b_length] = part();
    const std::string first = text.substr(a, a_length), second = text.substr(b, b_length);
    text.replace(a, a_length, second);
    text.replace(std::min(b, text.size()), b_length, first);
  }
  void splice() {
    const std::string& other = seeds[random.below(seeds.size())];
    const std::size_t from = random.below(other.size() + 1);
    text = text.substr(0, place()) + other.substr(from, random.below(other.size() - from + 1)) + text.substr(place());
  }
  void setNumber() {
    const std::size_t size = std::size_t{1} << random.below(4);
    if (text.size() < size) return;
    std::size_t at = random.below(text.size() - size + 1);
    if (random.below(2) == 0) at -= at % size;
    const std::uint64_t number = awkward_numbers[random.below(std::size(awkward_numbers))];
    for (std::size_t k = 0; k < size; ++k) text[at + k] = static_cast<char>(number >> 8 * k);  // little-endian
  }
};

constexpr void (Damage::*damages[])() = {
    &Damage::flipBit,   &Damage::setByte,     &Damage::insertBytes, &Damage::eraseSome,   &Damage::cut,
    &Damage::repeat,    &Damage::replaceWord, &Damage::replaceWord, &Damage::replaceWord, &Damage::insertWord,
    &Damage::swapParts, &Damage::splice,      &Damage::setNumber};

}  // namespace

Mutator::Mutator(std::uint64_t seed, std::vector<std::string> seeds)
    : seed_(seed), seeds_(std::move(seeds)), words_(std::begin(awkward_words), std::end(awkward_words)) {
  std::set<std::string> own;
  for (const std::string& text : seeds_) {
    for (std::size_t at = 0; at < text.size();) {
      const auto [begin, length] = wordAt(text, at);
      if (length > 1 && length < 40) own.insert(text.substr(begin, length));
      at = begin + std::max<std::size_t>(length, 1);
    }
  }
  words_.insert(words_.end(), own.begin(), own.end());
}

std::string Mutator::input(std::uint64_t number) const {
  if (number < seeds_.size()) return seeds_[number];
  Random random(seed_ * 0xd1342543de82ef95ull + number);
  std::string text = seeds_[random.below(seeds_.size())];
  const std::size_t count = 1 + random.below(random.below(3) == 0 ? 8 : 2);
  Damage damage{text, random, seeds_, words_};
  for (std::size_t k = 0; k < count && text.size() < max_input; ++k)
    (damage.*damages[random.below(std::size(damages))])();
  return text;
}

}  // namespace palpate::fuzz

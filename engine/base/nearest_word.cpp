#include "base/nearest_word.h"

#include <algorithm>
#include <numeric>
#include <string_view>

namespace palpate {
namespace {

/// Insertions, deletions, substitutions and swaps of neighbours that turn one word into the other (optimal string
/// alignment).
int editDistance(std::string_view a, std::string_view b) {
  std::vector<int> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    before.swap(row);
    row.swap(next);
  }
  return row.back();
}

}  // namespace

std::string nearestWord(const std::string& word, const std::vector<std::string>& known) {
  std::string nearest;
  int least = static_cast<int>(word.size()) + 1;
  for (const std::string& candidate : known) {
    const int distance = editDistance(word, candidate);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  // A third of the letters may be wrong; with more, the nearest word is a guess that misleads.
  const int longest_slip = std::max(1, static_cast<int>(std::max(word.size(), nearest.size())) / 3);
  return least <= longest_slip ? nearest : "";
}

std::string listed(const std::vector<std::string>& words, const char* last_joint) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? std::string(" ") + last_joint + " " : ", ") + words[i];
  }
  return text;
}

}  // namespace palpate

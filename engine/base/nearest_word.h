#pragma once

#include <string>
#include <vector>

namespace palpate {

/// Which of the words that are known here was probably meant; empty where none is near.
std::string nearestWord(const std::string& word, const std::vector<std::string>& known);

/// "a, b and c", with `last_joint` for "and".
std::string listed(const std::vector<std::string>& words, const char* last_joint);

}  // namespace palpate

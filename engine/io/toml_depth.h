#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Throws InputError with line and column where TOML text has a key of more than max_toml_depth parts
/// ("a.b.c" has three), or that many lists and inline tables within one another. Says nothing about text that is no
/// TOML for another reason: the parser does.
void checkTomlDepth(std::string_view text, const std::string& file);

}  // namespace palpate

#pragma once

#include <string>

namespace palpate {

/// A scene file's text with one key of a table set to another value. Where the key stands only its value changes;
/// else it is added at the end of the table, or with the table at the end of the text. Comments and all else stay.
/// @param table  "discretization", as in a header [table]
/// @param value  as TOML writes it: `0.01`, `"int16"`
std::string withSceneKey(const std::string& text, const std::string& table, const std::string& key,
                         const std::string& value);

/// The same scene with a header for each of its tables, which withSceneKey needs, in place of inline ones and dotted
/// keys. Comments are lost. Throws InputError where the text is no TOML. @param file  what errors call it
std::string withHeaders(const std::string& text, const std::string& file);

}  // namespace palpate

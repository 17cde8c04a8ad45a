#include "io/scene_edit.h"

#include <sstream>
#include <vector>

#include "io/toml_table.h"

namespace palpate {
namespace {

std::string trimmed(const std::string& s) {
  const auto begin = s.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return s.substr(begin, s.find_last_not_of(" \t\r") - begin + 1);
}

/// Where a line's comment begins, spaces before it included, or its end. A # within quotes begins none.
std::size_t commentOf(const std::string& line) {
  char quote = 0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (quote == '"' && line[k] == '\\') {
      ++k;
    } else if (quote != 0) {
      if (line[k] == quote) quote = 0;
    } else if (line[k] == '"' || line[k] == '\'') {
      quote = line[k];
    } else if (line[k] == '#') {
      while (k > 0 && (line[k - 1] == ' ' || line[k - 1] == '\t')) --k;
      return k;
    }
  }
  return line.size();
}

/// Whether a line sets the key.
bool sets(const std::string& line, const std::string& key) {
  const auto equals = line.find('=');
  if (equals == std::string::npos || equals > commentOf(line)) return false;
  const std::string name = trimmed(line.substr(0, equals));
  return name == key || name == "\"" + key + "\"";
}

}  // namespace

std::string withSceneKey(const std::string& text, const std::string& table, const std::string& key,
                         const std::string& value) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);

  const std::string assignment = key + " = " + value;
  bool inside = false;
  std::size_t end_of_table = 0;  // the line after its last that is not empty or a comment; 0: no such table
  for (std::size_t k = 0; k < lines.size(); ++k) {
    std::string& line = lines[k];
    const std::string code = trimmed(line.substr(0, commentOf(line)));
    if (code.empty()) continue;
    if (code.front() == '[') {
      inside = code == "[" + table + "]";
    } else if (inside && sets(line, key)) {
      line = line.substr(0, line.find('=')) + "= " + value + line.substr(commentOf(line));
      end_of_table = std::string::npos;
      break;
    }
    if (inside) end_of_table = k + 1;
  }
  if (end_of_table == 0) {
    lines.insert(lines.end(), {"", "[" + table + "]", assignment});
  } else if (end_of_table != std::string::npos) {
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(end_of_table), assignment);
  }
  std::string result;
  for (const auto& line : lines) result += line + "\n";
  return result;
}

std::string withHeaders(const std::string& text, const std::string& file) {
  toml::table document = parseToml(text, file);
  for (auto&& [key, node] : document)
    if (toml::table* table = node.as_table()) table->is_inline(false);
  std::ostringstream out;
  out << toml::toml_formatter(document) << '\n';
  return out.str();
}

}  // namespace palpate

#include "app/render/shader_source.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace palpate::app {
namespace {

const std::string version_line = "#version 330 core\n";

class Joiner {
 public:
  explicit Joiner(std::string folder) : folder_(std::move(folder)) { source_.text = version_line; }

  /// @param from  "file:line" of the directive that asks for it, or empty
  void add(const std::string& name, const std::string& from) {
    if (std::find(source_.files.begin(), source_.files.end(), name) != source_.files.end()) return;
    const std::string path = folder_ + "/" + name;
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
      throw std::runtime_error((from.empty() ? "" : from + ": ") + "can't read the shader file " + path);
    const std::size_t number = source_.files.size();
    source_.files.push_back(name);
    continueAt(1, number);
    std::string line;
    for (int n = 1; std::getline(file, line); ++n) {
      const std::size_t hash = line.find_first_not_of(" \t");
      if (hash != std::string::npos && line.compare(hash, 8, "#include") == 0) {
        add(includedName(line.substr(hash), path + ":" + std::to_string(n)), path + ":" + std::to_string(n));
        continueAt(n + 1, number);
      } else {
        source_.text += line + "\n";
      }
    }
  }

  ShaderSource take() { return std::move(source_); }

 private:
  void continueAt(int line, std::size_t number) {
    source_.text += "#line " + std::to_string(line) + " " + std::to_string(number) + "\n";
  }

  /// @param directive  the line from its '#' on
  static std::string includedName(const std::string& directive, const std::string& place) {
    const std::size_t open = directive.find_first_not_of(" \t", std::strlen("#include"));
    const std::size_t close = open == std::string::npos ? open : directive.find('"', open + 1);
    if (close != std::string::npos && directive[open] == '"') {
      const std::string name = directive.substr(open + 1, close - open - 1);
      const std::size_t rest = directive.find_first_not_of(" \t\r", close + 1);
      if (!name.empty() && name.find('/') == std::string::npos &&
          (rest == std::string::npos || directive.compare(rest, 2, "//") == 0))
        return name;
    }
    throw std::runtime_error(place +
                             ": malformed include; write #include \"name.glsl\" with a file of the same folder");
  }

  std::string folder_;
  ShaderSource source_;
};

}  // namespace

ShaderSource readShader(const std::string& shader_dir, const std::string& name) {
  Joiner joiner(shader_dir);
  joiner.add(name, "");
  return joiner.take();
}

std::string withFileNames(const std::string& log, const std::vector<std::string>& files) {
  std::istringstream lines(log);
  std::string result, line;
  while (std::getline(lines, line)) {
    unsigned file = 0, row = 0;
    int length = 0;  // stays 0 unless the whole pattern is there
    if (std::sscanf(line.c_str(), "%u:%u(%*u)%n", &file, &row, &length) < 2 || length == 0)
      std::sscanf(line.c_str(), "%u(%u)%n", &file, &row, &length);
    if (length > 0 && file < files.size())
      line = files[file] + ":" + std::to_string(row) + line.substr(static_cast<std::size_t>(length));
    result += line + "\n";
  }
  return result;
}

}  // namespace palpate::app

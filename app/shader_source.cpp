#include "app/shader_source.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace palpate {
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
        add(includedName(line, path + ":" + std::to_string(n)), path + ":" + std::to_string(n));
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

  static std::string includedName(const std::string& line, const std::string& place) {
    static const std::regex directive(R"re(\s*#include\s+"([^"/]+)"\s*(//.*)?\r?)re");
    std::smatch match;
    if (!std::regex_match(line, match, directive))
      throw std::runtime_error(place + ": malformed include; write #include \"name.glsl\" with a file of the same folder");
    return match[1];
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
  static const std::regex mesa(R"((\d+):(\d+)\(\d+\))"), nvidia(R"((\d+)\((\d+)\))");
  std::istringstream lines(log);
  std::string result, line;
  while (std::getline(lines, line)) {
    std::smatch match;
    constexpr auto at_start = std::regex_constants::match_continuous;
    if (std::regex_search(line, match, mesa, at_start) || std::regex_search(line, match, nvidia, at_start)) {
      const std::size_t number = std::stoul(match[1]);
      if (number < files.size()) line = files[number] + ":" + match[2].str() + match.suffix().str();
    }
    result += line + "\n";
  }
  return result;
}

}  // namespace palpate

#pragma once

#include <string>
#include <vector>

namespace palpate::app {

/// GLSL text joined from files.
struct ShaderSource {
  std::string text;
  std::vector<std::string> files;  // the name behind each source string number of the #line directives
};

/// Reads a shader and whatever it includes. A line `#include "name"` stands for that file
/// of the same folder, once: a second inclusion, also through others, adds nothing.
/// Throws std::runtime_error "file:line: problem" where a file is missing or an include is malformed.
ShaderSource readShader(const std::string& shader_dir, const std::string& name);

/// A compiler's log with file names in place of source string numbers
/// ("0:12(5): error" of Mesa, "0(12) : error" of NVIDIA become "skin.frag:12").
std::string withFileNames(const std::string& log, const std::vector<std::string>& files);

}  // namespace palpate::app

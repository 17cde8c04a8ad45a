#pragma once

#include <string>
#include <utility>

#include <epoxy/gl.h>

namespace palpate::app {

/// A linked program. Its uniform block "Frame", where it has one, is bound to point 0, and
/// each sampler is bound to the texture unit that texture_units.h gives its name.
class ShaderProgram {
 public:
  /// Reads `vertex` and `fragment` (file names) from the folder.
  /// Throws std::runtime_error naming file and line of what can't be read, compiled or linked.
  ShaderProgram(const std::string& shader_dir, const std::string& vertex, const std::string& fragment);
  ~ShaderProgram();
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;

  void use() const { glUseProgram(program_); }

  /// Location of a uniform; throws std::runtime_error where the program has no such uniform.
  GLint uniform(const char* name) const;

 private:
  std::string name_;
  GLuint program_ = 0;
};

}  // namespace palpate::app

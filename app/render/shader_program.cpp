#include "app/render/shader_program.h"

#include <stdexcept>
#include <vector>

#include "app/render/shader_source.h"
#include "app/render/texture_units.h"

namespace palpate::app {
namespace {

/// The shader's or the program's log, with the matching pair of OpenGL functions.
template <class GetParameter, class GetLog>
std::string infoLog(GLuint name, GetParameter getParameter, GetLog getLog) {
  GLint length = 0;
  getParameter(name, GL_INFO_LOG_LENGTH, &length);
  std::vector<char> text(static_cast<std::size_t>(length) + 1);
  getLog(name, length, nullptr, text.data());
  return text.data();
}

GLuint compile(GLenum kind, const std::string& shader_dir, const std::string& file) {
  const ShaderSource source = readShader(shader_dir, file);
  const GLuint shader = glCreateShader(kind);
  const char* text = source.text.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE) {
    const std::string log = infoLog(shader, glGetShaderiv, glGetShaderInfoLog);
    glDeleteShader(shader);
    throw std::runtime_error("the shader " + shader_dir + "/" + file + " does not compile:\n" +
                             withFileNames(log, source.files));
  }
  return shader;
}

}  // namespace

ShaderProgram::ShaderProgram(const std::string& shader_dir, const std::string& vertex, const std::string& fragment)
    : name_(vertex + " + " + fragment) {
  const GLuint vertex_shader = compile(GL_VERTEX_SHADER, shader_dir, vertex);
  GLuint fragment_shader = 0;
  try {
    fragment_shader = compile(GL_FRAGMENT_SHADER, shader_dir, fragment);
  } catch (...) {
    glDeleteShader(vertex_shader);
    throw;
  }
  program_ = glCreateProgram();
  glAttachShader(program_, vertex_shader);
  glAttachShader(program_, fragment_shader);
  glDeleteShader(vertex_shader);
  glDeleteShader(fragment_shader);
  glLinkProgram(program_);
  GLint linked = GL_FALSE;
  glGetProgramiv(program_, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    const std::string log = infoLog(program_, glGetProgramiv, glGetProgramInfoLog);
    glDeleteProgram(program_);
    throw std::runtime_error("the shaders " + name_ + " do not link:\n" + log);
  }

  const GLuint frame = glGetUniformBlockIndex(program_, "Frame");
  if (frame != GL_INVALID_INDEX) glUniformBlockBinding(program_, frame, 0);
  use();
  for (int unit = 0; unit < kTextureUnitCount; ++unit) {
    const GLint location = glGetUniformLocation(program_, texture_unit_names[unit]);
    if (location >= 0) glUniform1i(location, unit);
  }
  glUseProgram(0);
}

ShaderProgram::~ShaderProgram() { glDeleteProgram(program_); }

GLint ShaderProgram::uniform(const char* name) const {
  const GLint location = glGetUniformLocation(program_, name);
  if (location < 0) throw std::runtime_error("the shaders " + name_ + " have no uniform " + name);
  return location;
}

}  // namespace palpate::app

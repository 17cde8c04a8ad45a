#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "app/render/offscreen_context.h"
#include "app/render/renderer.h"
#include "app/render/shader_program.h"
#include "app/render/shader_source.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("An included file is joined once, and lines keep their places", "[shader]") {
  const TempFolder folder;
  folder.write("a.glsl", "float a;\n");
  folder.write("b.glsl", "#include \"a.glsl\"\nfloat b;\n");
  folder.write("main.frag", "#include \"a.glsl\"\n  #include \"b.glsl\"  // again through b\nfloat c;\n");
  const ShaderSource source = readShader(folder.path(""), "main.frag");
  CHECK(source.files == std::vector<std::string>{"main.frag", "a.glsl", "b.glsl"});
  CHECK(source.text ==
        "#version 330 core\n"
        "#line 1 0\n"
        "#line 1 1\nfloat a;\n"
        "#line 2 0\n"
        "#line 1 2\n"
        "#line 2 2\nfloat b;\n"
        "#line 3 0\nfloat c;\n");
}

TEST_CASE("A wrong include names file, line and what is wanted", "[shader]") {
  const TempFolder folder;
  folder.write("main.frag", "void main() {\n}\n#include \"gone.glsl\"\n");
  CHECK_THROWS_WITH(readShader(folder.path(""), "main.frag"),
                    Catch::Contains("main.frag:3: ") && Catch::Contains("gone.glsl"));
  folder.write("main.frag", "\n#include <gone.glsl>\n");
  CHECK_THROWS_WITH(readShader(folder.path(""), "main.frag"), Catch::Contains("main.frag:2: malformed include"));
  CHECK_THROWS_WITH(readShader(folder.path(""), "none.frag"), Catch::Contains("none.frag"));
}

TEST_CASE("Compilers' logs get file names", "[shader]") {
  const std::vector<std::string> files{"skin.frag", "studio.glsl"};
  CHECK(withFileNames("1:12(5): error: x undeclared\n", files) == "studio.glsl:12: error: x undeclared\n");
  CHECK(withFileNames("0(7) : error C1008\n", files) == "skin.frag:7 : error C1008\n");
  CHECK(withFileNames("9:1(1): other\nplain\n", files) == "9:1(1): other\nplain\n");
}

TEST_CASE("A shader that does not compile names the included file and its line", "[shader][gl]") {
  const OffscreenContext context;
  const TempFolder folder;
  folder.write("ok.vert", "void main() { gl_Position = vec4(0.0); }\n");
  folder.write("broken.glsl", "float good() { return 1.0; }\nfloat bad() { return missing; }\n");
  folder.write("main.frag", "#include \"broken.glsl\"\nout vec4 colour;\nvoid main() { colour = vec4(bad()); }\n");
  CHECK_THROWS_WITH(ShaderProgram(folder.path(""), "ok.vert", "main.frag"),
                    Catch::Contains("main.frag does not compile") && Catch::Contains("broken.glsl:2:"));

  folder.write("main.frag", "out vec4 colour;\nfloat missing();\nvoid main() { colour = vec4(missing()); }\n");
  CHECK_THROWS_WITH(ShaderProgram(folder.path(""), "ok.vert", "main.frag"), Catch::Contains("do not link"));

  folder.write("main.frag", "out vec4 colour;\nvoid main() { colour = vec4(1.0); }\n");
  const ShaderProgram program(folder.path(""), "ok.vert", "main.frag");
  CHECK_THROWS_WITH(program.uniform("absent"), Catch::Contains("absent"));
}

TEST_CASE("The shaders' folder is found, and a wrong PALPATE_SHADER_DIR is refused", "[shader]") {
  ::unsetenv("PALPATE_SHADER_DIR");
  CHECK(std::filesystem::exists(findShaderDir() + "/studio.glsl"));
  const TempFolder empty;
  ::setenv("PALPATE_SHADER_DIR", empty.path("").c_str(), 1);
  CHECK_THROWS_WITH(findShaderDir(), Catch::Contains(empty.path("")));
  empty.write("frame.glsl", "");
  CHECK(findShaderDir() == empty.path(""));
  ::unsetenv("PALPATE_SHADER_DIR");
}

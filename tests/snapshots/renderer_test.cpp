// Pictures of the renderer, held to reference pictures in this folder. Set
// PALPATE_UPDATE_SNAPSHOTS=1 to write the references anew, then look at them before committing.
#include "app/render/renderer.h"
#include "base/build_info.h"

#include <epoxy/gl.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "app/render/framebuffer.h"
#include "app/render/offscreen_context.h"
#include "app/render/picture_difference.h"
#include "contact/tools/tool_list.h"
#include "snapshots/hand_made_model.h"

using namespace palpate;
using namespace palpate::app;
namespace fs = std::filesystem;

namespace {

constexpr int width = 320, height = 240;
const Vec3 top(0, 0, 0.035);

ToolShape ball() {
  ToolShape tool;
  tool.radius = 0.008;
  return tool;
}

/// An ellipsoid organ, its renderer and a picture to draw into.
struct Studio {
  explicit Studio(const ToolShape& tool = ball())
      : model(handMadeModel(ellipsoidSurface(Vec3(0.07, 0.05, 0.035), 4), 0.012, tool)),
        renderer(model, findShaderDir()),
        framebuffer(width, height) {
    view.camera.frame(renderer.centre() + Vec3(0, 0, 0.008), renderer.radius(), width, height);
  }

  Snapshot atRest() const { return restSnapshot(model, top + Vec3(0, 0, 0.012)); }

  Snapshot pressed() const {
    Snapshot snapshot = restSnapshot(model, top - Vec3(0, 0, 0.008));
    pressDent(model, top, 0.011, 0.024, snapshot);
    return snapshot;
  }

  Picture picture(const Snapshot& snapshot) {
    framebuffer.bind();
    scale = renderer.draw(snapshot, view, width, height);
    REQUIRE(glGetError() == GL_NO_ERROR);
    return framebuffer.read();
  }

  OffscreenContext context;  // first: everything below needs it; it throws, and so fails, where EGL can't start
  Model model;
  Renderer renderer;
  Framebuffer framebuffer;
  View view;
  ColourScale scale;
};

std::string referenceFile(const std::string& name) { return sourceFolder() + "/tests/snapshots/" + name + ".png"; }

/// Compares with the reference of this name; where they differ, leaves the picture and the
/// difference in the build folder and says where.
void checkPicture(const std::string& name, const Picture& actual) {
  if (std::getenv("PALPATE_UPDATE_SNAPSHOTS")) {
    writePng(referenceFile(name), actual);
    WARN("wrote " << referenceFile(name) << "; look at it");
    return;
  }
  const PictureDifference d = difference(readPng(referenceFile(name)), actual);
  const fs::path folder = PALPATE_BINARY_DIR "/snapshots";
  if (!looksSame(d)) {
    fs::create_directories(folder);
    writePng(folder / (name + "_actual.png"), actual);
    writePng(folder / (name + "_difference.png"), d.image);
  }
  INFO("reference   " << referenceFile(name));
  INFO("actual      " << (folder / (name + "_actual.png")).string());
  INFO("difference  " << (folder / (name + "_difference.png")).string());
  INFO("mean delta E " << d.mean << ", strong share " << d.strong_share << ", worst " << d.worst);
  CHECK(looksSame(d));
}

}  // namespace

TEST_CASE("The organ at rest and pressed looks as it should", "[snapshot]") {
  Studio studio;
  checkPicture("rest", studio.picture(studio.atRest()));
  checkPicture("pressed", studio.picture(studio.pressed()));
}

TEST_CASE("A picture without the deformation does not pass for one with it", "[snapshot]") {
  // The tool stands as in the pressed picture; only the tissue does not give way.
  Studio studio;
  Snapshot stiff = studio.pressed();
  std::fill(stiff.u.begin(), stiff.u.end(), Float4{});
  const PictureDifference d = difference(readPng(referenceFile("pressed")), studio.picture(stiff));
  CHECK_FALSE(looksSame(d));
  CHECK(d.strong_share > 0.005);  // and not by a hair: more than twice the allowed share
}

TEST_CASE("Fields in colour look as they should", "[snapshot]") {
  Studio studio;
  studio.view.show_fixed = false;
  studio.view.show_forces = false;
  studio.view.colour_map = ColourMap::Displacement;
  checkPicture("displacement", studio.picture(studio.pressed()));
  CHECK(studio.scale.min == 0);
  CHECK(studio.scale.max == Approx(0.0087).epsilon(0.1));  // the dent's 11 mm, smoothed by the shape functions
  studio.view.colour_map = ColourMap::VonMises;
  checkPicture("von_mises", studio.picture(studio.pressed()));
  studio.view.colour_map = ColourMap::J;
  checkPicture("J", studio.picture(studio.pressed()));
  CHECK(studio.scale.min + studio.scale.max == Approx(2));
}

TEST_CASE("Overlays look as they should", "[snapshot]") {
  Studio studio;
  studio.view.show_nodes = studio.view.show_contact = true;
  studio.view.picked_point = studio.model.pointCount() / 2;
  checkPicture("nodes_support_contact", studio.picture(studio.pressed()));
  studio.view = View{studio.view.camera};
  studio.view.show_points = true;
  studio.view.show_tool = false;
  studio.view.pulled_vertex = 5;
  studio.view.pull_target = Vec3(0.03, -0.05, 0.06);
  checkPicture("points_pull", studio.picture(studio.atRest()));
}

TEST_CASE("Flat and round bars look as they should, from nearby and below", "[snapshot]") {
  ToolShape tool{ToolKind::FlatCylinder, 0.008, 0.03, {}};
  {
    Studio studio(tool);
    studio.view.camera.distance *= 0.5;
    studio.view.camera.target = top;
    checkPicture("flat_cylinder_near", studio.picture(studio.pressed()));
  }
  tool.kind = ToolKind::Capsule;
  Studio studio(tool);
  studio.view.camera.elevation_deg = -12;  // the ground is not drawn from below
  checkPicture("capsule_below", studio.picture(studio.pressed()));
}

TEST_CASE("Equal states give equal pictures, whatever was drawn between", "[snapshot]") {
  Studio studio;
  const Picture first = studio.picture(studio.pressed());
  studio.view.colour_map = ColourMap::J;
  studio.view.show_nodes = true;
  studio.picture(studio.atRest());
  Framebuffer other(200, 300);
  other.bind();
  studio.renderer.draw(studio.atRest(), studio.view, 200, 300);
  studio.view.colour_map = ColourMap::Tissue;
  studio.view.show_nodes = false;
  CHECK(studio.picture(studio.pressed()).rgb == first.rgb);
}

TEST_CASE("Drawing leaves the context as it found it", "[snapshot]") {
  Studio studio;
  studio.view.show_nodes = studio.view.show_contact = true;
  studio.view.picked_point = 0;
  studio.framebuffer.bind();
  GLint bound = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  studio.picture(studio.pressed());

  const auto state = [](GLenum name) {
    GLint value = -1;
    glGetIntegerv(name, &value);
    return value;
  };
  CHECK(state(GL_DRAW_FRAMEBUFFER_BINDING) == bound);
  for (const GLenum binding : {GL_CURRENT_PROGRAM, GL_VERTEX_ARRAY_BINDING, GL_ARRAY_BUFFER_BINDING,
                               GL_UNIFORM_BUFFER_BINDING, GL_RENDERBUFFER_BINDING})
    CHECK(state(binding) == 0);
  for (const GLenum test : {GL_DEPTH_TEST, GL_BLEND, GL_CULL_FACE, GL_POLYGON_OFFSET_FILL, GL_DEPTH_CLAMP,
                            GL_SCISSOR_TEST, GL_PROGRAM_POINT_SIZE})
    CHECK(glIsEnabled(test) == GL_FALSE);
  CHECK(state(GL_ACTIVE_TEXTURE) == GL_TEXTURE0);
  CHECK(state(GL_TEXTURE_BINDING_2D) == 0);
  CHECK(state(GL_DEPTH_FUNC) == GL_LESS);
  CHECK(state(GL_DEPTH_WRITEMASK) == GL_TRUE);
  CHECK(state(GL_BLEND_EQUATION_RGB) == GL_FUNC_ADD);
  GLint viewport[4];
  glGetIntegerv(GL_VIEWPORT, viewport);
  CHECK((viewport[2] == width && viewport[3] == height));
}

TEST_CASE("The picture is smooth: no bands in the backdrop, no steps along contours", "[snapshot]") {
  Studio studio;
  const Picture p = studio.picture(studio.atRest());
  const auto at = [&](int x, int y) { return static_cast<int>(p.rgb[3 * (y * width + x)]); };
  // Dither: a band would be a long run of one value along the gradient's direction.
  int longest = 0, run = 1;
  for (int x = 1; x < width; ++x) {
    run = at(x, 8) == at(x - 1, 8) ? run + 1 : 1;
    longest = std::max(longest, run);
  }
  CHECK(longest < 24);
  // Four samples per pixel: on the organ's left contour there are pixels of mixed colour.
  int mixed = 0, rows = 0;
  for (int y = 110; y < 160; ++y) {
    int edge = 2;
    for (int x = 3; x < width / 2; ++x)
      if (std::abs(at(x + 1, y) - at(x - 1, y)) > std::abs(at(edge + 1, y) - at(edge - 1, y))) edge = x;
    const double outside = at(edge - 2, y), inside = at(edge + 2, y);
    for (const int x : {edge - 1, edge, edge + 1}) {
      const double share = (at(x, y) - outside) / (inside - outside);
      if (share > 0.15 && share < 0.85) {
        ++mixed;
        break;
      }
    }
    ++rows;
  }
  CHECK(mixed > rows / 2);
}

#include "app/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "app/render/colour.h"
#include "app/render/frame.h"
#include "app/render/ground_shade.h"
#include "app/render/mesh_buffers.h"
#include "app/render/multisample_target.h"
#include "app/render/noise_texture.h"
#include "app/render/overlays.h"
#include "app/render/rigid_mesh.h"
#include "app/render/shader_program.h"
#include "app/render/shadow_map.h"
#include "app/render/skin_mesh.h"
#include "app/render/solid_mesh.h"
#include "app/render/texture_units.h"
#include "base/build_info.h"

namespace palpate::app {
namespace {

constexpr double radians_per_degree = std::numbers::pi / 180;

// The key light stands to the left of the camera's first position, high and towards it; it
// stays there while the camera turns, as in a room.
constexpr double key_azimuth_from_camera_deg = -58;
constexpr double key_elevation_deg = 52;

constexpr float patterns_per_radius = 0.62F;  // repeats of the tissue's coarse unevenness
constexpr int colour_count = 256;
constexpr float ghost_opacity = 0.35F;
constexpr float ghost_skin_opacity = 0.30F;  // lumps 15 mm deep show, and so does the organ's shape
constexpr double ghost_distance = 5e-4;      // m, between tool and hand: less can't be told apart

Vec3 keyDirection(double camera_azimuth_deg) {
  const double a = (camera_azimuth_deg + key_azimuth_from_camera_deg) * radians_per_degree,
               e = key_elevation_deg * radians_per_degree;
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

/// Where things stand; what camera, light and ground are laid out around.
struct Extent {
  Vec3 centre = Vec3::Zero(), ground = Vec3::Zero();  // m
  double radius = 0;                                  // m

  /// @param positions  the skin's vertices, m
  template <class Position>
  explicit Extent(const std::vector<Position>& positions) {
    Eigen::AlignedBox3d box;
    for (const Position& x : positions) box.extend(x.template cast<double>());
    if (box.isEmpty()) return;
    centre = box.center();
    for (const Position& x : positions) radius = std::max(radius, (x.template cast<double>() - centre).norm());
    // A hair below the lowest point, so that a flat base does not fight with the ground.
    ground = {centre.x(), centre.y(), box.min().z() - 2e-3 * radius};
  }
};

void requireOpenGl33() {
  if (epoxy_gl_version() < 33)
    throw std::runtime_error("OpenGL 3.3 is needed, this context has " + std::to_string(epoxy_gl_version() / 10) + "." +
                             std::to_string(epoxy_gl_version() % 10) + "; run with --offscreen");
}

Eigen::Matrix4f worldFrom(const Pose& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.orientation.toRotationMatrix();
  m.topRightCorner<3, 1>() = pose.position;
  return m.cast<float>();
}

Eigen::Vector4f with(const Vec3& v, double w) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), static_cast<float>(w)};
}

}  // namespace

struct Renderer::Parts {
  Parts(const Body& the_model, const std::string& shader_dir, std::span<const int> whole_vertex);

  void fillFrame(const Snapshot& snapshot, const View& view, int width, int height);
  void drawShadows(const Snapshot& snapshot, const View& view);
  void drawPicture(const Snapshot& snapshot, const View& view);
  void drawSkin(float opacity);
  void drawBalls(const View& view) const;
  void addRigidBodies();
  /// Calls draw(body, world_from_rest) for each that is drawn.
  template <class Draw>
  void forEachRigid(const Snapshot& snapshot, Draw draw) const;
  void drawRigid(const Snapshot& snapshot, const Camera& camera, float opacity) const;
  void drawGhost(const Snapshot& snapshot) const;
  template <class Draw>
  void forEachTool(const Snapshot& snapshot, Draw draw) const;
  void bindTextures(const View& view);
  void releaseState() const;

  const Body& model;
  Extent rest;
  Extent extent;  // at rest; of the present shape where it stands alone on paper
  Vec3 key;

  SkinMesh skin;
  MeshBuffers skin_buffers, tool_buffers;
  std::vector<std::unique_ptr<MeshBuffers>> further_buffers;  // of the tools beside the first
  ShaderProgram skin_program, tool_program, ground_program, backdrop_program;
  GLint tool_place, tool_opacity, skin_opacity, skin_below, skin_above;
  MeshBuffers ball_buffers;
  struct Rigid {
    RigidBody body;  // its motion
    std::unique_ptr<MeshBuffers> mesh;
    Eigen::AlignedBox3d box;  // m, at rest
    bool below = false;       // the organ: the ground lies under it
  };
  std::vector<Rigid> rigid;
  ShadowMap shadow_map;
  GroundShade ground_shade;
  NoiseTexture noise;
  GlTexture sequential_colours, diverging_colours;
  GlBuffer frame_buffer;
  GlVertexArray no_vertices;
  MultisampleTarget target;
  Overlays overlays;
};

namespace {

Vec3f linearLight(const Vec3f& encoded) {
  return encoded.unaryExpr([](float c) { return decodeSrgb(c); });
}

void fillColours(GLuint texture, ColourMap map) {
  std::vector<Vec3f> linear(colour_count);
  for (int i = 0; i < colour_count; ++i) linear[i] = linearLight(colourOf(map, i / (colour_count - 1.0)));
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB16F, colour_count, 1, 0, GL_RGB, GL_FLOAT, linear.data());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  glBindTexture(GL_TEXTURE_2D, 0);
}

/// Whether a box stands anywhere between two places.
bool meets(const Eigen::AlignedBox3d& box, const Vec3& from, const Vec3& to) {
  const Vec3 way = to - from;
  double enters = 0, leaves = 1;
  for (int a = 0; a < 3; ++a) {
    const double at_min = (box.min()[a] - from[a]) / way[a], at_max = (box.max()[a] - from[a]) / way[a];
    enters = std::max(enters, std::min(at_min, at_max));
    leaves = std::min(leaves, std::max(at_min, at_max));
  }
  return enters < leaves;
}

/// A lump, as tool.frag shades it.
SolidMesh ballMesh() {
  SolidMesh mesh = sphereMesh();
  for (SolidVertex& vertex : mesh.vertices) vertex.finish = static_cast<float>(Finish::Lump);
  return mesh;
}

}  // namespace

Renderer::Parts::Parts(const Body& the_model, const std::string& shader_dir, std::span<const int> whole_vertex)
    : model(the_model),
      rest(model.skin.surface.vertices),
      extent(rest),
      key(keyDirection(model.scene.camera.azimuth_deg)),
      skin(model, whole_vertex),
      skin_buffers(skin),
      tool_buffers(toolMesh(model.scene.tools[0].shape)),
      skin_program(shader_dir, "skin.vert", "skin.frag"),
      tool_program(shader_dir, "solid.vert", "tool.frag"),
      ground_program(shader_dir, "ground.vert", "ground.frag"),
      backdrop_program(shader_dir, "backdrop.vert", "backdrop.frag"),
      tool_place(tool_program.uniform("world_from_local")),
      tool_opacity(tool_program.uniform("opacity")),
      skin_opacity(skin_program.uniform("opacity")),
      skin_below(skin_program.uniform("below")),
      skin_above(skin_program.uniform("above")),
      ball_buffers(ballMesh()),
      shadow_map(shader_dir),
      ground_shade(shader_dir),
      overlays(model, shader_dir) {
  for (std::size_t t = 1; t < model.tools.tool.size(); ++t)
    further_buffers.push_back(
        std::make_unique<MeshBuffers>(toolMesh(model.tools.tool[t].shape, !model.tools.tool[t].path.empty())));
  addRigidBodies();
  fillColours(sequential_colours, ColourMap::Displacement);
  fillColours(diverging_colours, ColourMap::J);
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(Frame), nullptr, GL_STREAM_DRAW);
  glBindBuffer(GL_UNIFORM_BUFFER, 0);
}

/// Calls draw(tool, pose, mesh) for each tool and each finger of jaws.
template <class Draw>
void Renderer::Parts::forEachTool(const Snapshot& snapshot, Draw draw) const {
  for (const ToolBody& body : model.tools.body) {
    const auto further = static_cast<std::size_t>(body.tool - 1);
    draw(body.tool, bodyPose(body, snapshot.tools.posture(body.tool)),
         body.tool == 0 ? tool_buffers : *further_buffers[further]);
  }
}

void Renderer::Parts::addRigidBodies() {
  const double lowest = rest.ground.z();
  for (const RigidSpec& spec : model.scene.rigid) {
    const SolidMesh mesh = rigidMesh(spec, rest.centre, rest.radius);
    if (mesh.vertices.empty()) continue;
    Rigid& drawn = rigid.emplace_back();
    Eigen::AlignedBox3d& box = drawn.box;
    for (const SolidVertex& v : mesh.vertices) box.extend(v.position.cast<double>());
    drawn.body.motion = spec.motion;
    drawn.mesh = std::make_unique<MeshBuffers>(mesh);
    constexpr double sunk = 0.05;  // of the organ's radius, that it may lie in its hollows
    drawn.below = box.max().z() < lowest + sunk * rest.radius;
    if (drawn.below) rest.ground.z() = std::min(rest.ground.z(), box.min().z());
  }
  extent = rest;
}

template <class Draw>
void Renderer::Parts::forEachRigid(const Snapshot& snapshot, Draw draw) const {
  const double time = static_cast<double>(snapshot.tick) / model.scene.dynamics.rate_hz;
  for (const Rigid& body : rigid) draw(body, body.body.at(time));
}

void Renderer::Parts::fillFrame(const Snapshot& snapshot, const View& view, int width, int height) {
  const Camera& camera = view.camera;
  const ToolShape& tool = model.scene.tools[0].shape;
  Frame frame;
  frame.clip_from_world = (camera.projection(width, height) * camera.view()).cast<float>();
  frame.shadow_from_world = shadow_map.mapFromWorld();
  frame.eye = with(camera.eye(), 1);
  frame.key = with(key, shadow_map.normalOffset());
  const double handle_end = toolHandleEnd(tool);
  frame.tool_begin = with(snapshot.toolPose().toWorld({0, 0, tool.radius}), view.show_tool ? tool.radius : 0);
  frame.tool_end = with(snapshot.toolPose().toWorld({0, 0, handle_end}), view.show_fixed ? 1 : 0);
  // On paper nothing lies under the body that would take light from it.
  frame.ground =
      with(view.show_room ? extent.ground : Vec3(extent.ground - 100 * extent.radius * Vec3::UnitZ()), extent.radius);
  frame.picture = {static_cast<float>(width), static_cast<float>(height), view.pixel_ratio,
                   view.colour_map == ColourMap::Tissue ? 0.0F
                   : view.show_room                     ? 1.0F
                                                        : 2.0F};
  frame.tissue = with(model.scene.organs[0].colour, patterns_per_radius / rest.radius);
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof frame, &frame, GL_STREAM_DRAW);
  glBindBuffer(GL_UNIFORM_BUFFER, 0);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_buffer);
}

void Renderer::Parts::drawShadows(const Snapshot& snapshot, const View& view) {
  bool on_ground = false;  // what lies below the organ casts no shade on the ground, or it would on itself
  const DrawCasters casters = [&](GLint clip_from_local, const Eigen::Matrix4f& clip_from_world) {
    forEachRigid(snapshot, [&](const Rigid& body, const Pose& pose) {
      if (on_ground && body.below) return;
      const Eigen::Matrix4f clip_from_rest = clip_from_world * worldFrom(pose);
      glUniformMatrix4fv(clip_from_local, 1, GL_FALSE, clip_from_rest.data());
      body.mesh->draw();
    });
    glUniformMatrix4fv(clip_from_local, 1, GL_FALSE, clip_from_world.data());
    skin_buffers.draw();
    if (!view.show_tool) return;
    forEachTool(snapshot, [&](int, const Pose& pose, const MeshBuffers& mesh) {
      const Eigen::Matrix4f clip_from_tool = clip_from_world * worldFrom(pose);
      glUniformMatrix4fv(clip_from_local, 1, GL_FALSE, clip_from_tool.data());
      mesh.draw();
    });
  };
  shadow_map.draw(key, extent.centre, extent.radius, casters);
  on_ground = true;
  ground_shade.draw(key, extent.ground, extent.radius, casters);
}

void Renderer::Parts::bindTextures(const View& view) {
  const auto bind = [](TextureUnit unit, GLenum kind, GLuint texture) {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(kind, texture);
  };
  bind(kShadowMapUnit, GL_TEXTURE_2D, shadow_map.texture());
  bind(kNoiseUnit, GL_TEXTURE_3D, noise.texture());
  bind(kColoursUnit, GL_TEXTURE_2D, view.colour_map == ColourMap::J ? diverging_colours : sequential_colours);
  bind(kGroundShadeUnit, GL_TEXTURE_2D, ground_shade.texture());
  glActiveTexture(GL_TEXTURE0);
}

void Renderer::Parts::drawPicture(const Snapshot& snapshot, const View& view) {
  // Bodies first: what they hide of ground and backdrop is then never shaded.
  glEnable(GL_CULL_FACE);
  if (!view.ghost) drawSkin(1);
  drawBalls(view);
  drawRigid(snapshot, view.camera, 1);
  if (view.show_tool) {
    tool_program.use();
    glUniform1f(tool_opacity, 1);
    forEachTool(snapshot, [&](int, const Pose& pose, const MeshBuffers& mesh) {
      const Eigen::Matrix4f place = worldFrom(pose);
      glUniformMatrix4fv(tool_place, 1, GL_FALSE, place.data());
      mesh.draw();
    });
  }
  if (view.show_room) {
    glBindVertexArray(no_vertices);
    ground_program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3 * 64);
    glDisable(GL_CULL_FACE);
    glDepthFunc(GL_LEQUAL);
    backdrop_program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  if (view.ghost) drawSkin(ghost_skin_opacity);
  drawRigid(snapshot, view.camera, ghost_opacity);
  glDisable(GL_CULL_FACE);
  glDepthFunc(GL_LEQUAL);
}

/// @param opacity  1: those that do not stand before the organ's middle; less: those that do, over all else
void Renderer::Parts::drawRigid(const Snapshot& snapshot, const Camera& camera, float opacity) const {
  tool_program.use();
  glUniform1f(tool_opacity, opacity);
  glEnable(GL_CULL_FACE);
  if (opacity < 1) glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  forEachRigid(snapshot, [&](const Rigid& body, const Pose& pose) {
    const bool covers = meets(body.box, pose.toLocal(camera.eye()), pose.toLocal(rest.centre));
    if (covers != (opacity < 1)) return;
    const Eigen::Matrix4f place = worldFrom(pose);
    glUniformMatrix4fv(tool_place, 1, GL_FALSE, place.data());
    body.mesh->draw();
  });
  glDisable(GL_BLEND);
}

/// @param opacity  1, or less: over all that is drawn before, its near side only
void Renderer::Parts::drawSkin(float opacity) {
  skin_program.use();
  glUniform1f(skin_opacity, opacity);
  const Vec3f under = linearLight(belowColour()), over = linearLight(aboveColour());
  glUniform3fv(skin_below, 1, under.data());
  glUniform3fv(skin_above, 1, over.data());
  if (opacity >= 1) return skin_buffers.draw();
  glEnable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  skin_buffers.draw();
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
}

void Renderer::Parts::drawBalls(const View& view) const {
  if (view.balls.empty()) return;
  tool_program.use();
  glUniform1f(tool_opacity, 1);
  for (const Ball& ball : view.balls) {
    Eigen::Matrix4f place = Eigen::Matrix4f::Identity();
    place.topLeftCorner<3, 3>() *= static_cast<float>(ball.radius);
    place.topRightCorner<3, 1>() = ball.centre.cast<float>();
    glUniformMatrix4fv(tool_place, 1, GL_FALSE, place.data());
    ball_buffers.draw();
  }
}

/// Where the hand is that the first tool stays behind: seen through tissue and tool.
void Renderer::Parts::drawGhost(const Snapshot& snapshot) const {
  tool_program.use();
  glUniform1f(tool_opacity, ghost_opacity);
  glEnable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_DEPTH_TEST);
  forEachTool(snapshot, [&](int tool, Pose pose, const MeshBuffers& mesh) {
    if (tool > 0) return;
    const Quat turn = snapshot.hand_pose.orientation * snapshot.toolPose().orientation.conjugate();
    pose.position = snapshot.hand_pose.position + turn * (pose.position - snapshot.toolPose().position);
    pose.orientation = turn * pose.orientation;
    const Eigen::Matrix4f place = worldFrom(pose);
    glUniformMatrix4fv(tool_place, 1, GL_FALSE, place.data());
    mesh.draw();
  });
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
}

/// Leaves the context as a fresh one has it, but for the framebuffer and its viewport.
void Renderer::Parts::releaseState() const {
  glDisable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glUseProgram(0);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, 0);
  for (int unit = kTextureUnitCount - 1; unit >= 0; --unit) {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, 0);
    glBindTexture(GL_TEXTURE_3D, 0);
  }
  glBlendFunc(GL_ONE, GL_ZERO);
  glClearColor(0, 0, 0, 0);
  glPolygonOffset(0, 0);
}

Renderer::Renderer(const Body& model, const std::string& shader_dir, std::span<const int> whole_vertex) {
  requireOpenGl33();
  parts_ = std::make_unique<Parts>(model, shader_dir, whole_vertex);
}

Renderer::~Renderer() = default;

void Renderer::goOnWith(const Body& model) {
  parts_->skin.goOnWith(model);
  parts_->overlays.goOnWith(model);
}

ColourScale Renderer::draw(const Snapshot& snapshot, const View& view, int framebuffer_width, int framebuffer_height) {
  Parts& parts = *parts_;
  if (framebuffer_width <= 0 || framebuffer_height <= 0) return {view.colour_map, 0, 1};  // a minimised window
  GLint shown = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &shown);

  const ColourScale scale = parts.skin.update(snapshot, view);
  parts.skin_buffers.update(parts.skin);
  const Extent now(parts.skin.positions());
  parts.extent = view.show_room ? parts.rest : now;
  parts.extent.ground.z() = std::min(parts.extent.ground.z(), now.ground.z());  // tissue may hang lower than at rest
  parts.key = keyDirection(view.light_azimuth_deg.value_or(parts.model.scene.camera.azimuth_deg));

  glEnable(GL_DEPTH_TEST);
  parts.drawShadows(snapshot, view);
  parts.fillFrame(snapshot, view, framebuffer_width, framebuffer_height);
  parts.target.bind(framebuffer_width, framebuffer_height);
  if (!view.show_room) glClearColor(1, 1, 1, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  parts.bindTextures(view);
  parts.drawPicture(snapshot, view);
  if (view.show_tool && snapshot.yield_m > ghost_distance) parts.drawGhost(snapshot);
  parts.overlays.draw(snapshot, view, parts.skin, parts.extent.radius, framebuffer_height);
  parts.target.resolveInto(static_cast<GLuint>(shown));
  parts.releaseState();
  return scale;
}

const std::vector<Vec3f>& Renderer::skinPositions() const { return parts_->skin.positions(); }
Vec3 Renderer::centre() const { return parts_->rest.centre; }
double Renderer::radius() const { return parts_->rest.radius; }

std::string findShaderDir() {
  namespace fs = std::filesystem;
  const auto holdsShaders = [](const fs::path& folder) {
    std::error_code ignored;
    return fs::exists(folder / "frame.glsl", ignored);
  };
  if (const char* wanted = std::getenv("PALPATE_SHADER_DIR"); wanted && *wanted) {
    if (holdsShaders(wanted)) return wanted;
    throw std::runtime_error(std::string("PALPATE_SHADER_DIR names ") + wanted + ", which holds no frame.glsl");
  }
  const fs::path source = dataFolder() + "/shaders";
  if (holdsShaders(source)) return source;
  std::error_code ignored;
  const fs::path beside = fs::read_symlink("/proc/self/exe", ignored).parent_path() / "shaders";
  if (holdsShaders(beside)) return beside;
  throw std::runtime_error("no shaders in " + source.string() + " nor in " + beside.string() +
                           "; set PALPATE_SHADER_DIR to the folder of frame.glsl");
}

}  // namespace palpate::app

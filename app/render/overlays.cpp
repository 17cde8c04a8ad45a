#include "app/render/overlays.h"

#include <algorithm>
#include <cmath>

#include "app/render/field.h"

namespace palpate::app {
namespace {

// Linear-light colours that stand off from tissue and from each other.
const Vec3f node_colour(0.92F, 0.90F, 0.84F);
const Vec3f imposed_colour(0.16F, 0.42F, 0.95F);
const Vec3f point_colour(0.20F, 0.75F, 0.55F);
const Vec3f picked_colour(1.0F, 0.75F, 0.10F);
const Vec3f weak_colour(0.25F, 0.20F, 0.35F);
const Vec3f force_colour(1.0F, 0.62F, 0.06F);
const Vec3f contact_colour(0.15F, 0.75F, 0.85F);
const Vec3f pull_colour(0.55F, 0.90F, 0.25F);

constexpr std::size_t max_points = 6000;  // more would be a fog; every n-th is shown instead
constexpr float hidden_opacity = 0.42F;

// An arrow grows with the root of its force, so that both a touch and a firm press can be read.
constexpr double longest_arrow_in_radii = 0.9;
constexpr double full_force = 1.5;  // N, drawn at the longest
// Forces at the skin are compared among themselves.
constexpr double longest_contact_in_tool_radii = 2;
constexpr double min_contact_share = 0.02;
constexpr double min_force = 1e-4;  // N, below which no arrow is drawn

double arrowLength(double force, double organ_radius) {
  return longest_arrow_in_radii * organ_radius * std::sqrt(std::min(1.0, force / full_force));
}

}  // namespace

Overlays::Overlays(const Body& model, const std::string& shader_dir)
    : model_(&model),
      dot_program_(shader_dir, "point.vert", "point.frag"),
      arrow_program_(shader_dir, "arrow.vert", "marker.frag"),
      bubble_program_(shader_dir, "bubble.vert", "marker.frag"),
      opacity_(dot_program_.uniform("opacity")),
      arrow_clear_(arrow_program_.uniform("clear")),
      bubble_clear_(bubble_program_.uniform("clear")),
      bubble_place_(bubble_program_.uniform("world_from_local")),
      bubble_tint_(bubble_program_.uniform("tint")),
      arrow_mesh_(arrowMesh()),
      sphere_mesh_(sphereMesh()) {
  static_assert(sizeof(Dot) == 7 * sizeof(float) && sizeof(Arrow) == 10 * sizeof(float));
  glBindVertexArray(dot_array_);
  glBindBuffer(GL_ARRAY_BUFFER, dot_buffer_);
  addAttribute(0, 3, 0, 7);
  addAttribute(1, 4, 3, 7);
  glBindVertexArray(arrow_mesh_.vertexArray());
  glBindBuffer(GL_ARRAY_BUFFER, arrow_buffer_);
  addAttribute(3, 3, 0, 10);
  addAttribute(4, 4, 3, 10);
  addAttribute(5, 3, 7, 10);
  for (const GLuint per_arrow : {3U, 4U, 5U}) glVertexAttribDivisor(per_arrow, 1);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void Overlays::draw(const Snapshot& snapshot, const View& view, const SkinMesh& skin, double organ_radius,
                    int framebuffer_height) {
  dots_.clear();
  arrows_.clear();
  clear_arrows_.clear();
  bubble_radius_ = 0;
  if (view.show_points) addPoints(snapshot);
  if (view.show_nodes) addNodes(snapshot);
  if (view.picked_point >= 0 && view.picked_point < model_->pointCount()) addSupport(snapshot, view.picked_point);
  if (skin.leftOf(view.pulled_vertex) >= 0) addPull(view, skin, framebuffer_height);
  if (view.show_contact) addContactForces(snapshot, view, skin, framebuffer_height);
  if (view.show_forces) addToolForce(snapshot, view, organ_radius, framebuffer_height);
  drawArrows(clear_arrows_, GL_ALWAYS);
  drawArrows(arrows_, GL_LESS);
  if (!dots_.empty()) drawDots();
  if (bubble_radius_ > 0) drawBubble();
}

/// Nodes stand at X_i + u_i, where their parameters put them; the field there differs a
/// little, since MMLS approximates and does not interpolate.
void Overlays::addNodes(const Snapshot& snapshot) {
  for (int i = 0; i < model_->nodeCount(); ++i) {
    const Vec3 u = snapshot.u.empty() ? Vec3::Zero() : toVec3(snapshot.u[i]);
    const bool imposed = model_->imposed[i] != 0;
    dots_.push_back({(model_->X[i] + u).cast<float>(), imposed ? imposed_colour : node_colour, imposed ? 6.0F : 5.0F});
  }
}

void Overlays::addPoints(const Snapshot& snapshot) {
  const std::vector<Vec3f> x = deformed(model_->point_X, model_->point_shape, snapshot.u);
  const std::size_t every = (x.size() + max_points - 1) / max_points;
  for (std::size_t q = 0; q < x.size(); q += every) dots_.push_back({x[q], point_colour, 3.0F});
}

void Overlays::addSupport(const Snapshot& snapshot, int point) {
  const ShapeTable& shape = model_->point_shape;
  const int begin = shape.begin[point], end = shape.begin[point + 1];
  const auto moved = [&](int node) {
    return Vec3(model_->X[node] + (snapshot.u.empty() ? Vec3::Zero() : toVec3(snapshot.u[node])));
  };
  Vec3 centre = model_->point_X[point];
  double largest = 0;
  for (int k = begin; k < end; ++k) {
    centre += shape.N[k] * (moved(shape.node[k]) - model_->X[shape.node[k]]);
    largest = std::max(largest, std::abs(shape.N[k]));
  }
  for (int k = begin; k < end; ++k) {
    const Vec3 x = moved(shape.node[k]);
    const float share = static_cast<float>(std::sqrt(std::abs(shape.N[k]) / largest));
    dots_.push_back({x.cast<float>(), weak_colour + share * (picked_colour - weak_colour), 5 + 8 * share});
    bubble_radius_ = std::max(bubble_radius_, static_cast<float>((x - centre).norm()));
  }
  bubble_centre_ = centre.cast<float>();
  dots_.push_back({bubble_centre_, Vec3f::Ones(), 9});
}

void Overlays::addPull(const View& view, const SkinMesh& skin, int framebuffer_height) {
  const Vec3f& from = skin.positions()[skin.leftOf(view.pulled_vertex)];
  const Vec3f to = view.pull_target.cast<float>();
  const double pixel = view.camera.pixelSize(view.pull_target, framebuffer_height) * view.pixel_ratio;
  arrows_.push_back({from, to - from, static_cast<float>(1.6 * std::abs(pixel)), pull_colour});
  dots_.push_back({from, pull_colour, 9});
}

/// The force on the tool, from its tip the way that it pushes; shows through the tool's body.
void Overlays::addToolForce(const Snapshot& snapshot, const View& view, double organ_radius, int framebuffer_height) {
  const Vec3 force = snapshot.force.force_filtered;
  const double size = force.norm();
  if (!(size > min_force) || !force.allFinite()) return;
  const Vec3 tip = snapshot.toolPose().position;
  const double pixel = view.camera.pixelSize(tip, framebuffer_height) * view.pixel_ratio;
  clear_arrows_.push_back({tip.cast<float>(), (force / size * arrowLength(size, organ_radius)).cast<float>(),
                           static_cast<float>(3.6 * std::abs(pixel)), force_colour});
}

/// The forces on the tissue, from the skin inwards; tool and tissue hide them, so they show through.
void Overlays::addContactForces(const Snapshot& snapshot, const View& view, const SkinMesh& skin,
                                int framebuffer_height) {
  double largest = 0;
  for (int k = 0; k < snapshot.contact_count; ++k)
    largest = std::max(largest, toVec3(snapshot.contact_force[k]).norm());
  if (!(largest > 0) || !std::isfinite(largest)) return;
  const double pixel = view.camera.pixelSize(snapshot.toolPose().position, framebuffer_height) * view.pixel_ratio;
  for (int k = 0; k < snapshot.contact_count; ++k) {
    const Vec3 force = toVec3(snapshot.contact_force[k]);
    const double share = force.norm() / largest;
    const int v = skin.leftOf(snapshot.contact_vertex[k]);
    if (share < min_contact_share || v < 0) continue;
    const Vec3 along =
        force.normalized() * longest_contact_in_tool_radii * model_->scene.tools[0].shape.radius * std::sqrt(share);
    clear_arrows_.push_back(
        {skin.positions()[v], along.cast<float>(), static_cast<float>(1.1 * std::abs(pixel)), contact_colour});
  }
}

void Overlays::drawDots() const {
  glBindBuffer(GL_ARRAY_BUFFER, dot_buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(dots_.size() * sizeof(Dot)), dots_.data(), GL_STREAM_DRAW);
  dot_program_.use();
  glBindVertexArray(dot_array_);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  const auto pass = [&](GLenum depth, float opacity) {
    glDepthFunc(depth);
    glUniform1f(opacity_, opacity);
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(dots_.size()));
  };
  pass(GL_GREATER, hidden_opacity);
  glDepthMask(GL_TRUE);
  pass(GL_LEQUAL, 1);
  glDisable(GL_BLEND);
  glDisable(GL_PROGRAM_POINT_SIZE);
}

void Overlays::drawArrows(const std::vector<Arrow>& arrows, GLenum depth_test) const {
  if (arrows.empty()) return;
  glBindBuffer(GL_ARRAY_BUFFER, arrow_buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(arrows.size() * sizeof(Arrow)), arrows.data(), GL_STREAM_DRAW);
  arrow_program_.use();
  glUniform1i(arrow_clear_, 0);
  glDepthFunc(depth_test);
  glEnable(GL_CULL_FACE);
  arrow_mesh_.drawInstances(static_cast<int>(arrows.size()));
  glDisable(GL_CULL_FACE);
}

void Overlays::drawBubble() const {
  Eigen::Matrix4f place = Eigen::Matrix4f::Identity();
  place.topLeftCorner<3, 3>() *= bubble_radius_;
  place.topRightCorner<3, 1>() = bubble_centre_;
  bubble_program_.use();
  glUniform1i(bubble_clear_, 1);
  glUniformMatrix4fv(bubble_place_, 1, GL_FALSE, place.data());
  glUniform4f(bubble_tint_, picked_colour.x(), picked_colour.y(), picked_colour.z(), 0.75F);
  glEnable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_DEPTH_TEST);
  sphere_mesh_.draw();
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
}

}  // namespace palpate::app

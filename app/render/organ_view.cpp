#include "app/render/organ_view.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "app/render/field.h"
#include "setup/place.h"

namespace palpate::app {

OrganView::OrganView(const Body& model) : model_(&model), whole_(model, findShaderDir()) {}

/// The snapshot's nodes are those of its place.
void OrganView::follow(const Snapshot& snapshot) {
  if (!snapshot.place || snapshot.place == place_) return;
  model_ = &snapshot.place->model;
  whole_.goOnWith(*model_);
  cut_renderer_.reset();
  place_ = snapshot.place;
}

ColourScale OrganView::draw(const Snapshot& snapshot, const View& view, int framebuffer_width, int framebuffer_height) {
  follow(snapshot);
  cut_shown_ = view.section.on;
  if (!view.section.on) return whole_.draw(snapshot, view, framebuffer_width, framebuffer_height);
  const bool moved = view.section.offset != shown_.offset || view.section.normal != shown_.normal;
  if (!cut_renderer_ || moved) {
    shown_ = view.section;
    try {
      auto body = std::make_unique<const CutBody>(cutBody(*model_, planeOf(shown_, centre(), radius())));
      cut_renderer_.reset();  // before the body that it draws
      cut_ = std::move(body);
      cut_renderer_ = std::make_unique<Renderer>(*cut_, findShaderDir(), cut_->whole_vertex);
    } catch (const std::invalid_argument&) {  // the plane leaves nothing: the last cut stays
    }
  }
  if (!cut_renderer_) return whole_.draw(snapshot, view, framebuffer_width, framebuffer_height);
  positions_ = deformed(model_->skin.surface.vertices, model_->skin, snapshot.u);
  return cut_renderer_->draw(snapshot, view, framebuffer_width, framebuffer_height);
}

const std::vector<Vec3f>& OrganView::skinPositions() {
  return cut_shown_ && cut_ ? positions_ : whole_.skinPositions();
}

CutPlane planeOf(const Section& section, const Vec3& centre, double radius) {
  return {centre + static_cast<double>(section.offset) * radius * section.normal, section.normal};
}

void faceCut(Section& section, const Camera& camera) {
  const Vec3 towards = -camera.forward();
  Eigen::Index most = 0;
  towards.cwiseAbs().maxCoeff(&most);
  section.normal = Vec3::Zero();
  section.normal[most] = towards[most] > 0 ? 1 : -1;
  section.offset = 0;
}

void cutThroughTool(Section& section, const Pose& tool, const Camera& camera, const Vec3& centre, double radius) {
  const Vec3 axis = tool.orientation * Vec3::UnitZ(), towards = -camera.forward();
  const Vec3 normal = towards - towards.dot(axis) * axis;
  if (normal.norm() < 1e-6 || !(radius > 0)) return;
  section.normal = normal.normalized();
  section.offset = static_cast<float>(std::clamp((tool.position - centre).dot(section.normal) / radius, -0.95, 0.95));
  section.on = true;
}

std::vector<Ball> ballsInside(const Body& model, const AlignedVector<Float4>& u) {
  std::vector<Ball> balls;
  for (const MaterialSpec& spec : model.scene.materials) {
    if (spec.everywhere || spec.region.kind != Region::Kind::Sphere) continue;
    Ball ball{spec.region.point, spec.region.radius};
    Vec3 moved = Vec3::Zero();  // with the nodes in it, or the nearest
    double count = 0, nearest = 1e30;
    Vec3 next = Vec3::Zero();
    for (std::size_t i = 0; i < model.X.size() && i < u.size(); ++i) {
      const double distance = (model.X[i] - spec.region.point).norm();
      if (distance < nearest) {
        nearest = distance;
        next = toVec3(u[i]);
      }
      if (distance > spec.region.radius) continue;
      moved += toVec3(u[i]);
      ++count;
    }
    ball.centre += count > 0 ? Vec3(moved / count) : next;
    balls.push_back(ball);
  }
  return balls;
}

}  // namespace palpate::app

#pragma once

#include <memory>

#include "app/render/cut_body.h"
#include "app/render/renderer.h"

namespace palpate::app {

/// Draws the organ whole or cut open, as the view says; what is made for a cut is kept until it moves.
/// All functions belong to the thread with the OpenGL context.
class OrganView {
 public:
  explicit OrganView(const Body& model);

  ColourScale draw(const Snapshot& snapshot, const View& view, int framebuffer_width, int framebuffer_height);

  /// Of the whole organ, as last drawn (Renderer): what is picked and pulled.
  const std::vector<Vec3f>& skinPositions();
  Vec3 centre() const { return whole_.centre(); }
  double radius() const { return whole_.radius(); }

 private:
  void follow(const Snapshot& snapshot);

  const Body* model_;                   // of the snapshot that is shown
  std::shared_ptr<const Place> place_;  // likewise; null where the cloud stays
  Renderer whole_;
  std::vector<Vec3f> positions_;
  bool cut_shown_ = false;
  Section shown_;
  std::unique_ptr<const CutBody> cut_;
  std::unique_ptr<Renderer> cut_renderer_;
};

/// The plane of a section of this body.
CutPlane planeOf(const Section& section, const Vec3& centre, double radius);

/// Turns the section so that its cut faces the eye: across the axis that the eye looks along most.
void faceCut(Section& section, const Camera& camera);
/// A section through the tool's axis that faces the eye.
void cutThroughTool(Section& section, const Pose& tool, const Camera& camera, const Vec3& centre, double radius);

/// The spheres of a scene's later materials, where they lie now: lumps and vessels.
std::vector<Ball> ballsInside(const Body& model, const AlignedVector<Float4>& u);

}  // namespace palpate::app

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/figures/figure.h"
#include "app/render/camera.h"
#include "app/render/colour_map.h"
#include "app/render/cut_body.h"
#include "app/render/picture.h"
#include "base/types.h"
#include "simulation/model.h"

namespace palpate::app {

class Renderer;

/// A value at each node to colour a body by, e.g. the distance to a reference.
struct NodeField {
  std::vector<float> values;  // (node_count) in the unit that the label names; NaN counts for nothing
  std::string label;          // "Distance to the reference, mm"
  bool diverging = false;     // colours that part at the middle of the range
};

/// A picture of a deformed body for a printed page.
struct BodyPicture {
  std::string title;                           // may be empty
  ColourMap colour = ColourMap::Displacement;  // Tissue: no colour bar
  std::optional<NodeField> field;              // shown in place of `colour`
  std::optional<double> low, high;             // of the colours: the field's unit, or m, Pa or 1; else from the values
  double azimuth_deg = -60;                    // of the eye around +z, from +x
  double elevation_deg = 18;                   // of the eye above the horizon
  bool rest_outline = true;                    // thin lines where the body's outline was at rest
  std::optional<Pose> tool;                    // else none is drawn
};

/// A picture with what is needed to find places in it.
struct DrawnBody {
  Picture picture;
  Camera camera;     // that it was drawn with
  double low, high;  // that the ends of the colours stand for
};

/// Draws pictures of one model, each framed around the deformed body. The writer whose context
/// it uses, and the model, must outlive it.
class BodyPainter {
 public:
  /// @param cut  where the body is cut open, so that its inside is seen
  BodyPainter(FigureWriter& writer, const Model& model, const std::optional<CutPlane>& cut = {});
  ~BodyPainter();

  /// @param u  displacement parameters, m   (node_count); empty: at rest
  /// Throws std::invalid_argument where u or the field's values are not one per node.
  DrawnBody draw(const BodyPicture& picture, const AlignedVector<Float4>& u, int width = 1400, int height = 1000);

  /// The same into a PNG file. Throws std::runtime_error that names the file and the reason.
  void write(const std::string& png, const BodyPicture& picture, const AlignedVector<Float4>& u, int width = 1400,
             int height = 1000);

 private:
  FigureWriter& writer_;
  std::unique_ptr<const Model> cut_;
  const Model& model_;  // that is drawn: cut open or whole
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace palpate::app

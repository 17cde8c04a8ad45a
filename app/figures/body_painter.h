#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/render/body_picture.h"
#include "app/render/camera.h"
#include "app/render/cut_body.h"
#include "app/render/picture.h"

namespace palpate::app {

class FigureWriter;
class Renderer;

/// A picture with what is needed to find places in it.
struct DrawnBody {
  Picture picture;
  Camera camera;     // that it was drawn with
  double low, high;  // that the ends of the colours stand for
};

/// Draws pictures of one model, each framed around the deformed body. The writer whose context
/// it uses, and the model, must outlive it. (Written in figures/, on whose paper it draws.)
class BodyPainter {
 public:
  /// @param cut  where the body is cut open, so that its inside is seen
  BodyPainter(FigureWriter& writer, const Body& model, const std::optional<CutPlane>& cut = {});
  ~BodyPainter();

  /// @param u  displacement parameters, m   (node_count); empty: at rest
  /// Throws std::invalid_argument where u or the field's values are not one per node.
  DrawnBody draw(const BodyPicture& picture, const AlignedVector<Float4>& u, int width = 1400, int height = 1000);

  /// The same into a PNG file. Throws std::runtime_error that names the file and the reason.
  void write(const std::string& png, const BodyPicture& picture, const AlignedVector<Float4>& u, int width = 1400,
             int height = 1000);

 private:
  FigureWriter& writer_;
  std::unique_ptr<const Body> cut_;
  const Body& model_;  // that is drawn: cut open or whole
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace palpate::app

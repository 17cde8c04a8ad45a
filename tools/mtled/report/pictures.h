#pragma once

#include <memory>
#include <string>
#include <vector>

// Plain data; nothing here needs what draws it.
#include "app/figures/figure.h"
#include "app/render/body_picture.h"
#include "app/render/cut_body.h"
#include "app/render/picture.h"
#include "base/types.h"

namespace palpate {
struct Model;
}

namespace palpate::tools {

// What a command describes and leaves to be drawn.
using app::Band;
using app::BodyPicture;
using app::ColourMap;
using app::CutPlane;
using app::Figure;
using app::figure_colour_count;
using app::Histogram;
using app::histogramOf;
using app::ink_colour;
using app::NodeField;
using app::paretoFront;
using app::Picture;
using app::Series;
using app::SeriesStyle;

struct Atlas;
struct AtlasAxis;

/// Draws mtled's pictures into PNG files, off-screen. One at a time, used by one thread.
/// Each throws std::runtime_error that names the file and the reason.
class Pictures {
 public:
  virtual ~Pictures() = default;

  virtual void write(const std::string& png, const Figure& figure) = 0;
  virtual void write(const std::string& png, const Histogram& histogram) = 0;
  virtual void write(const std::string& png, const Picture& picture) = 0;

  /// A deformed body.
  /// @param u    displacement parameters, m   (node_count)
  /// @param cut  where the body is cut open; null: it is whole
  virtual void write(const std::string& png, const BodyPicture& picture, const Model& model,
                     const AlignedVector<Float4>& u, const CutPlane* cut) = 0;

  /// The atlas' map: a row of coloured squares for each axis that it has cells of, with a letter for who can't tell
  /// the colours.
  virtual void write(const std::string& png, const Atlas& atlas, const std::vector<AtlasAxis>& axes) = 0;
};

/// Null in a program that was built without pictures (PALPATE_APP=OFF).
/// Throws std::runtime_error where nothing can be drawn off-screen, saying what to install.
std::unique_ptr<Pictures> openPictures();

/// What stands where a picture would be named: empty in a program that has pictures.
std::string withoutPictures();

/// Writes one picture of its own. @return what to say of it: the file's name, or why there is none
template <class... What>
std::string writePicture(const std::string& png, const What&... what) {
  const std::unique_ptr<Pictures> pictures = openPictures();
  if (!pictures) return withoutPictures();
  pictures->write(png, what...);
  return png;
}

}  // namespace palpate::tools

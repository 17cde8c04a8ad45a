#pragma once

#include <memory>
#include <string>

#include "app/figures/figure.h"
#include "app/figures/figure_axis.h"
#include "app/render/picture.h"

namespace palpate::app {

class Canvas;

/// A figure with the places of its axes, px.
struct DrawnFigure {
  Picture picture;
  Axis x, y;
};

/// Draws figures for a printed page, off-screen: dark on white, type as large as is fit for
/// pictures that are shown at about half their pixels. One at a time, used by one thread.
class FigureWriter {
 public:
  /// Throws std::runtime_error where there is no off-screen drawing, saying what to install.
  FigureWriter();
  ~FigureWriter();

  /// Throws std::invalid_argument, naming the series, where x and y differ in length.
  DrawnFigure draw(const Figure& figure, int width = 1600, int height = 1000);
  DrawnFigure draw(const Histogram& histogram, int width = 1600, int height = 1000);

  /// The same into a PNG file. Throws std::runtime_error that names the file and the reason.
  void write(const std::string& png, const Figure& figure, int width = 1600, int height = 1000);
  void write(const std::string& png, const Histogram& histogram, int width = 1600, int height = 1000);

  /// What it draws on, for other pictures of the same page (BodyPainter).
  Canvas& canvas() { return *canvas_; }

 private:
  std::unique_ptr<Canvas> canvas_;
};

}  // namespace palpate::app

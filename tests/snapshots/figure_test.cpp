#include "app/figure.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "app/body_picture.h"
#include "simulation/build_model.h"
#include "discretization/solids.h"

using namespace palpate;

TEST_CASE("demo", "[.demo]") {
  FigureWriter writer;
  Figure f;
  f.title = "Gel cylinder: reaction over compression";
  f.x_label = "Compression, mm";
  f.y_label = "Reaction, N";
  Series a{"Reference, hexahedra", {}, {}, SeriesStyle::Line, ink_colour, {}, {}}, b{"MTLED, 4 points per cell", {}, {}, SeriesStyle::LineAndPoints, next_colour, {}, {}},
      c{"MTLED, 1 point per cell", {}, {}, SeriesStyle::Dashed, next_colour, {}, {}};
  Band band{"Measured, ± one standard deviation", {}, {}, {}, 0};
  for (int k = 0; k <= 200; ++k) {
    const double x = 0.03 * k, y = 3.1 * x + 0.9 * x * x;
    a.x.push_back(x), a.y.push_back(y);
    band.x.push_back(x), band.low.push_back(0.9 * y), band.high.push_back(1.12 * y);
    if (k % 10 == 0) b.x.push_back(x), b.y.push_back(y * 1.03);
    c.x.push_back(x), c.y.push_back(k > 80 && k < 100 ? NAN : y * 1.25);
  }
  f.series = {a, b, c};
  f.bands = {band};
  writer.write("/tmp/fig/curve.png", f);

  Figure g;
  g.title = "Extension of a box: convergence of the displacement";
  g.x_label = "Node spacing h, mm";
  g.y_label = "Relative L2 error";
  g.log_x = g.log_y = true;
  for (int m = 0; m < 4; ++m) {
    Series s;
    s.label = std::vector<std::string>{"Standard MTLED", "Corrected gradients", "Node patches", "Order 2"}[m];
    s.style = m == 3 ? SeriesStyle::Dashed : SeriesStyle::LineAndPoints;
    if (m == 3) s.colour = ink_colour;
    for (double h : {1.0, 1.5, 2.0, 3.0, 5.0, 8.0}) s.x.push_back(h), s.y.push_back(2e-4 * std::pow(h, 1.2 + 0.3 * m) * (3 - 0.5 * m));
    g.series.push_back(s);
  }
  g.marks.push_back({"Limit 1 %", 0.01, true, 1});
  writer.write("/tmp/fig/convergence.png", g);

  Figure p;
  p.title = "What a millisecond buys";
  p.x_label = "Time of a step, µs";
  p.y_label = "Error of the force, %";
  p.log_x = true;
  Series cloud{"Configurations", {}, {}, SeriesStyle::Points, 0, {}, {}};
  unsigned r = 7;
  const auto rnd = [&] { r = r * 1664525u + 1013904223u; return (r >> 8) / 16777216.0; };
  for (int k = 0; k < 22; ++k) {
    const double t = 60 * std::pow(30, rnd());
    cloud.x.push_back(t), cloud.y.push_back(900 / t + 4 * rnd());
    cloud.point_labels.push_back("h" + std::to_string(3 + k % 5) + " q" + std::to_string(1 + k % 3));
  }
  cloud.highlighted = paretoFront(cloud.x, cloud.y);
  Series front{"Pareto front", {}, {}, SeriesStyle::Step, 1, {}, {}};
  for (int i : cloud.highlighted) front.x.push_back(cloud.x[i]), front.y.push_back(cloud.y[i]);
  p.series = {front, cloud};
  p.marks.push_back({"1 kHz", 1000, false, 2});
  writer.write("/tmp/fig/pareto.png", p);

  std::vector<double> v;
  for (int k = 0; k < 20000; ++k) v.push_back(1e-6 * std::exp(1.2 * (rnd() + rnd() + rnd() + rnd() - 2)));
  v.push_back(2.5e-5);
  Histogram h = histogramOf(v, 60);
  h.title = "Error at the nodes";
  h.x_label = "Distance to the reference, m";
  h.y_label = "Nodes";
  h.marks = {{"median", 1e-6, false, ink_colour}, {"p99", 4.1e-6, false, ink_colour}, {"limit", 2e-5, false, 1}};
  writer.write("/tmp/fig/histogram.png", h);

  Figure z;
  z.title = "Noise everywhere, so that the legend stands above";
  z.x_label = "Time, s";
  z.y_label = "Velocity, m/s";
  for (int m = 0; m < 5; ++m) {
    Series s;
    s.label = "Node " + std::to_string(117 * m) + " of the upper face";
    for (int k = 0; k < 800; ++k) s.x.push_back(0.002 * k), s.y.push_back(1e-4 * (rnd() - 0.5) * (m + 1));
    z.series.push_back(s);
  }
  writer.write("/tmp/fig/noise.png", z);

  Scene scene;
  scene.name = "gel";
  scene.solid = Scene::Solid::Cylinder;
  scene.size = Vec3(0.03, 0.03, 0.017);
  scene.spacing = 0.003;
  scene.materials.emplace_back();
  scene.materials[0].young = 3000;
  scene.materials[0].poisson = 0.49;
  BoundarySpec base;
  base.region.kind = Region::Kind::NearPlane;
  base.region.distance = 1e-6;
  scene.boundaries.push_back(base);
  const Model model = buildModel(scene, cylinderSurface(0.015, 0.017, 0.0015));
  AlignedVector<Float4> u(model.X.size());
  NodeField error{{}, "Distance to the reference, µm", false};
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vec3 X = model.X[i];
    const double t = X.z() / 0.017, d = 0.2 * t, bulge = 0.9 * d * 4 * t * (1 - t);
    u[i] = toFloat4(Vec3(bulge * X.x(), bulge * X.y(), -d * X.z()));
    error.values.push_back(30 * std::abs(X.x()) / 0.015 * t + 3);
  }
  BodyPainter painter(writer, model);
  BodyPicture picture;
  picture.title = "Gel cylinder compressed by a fifth";
  painter.write("/tmp/fig/body_displacement.png", picture, u);
  picture.colour = ColourMap::J;
  painter.write("/tmp/fig/body_J.png", picture, u);
  picture.field = error;
  picture.azimuth_deg = 130;
  picture.elevation_deg = 35;
  painter.write("/tmp/fig/body_error.png", picture, u);
}

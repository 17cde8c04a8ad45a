#include "app/render/field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mechanics/materials/material.h"

namespace palpate::app {

std::vector<float> pointValues(const Body& model, const Displacements& u, ColourMap map,
                               const std::vector<Material>& present) {
  const ShapeTable& shape = model.point_shape;
  const std::vector<Material>& materials = present.empty() ? model.materials : present;
  std::vector<float> values(model.point_X.size());
  for (std::size_t q = 0; q < values.size(); ++q) {
    Mat3 F = Mat3::Identity();
    if (!u.empty())
      for (int k = shape.begin[q]; k < shape.begin[q + 1]; ++k)
        F += toVec3(u[shape.node[k]]) * shape.gradN[k].transpose();
    const double value =
        map == ColourMap::J ? F.determinant() : vonMises(materials[model.point_material[q]].firstPiola(F), F);
    values[q] = static_cast<float>(value);
  }
  return values;
}

std::vector<float> nodeAverages(const Body& model, const std::vector<float>& point_values) {
  const ShapeTable& shape = model.point_shape;
  std::vector<double> sum(model.X.size(), 0.0), weight(model.X.size(), 0.0);
  for (std::size_t q = 0; q < point_values.size(); ++q) {
    if (!std::isfinite(point_values[q])) continue;
    for (int k = shape.begin[q]; k < shape.begin[q + 1]; ++k) {
      const double w = model.point_volume[q] * std::max(0.0, shape.N[k]);
      sum[shape.node[k]] += w * point_values[q];
      weight[shape.node[k]] += w;
    }
  }
  std::vector<float> averages(model.X.size());
  for (std::size_t i = 0; i < averages.size(); ++i)
    averages[i] = weight[i] > 0 ? static_cast<float>(sum[i] / weight[i]) : std::numeric_limits<float>::quiet_NaN();
  return averages;
}

std::vector<float> skinAverages(const Body& model, const std::vector<float>& node_values) {
  const SkinModel& shape = model.skin;
  std::vector<float> values(shape.surface.vertices.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    double sum = 0, weight = 0;
    for (int k = shape.begin[v]; k < shape.begin[v + 1]; ++k) {
      const double w = std::max(0.0F, shape.N[k]);
      if (!std::isfinite(node_values[shape.node[k]])) continue;
      sum += w * node_values[shape.node[k]];
      weight += w;
    }
    values[v] = weight > 0 ? static_cast<float>(sum / weight) : 0.0F;
  }
  return values;
}

std::vector<float> skinValues(const Body& model, const Displacements& u, const std::vector<Vec3f>& x, ColourMap map,
                              const std::vector<Material>& materials) {
  switch (map) {
    case ColourMap::Tissue:
    case ColourMap::Pressure:  // no field of the tissue's: the view brings it (View::skin_values)
      return std::vector<float>(x.size(), 0.0F);
    case ColourMap::Displacement: {
      std::vector<float> values(x.size());
      for (std::size_t v = 0; v < x.size(); ++v)
        values[v] = (x[v] - model.skin.surface.vertices[v].cast<float>()).norm();
      return values;
    }
    case ColourMap::VonMises:
    case ColourMap::J:
      return skinAverages(model, nodeAverages(model, pointValues(model, u, map, materials)));
  }
  return {};
}

ColourScale automaticScale(const std::vector<float>& values, ColourMap map) {
  constexpr double min_displacement = 1e-4, min_stress = 10, min_pressure = 1000, min_volume_change = 0.01;
  double largest = 0;
  for (const float value : values) largest = std::max(largest, std::abs(value - (map == ColourMap::J ? 1.0 : 0.0)));
  switch (map) {
    case ColourMap::Tissue:
      break;
    case ColourMap::Displacement:
      return {map, 0, std::max(largest, min_displacement)};
    case ColourMap::VonMises:
      return {map, 0, std::max(largest, min_stress)};
    case ColourMap::Pressure:
      return {map, 0, std::max(largest, min_pressure)};
    case ColourMap::J: {
      const double change = std::max(largest, min_volume_change);
      return {map, 1 - change, 1 + change};
    }
  }
  return {map, 0, 1};
}

}  // namespace palpate::app

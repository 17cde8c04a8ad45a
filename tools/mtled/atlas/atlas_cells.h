#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mtled/atlas/atlas_result.h"

namespace palpate::tools {

/// What one row of the map varies.
struct AtlasAxis {
  std::string key;    // "nu"
  std::string title;  // "Poisson's ratio, sides free"
  std::string about;  // what is run, and with what it is compared
};

/// One place of the map.
struct AtlasCell {
  enum class When { Always, Quick, Full };  // run always, with --quick only, or without only
  std::string axis, value;                  // an axis's key; "0.49"
  When when = When::Full;
  /// Throws InputError where the set-up refuses, AtlasInterrupted. Cells are run by several threads at once.
  std::function<AtlasMeasure()> run;

  std::string name() const;  // "nu/0.49": on the command line
};

/// All of them, in the map's order.
const std::vector<AtlasAxis>& atlasAxes();
const std::vector<AtlasCell>& atlasCells();

// Its parts.
void addSolidCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells);    // deformation and material
void addToolCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells);     // speed, teleport, bottom
void addCloudCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells);    // nodes that lie badly
void addNumericCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells);  // time step, float32, modes
void addSceneCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells);    // hands on the scenes of assets

}  // namespace palpate::tools

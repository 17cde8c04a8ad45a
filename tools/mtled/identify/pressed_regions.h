#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batch/sensitivity.h"

namespace palpate::tools {

/// A press that had come to rest.
struct SettledPress {
  Vec3 tip = Vec3::Zero();  // m, of the tool
  double force = 0;         // N, along the tool's axis
  int line = 0;             // of the file
};

/// Presses of a CSV file with columns x_m, y_m, z_m (or x_mm, ...), of the tool's tip, and force_N (or force_mN).
/// Throws InputError naming file and line of what can't be used.
std::vector<SettledPress> readPresses(const std::string& path);

/// A scene's answers to presses with any materials, and their derivatives.
class PressedRegions {
 public:
  /// @param numbers  that are sought
  /// Throws InputError for a scene that sensitivities are not for, or that has no such number.
  PressedRegions(const Model& model, std::vector<SettledPress> presses, std::vector<MaterialNumber> numbers,
                 int threads);

  /// Goes on with the same scene, set up anew; presses are solved from where they were.
  void setUpAnew(const Model& model);

  /// Forces along the tool's axis, N (press_count), with these values. Throws std::runtime_error naming the press that
  /// has none.
  std::vector<double> forces(const std::vector<double>& values);

  /// Their derivatives at the values of the last forces() (press_count)(number_count).
  std::vector<std::vector<double>> derivatives();

  /// EquilibriumSensitivity::expectedError of a press at these values.
  double expectedError(std::size_t press);

  int solutionCount() const;  // linear ones so far

 private:
  Pose poseOf(const SettledPress& press) const;
  void putIn(const std::vector<double>& values);
  template <class Each>
  void forPresses(Each each);

  const Model* model_;
  const std::vector<SettledPress> presses_;
  const std::vector<MaterialNumber> numbers_;
  EquilibriumQuantity axial_;
  std::vector<std::unique_ptr<EquilibriumSensitivity>> bodies_;  // one for each thread
  int solved_before_ = 0;                                        // by those of earlier set-ups
  std::vector<AlignedVector<Double4>> u_;                        // (press_count) last equilibria; empty: none yet
  std::vector<double> lacking_;                                  // (press_count) EquilibriumSensitivity::lacking
};

}  // namespace palpate::tools

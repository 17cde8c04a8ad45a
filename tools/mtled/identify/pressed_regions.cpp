#include "mtled/identify/pressed_regions.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <thread>
#include <utility>

#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/csv_table.h"

namespace palpate::tools {
namespace {

/// A column of m or mm, N or mN, as m or N.
std::vector<double> columnIn(const CsvTable& table, const std::string& name, const std::string& unit) {
  if (table.find(name + "_m" + unit) < 0) return table[name + "_" + unit];
  if (table.find(name + "_" + unit) >= 0)
    throw InputError(table.header, "columns " + name + "_" + unit + " and " + name + "_m" + unit + " for the same",
                     "leave one of them out");
  std::vector<double> column = table[name + "_m" + unit];
  for (double& value : column) value *= 1e-3;
  return column;
}

}  // namespace

std::vector<SettledPress> readPresses(const std::string& path) {
  const CsvTable table = readCsvTable(path);
  const std::vector<double> x = columnIn(table, "x", "m"), y = columnIn(table, "y", "m"), z = columnIn(table, "z", "m"),
                            force = columnIn(table, "force", "N");
  std::vector<SettledPress> presses;
  for (std::size_t k = 0; k < table.rowCount(); ++k) {
    const Vec3 tip(x[k], y[k], z[k]);
    if (!tip.allFinite() || !std::isfinite(force[k]))
      throw InputError({path, table.line[k]}, "a number of this press is missing", "fill it in, or leave the row out");
    presses.push_back({tip, force[k], table.line[k]});
  }
  return presses;
}

PressedRegions::PressedRegions(const Model& model, std::vector<SettledPress> presses,
                               std::vector<MaterialNumber> numbers, int threads)
    : presses_(std::move(presses)), numbers_(std::move(numbers)), u_(presses_.size()), lacking_(presses_.size()) {
  axial_.direction = model.tools.first().start.pose.orientation * Vec3::UnitZ();
  bodies_.resize(static_cast<std::size_t>(std::clamp(threads, 1, std::max(1, static_cast<int>(presses_.size())))));
  setUpAnew(model);
  for (const MaterialNumber& number : numbers_) bodies_.front()->check(number);
}

void PressedRegions::setUpAnew(const Model& model) {
  constexpr double accuracy = 1e-6;  // forces are measured to a thousandth at best
  model_ = &model;
  for (auto& body : bodies_) {
    if (body) solved_before_ += body->solutionCount();
    body = std::make_unique<EquilibriumSensitivity>(
        model, 1, [] { return !interrupted(); }, accuracy);
  }
}

Pose PressedRegions::poseOf(const SettledPress& press) const {
  Pose pose = model_->tools.first().start.pose;
  pose.position = press.tip;
  return pose;
}

/// Calls each(body, press) for all presses, side by side. No answer depends on who gives it.
template <class Each>
void PressedRegions::forPresses(Each each) {
  std::vector<std::exception_ptr> failed(presses_.size());
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < bodies_.size(); ++t)
    threads.emplace_back([&, t] {
      for (std::size_t k = t; k < presses_.size(); k += bodies_.size()) {
        try {
          each(*bodies_[t], k);
        } catch (...) {
          failed[k] = std::current_exception();
          return;
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t k = 0; k < failed.size(); ++k) {
    if (!failed[k]) continue;
    try {
      std::rethrow_exception(failed[k]);
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw std::runtime_error("the press of line " + std::to_string(presses_[k].line) + ": " + error.what());
    }
  }
}

void PressedRegions::putIn(const std::vector<double>& values) {
  std::vector<Material> materials = bodies_.front()->materials();
  for (std::size_t k = 0; k < numbers_.size(); ++k) {
    Material& material = materials[static_cast<std::size_t>(numbers_[k].material)];
    const auto present = material.get(numbers_[k].name);
    std::vector<double> changed(present.begin(), present.end());
    changed[static_cast<std::size_t>(numbers_[k].entry)] = values[k];
    material.set(numbers_[k].name, changed);
  }
  for (auto& body : bodies_) body->setMaterials(materials);
}

std::vector<double> PressedRegions::forces(const std::vector<double>& values) {
  putIn(values);
  std::vector<double> forces(presses_.size());
  forPresses([&](EquilibriumSensitivity& body, std::size_t k) {
    const Pose pose = poseOf(presses_[k]);
    bool near = !u_[k].empty();
    if (near) {
      try {
        body.settleFrom(u_[k], pose);
      } catch (const std::runtime_error&) {
        near = false;
      }
    }
    if (!near) {
      body.settle(pose);
      lacking_[k] = body.lacking();
    }
    u_[k] = body.u();
    forces[k] = body.valueOf(axial_);
  });
  return forces;
}

std::vector<std::vector<double>> PressedRegions::derivatives() {
  std::vector<std::vector<double>> slopes(presses_.size());
  forPresses([&](EquilibriumSensitivity& body, std::size_t k) {
    body.takeFrom(u_[k], poseOf(presses_[k]));
    slopes[k] = body.derivatives(axial_, numbers_);
  });
  return slopes;
}

double PressedRegions::expectedError(std::size_t press) {
  bodies_.front()->takeFrom(u_[press], poseOf(presses_[press]), lacking_[press]);
  return bodies_.front()->expectedError();
}

int PressedRegions::solutionCount() const {
  int count = solved_before_;
  for (const auto& body : bodies_) count += body->solutionCount();
  return count;
}

}  // namespace palpate::tools

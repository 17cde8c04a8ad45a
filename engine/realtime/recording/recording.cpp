#include "realtime/recording/recording.h"

#include "base/input_error.h"
#include "base/number_text.h"
#include "mechanics/materials/material_law.h"
#include "model/model.h"
#include "model/model_hash.h"

namespace palpate {
namespace {

/// What is wrong with a number that must be below `count`.
std::string missing(const char* what, int number, int count) {
  if (number < count) return {};
  return format("there is no %s %d: the model has %d, from 0 on", what, number, count);
}

std::string beyond(const char* what, const Vec3& value, double most) {
  if (value.cwiseAbs().maxCoeff() <= most) return {};
  return format("%s with a component beyond %g", what, most);
}

std::string materialProblem(const Model& model, int index, const Material& material) {
  if (index < 0) return "a material's number can't be negative";
  if (std::string problem = missing("material", index, static_cast<int>(model.materials.size())); !problem.empty())
    return problem;
  const Material& loaded = model.materials[static_cast<std::size_t>(index)];
  if (material.law != loaded.law) return std::string("the material is ") + loaded.lawDescription().title;
  if (material.density != loaded.density) return "the density can't change while a run goes on";
  std::string problem;
  forEachParameter(material, [&](const Parameter& p, std::span<const double> values) {
    for (const double value : values)
      if (problem.empty() && !p.range.contains(value)) problem = std::string(p.name) + " must be " + p.range.text();
  });
  return problem;
}

/// Why a request can't be of a run of this model; "": it can.
std::string problemOf(const Request& request, const Model& model) {
  using Kind = Request::Kind;
  const int vertices = model.skin.vertexCount(), tools = model.tools.toolCount(),
            regions = static_cast<int>(model.boundary.motions.size());
  std::string problem = beyond("a pose", request.pose.position, Request::farthest);
  switch (request.kind) {
    case Kind::SetFriction:
      problem = missing("tool", request.index, tools);
      if (request.index < 0 || !(request.value >= 0 && request.value <= Request::most_friction))
        problem = format("friction must be 0 .. %g", Request::most_friction);
      return problem;
    case Kind::SetMaterial:
      return materialProblem(model, request.index, request.material);
    case Kind::SetGravity:
      return request.point == model.scene.dynamics.gravity ? std::string()
                                                           : beyond("gravity", request.point, Request::most_gravity);
    case Kind::SetForce:
    case Kind::Pin:
    case Kind::Pull:
    case Kind::Unpin:
      problem = missing("skin vertex", request.index, vertices);
      break;
    case Kind::MoveRegion:
      problem = missing("region", request.index, regions);
      break;
    case Kind::MoveHand:
    case Kind::SetOpening:
      if (problem.empty()) problem = missing("tool", request.index, tools);
      break;
    default:
      break;
  }
  return problem.empty() ? beyond("a place, shift or force", request.point, Request::farthest) : problem;
}

}  // namespace

void checkRate(const Recording& recording, double rate_hz, const std::string& file) {
  constexpr int kRateLine = 4;
  if (recording.rate_hz == rate_hz) return;
  throw InputError(
      {file, kRateLine},
      "recorded at " + shortest(recording.rate_hz) + " Hz, but the scene runs at " + shortest(rate_hz) + " Hz",
      "replay with --rate " + shortest(recording.rate_hz));
}

void checkRecordingFits(const Recording& recording, const Model& model, const std::string& file) {
  constexpr int kModelLine = 3;
  checkRate(recording, model.scene.dynamics.rate_hz, file);
  const std::uint64_t hash = modelHash(model);
  if (recording.model_hash != hash) {
    throw InputError({file, kModelLine},
                     "recorded with model " + hex16(recording.model_hash) + " (scene " + inQuotes(recording.scene) +
                         "), but this one is " + hex16(hash) + " (scene " + inQuotes(model.scene.name) + ")",
                     "replay with the scene, program, machine and PALPATE_KERNEL it was recorded with");
  }
  for (std::size_t k = 0; k < recording.changes.size(); ++k)
    if (const std::string problem = problemOf(recording.changes[k].request, model); !problem.empty())
      throw InputError({file, recording.line.empty() ? 0 : recording.line[k]}, problem,
                       "this recording was not left so; record the run again");
}

}  // namespace palpate

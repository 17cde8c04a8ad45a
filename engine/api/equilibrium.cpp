#include <thread>

#include "api/border.h"
#include "api/handles.h"
#include "batch/sensitivity.h"
#include "step/tool_bodies.h"

using namespace palpate;
using namespace palpate::api;

struct palpate_equilibrium {
  palpate_equilibrium(const palpate_model& of, std::shared_ptr<const Model> place, int threads)
      : loaded(of.model), model(std::move(place)), body(*model, threads) {}

  std::shared_ptr<const Model> loaded;
  std::shared_ptr<const Model> model;  // loaded; where the cloud follows the tool, that of the place for the pose
  EquilibriumSensitivity body;
  std::optional<Pose> tool;
};

namespace {

/// What is asked of an equilibrium. Throws Refusal.
EquilibriumQuantity quantityOf(const palpate_equilibrium& equilibrium, const palpate_quantity* wanted) {
  if (wanted == nullptr) throw Refusal(PALPATE_BAD_ARGUMENT, "quantity is NULL");
  const palpate_quantity asked = given(wanted);
  EquilibriumQuantity quantity;
  if (!isPlace(asked.direction)) throw Refusal(PALPATE_BAD_ARGUMENT, "quantity.direction is not finite, or too long");
  quantity.direction = Vec3(asked.direction[0], asked.direction[1], asked.direction[2]).stableNormalized();
  if (quantity.direction.isZero(0)) throw Refusal(PALPATE_BAD_ARGUMENT, "quantity.direction has no length");
  const auto checkIndex = [&asked](std::size_t count) {
    if (asked.index < 0 || static_cast<std::size_t>(asked.index) >= count)
      throw Refusal(PALPATE_BAD_ARGUMENT, "quantity.index " + std::to_string(asked.index) + " is not in 0 .. " +
                                              std::to_string(static_cast<std::int64_t>(count) - 1));
  };
  switch (asked.kind) {
    case PALPATE_TOOL_FORCE:
      quantity.kind = EquilibriumQuantity::Kind::ToolForce;
      return quantity;
    case PALPATE_REGION_FORCE:
      checkIndex(equilibrium.model->boundary.motions.size());
      quantity.kind = EquilibriumQuantity::Kind::RegionForce;
      quantity.region = asked.index;
      return quantity;
    case PALPATE_DISPLACEMENT: {
      if (asked.points == nullptr || asked.points->model != equilibrium.loaded)
        throw Refusal(PALPATE_BAD_ARGUMENT, "quantity.points is NULL, or of another model");
      checkIndex(asked.points->X.size());
      quantity.kind = EquilibriumQuantity::Kind::Displacement;
      const auto rows = asked.points->rowsAt(equilibrium.model);
      const ShapeTable& shape = *rows->shape;
      for (int e = shape.begin[asked.index]; e < shape.begin[asked.index + 1]; ++e)
        quantity.row.emplace_back(shape.node[e], shape.N[e]);
      return quantity;
    }
    default:
      throw Refusal(PALPATE_BAD_ARGUMENT, "there is no quantity.kind " + std::to_string(asked.kind));
  }
}

MaterialNumber numberFrom(const palpate_material_number& number) {
  if (number.name == nullptr) throw Refusal(PALPATE_BAD_ARGUMENT, "a number without a name");
  return {number.material, number.name, number.entry};
}

/// The model for a tool at a pose (or nowhere).
std::shared_ptr<const Model> placeFor(const palpate_model& of, const double* pose) {
  if (!of.places || pose == nullptr) return of.model;
  ToolPostures tools = posturesOf(initialState(*of.model));
  tools[0].pose = poseFrom(pose);
  const auto place = of.places->at(placeUnder(of.places->places(), tools));
  return {place, &place->model};
}

/// Calls what solves for an equilibrium; where there is none, that is a refusal.
template <class Solve>
void settled(Solve solve) {
  try {
    solve();
  } catch (const InputError&) {
    throw;
  } catch (const Refusal&) {
    throw;
  } catch (const std::runtime_error& none) {
    throw Refusal(PALPATE_REFUSED, none.what());
  }
}

}  // namespace

extern "C" {

int32_t palpate_settle(const palpate_model* model, const double* pose, double time, int32_t threads,
                       palpate_equilibrium** equilibrium, palpate_error* error) {
  if (equilibrium != nullptr) *equilibrium = nullptr;
  if (const std::int32_t code = nullAmong(error, {{model, "model"}, {equilibrium, "equilibrium"}})) return code;
  if (pose != nullptr && !isPose(pose)) return say(error, PALPATE_BAD_ARGUMENT, "pose is not finite, or no turn");
  if (!(time >= 0 && std::isfinite(time))) return say(error, PALPATE_BAD_ARGUMENT, "time is negative, or not finite");
  if (const std::int32_t code = sayToo(error, outside("threads", threads, 0, max_threads + 1))) return code;
  return guarded(error, [&] {
    const int cores = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, max_threads);
    auto made = std::make_unique<palpate_equilibrium>(*model, placeFor(*model, pose), threads > 0 ? threads : cores);
    if (pose != nullptr) made->tool = poseFrom(pose);
    settled([&] { made->body.settle(made->tool, time); });
    *equilibrium = made.release();
    return PALPATE_OK;
  });
}

void palpate_equilibrium_destroy(palpate_equilibrium* equilibrium) { delete equilibrium; }

int32_t palpate_settle_with(palpate_equilibrium* equilibrium, const palpate_material_number* number, double value,
                            palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{equilibrium, "equilibrium"}, {number, "number"}})) return code;
  return guarded(error, [&] {
    const MaterialNumber wanted = numberFrom(*number);
    EquilibriumSensitivity& body = equilibrium->body;
    body.check(wanted);
    const std::vector<Material> before = body.materials();
    std::vector<Material> materials = before;
    Material& material = materials[static_cast<std::size_t>(wanted.material)];
    const auto present = material.get(wanted.name);
    std::vector<double> values(present.begin(), present.end());
    values[static_cast<std::size_t>(wanted.entry)] = value;
    setParameter(material, {number->name, values.data(), static_cast<std::int32_t>(values.size())});
    checkMaterial(material);
    checkMatter(material);
    material.updateModuli();
    const auto u = body.u();
    const double lacking = body.lacking();
    settled([&] {
      try {
        body.setMaterials(materials);
        body.settleFrom(u, equilibrium->tool, lacking);
      } catch (...) {
        body.setMaterials(before);
        body.settleFrom(u, equilibrium->tool, lacking);
        throw;
      }
    });
    return PALPATE_OK;
  });
}

int32_t palpate_equilibrium_value(palpate_equilibrium* equilibrium, const palpate_quantity* quantity, double* value,
                                  palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{equilibrium, "equilibrium"}, {value, "value"}})) return code;
  return guarded(error, [&] {
    *value = equilibrium->body.valueOf(quantityOf(*equilibrium, quantity));
    return PALPATE_OK;
  });
}

int32_t palpate_equilibrium_expected_error(palpate_equilibrium* equilibrium, double* share) {
  if (const int32_t code = nullAmong({{equilibrium, "equilibrium"}, {share, "share"}})) return code;
  return guarded(nullptr, [&] {
    *share = equilibrium->body.expectedError();
    return PALPATE_OK;
  });
}

int32_t palpate_sensitivity(palpate_equilibrium* equilibrium, const palpate_quantity* quantity,
                            const palpate_material_number* numbers, int32_t count, double* derivatives,
                            palpate_error* error) {
  if (const std::int32_t code =
          nullAmong(error, {{equilibrium, "equilibrium"}, {numbers, "numbers"}, {derivatives, "derivatives"}}))
    return code;
  if (count < 1) return say(error, PALPATE_BAD_ARGUMENT, "count is less than 1");
  return guarded(error, [&] {
    std::vector<MaterialNumber> asked;
    for (std::int32_t k = 0; k < count; ++k) asked.push_back(numberFrom(numbers[k]));
    std::vector<double> slopes;
    settled([&] { slopes = equilibrium->body.derivatives(quantityOf(*equilibrium, quantity), asked); });
    std::copy(slopes.begin(), slopes.end(), derivatives);
    return PALPATE_OK;
  });
}

}  // extern "C"
